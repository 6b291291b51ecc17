//! `backseat-soak`: long runs.

use std::process::ExitCode;

use anyhow::Result;
use backseat_soak::stuck::{self, frozen};
use backseat_soak::{beside, kills, replays, slurm, tcp, year};
use clap::Parser;

/// Long runs; exit code 1 if something is not as required
#[derive(Parser)]
#[command(max_term_width = 100)]
enum Cli {
    /// Simulate days as fast as possible, with faults and one client that subscribes to everything
    Year(year::Year),
    /// Serve clients over TCP in real time with `backseat mvc --log`
    Tcp(tcp::Tcp),
    /// Kill, stop, suspend and cut off `backseat run` at random instants while it steers `backseat mvc`
    Kills(kills::Kills),
    /// Fly every fault of the plugin `faulty` beside a good plugin, and measure the good one's modifies
    Beside(beside::Beside),
    /// Fly simulated dives with drawn faults, and replay their logs to the same bytes
    Replays(replays::Replays),
    /// Fly a campaign on a Slurm of one node, kill a task and take the node away, as root; exit code 77 without Slurm
    Slurm(slurm::Slurm),
    /// Measure the runtime's modifies and its response to the operator while standard error and disks are slow, stuck,
    /// full or closed
    Stuck(stuck::Stuck),
    /// The same while the log's file system is frozen, as root; exit code 77 if no file system can be frozen
    Frozen(frozen::Frozen),
}

/// Nothing was shown. Automake's tests use this code when they are skipped.
const NOT_SHOWN: u8 = 77;

fn main() -> Result<ExitCode> {
    let (report, faults) = match Cli::parse() {
        Cli::Year(arguments) => {
            let report = year::run(&arguments)?;
            (report.to_string(), report.faults())
        }
        Cli::Tcp(arguments) => {
            let report = tcp::run(&arguments)?;
            (report.to_string(), report.faults())
        }
        Cli::Beside(arguments) => {
            let report = beside::run(&arguments)?;
            (report.to_string(), report.faults())
        }
        Cli::Replays(arguments) => {
            let report = replays::run(&arguments)?;
            (report.to_string(), report.faults())
        }
        Cli::Slurm(arguments) => {
            let report = slurm::run(&arguments)?;
            if !report.was_shown() {
                println!("{report}");
                return Ok(ExitCode::from(NOT_SHOWN));
            }
            (report.to_string(), report.faults())
        }
        Cli::Stuck(arguments) => {
            let report = stuck::run(&arguments)?;
            (report.to_string(), report.faults())
        }
        Cli::Frozen(arguments) => {
            let report = frozen::run(&arguments)?;
            if !report.was_shown() {
                println!("{report}");
                return Ok(ExitCode::from(NOT_SHOWN));
            }
            (report.to_string(), report.faults())
        }
        Cli::Kills(arguments) => {
            let report = kills::run(&arguments)?;
            (report.to_string(), report.faults())
        }
    };
    println!("{report}");
    for fault in &faults {
        println!("NOT AS IT MUST BE: {fault}");
    }
    Ok(if faults.is_empty() {
        ExitCode::SUCCESS
    } else {
        ExitCode::FAILURE
    })
}
