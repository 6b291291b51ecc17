//! `backseat log`: what the log of a run says.

mod info;
#[cfg(feature = "simulation")]
mod judge;

use std::path::Path;

use anyhow::{Context, Result};
use backseat_recorder::read;
use clap::Subcommand;

#[derive(Debug, Subcommand)]
pub(crate) enum Log {
    /// Show what a log is of: mission, times, what is attached, what is missing
    Info(info::LogInfo),
    /// Judge a recorded run by the safety requirements, as simulations are judged
    ///
    /// The oracle that judges simulations reads the link's bytes in the log of a dive, with the mission's limits and the
    /// fence that are attached to it. A line for each rule says whether it held and how often there was something to judge,
    /// or why it could not be judged. The word before that is the side that the rule looks at: `sent` our sentences
    /// alone, `heard` our sentences after what the runtime had read from the vehicle, `operator` our sentences after what
    /// the operator did, `arrived` and `truth` what only a simulation knows: these are never judged here, even in the log
    /// of a simulation. Where a rule broke, time, rule, text and sentence follow.
    ///
    /// Where the disk was too slow, records are missing. Past such a gap nothing is claimed that hangs on what was before
    /// it, until the log tells it again.
    ///
    /// Exit code 0 where nothing broke, 1 where something did, 2 where the file cannot be judged.
    #[cfg(feature = "simulation")]
    Judge(judge::LogJudge),
}

pub(crate) fn log(command: &Log) -> Result<bool> {
    match command {
        Log::Info(arguments) => info::info(arguments),
        #[cfg(feature = "simulation")]
        Log::Judge(arguments) => judge::judge(arguments),
    }
}

fn read_log(path: &Path) -> Result<backseat_recorder::Log> {
    read(path).context("expected the log of a run, as `run` or `sim --log` writes it")
}
