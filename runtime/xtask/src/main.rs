//! The one door to the project's tasks: `cargo xtask demo`, `cargo xtask test`, and what they are made of.

mod cargo;
mod cross;
mod demo;
mod digest;
mod hunt;
mod safety;
mod seeds;
mod switches;
mod tidy;

use std::process::ExitCode;

use anyhow::Result;
use clap::{Parser, Subcommand};

#[derive(Parser)]
#[command(about, max_term_width = 100)]
struct Cli {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Build everything and fly the isobath mission in simulation; says where its log and picture are
    Demo,
    /// Run everything that checks the project: format, lints, tests, project rules
    Test,
    /// Build the project's plugins into target/plugins
    Plugins,
    /// Run the benchmarks and print the speed table
    Bench,
    /// Fly a mission with many seeds and tell how many held its expectations
    Seeds(seeds::Seeds),
    /// Fly drawn missions with drawn troubles on all cores, and look for what must never be
    Hunt(hunt::Hunt),
    /// Fly the same seeds in several processes and builds, and compare what they tell
    Digest(digest::Digest),
    /// Check the project's own rules
    Tidy,
}

fn main() -> ExitCode {
    let result: Result<()> = match Cli::parse().task {
        Task::Demo => demo::demo(),
        Task::Test => demo::test(),
        Task::Plugins => demo::plugins(),
        Task::Bench => demo::bench(),
        Task::Seeds(arguments) => seeds::seeds(&arguments),
        Task::Hunt(arguments) => hunt::hunt(&arguments),
        Task::Digest(arguments) => digest::digest(&arguments),
        Task::Tidy => tidy::tidy(),
    };
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("xtask: {error:#}");
            ExitCode::FAILURE
        }
    }
}
