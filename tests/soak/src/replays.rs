//! Simulated dives with drawn faults, flown and replayed: core and plugins must do the same again, to the same bytes.

use std::fmt;

use anyhow::{Context, Result};
use backseat_hunt::{Fault, Plan, Range, SWAPS};
use backseat_plugin_host::Host;
use backseat_recorder::LogReader;
use backseat_replay::{Configs, Flow, Replay, Report, Task};
use clap::Args;

/// The parameters.
#[derive(Clone, Debug, Args)]
pub struct Replays {
    /// Number of dives
    #[arg(long, default_value_t = 100)]
    pub dives: u64,
    /// The first seed
    #[arg(long, default_value_t = 1)]
    pub first: u64,
}

/// The results.
#[derive(Clone, Debug, Default)]
pub struct ReplaysReport {
    dives: u64,
    processes: u64,
    inputs: u64,
    outputs: u64,
    steps: u64,
    restarts: u64,
    swaps: u64,
    unplayed: u64,
    seconds: f64,
    different: Vec<String>,
}

/// Flies and replays the dives.
///
/// # Errors
///
/// If a dive cannot be flown, or its log cannot be read.
pub fn run(arguments: &Replays) -> Result<ReplaysReport> {
    let range = Range::new(backseat_test_support::plugins())?;
    let folder = tempfile::tempdir()?;
    let path = folder.path().join("dive.mcap");
    let mut all = ReplaysReport::default();
    for seed in arguments.first..arguments.first + arguments.dives {
        let mut plan = Plan::draw(seed);
        // The log of a simulation has no component that only a swap brings, and no config of it.
        plan.faults
            .retain(|planned| !matches!(&planned.fault, Fault::Swap { to, .. } if *to != SWAPS[0]));
        range.fly_logged(&plan, &path)?;
        let mut log = LogReader::open(&path)?;
        let task = Task::of(&log, Configs::default())?;
        let mut replay = Replay::new(task, &Host::new()?, Vec::new(), 1)?;
        while let Some(message) = log.next_message()? {
            if replay.take(message).with_context(|| format!("seed {seed}"))? == Flow::Over {
                break;
            }
        }
        all.add(seed, &replay.finish(log.is_complete()));
    }
    Ok(all)
}

impl ReplaysReport {
    fn add(&mut self, seed: u64, report: &Report) {
        self.dives += 1;
        self.processes += report.processes;
        self.inputs += report.inputs;
        self.outputs += report.outputs;
        self.seconds += report.seconds;
        for plugin in &report.plugins {
            self.steps += plugin.steps;
            self.restarts += plugin.restarts;
            self.swaps += plugin.swaps;
            self.unplayed += plugin.unplayed;
        }
        if report.identical != Some(true) {
            self.different
                .push(format!("seed {seed}: {}", report.lines().join("\n")));
        }
    }

    /// What is not as it must be.
    #[must_use]
    pub fn faults(&self) -> Vec<String> {
        let mut faults = self.different.clone();
        // Twenty dives are enough for each of these to happen.
        if self.dives >= 20 {
            for (what, count) in [
                ("no version took a plugin's place", self.swaps),
                ("no process was killed", self.processes - self.dives),
                ("no plugin was restarted", self.restarts),
                ("no plugin stood in for another", self.unplayed),
            ] {
                if count == 0 {
                    faults.push(what.to_owned());
                }
            }
        }
        faults
    }
}

impl fmt::Display for ReplaysReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} dives of {:.1} h, {} processes: {} outputs of {} inputs, {} steps, {} restarts and {} swaps of plugins ({} steps of \
             plugins that are not in the log); {} dives differ",
            self.dives,
            self.seconds / 3600.0,
            self.processes,
            self.outputs,
            self.inputs,
            self.steps,
            self.restarts,
            self.swaps,
            self.unplayed,
            self.different.len()
        )
    }
}
