//! `backseat-soak`: long runs of the mock vehicle.

use std::process::ExitCode;

use anyhow::Result;
use backseat_soak::{tcp, year};
use clap::Parser;

/// Long runs of the mock vehicle; exit code 1 where something was not as it must be
#[derive(Parser)]
#[command(max_term_width = 100)]
enum Cli {
    /// Fly days of simulated time as fast as they go, with faults, one client that asks for all
    Year(year::Year),
    /// Serve clients over TCP in real time by `backseat mvc --log`
    Tcp(tcp::Tcp),
}

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
