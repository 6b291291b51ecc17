//! The program `backseat-hunt`. The crate's documentation explains it.

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io::{ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::process::ExitCode;
use std::thread;
use std::time::{Duration, Instant};

use anyhow::{Context, Result, bail};
use backseat_hunt::{
    Alarm, Coverage, Digests, Flight, Hunt, Order, Plan, Range, each_seed, of_mission, of_plans, shrink,
};
use clap::{Args, Parser, Subcommand};
use indicatif::{ProgressBar, ProgressStyle};
use serde::{Deserialize, Serialize};

/// Look for a mission in which something unsafe is sent, or in which control is not handed back
#[derive(Parser)]
#[command(max_term_width = 100)]
struct Cli {
    /// The folder of the built plugins
    #[arg(long, default_value = "target/plugins", global = true)]
    plugins: PathBuf,
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Fly random missions on all cores, and print coverage and failures
    Fly(Fly),
    /// Fly the plan in a file, and print the result
    Replay {
        /// The plan
        plan: PathBuf,
        /// Write the whole log of the flight to this file
        #[arg(long)]
        log: Option<PathBuf>,
        /// Leave out this check of the safety monitor (a mutation), in a build with the feature `mutations`
        #[arg(long)]
        without: Option<String>,
    },
    /// Add up the coverage of several hunts, from the files that `fly --coverage` has written
    Sum {
        /// The files
        #[arg(required = true)]
        files: Vec<PathBuf>,
        /// List the pairs of fault and state that were met less often than this
        #[arg(long, default_value_t = 0)]
        least: u64,
    },
    /// Fly missions without faults, and print what the monitor finds untrue in their navigation
    Alarms {
        /// Number of missions
        #[arg(long, default_value_t = 1000)]
        runs: u64,
        /// The first seed
        #[arg(long, default_value_t = 1)]
        first: u64,
        /// Number of threads [default: one for each core]
        #[arg(long)]
        workers: Option<usize>,
        /// Multiply the default limits of the integrity checks by this
        #[arg(long, default_value_t = 1.0)]
        times: f64,
        /// Write the plans of missions with an alarm or a broken rule into this folder, for `replay`
        #[arg(long, value_name = "DIR")]
        save: Option<PathBuf>,
    },
    /// Print digests of many runs, one line for each seed; a refactoring must not change them
    Digests(Seeds),
    /// Print the tree hash, and below it the hash of each crate
    Tree,
    /// List the mutations of this build: the checks of the monitor that it can leave out
    Checks,
    /// Print the whole plan that a seed draws
    Show {
        /// The seed
        seed: u64,
        /// From the missions of `fly --detours`
        #[arg(long)]
        detours: bool,
        /// From the missions of `alarms`
        #[arg(long, conflicts_with = "detours")]
        clean: bool,
    },
}

#[derive(Args)]
struct Seeds {
    /// A mission's folder [default: the random missions of `fly`]
    #[arg(long)]
    mission: Option<PathBuf>,
    /// Use the random missions of `fly --detours`
    #[arg(long, conflicts_with = "mission")]
    detours: bool,
    /// Number of seeds
    #[arg(long, default_value_t = 200)]
    runs: u64,
    /// The first seed
    #[arg(long, default_value_t = 1)]
    first: u64,
    /// Number of threads [default: one for each core]
    #[arg(long)]
    workers: Option<usize>,
}

#[derive(Args)]
struct Fly {
    /// Number of missions
    #[arg(long, default_value_t = 1000)]
    runs: u64,
    /// Begin no mission after this many seconds
    #[arg(long)]
    seconds: Option<u64>,
    /// The first seed
    #[arg(long, default_value_t = 1)]
    first: u64,
    /// Number of threads [default: one for each core]
    #[arg(long)]
    workers: Option<usize>,
    /// Fly other missions instead, without faults: among obstacles, with a plugin that leads inserts around them and
    /// then cancels the ones that lead around
    #[arg(long, conflicts_with_all = ["coverage", "both"])]
    detours: bool,
    /// List the pairs of fault and state that were met less often than this
    #[arg(long, default_value_t = 0)]
    least: u64,
    /// Fail if the share of missions with a lease and an accepted insert is smaller, percent
    #[arg(long, default_value_t = 0.0)]
    both: f64,
    /// Also write the coverage to this file, for `sum`
    #[arg(long)]
    coverage: Option<PathBuf>,
    /// Write the shrunk plans of failures into this folder
    #[arg(long, default_value = "target/hunt")]
    save: PathBuf,
    /// Stop at the first mission that fails
    #[arg(long)]
    stop: bool,
    /// Do not shrink failures
    #[arg(long)]
    whole: bool,
    /// Print a short summary
    #[arg(long)]
    brief: bool,
    /// Leave out this check of the safety monitor (a mutation), to see that the hunt notices, in a build with the
    /// feature `mutations`
    #[arg(long)]
    without: Option<String>,
}

fn main() -> ExitCode {
    match run() {
        Ok(true) => ExitCode::SUCCESS,
        Ok(false) => ExitCode::FAILURE,
        Err(error) => {
            eprintln!("hunt: {error:#}");
            ExitCode::from(2)
        }
    }
}

fn run() -> Result<bool> {
    let cli = Cli::parse();
    match cli.task {
        Task::Fly(arguments) => fly(&cli.plugins, &arguments),
        Task::Replay { plan, log, without } => {
            if let Some(check) = &without {
                leave_out(check)?;
            }
            replay(&cli.plugins, &plan, log.as_deref())
        }
        Task::Sum { files, least } => sum(&files, least),
        Task::Alarms {
            runs,
            first,
            workers,
            times,
            save,
        } => {
            let seeds = first..first.saturating_add(runs);
            alarms(&cli.plugins, seeds, workers, times, save.as_deref())
        }
        Task::Digests(seeds) => digests(&cli.plugins, &seeds),
        Task::Tree => {
            print(&format!("{TREE}\n{}\n", TREES.replace(',', "\n")))?;
            Ok(true)
        }
        Task::Checks => {
            print(&checks()?)?;
            Ok(true)
        }
        Task::Show { seed, detours, clean } => {
            let plan = if clean {
                Plan::draw_clean(seed, 1.0)
            } else {
                drawn(detours)(seed)
            };
            print(&plan.to_toml())?;
            Ok(true)
        }
    }
}

/// A digest of the paths and contents of the sources of core, fence, mvc, oracle, sim and spi that this was built from.
const TREE: &str = env!("BACKSEAT_TREE");

/// The same digest of the sources of each of these crates alone, as `NAME DIGEST` with a comma between two.
const TREES: &str = env!("BACKSEAT_TREES");

fn tree_line(tree: Option<&str>) -> String {
    format!("tree {}", tree.unwrap_or("unknown"))
}

#[expect(
    clippy::disallowed_methods,
    reason = "the hunt's own time, which does not affect any flight"
)]
fn now() -> Instant {
    Instant::now()
}

