//! `backseat-soak`: long runs.

use std::process::ExitCode;

use anyhow::Result;
use backseat_soak::stuck::{self, frozen};
use backseat_soak::{beside, kills, tcp, year};
use clap::Parser;

/// Long runs; exit code 1 where something was not as it must be
#[derive(Parser)]
#[command(max_term_width = 100)]
enum Cli {
    /// Fly days of simulated time as fast as they go, with faults, one client that asks for all
    Year(year::Year),
    /// Serve clients over TCP in real time by `backseat mvc --log`
    Tcp(tcp::Tcp),
    /// Kill, stop, suspend and cut off `backseat run` at random instants while it steers `backseat mvc`
    Kills(kills::Kills),
    /// Fly every fault of the plugin `faulty` beside a good plugin, and measure the good one's modifies
    Beside(beside::Beside),
    /// Measure the runtime's modifies and how soon it obeys, while standard error and disks are slow, stuck, full or gone
    Stuck(stuck::Stuck),
    /// The same while the log's file system is frozen, as root; exit code 77 where none can be frozen
    Frozen(frozen::Frozen),
}

/// Nothing was shown. Automake's tests say by this code that they were skipped.
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
