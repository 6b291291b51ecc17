//! `backseat-explore`: see the crate.

use std::collections::BTreeMap;
use std::process::ExitCode;
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Result, bail};
use backseat_explore::{Bounds, DEPTH_MAX, Found, Kind, Level, Prepared, SENTENCES, Searched, search};
use clap::Parser;
use serde::Serialize;

/// Tries all sequences of inputs to core from prepared states, and looks for a broken safety requirement
#[derive(Parser)]
#[command(max_term_width = 100)]
struct Cli {
    /// How long, all states together
    #[arg(long, default_value_t = 10.0)]
    minutes: f64,
    /// Only from these states
    #[arg(long, value_enum)]
    state: Vec<Prepared>,
    /// No deeper than this
    #[arg(long, default_value_t = DEPTH_MAX)]
    depth: usize,
    /// No more states than this from one prepared state: 48 bytes each, and as much again while a level is added
    #[arg(long, default_value_t = 40_000_000)]
    states: usize,
    /// Threads [default: one a core]
    #[arg(long)]
    workers: Option<usize>,
    /// Print one JSON object in place of the table
    #[arg(long)]
    json: bool,
    /// Try nothing, but tell what happens in this sequence from the one state that is given
    #[arg(long, value_enum, value_delimiter = ',', requires = "state")]
    sequence: Vec<Kind>,
    /// A mutation: leave a check of the monitor out, in a build with the feature `mutations`
    #[arg(long)]
    without: Option<String>,
    /// Leave each check out in turn, three deep by default, and tell which are found, in a build with `mutations`
    #[arg(long, conflicts_with_all = ["without", "sequence", "json", "minutes"])]
    every_check: bool,
}

/// What is known of one prepared state at the end.
#[derive(Serialize)]
struct Report {
    state: Prepared,
    kinds: usize,
    depth: usize,
    states: usize,
    transitions: u64,
    cut: u64,
    seconds: f64,
    levels: Vec<Level>,
    said: BTreeMap<&'static str, u64>,
    broken: Vec<BrokenReport>,
}

#[derive(Serialize)]
struct BrokenReport {
    rule: &'static str,
    text: String,
    sequence: Vec<String>,
}

#[expect(clippy::disallowed_methods, reason = "it is told how long it may take")]
fn now() -> Instant {
    Instant::now()
}

fn main() -> ExitCode {
    match explore(&Cli::parse()) {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("backseat-explore: {error:#}");
            ExitCode::from(2)
        }
    }
}

/// Whether nothing was broken.
fn explore(cli: &Cli) -> Result<bool> {
    if let Some(check) = &cli.without {
        leave_out(check)?;
    }
    if cli.every_check {
        return every_check(cli);
    }
    if !cli.sequence.is_empty() {
        return Ok(tell(cli.state[0], &cli.sequence));
    }
    let (states, workers) = (states(cli), workers(cli));
    let end = now() + Duration::from_secs_f64(cli.minutes * 60.0);
    let mut reports = Vec::new();
    for (index, state) in states.iter().enumerate() {
        let began = now();
        // What one state leaves over is the others'.
        let share = end.saturating_duration_since(began) / (states.len() - index) as u32;
        let world = state.world();
        let kinds = Kind::all(world.hovers());
        let bounds = Bounds {
            depth: cli.depth,
            states: cli.states,
            workers,
            is_over: &|| began.elapsed() >= share,
            tell: &|level| {
                eprintln!(
                    "{}, {} deep: {} states, {} sequences{}",
                    state.name(),
                    level.depth,
                    level.states,
                    level.transitions,
                    if level.part < 1.0 { ", not all" } else { "" }
                );
            },
        };
        let searched = search(&world, &kinds, &bounds);
        let seconds = began.elapsed().as_secs_f64();
        for found in searched.found.values() {
            eprintln!("{}", in_words(*state, found));
        }
        reports.push(report(*state, kinds.len(), &searched, seconds));
    }
    if cli.json {
        println!("{}", serde_json::to_string(&reports)?);
    } else {
        print(&reports);
    }
    Ok(reports.iter().all(|report| report.broken.is_empty()))
}

fn states(cli: &Cli) -> &[Prepared] {
    if cli.state.is_empty() {
        Prepared::all()
    } else {
        &cli.state
    }
}

fn workers(cli: &Cli) -> usize {
    let cores = || thread::available_parallelism().map(Into::into).ok();
    cli.workers.or_else(cores).unwrap_or(1)
}

