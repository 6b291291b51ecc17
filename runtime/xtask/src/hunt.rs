use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};

use anyhow::{Context, Result, bail};
use clap::Args;

use crate::cargo::{cargo, root, target};
use crate::plugins::plugins;

/// Looks for a mission in which something unsafe is sent, or in which the helm does not come back.
#[derive(Args, Default)]
pub(crate) struct Hunt {
    /// How many missions
    #[arg(long, default_value_t = 1000)]
    runs: u64,
    /// No mission begins after so many seconds
    #[arg(long)]
    seconds: Option<u64>,
    /// The first seed
    #[arg(long, default_value_t = 1)]
    first: u64,
    /// Threads [default: one a core]
    #[arg(long)]
    workers: Option<usize>,
    /// Say which pairs of fault and state were met less often
    #[arg(long)]
    least: Option<u64>,
    /// Other missions, without faults: among walls, with a plugin that only leads inserts round them and takes back
    /// what leads round
    #[arg(long, conflicts_with = "coverage")]
    detours: bool,
    /// Write what was exercised here too; `--sum` adds such files up
    #[arg(long)]
    coverage: Option<PathBuf>,
    /// Fly none, but add up what these hunts have exercised
    #[arg(long, num_args = 1.., conflicts_with_all = ["without", "every_check", "replay", "coverage", "detours"])]
    sum: Vec<PathBuf>,
    /// Fly this plan instead, as the hunt keeps them
    #[arg(long, conflicts_with_all = ["without", "every_check", "detours"])]
    replay: Option<PathBuf>,
    /// Switch this check of the monitor off, in a build of its own
    #[arg(long)]
    without: Option<String>,
    /// Switch each check off in turn: each must be found, if not by these missions then by those of `--detours`
    #[arg(long, conflicts_with_all = ["without", "detours", "coverage"])]
    every_check: bool,
}

impl Hunt {
    /// So many missions from the first seed on.
    pub(crate) fn of(runs: u64, detours: bool) -> Self {
        Self {
            runs,
            first: 1,
            detours,
            ..Self::default()
        }
    }
}

pub(crate) fn hunt(arguments: &Hunt) -> Result<()> {
    plugins()?;
    let mutated = arguments.every_check || arguments.without.is_some();
    let program = build(mutated)?;
    if let Some(plan) = &arguments.replay {
        return ended(command(&program, &["replay"])?.arg(plan), "the plan found something");
    }
    if !arguments.sum.is_empty() {
        let mut sum = command(&program, &["sum"])?;
        for file in &arguments.sum {
            // The program runs in the checkout's folder, and not in the user's.
            sum.arg(std::path::absolute(file)?);
        }
        sum.args(["--least", &arguments.least.unwrap_or(0).to_string()]);
        return ended(&mut sum, "something was found");
    }
    if arguments.every_check {
        return every_check(&program, arguments);
    }
    let mut fly = fly(&program, arguments)?;
    if arguments.detours {
        fly.arg("--detours");
    }
    if let Some(check) = &arguments.without {
        fly.args(["--without", check]);
    }
    ended(&mut fly, "something was found")
}

/// The hunt's program; with mutations it has another name, so that neither is taken for the
/// other.
fn build(mutated: bool) -> Result<PathBuf> {
    let mut arguments = vec!["build", "--release", "--package", "backseat-hunt"];
    if mutated {
        arguments.extend(["--features", "mutations"]);
    }
    cargo(&arguments)?;
    let program = target()?.join("release/backseat-hunt");
    if !mutated {
        return Ok(program);
    }
    let apart = target()?.join("release/backseat-hunt-mutations");
    fs::copy(&program, &apart).with_context(|| apart.display().to_string())?;
    Ok(apart)
}

fn command(program: &PathBuf, arguments: &[&str]) -> Result<Command> {
    let mut command = Command::new(program);
    command
        .args(arguments)
        .arg("--plugins")
        .arg(target()?.join("plugins"))
        .current_dir(root()?);
    Ok(command)
}

fn fly(program: &PathBuf, arguments: &Hunt) -> Result<Command> {
    let mut fly = command(program, &["fly"])?;
    fly.args([
        "--runs",
        &arguments.runs.to_string(),
        "--first",
        &arguments.first.to_string(),
    ]);
    let options = [
        ("--seconds", arguments.seconds),
        ("--workers", arguments.workers.map(|workers| workers as u64)),
        ("--least", arguments.least),
    ];
    for (option, value) in options {
        if let Some(value) = value {
            fly.args([option, &value.to_string()]);
        }
    }
    if let Some(coverage) = &arguments.coverage {
        fly.arg("--coverage").arg(std::path::absolute(coverage)?);
    }
    Ok(fly)
}

fn ended(command: &mut Command, otherwise: &str) -> Result<()> {
    let status = command.status().with_context(|| format!("{command:?}"))?;
    match status.code() {
        Some(0) => Ok(()),
        Some(1) => bail!("{otherwise}"),
        _ => bail!("{command:?} ended with {status}"),
    }
}

/// One line a check: in how many missions the hunt found that it was off.
fn every_check(program: &PathBuf, arguments: &Hunt) -> Result<()> {
    let listed = command(program, &["checks"])?.output()?;
    let checks = String::from_utf8_lossy(&listed.stdout).into_owned();
    let mut unfound = Vec::new();
    for line in checks.lines() {
        let Some((check, what)) = line.split_once('\t') else {
            continue;
        };
        let without = |more: &[&str]| -> Result<Output> {
            let mut fly = fly(program, arguments)?;
            Ok(fly
                .args(["--without", check, "--whole", "--brief"])
                .args(more)
                .output()?)
        };
        let mut output = without(&[])?;
        if output.status.code() == Some(0) {
            output = without(&["--detours"])?;
        }
        let text = String::from_utf8_lossy(&output.stdout);
        match output.status.code() {
            Some(1) => println!(
                "found    {check:32} {what}\n         {}",
                text.trim().replace('\n', "\n         ")
            ),
            Some(0) => {
                println!(
                    "NOT FOUND {check:31} {what}\n         {}",
                    text.trim().replace('\n', "\n         ")
                );
                unfound.push(check.to_owned());
            }
            _ => bail!("without {check}: {}", String::from_utf8_lossy(&output.stderr).trim()),
        }
    }
    if !unfound.is_empty() {
        bail!("not found: {}", unfound.join(", "));
    }
    Ok(())
}
