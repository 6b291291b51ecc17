use std::fmt::{self, Write as _};
use std::fs;
use std::path::PathBuf;
use std::process::{Command, Stdio};

use anyhow::{Context, Result, bail};
use clap::Args;

use crate::cargo::{cargo, cargo_command, root, run, target};
use crate::compile::{compile, with_lints};
use crate::digest::{self, Digest};
use crate::exports;
use crate::hunt::{self, Hunt};
use crate::plugins;
use crate::python;
use crate::seeds::{self, Seeds};
use crate::steps::Steps;
use crate::tests::prepare;

/// The file with the date, commit and results of the last run.
const RECORD: &str = "tests/soak/last-run.txt";

/// The exit code of a long run that is not possible on this machine.
const SKIPPED: i32 = 77;

/// The tests that take too long for every change. Run them before a release, or after a change of what they test.
#[derive(Args)]
pub(crate) struct Soak {
    /// Run nothing; print when the soak last ran, on which commit, and its results
    #[arg(long)]
    last: bool,
    /// Run only the steps whose names contain this text; such a run is not recorded
    #[arg(long, value_name = "TEXT", conflicts_with = "last")]
    only: Option<String>,
}

/// A step's name and its function.
type Task = (&'static str, fn() -> Result<()>);

/// The steps, the longest last.
const TASKS: [Task; 14] = [
    ("property tests, other and more cases", properties),
    ("seeds of the reference missions", flights),
    ("same bytes in debug and release", same_bytes),
    ("sonar exports in other readers", exports::exports),
    ("plugins in Python", python::python),
    ("kills of the runtime", || long(&["kills", "--trials", "100"])),
    ("dives with faults, replayed", || long(&["replays", "--dives", "100"])),
    ("faulty plugins beside a good one", || long(&["beside"])),
    ("stuck terminals and disks around the runtime", || long(&["stuck"])),
    ("a frozen file system under the log", || where_possible("frozen")),
    ("a campaign on Slurm", || where_possible("slurm")),
    ("clients over TCP", || long(&["tcp", "--minutes", "5"])),
    ("a simulated month", || long(&["year", "--days", "30"])),
    ("hunt", hunts),
];

pub(crate) fn soak(arguments: &Soak) -> Result<()> {
    let record = root()?.join(RECORD);
    if arguments.last {
        let text = fs::read_to_string(&record)
            .with_context(|| format!("{RECORD}: no soak has been recorded; run `cargo xtask soak`"))?;
        print!("{text}");
        return Ok(());
    }
    let chosen = |name: &str| arguments.only.as_ref().is_none_or(|only| name.contains(only.as_str()));
    let names: Vec<&str> = TASKS.iter().map(|(name, _)| *name).collect();
    if !names.iter().any(|name| chosen(name)) {
        bail!("no step has this in its name; there are: {}", names.join(", "));
    }
    // Read before the hour that the soak takes, because a commit made meanwhile was not tested.
    let began = format!("last run of `cargo xtask soak`: {}\non commit {}", date()?, commit()?);
    let mut steps = Steps::default();
    let (mut failed, mut not_shown) = (Vec::new(), Vec::new());
    for (name, task) in TASKS {
        if !chosen(name) {
            continue;
        }
        // A failed step does not prevent the later ones.
        if let Err(error) = steps.run(name, task) {
            match error.downcast_ref::<NotShown>() {
                Some(NotShown(why)) => not_shown.push(format!("{name}: {why}")),
                None => failed.push(format!("{name}: {error:#}")),
            }
        }
    }
    let mut told = format!("{began}\n\n{steps}");
    for failure in &failed {
        let _infallible = writeln!(told, "FAILED {failure}");
    }
    for step in &not_shown {
        let _infallible = writeln!(told, "NOT SHOWN {step}");
    }
    println!("\n{told}");
    if arguments.only.is_none() {
        fs::write(&record, told).with_context(|| RECORD.to_owned())?;
        println!("recorded in {RECORD}: commit this file");
    }
    if failed.is_empty() {
        return Ok(());
    }
    bail!("{} of the soak's steps failed", failed.len())
}

/// Runs `tests/soak`, built for release.
fn long(arguments: &[&str]) -> Result<()> {
    run(&mut long_command(arguments)?)
}

fn long_command(arguments: &[&str]) -> Result<Command> {
    plugins::plugins()?;
    cargo(&[
        "build",
        "--release",
        "--package",
        "backseat-soak",
        "--package",
        "backseat-stall",
    ])?;
    println!("> backseat-soak {}", arguments.join(" "));
    let mut command = Command::new(target()?.join("release/backseat-soak"));
    command
        .args(arguments)
        .env("BACKSEAT_TEST_PROGRAM", target()?.join("release/backseat"))
        .env("BACKSEAT_TEST_PLUGINS", plugins::folder()?);
    Ok(command)
}

/// A step that is not possible on this machine, and why: neither a success nor a failure.
#[derive(Debug)]
struct NotShown(String);

impl fmt::Display for NotShown {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "not shown: {}", self.0)
    }
}

