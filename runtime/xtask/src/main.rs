//! The entry point for the project's tasks: `cargo xtask demo`, `cargo xtask test`, and their parts.

mod cargo;
mod check;
mod compile;
mod console;
mod cross;
mod demo;
mod digest;
mod explore;
mod exports;
mod hunt;
mod mutants;
mod mutations;
mod package;
mod plugins;
mod python;
mod reference;
mod safety;
mod sea;
mod seeds;
mod soak;
mod sonar_page;
mod steps;
mod tests;
mod tidy;
mod wheel;
mod workspace;

use std::process::ExitCode;

use anyhow::Result;
use clap::{Parser, Subcommand};

#[derive(Parser)]
#[command(bin_name = "cargo xtask", about = "The project's tasks", max_term_width = 100)]
struct Cli {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Build everything and fly the isobath mission in simulation; prints where its log and picture are
    Demo,
    /// Run all checks of a change: format, project rules, dependencies, lints, tests, examples
    Test,
    /// Run the part of `test` that a change needs: lints, the tests of changed crates and of crates that depend on
    /// them, one flight of each reference mission
    Quick(check::Quick),
    /// Run the tests that take too long for every change, before a release; `--last` prints when and on which commit
    /// they last ran
    Soak(soak::Soak),
    /// Build the project's plugins into target/plugins
    Plugins,
    /// Run the benchmarks and print the speed table
    Bench,
    /// Fly a mission with many seeds and count those that meet its expectations
    Seeds(seeds::Seeds),
    /// Fly random missions with random faults on all cores, and look for violations of safety
    Hunt(hunt::Hunt),
    /// Try all short sequences of inputs to core from prepared states, and look for a broken safety requirement
    Explore(explore::Explore),
    /// Change the code of the safety monitor in one place at a time, and see whether a test notices
    Mutants(mutants::Mutants),
    /// Fly the same seeds in several processes and builds, and compare the results
    Digest(digest::Digest),
    /// Open the exports of `s7k export` and `log export` with readers that others wrote (from PyPI), and compare every
    /// figure
    Exports,
    /// Test the page of the web console in Chromium, with Node 20 and playwright-core (from npm), and take pictures of it
    Console,
    /// Build the program for sea, static and reproducible, for x86_64 and aarch64 (with Zig and cargo-zigbuild from PyPI);
    /// and of it Debian packages with unit, man pages and completions, and a list of what is in it (with cargo-deb,
    /// cargo-auditable and cargo-cyclonedx from crates.io)
    Package(package::Package),
    /// Test the SDK for plugins in Python and fly its plugins, with componentize-py (from PyPI); builds the components of
    /// the plugins in Python into target/plugins. Then build the package `backseat` for studies into target/wheels, with
    /// Maturin (from PyPI), and run its tests and its notebook
    Python,
    /// Generate the pages in runtime/docs/reference and the schemas in missions/schemas from runtime/reference/keys
    Reference,
    /// Check the project's own rules
    Tidy,
}

fn main() -> ExitCode {
    let result: Result<()> = match Cli::parse().task {
        Task::Demo => demo::demo(),
        Task::Test => check::test(),
        Task::Quick(arguments) => check::quick(&arguments),
        Task::Soak(arguments) => soak::soak(&arguments),
        Task::Plugins => plugins::plugins(),
        Task::Bench => demo::bench(),
        Task::Seeds(arguments) => seeds::seeds(&arguments),
        Task::Hunt(arguments) => hunt::hunt(&arguments),
        Task::Explore(arguments) => explore::explore(&arguments),
        Task::Mutants(arguments) => mutants::mutants(&arguments),
        Task::Digest(arguments) => digest::digest(&arguments),
        Task::Exports => exports::exports(),
        Task::Console => console::console(),
        Task::Package(arguments) => package::package(&arguments),
        Task::Python => python::python(),
        Task::Reference => reference::reference(),
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