const fn drawn(detours: bool) -> fn(u64) -> Plan {
    if detours { Plan::draw_detours } else { Plan::draw }
}

fn fly(plugins: &Path, arguments: &Fly) -> Result<bool> {
    if let Some(check) = &arguments.without {
        leave_out(check)?;
    }
    let begun = now();
    let bar = ProgressBar::new(arguments.runs);
    if let Ok(style) = ProgressStyle::with_template("{bar:40} {pos}/{len} {per_sec} {eta} {msg}") {
        bar.set_style(style);
    }
    let limit = arguments.seconds.map(Duration::from_secs);
    let order = Order {
        plugins: plugins.to_path_buf(),
        draw: drawn(arguments.detours),
        first: arguments.first,
        runs: arguments.runs,
        workers: arguments.workers.unwrap_or_else(cores),
        stop_at_failure: arguments.stop,
    };
    let hunt = Hunt::fly(&order, |done| {
        bar.set_position(done.flown);
        if done.failed > 0 {
            bar.set_message(format!("{} failed", done.failed));
        }
        // Printed at once, because a long hunt may be interrupted. With a check left out, failures are expected.
        if let Some((plan, failure)) = done.failure.filter(|_| arguments.without.is_none()) {
            bar.suspend(|| eprintln!("seed {}: {}", plan.seed, failure.text));
        }
        limit.is_none_or(|limit| now().duration_since(begun) < limit)
    })?;
    bar.finish_and_clear();
    let wall_s = now().duration_since(begun).as_secs_f64();
    let coverage = &hunt.coverage;
    if let Some(path) = &arguments.coverage {
        let flown = Flights {
            first: arguments.first,
            tree: Some(TREE.to_owned()),
            coverage: coverage.clone(),
        };
        fs::write(path, serde_json::to_string(&flown)?).with_context(|| path.display().to_string())?;
    }
    if arguments.brief {
        println!("{}", coverage.brief());
        println!("{}", tree_line(Some(TREE)));
        return Ok(hunt.failed.is_empty());
    }
    println!("{coverage}");
    println!("{}", tree_line(Some(TREE)));
    println!(
        "{wall_s:.0} s on {} threads: {:.0} x real time each",
        order.workers,
        coverage.sim_seconds / wall_s / order.workers as f64
    );
    tell_rare(coverage, arguments.least);
    if hunt.failed.is_empty() {
        let share = 100.0 * coverage.with_both as f64 / coverage.flights.max(1) as f64;
        let empty = share < arguments.both;
        if empty {
            println!(
                "too little was exercised: expected {} % with a lease and an insert",
                arguments.both
            );
        }
        return Ok(!empty);
    }
    keep(plugins, arguments, &hunt)?;
    Ok(false)
}

