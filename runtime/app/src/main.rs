//! `backseat`: simulates, deploys and checks plugins that steer a Bluefin vehicle through the Standard Payload
//! Interface. This crate holds the command line and the drivers that read clocks and sockets; the logic is in the
//! crates below it.

#![warn(clippy::print_stdout, clippy::print_stderr)]

mod arguments;
mod aside;
mod cache;
#[cfg(feature = "simulation")]
mod campaign;
mod check;
mod cli;
mod clock;
#[cfg(feature = "console")]
mod console;
mod doctor;
#[cfg(feature = "simulation")]
mod events;
mod explain;
mod external;
#[cfg(feature = "simulation")]
mod fly;
mod generate;
mod helm;
mod keeper;
mod link;
mod lock;
mod log;
mod log_parts;
mod log_room;
#[cfg(feature = "simulation")]
mod map;
#[cfg(feature = "simulation")]
mod mvc;
mod operator;
mod output;
mod owner;
#[cfg(feature = "simulation")]
mod peer;
#[cfg(feature = "simulation")]
mod plc;
#[cfg(feature = "plugin")]
mod plugin;
mod plugins;
mod rate;
#[cfg(test)]
mod real_time;
mod recording;
mod replay;
mod run;
mod s7k;
mod service;
#[cfg(feature = "simulation")]
mod sim;
mod sonar;
#[cfg(feature = "simulation")]
mod sonar_settings;
#[cfg(feature = "simulation")]
mod speed;
mod spi;
mod state;
#[cfg(feature = "simulation")]
mod surroundings;
mod swap;
mod terminal;

use std::io::IsTerminal;
use std::panic::UnwindSafe;
use std::process::ExitCode;

use backseat_mission::with_suggestion;
use backseat_reference::{MET, PANICKED, STOPPED, UNMET, UNUSABLE};
use clap::Parser;
use tracing_subscriber::Layer as _;
use tracing_subscriber::filter::{LevelFilter, Targets};
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::util::SubscriberInitExt;

use crate::cli::{Cli, Command};

fn main() -> ExitCode {
    terminal::start();
    let code = guarded(program);
    terminal::finish();
    code
}

/// A panic in this thread ends the program with the exit code that Rust gives it, but waits until its message is
/// printed.
fn guarded(program: impl FnOnce() -> ExitCode + UnwindSafe) -> ExitCode {
    std::panic::catch_unwind(program).unwrap_or(ExitCode::from(PANICKED))
}

fn program() -> ExitCode {
    let cli = Cli::parse();
    let told = std::env::var("BACKSEAT_LOG")
        .ok()
        .and_then(|directives| directives.parse().ok());
    let lines = tracing_subscriber::fmt::layer()
        .with_writer(terminal::ByLevel)
        // The subscriber's own errors would go to `eprintln!`, which panics where standard error is closed.
        .log_internal_errors(false)
        .with_ansi(std::io::stderr().is_terminal())
        .with_target(false);
    // The journal has a time of its own for each line.
    let lines = if terminal::is_journal() {
        lines.without_time().boxed()
    } else {
        lines.boxed()
    };
    tracing_subscriber::registry()
        .with(lines)
        .with(told.unwrap_or_else(|| {
            // What a library says of its connections to viewers is no news of the dive.
            Targets::new()
                .with_default(LevelFilter::INFO)
                .with_target("foxglove", LevelFilter::OFF)
        }))
        .init();
    let result = match &cli.command {
        #[cfg(feature = "simulation")]
        Command::Sim(arguments) => sim::sim(arguments),
        #[cfg(feature = "simulation")]
        Command::Campaign(arguments) => return ended(campaign::campaign(arguments)),
        Command::Run(arguments) => return run_ended(run::run(arguments)),
        #[cfg(feature = "simulation")]
        Command::Fly(arguments) => fly::fly(arguments),
        #[cfg(feature = "simulation")]
        Command::Mvc(arguments) => mvc::mvc(arguments),
        #[cfg(feature = "simulation")]
        Command::Plc(arguments) => plc::plc(arguments),
        Command::Check(arguments) => check::check(arguments),
        Command::Doctor(arguments) => doctor::doctor(arguments),
        Command::Replay(arguments) => replay::replay(arguments),
        Command::Log(command) => log::log(command),
        #[cfg(feature = "plugin")]
        Command::Plugin(command) => plugin::plugin(command),
        Command::Spi(command) => spi::spi(command),
        Command::S7k(command) => s7k::s7k(command),
        Command::Swap(arguments) => swap::swap(arguments),
        Command::Key(arguments) => lock::key(arguments),
        Command::Explain(arguments) => explain::explain(arguments),
        Command::Generate(arguments) => generate::generate(arguments),
    };
    ended(result.map(|met| if met { MET } else { UNMET }))
}

fn ended(result: anyhow::Result<u8>) -> ExitCode {
    match result {
        Ok(code) => ExitCode::from(code),
        Err(error) => {
            // One line: what, where, what to do. Plugins have their own readers of their settings.
            terminal::tell_error(&format!(
                "error: {}{}",
                with_suggestion(&one_line(&error)),
                owner::who_asked(&error)
            ));
            ExitCode::from(UNUSABLE)
        }
    }
}

/// A service that is refused as it was given stays down, but what is around it may pass in mid-dive.
fn run_ended(result: anyhow::Result<bool>) -> ExitCode {
    let passes = result.as_ref().is_err_and(|error| error.chain().any(service::may_pass));
    let code = ended(result.map(|met| if met { MET } else { UNMET }));
    if passes { ExitCode::from(STOPPED) } else { code }
}

/// An error and its causes in one line, without the causes that the text already contains.
fn one_line(error: &anyhow::Error) -> String {
    let mut text = String::new();
    for cause in error.chain() {
        let cause = cause.to_string();
        if text.is_empty() {
            text = cause;
        } else if !text.contains(&cause) {
            text.push_str(": ");
            text.push_str(&cause);
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_of_the_loop_ends_the_program_as_rust_does() {
        assert_eq!(guarded(|| panic!("the test panics")), ExitCode::from(101));
        assert_eq!(guarded(|| ExitCode::from(UNMET)), ExitCode::from(UNMET));
    }
}
