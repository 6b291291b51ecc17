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

/// One mission in so many is flown a second time, by its resolved plan: it must write the same bytes.
const REPEAT_EVERY: u64 = 200;
/// What is kept of a failure goes on for so long after it.
const AFTER_FAILURE: Duration = Duration::from_secs(10);
/// No more plans are kept of one rule.
const KEPT: usize = 5;

/// What is to be flown.
pub struct Order {
    /// The folder of the built plugins.
    pub plugins: PathBuf,
    /// What a seed draws.
    pub draw: fn(u64) -> Plan,
    /// The first seed.
    pub first: u64,
    /// How many.
    pub runs: u64,
    /// On so many threads.
    pub workers: usize,
    /// Stop at the first failure.
    pub stop_at_failure: bool,
}

/// A mission that has been flown, and how far the hunt is with it.
pub struct Flown<'a> {
    /// How many are flown.
    pub flown: u64,
    /// How many of them failed.
    pub failed: u64,
    /// What this one failed by first, and its plan as it was flown.
    pub failure: Option<(&'a Plan, &'a Failure)>,
}

/// What was flown.
pub struct Hunt {
    /// What was exercised.
    pub coverage: Coverage,
    /// Plans that failed, by the rule that failed first, as they were flown.
    pub failed: BTreeMap<String, Vec<(Plan, Failure)>>,
}

impl Hunt {
    /// Flies all seeds on so many threads. `tick` is called after each mission, on its thread; no further one begins once it
    /// says false.
    ///
    /// # Errors
    /// Where a plan's mission cannot be made: the hunt itself is wrong then.
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
        // Through its file, as whoever replays it would.
        let written = Plan::from_toml(&flight.resolved.to_toml()).context("its own plan, written and read")?;
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
    // What is kept of a failure ends soon after it.
    if let Some(failure) = flight.failures.first()
        && let Some(at) = failure.at
    {
        flight.resolved.until = Some(at + AFTER_FAILURE);
    }
    Ok(flight)
}
