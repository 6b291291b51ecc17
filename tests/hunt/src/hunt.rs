use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};
use std::thread;
use std::time::Duration;

use anyhow::{Context, Result, bail};

use crate::coverage::Coverage;
use crate::flight::{Failure, Flight, Range};
use crate::plan::Plan;

/// Every mission of this number is flown a second time from its resolved plan, and must write the same bytes.
const REPEAT_EVERY: u64 = 200;
/// How long a recorded failure's plan continues after the failure.
const AFTER_FAILURE: Duration = Duration::from_secs(10);
/// The most plans that are kept for one rule.
const KEPT: usize = 5;

/// The parameters of a hunt.
pub struct Order {
    /// The folder of the built plugins.
    pub plugins: PathBuf,
    /// Draws the plan of a seed.
    pub draw: fn(u64) -> Plan,
    /// The first seed.
    pub first: u64,
    /// The number of missions.
    pub runs: u64,
    /// The number of threads.
    pub workers: usize,
    /// Whether to stop at the first failure.
    pub stop_at_failure: bool,
}

/// A mission that has been flown, and the progress of the hunt.
pub struct Flown<'a> {
    /// The number of missions flown.
    pub flown: u64,
    /// The number of those that failed.
    pub failed: u64,
    /// The first failure of this mission, with its plan as it was flown.
    pub failure: Option<(&'a Plan, &'a Failure)>,
}

/// The result of a hunt.
pub struct Hunt {
    /// The states, requests and faults that were met.
    pub coverage: Coverage,
    /// The plans that failed, as they were flown, by the rule of the first failure.
    pub failed: BTreeMap<String, Vec<(Plan, Failure)>>,
}

impl Hunt {
    /// Flies all seeds on several threads. `tick` is called after each mission, on its thread; when it returns false,
    /// no further mission begins.
    ///
    /// # Errors
    ///
    /// If a plan's mission cannot be created, which is an error of the hunt itself.
    pub fn fly(order: &Order, tick: impl Fn(&Flown<'_>) -> bool + Sync) -> Result<Self> {
        let range = Range::new(&order.plugins)?;
        let next = AtomicU64::new(order.first);
        let end = order.first.saturating_add(order.runs);
        let (flown, failed) = (AtomicU64::new(0), AtomicU64::new(0));
        let stop = AtomicBool::new(false);
        let all = Mutex::new(Self {
            coverage: Coverage::default(),
            failed: BTreeMap::new(),
        });
        let work = |range: Range| -> Result<()> {
            let mut coverage = Coverage::default();
            let result = loop {
                let seed = next.fetch_add(1, Ordering::Relaxed);
                if seed >= end || stop.load(Ordering::Relaxed) {
                    break Ok(());
                }
                let flight = match fly(&range, &(order.draw)(seed)) {
                    Ok(flight) => flight,
                    Err(error) => break Err(error.context(format!("seed {seed}"))),
                };
                coverage.add(&flight);
                if let Some(failure) = flight.failures.first() {
                    failed.fetch_add(1, Ordering::Relaxed);
                    if order.stop_at_failure {
                        stop.store(true, Ordering::Relaxed);
                    }
                    let mut all = all.lock().unwrap_or_else(PoisonError::into_inner);
                    let kept = all.failed.entry(failure.rule.clone()).or_default();
                    if kept.len() < KEPT {
                        kept.push((flight.resolved.clone(), failure.clone()));
                    }
                }
                let done = Flown {
                    flown: flown.fetch_add(1, Ordering::Relaxed) + 1,
                    failed: failed.load(Ordering::Relaxed),
                    failure: flight.failures.first().map(|failure| (&flight.resolved, failure)),
                };
                if !tick(&done) {
                    stop.store(true, Ordering::Relaxed);
                }
            };
            stop.fetch_or(result.is_err(), Ordering::Relaxed);
            all.lock()
                .unwrap_or_else(PoisonError::into_inner)
                .coverage
                .merge(&coverage);
            result
        };
        thread::scope(|scope| -> Result<()> {
            let mut workers = Vec::new();
            for _ in 0..order.workers.max(1) {
                let range = range.another()?;
                workers.push(scope.spawn(|| work(range)));
            }
            for worker in workers {
                match worker.join() {
                    Ok(result) => result?,
                    Err(_) => bail!("a worker of the hunt panicked"),
                }
            }
            Ok(())
        })?;
        let all = all.into_inner().unwrap_or_else(PoisonError::into_inner);
        Ok(all)
    }
}

fn fly(range: &Range, plan: &Plan) -> Result<Flight> {
    let mut flight = range.fly(plan)?;
    if plan.seed.is_multiple_of(REPEAT_EVERY) {
        // Through its file, as in a replay.
        let written = Plan::from_toml(&flight.resolved.to_toml()).context("its own plan, after writing and reading")?;
        let again = range.fly(&written)?;
        if again.report.digest != flight.report.digest {
            flight.failures.push(Failure {
                rule: "not-repeatable".to_owned(),
                text: format!(
                    "the resolved plan wrote other bytes: {} instead of {}",
                    again.report.digest, flight.report.digest
                ),
                at: None,
            });
        }
    }
    // A recorded failure's plan ends soon after the failure.
    if let Some(failure) = flight.failures.first()
        && let Some(at) = failure.at
    {
        flight.resolved.until = Some(at + AFTER_FAILURE);
    }
    Ok(flight)
}
