//! Digests of the bytes on the link in many runs, one a line, which a refactoring must not change.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread;

use anyhow::{Context, Result, bail};
use backseat_mission::{Layers, Mission};
use backseat_plugin_loader::Components;
use backseat_scenario::Scenario;
use backseat_sim::{Report, Simulation};
use serde::Serialize;
use sha2::{Digest, Sha256};

use crate::flight::{Range, host};
use crate::plan::Plan;

/// Two digests of a run: change the code, fly the seed again, compare.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Digests {
    /// The digest of every write on the vehicle's link, as in `sim --json`.
    pub link: String,
    /// The digest of the whole report: refusals with their texts, measures, violations, the oracle's counts.
    pub report: String,
}

impl Digests {
    fn of(report: &Report, failures: &impl Serialize) -> Result<Self> {
        // A drawn mission has the name of the folder to which it was written.
        let nameless = Report {
            mission: String::new(),
            ..report.clone()
        };
        let told = serde_json::to_vec(&(nameless, failures))?;
        Ok(Self {
            link: report.digest.clone(),
            report: format!("{:x}", Sha256::digest(told)),
        })
    }
}

/// Flies drawn plans and returns the digests by seed.
///
/// # Errors
///
/// If a plan's mission cannot be created, or a component is missing.
pub fn of_plans(
    plugins: &Path,
    draw: fn(u64) -> Plan,
    seeds: std::ops::Range<u64>,
    workers: usize,
) -> Result<BTreeMap<u64, Digests>> {
    let all = Range::new(plugins)?;
    let ranges = (0..workers.max(1)).map(|_| all.another()).collect::<Result<Vec<_>>>()?;
    each_seed(seeds, ranges, |range, seed| {
        let flight = range.fly(&draw(seed))?;
        let failures: Vec<&str> = flight.failures.iter().map(|failure| failure.text.as_str()).collect();
        Digests::of(&flight.report, &failures)
    })
}

/// Flies a mission's folder with many seeds and returns the digests by seed.
///
/// # Errors
///
/// If the mission or one of its components cannot be read.
pub fn of_mission(
    plugins: &Path,
    mission: &Path,
    seeds: std::ops::Range<u64>,
    workers: usize,
) -> Result<BTreeMap<u64, Digests>> {
    let mission = Mission::load(mission, &Layers::default())?;
    let scenario = Scenario::load(&mission)?;
    let components = Components::load(&host(plugins)?, &mission, Some(plugins))?;
    let workers = vec![(); workers.max(1)];
    each_seed(seeds, workers, |(), seed| {
        let mut simulation = Simulation::new(&mission, &scenario, seed, components.start(&mission)?, None)?;
        while simulation.advance()? {}
        let (report, ..) = simulation.finish()?;
        Digests::of(&report, &())
    })
}

/// Calls a function for each seed, on as many threads as there are workers.
///
/// # Errors
///
/// The first error, with its seed.
pub fn each_seed<W: Send, T: Send>(
    seeds: std::ops::Range<u64>,
    workers: Vec<W>,
    work: impl Fn(&W, u64) -> Result<T> + Sync,
) -> Result<BTreeMap<u64, T>> {
    let next = AtomicU64::new(seeds.start);
    let fly = |worker: W| -> Result<BTreeMap<u64, T>> {
        let mut done = BTreeMap::new();
        loop {
            let seed = next.fetch_add(1, Ordering::Relaxed);
            if seed >= seeds.end {
                return Ok(done);
            }
            done.insert(seed, work(&worker, seed).with_context(|| format!("seed {seed}"))?);
        }
    };
    let fly = &fly;
    thread::scope(|scope| {
        let threads: Vec<_> = workers
            .into_iter()
            .map(|worker| scope.spawn(move || fly(worker)))
            .collect();
        let mut all = BTreeMap::new();
        for thread in threads {
            match thread.join() {
                Ok(done) => all.append(&mut done?),
                Err(_) => bail!("a worker panicked"),
            }
        }
        Ok(all)
    })
}