fn cores() -> usize {
    thread::available_parallelism().map_or(1, usize::from)
}

/// Flies seeds and prints their digests: of the link, then of the report.
fn digests(plugins: &Path, seeds: &Seeds) -> Result<bool> {
    let range = seeds.first..seeds.first.saturating_add(seeds.runs);
    let workers = seeds.workers.unwrap_or_else(cores);
    let flown = match &seeds.mission {
        Some(mission) => of_mission(plugins, mission, range, workers)?,
        None => of_plans(plugins, drawn(seeds.detours), range, workers)?,
    };
    for (seed, Digests { link, report }) in &flown {
        println!("{seed} {link} {report}");
    }
    Ok(true)
}

/// Flies missions without faults and prints each alarm. Returns whether there was none.
fn alarms(
    plugins: &Path,
    seeds: std::ops::Range<u64>,
    workers: Option<usize>,
    times: f64,
    save: Option<&Path>,
) -> Result<bool> {
    let all = Range::new(plugins)?;
    let ranges = (0..workers.unwrap_or_else(cores).max(1))
        .map(|_| all.another())
        .collect::<Result<Vec<_>>>()?;
    let flown = each_seed(seeds, ranges, |range, seed| range.fly(&Plan::draw_clean(seed, times)))?;
    let (mut missions, mut kinds) = (0, BTreeMap::<String, u64>::new());
    let (mut leases, mut hours, mut fixes, mut failed, mut astray) = (0, 0.0, 0, 0, 0);
    for (seed, flight) in &flown {
        leases += flight.report.seen.leases;
        hours += flight.report.sim_seconds / 3600.0;
        let alarms: Vec<Alarm> = flight.alarms().collect();
        fixes += flight.navigation.len() - alarms.len();
        missions += u64::from(!alarms.is_empty());
        if let Some(folder) = save
            && !(alarms.is_empty() && flight.failures.is_empty())
        {
            let path = folder.join(format!("clean-{seed}.toml"));
            fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
            fs::write(&path, Plan::draw_clean(*seed, times).to_toml()).with_context(|| path.display().to_string())?;
        }
        for alarm in alarms {
            println!("seed {seed}: {:.3} s {}", alarm.at.as_secs_f64(), alarm.text);
            let what = alarm.text.split(':').next().unwrap_or_default().to_owned();
            *kinds.entry(what).or_default() += 1;
        }
        // Without bottom lock for hours a vehicle may estimate that it makes no headway, and never reach the end of a
        // line.
        let (lost, broken): (Vec<_>, Vec<_>) = flight.failures.iter().partition(|of| of.rule == "never-ends");
        astray += lost.len();
        failed += u64::from(!broken.is_empty());
        for failure in broken {
            println!("seed {seed}: broken: {}", failure.text);
        }
    }
    for (what, count) in &kinds {
        println!("{count} x {what}");
    }
    if astray > 0 {
        println!("{astray} x led astray by its drifting navigation: the mission did not end in its time");
    }
    println!(
        "{missions} of {} missions with an alarm, {failed} with a broken rule; {hours:.0} h, {leases} leases, {fixes} jumps by GPS",
        flown.len()
    );
    println!("{}", tree_line(Some(TREE)));
    // The late end of a vehicle without any bottom lock is not an alarm.
    Ok(missions == 0)
}

/// The coverage of a hunt, with the seeds that it drew.
#[derive(Serialize, Deserialize)]
struct Flights {
    first: u64,
    /// The tree hash. The oldest files do not have it.
    #[serde(default)]
    tree: Option<String>,
    coverage: Coverage,
}

fn tell_rare(coverage: &Coverage, least: u64) {
    for (kind, state, count) in coverage.rare(least) {
        println!("rare: {kind} in {}: {count}", state.name());
    }
}