fn report(state: Prepared, kinds: usize, searched: &Searched, seconds: f64) -> Report {
    let broken = |found: &Found| BrokenReport {
        rule: found.broken.rule,
        text: found.broken.text.clone(),
        sequence: found.sequence.iter().map(|kind| kind.name()).collect(),
    };
    Report {
        state,
        kinds,
        depth: searched.depth(),
        states: searched.states(),
        transitions: searched.transitions(),
        cut: searched.cut(),
        seconds,
        levels: searched.levels.clone(),
        said: SENTENCES.into_iter().zip(searched.said).collect(),
        broken: searched.found.values().map(broken).collect(),
    }
}

fn print(reports: &[Report]) {
    println!("| state | whole to depth | states | sequences | cut | seconds | broken |");
    println!("|---|---|---|---|---|---|---|");
    for report in reports {
        println!(
            "| {} | {} | {} | {} | {} | {:.0} | {} |",
            report.state.name(),
            report.depth,
            report.states,
            report.transitions,
            report.cut,
            report.seconds,
            report.broken.len()
        );
    }
}

/// A broken rule with its sequence, and the line that tells all that happens in it.
fn in_words(state: Prepared, found: &Found) -> String {
    let sequence: Vec<String> = found.sequence.iter().map(|kind| kind.name()).collect();
    let sequence = sequence.join(",");
    let state = state.name();
    format!(
        "broken: {}\n  cargo xtask explore --state {state} --sequence {sequence}",
        found.broken
    )
}

/// Prints what happens, sentence by sentence; whether nothing was broken.
fn tell(state: Prepared, sequence: &[Kind]) -> bool {
    let mut world = state.world();
    println!("{}: {}", state.name(), world.describe());
    world.watch();
    let mut broken = None;
    for kind in sequence {
        if let Err(found) = world.step(*kind) {
            broken = Some(found);
            break;
        }
    }
    for line in world.trace() {
        println!("{line}");
    }
    match &broken {
        Some(broken) => println!("broken: {broken}"),
        None => println!("nothing is broken: {}", world.describe()),
    }
    broken.is_none()
}

/// One line a check: whether a short sequence shows that it is off, and the shortest. Nothing is broken by it.
#[cfg(feature = "mutations")]
fn every_check(cli: &Cli) -> Result<bool> {
    use backseat_core::mutations::{Check, leave_none_out, leave_out};
    let mut found = 0;
    for check in Check::ALL {
        leave_out(check);
        let shortest = shortest(cli);
        leave_none_out();
        found += u32::from(shortest.is_some());
        let told = shortest.unwrap_or_else(|| "not found | ".to_owned());
        println!("| SR-{:03} | {} | {told} |", check.requirement(), check.name());
    }
    println!("{found} of {} checks are found", Check::ALL.len());
    Ok(true)
}

/// The rule that is broken, and the shortest sequence of all states that breaks it.
#[cfg(feature = "mutations")]
fn shortest(cli: &Cli) -> Option<String> {
    let mut shortest = None;
    let mut depth = cli.depth.min(3);
    for state in states(cli) {
        let world = match std::panic::catch_unwind(|| state.world()) {
            Ok(world) => world,
            Err(panic) => {
                let text = panic.downcast_ref::<String>().map_or("", String::as_str);
                return Some(format!("{text} | on the way to it"));
            }
        };
        let bounds = Bounds {
            depth,
            states: cli.states,
            workers: workers(cli),
            is_over: &|| false,
            tell: &|_| {},
        };
        let found = search(&world, &Kind::all(world.hovers()), &bounds).found;
        if let Some(found) = found.into_values().min_by_key(|found| found.sequence.len()) {
            depth = found.sequence.len() - 1;
            let sequence: Vec<String> = found.sequence.iter().map(|kind| kind.name()).collect();
            shortest = Some(format!(
                "{} | {}: {}",
                found.broken.rule,
                state.name(),
                sequence.join(", ")
            ));
        }
    }
    shortest
}

#[cfg(not(feature = "mutations"))]
fn every_check(_: &Cli) -> Result<bool> {
    bail!("this build leaves nothing out: it is without the feature `mutations`")
}

#[cfg(feature = "mutations")]
fn leave_out(name: &str) -> Result<()> {
    use backseat_core::mutations::{Check, leave_out};
    match Check::ALL.iter().find(|check| check.name() == name) {
        Some(check) => leave_out(*check),
        None => bail!("there is no check {name}"),
    }
    Ok(())
}

#[cfg(not(feature = "mutations"))]
fn leave_out(_: &str) -> Result<()> {
    bail!("this build leaves nothing out: it is without the feature `mutations`")
}