impl std::error::Error for NotShown {}

/// Runs a step that is not possible everywhere. Where it is not (no file system can be frozen, Slurm is not installed), the
/// tool reports why, and ends with [`SKIPPED`].
fn where_possible(step: &str) -> Result<()> {
    let mut command = long_command(&[step])?;
    let output = command
        .current_dir(root()?)
        .stderr(Stdio::inherit())
        .output()
        .with_context(|| format!("{command:?}"))?;
    let said = String::from_utf8_lossy(&output.stdout);
    print!("{said}");
    if output.status.code() == Some(SKIPPED) {
        let why = said
            .trim()
            .trim_start_matches("NOT SHOWN: ")
            .trim_start_matches("not shown: ");
        return Err(NotShown(why.to_owned()).into());
    }
    anyhow::ensure!(output.status.success(), "{command:?} ended with {}", output.status);
    Ok(())
}

/// The property tests of all crates, with other cases than in `test`, and more of them.
fn properties() -> Result<()> {
    let compiled = compile()?;
    plugins::build(&compiled.programs.join("backseat-componentize"))?;
    let mut command = cargo_command(&[
        "test",
        "--workspace",
        "--lib",
        "--tests",
        "--quiet",
        "--no-fail-fast",
        "--no-fail-fast",
        "--",
        "--skip",
        "real_time::",
    ]);
    with_lints(&mut command)?;
    let seed = date()?
        .bytes()
        .fold(0u64, |seed, byte| seed.wrapping_mul(31).wrapping_add(byte.into()));
    println!("PROPTEST_RNG_SEED={seed}");
    command
        .env("PROPTEST_RNG_SEED", seed.to_string())
        .env("PROPTEST_CASES", "4096");
    run(prepare(&mut command, &compiled)?)
}

fn flights() -> Result<()> {
    for mission in [
        "missions/isobath",
        "missions/plume",
        "missions/reinspect",
        "missions/coverage",
    ] {
        seeds::seeds(&Seeds {
            mission: mission.into(),
            runs: 200,
            first: 1,
            least: None,
        })?;
    }
    Ok(())
}

fn same_bytes() -> Result<()> {
    digest::digest(&Digest {
        missions: ["missions/isobath", "missions/plume"].map(PathBuf::from).into(),
        seeds: 5,
        faults: None,
        aarch64: false,
    })
}

fn hunts() -> Result<()> {
    hunt::hunt(&Hunt::of(4000, false))?;
    hunt::hunt(&Hunt::of(500, true))
}

/// The present time, as UTC.
fn date() -> Result<String> {
    told_by(Command::new("date").args(["-u", "+%Y-%m-%d %H:%M UTC"]))
}

/// The commit, and whether the tested tree differs from it.
fn commit() -> Result<String> {
    let commit = told_by(Command::new("git").args(["rev-parse", "HEAD"]))?;
    let changes = told_by(Command::new("git").args(["status", "--porcelain", "--", ":!tests/soak/last-run.txt"]))?;
    Ok(if changes.is_empty() {
        commit
    } else {
        format!("{commit}, with changes that were not committed")
    })
}

fn told_by(command: &mut Command) -> Result<String> {
    let output = command
        .current_dir(root()?)
        .output()
        .with_context(|| format!("{command:?}"))?;
    anyhow::ensure!(output.status.success(), "{command:?} ended with {}", output.status);
    Ok(String::from_utf8_lossy(&output.stdout).trim().to_owned())
}
