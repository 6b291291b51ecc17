use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output};

use anyhow::{Context, Result, bail};
use clap::Args;

use crate::cargo::{cargo, root, target};
use crate::plugins::plugins;

/// Looks for a mission in which something unsafe is sent, or in which control is not handed back.
#[derive(Args, Default)]
pub(crate) struct Hunt {
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
    /// List the pairs of fault and state that were met less often than this
    #[arg(long)]
    least: Option<u64>,
    /// Fly other missions instead, without faults: among obstacles, with a plugin that leads inserts around them and
    /// then cancels the ones that lead around
    #[arg(long, conflicts_with = "coverage")]
    detours: bool,
    /// Also write the coverage to this file; `--sum` adds such files up
    #[arg(long)]
    coverage: Option<PathBuf>,
    /// Fly no mission, but add up the coverage in these files
    #[arg(long, num_args = 1.., conflicts_with_all = ["without", "every_check", "replay", "coverage", "detours"])]
    sum: Vec<PathBuf>,
    /// Fly this plan instead, a file that the hunt has written
    #[arg(long, conflicts_with_all = ["without", "every_check", "detours"])]
    replay: Option<PathBuf>,
    /// Switch this check of the safety monitor off, in a separate build
    #[arg(long)]
    without: Option<String>,
    /// Switch off each check in turn; each must be found by the first 100 of these missions, by
    /// 100 of `--detours`, or else by all of these
    #[arg(long, conflicts_with_all = ["without", "detours", "coverage"])]
    every_check: bool,
}

impl Hunt {
    /// A hunt of this many missions, from the first seed on.
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
            // The program runs in the checkout's folder, not in the user's.
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

/// Builds the hunt's program. With mutations it has another name, so that the two cannot be confused.
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

/// With one check off, so many missions are flown first, and all only if they notice nothing.
const FEW: u64 = 100;

/// Prints one line for each check: in how many missions the hunt found that it was off.
fn every_check(program: &PathBuf, arguments: &Hunt) -> Result<()> {
    let listed = command(program, &["checks"])?.output()?;
    let checks = String::from_utf8_lossy(&listed.stdout).into_owned();
    let mut unfound = Vec::new();
    for line in checks.lines() {
        let Some((check, what)) = line.split_once('\t') else {
            continue;
        };
        let without = |runs: u64, more: &[&str]| -> Result<Output> {
            let mut fly = fly(
                program,
                &Hunt {
                    runs,
                    seconds: arguments.seconds,
                    first: arguments.first,
                    workers: arguments.workers,
                    ..Hunt::default()
                },
            )?;
            Ok(fly
                .args(["--without", check, "--whole", "--brief"])
                .args(more)
                .output()?)
        };
        // Most checks are missed within a few missions.
        let few = arguments.runs.min(FEW);
        let mut output = without(few, &[])?;
        if output.status.code() == Some(0) {
            output = without(few, &["--detours"])?;
        }
        if output.status.code() == Some(0) && arguments.runs > few {
            output = without(arguments.runs, &[])?;
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