/// Adds up several hunts. No mission may count twice.
fn sum(files: &[PathBuf], least: u64) -> Result<bool> {
    let mut hunts: Vec<(&Path, Flights)> = Vec::new();
    for path in files {
        let text = fs::read_to_string(path).with_context(|| path.display().to_string())?;
        let flights: Flights = serde_json::from_str(&text).with_context(|| path.display().to_string())?;
        hunts.push((path, flights));
    }
    hunts.sort_by_key(|(_, flights)| flights.first);
    let mut all = Coverage::default();
    let mut next = (0, Path::new(""));
    for (path, flights) in &hunts {
        if flights.first < next.0 {
            let (path, other) = (path.display(), next.1.display());
            bail!("{path} and {other} have flown some of the same seeds, which would count twice: leave one out");
        }
        next = (flights.first.saturating_add(flights.coverage.flights), *path);
        all.merge(&flights.coverage);
    }
    println!("{all}");
    println!("{}", all.brief());
    let trees: BTreeSet<Option<&str>> = hunts.iter().map(|(_, flights)| flights.tree.as_deref()).collect();
    for tree in &trees {
        println!("{}", tree_line(*tree));
    }
    if trees.len() > 1 {
        println!("these hunts are of {} trees", trees.len());
    }
    tell_rare(&all, least);
    Ok(all.failed == 0)
}

/// Shrinks one failure of each rule and writes its plan.
fn keep(plugins: &Path, arguments: &Fly, hunt: &Hunt) -> Result<()> {
    let range = Range::new(plugins)?;
    let folder = &arguments.save;
    fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    for (rule, plans) in &hunt.failed {
        for (plan, failure) in plans {
            println!("seed {}: {}", plan.seed, failure.text);
        }
        let Some((plan, _)) = plans.first() else { continue };
        let small = if arguments.whole {
            plan.clone()
        } else {
            shrink(&range, plan, rule)?
        };
        let path = folder.join(format!("{rule}-{}.toml", plan.seed));
        fs::write(&path, small.to_toml()).with_context(|| path.display().to_string())?;
        println!("  {rule}, {} faults:", small.faults.len());
        for line in small.lines() {
            println!("    {line}");
        }
        println!("  cargo xtask hunt --replay {}", path.display());
    }
    Ok(())
}

fn replay(plugins: &Path, path: &Path, log: Option<&Path>) -> Result<bool> {
    let text = fs::read_to_string(path).with_context(|| path.display().to_string())?;
    let plan = Plan::from_toml(&text).with_context(|| path.display().to_string())?;
    for line in plan.lines() {
        println!("{line}");
    }
    let range = Range::new(plugins)?;
    let Flight { report, failures, .. } = match log {
        Some(log) => range.fly_logged(&plan, log)?,
        None => range.fly(&plan)?,
    };
    println!(
        "{} after {:.0} s: {} leases, {} inserts accepted, digest {}",
        report.outcome, report.sim_seconds, report.seen.leases, report.seen.inserts_accepted, report.digest
    );
    for rejection in &report.rejections {
        println!("rejected {rejection}");
    }
    for failure in &failures {
        println!("{}: {}", failure.rule, failure.text);
    }
    if failures.is_empty() {
        println!("nothing found");
    }
    Ok(failures.is_empty())
}

#[cfg(feature = "mutations")]
fn checks() -> Result<String> {
    let line = |check: &backseat_core::mutations::Check| {
        format!("{}\t{:03} {}\n", check.name(), check.requirement(), check.what())
    };
    Ok(backseat_core::mutations::Check::ALL.iter().map(line).collect())
}

#[cfg(not(feature = "mutations"))]
fn checks() -> Result<String> {
    bail!("this build can switch no check off: build it with --features mutations");
}

/// A reader that leaves, such as `head`, is no error.
fn print(text: &str) -> Result<()> {
    match std::io::stdout().lock().write_all(text.as_bytes()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(error).context("standard output"),
        Ok(()) | Err(_) => Ok(()),
    }
}

#[cfg(feature = "mutations")]
fn leave_out(name: &str) -> Result<()> {
    use backseat_core::mutations::{Check, leave_out};
    let Some(check) = Check::ALL.iter().find(|check| check.name() == name) else {
        let names: Vec<&str> = Check::ALL.iter().map(|check| check.name()).collect();
        bail!("no check is called {name}: expected one of {}", names.join(", "));
    };
    println!(
        "without {} (requirement {:03}): {}",
        check.name(),
        check.requirement(),
        check.what()
    );
    leave_out(*check);
    Ok(())
}

#[cfg(not(feature = "mutations"))]
fn leave_out(name: &str) -> Result<()> {
    bail!("{name} cannot be left out in this build: only a test build with the feature `mutations` can")
}
