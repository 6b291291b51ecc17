//! The runtime is killed, stopped, suspended, cut off and told to end at random instants while it steers, as a separate
//! program beside the mock vehicle, over TCP (safety requirement 007).
//!
//! The vehicle's log decides, by the vehicle's own clock. However loaded the machine is, a modify ends within 5 s, and
//! station keeping within 2 s, of the last message that the vehicle received for it. A runtime that is not running
//! sends nothing. A request that was judged before a suspension is not sent after it. No identifier is used twice.

mod judge;
mod plan;
mod proxy;
mod report;
mod trial;

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::PathBuf;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU32, Ordering};
use std::thread;

use anyhow::{Result, bail};
use clap::Args;

pub use plan::{Act, Plan, Subject};
pub use report::KillsReport;

use judge::judge;
use trial::fly;

/// The parameters.
#[derive(Clone, Debug, Args)]
pub struct Kills {
    /// Number of missions, each with one fault
    #[arg(long, default_value_t = 500)]
    pub trials: u32,
    /// Seed for the faults and their instants
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Fraction of missions with a hovering vehicle, from 0 to 1
    #[arg(long, default_value_t = 0.2)]
    pub hovering_share: f64,
    /// Fraction of missions with inserts instead of steering, from 0 to 1
    #[arg(long, default_value_t = 0.1)]
    pub inserting_share: f64,
    /// Number of missions flown at once
    #[arg(long, default_value_t = 20)]
    pub at_once: u32,
    /// Fly only this trial of the seed, counted from 1
    #[arg(long)]
    pub only: Option<u32>,
    /// Write the vehicle's log of every failed trial into this folder
    #[arg(long, value_name = "DIR")]
    pub keep: Option<PathBuf>,
}

/// Flies the trials.
///
/// # Errors
///
/// If the fractions are invalid, or logs cannot be written.
pub fn run(arguments: &Kills) -> Result<KillsReport> {
    let (hovering, inserting) = (arguments.hovering_share, arguments.inserting_share);
    if !(hovering >= 0.0 && inserting >= 0.0 && hovering + inserting <= 1.0) {
        bail!("--hovering-share {hovering} and --inserting-share {inserting}: expected 0 or more, together at most 1");
    }
    // Built here, before several threads try to build it.
    let _program = backseat_test_support::program();
    let _plugins = backseat_test_support::plugins();
    let plans: Vec<Plan> = (1..=arguments.trials)
        .filter(|number| arguments.only.is_none_or(|only| only == *number))
        .map(|number| Plan::draw(arguments.seed, number, hovering, inserting))
        .collect();
    let (next, report) = (AtomicU32::new(0), Mutex::new(KillsReport::default()));
    thread::scope(|scope| {
        for _ in 0..arguments.at_once.max(1) {
            scope.spawn(|| {
                while let Some(plan) = plans.get(next.fetch_add(1, Ordering::Relaxed) as usize) {
                    let flown = catch_unwind(AssertUnwindSafe(|| fly(plan)));
                    let mut report = report.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
                    match flown {
                        Ok(record) => {
                            let verdict = judge(plan, &record);
                            keep(arguments, plan, &record.text, !verdict.misses.is_empty());
                            report.add(plan, verdict);
                        }
                        Err(panic) => report.add_failure(plan, panic.downcast_ref::<String>()),
                    }
                }
            });
        }
    });
    Ok(report.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner))
}

fn keep(arguments: &Kills, plan: &Plan, text: &str, missed: bool) {
    let Some(folder) = arguments.keep.as_ref().filter(|_| missed) else {
        return;
    };
    let path = folder.join(format!("trial-{}.log", plan.number));
    if let Err(error) = std::fs::create_dir_all(folder).and_then(|()| std::fs::write(&path, text)) {
        eprintln!("{}: {error}", path.display());
    }
}
