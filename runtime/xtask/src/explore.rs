use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail};
use clap::Args;

use crate::cargo::{cargo, root, target};

/// Tries all sequences of inputs to core from ten prepared states, and looks for a broken safety requirement.
#[derive(Args)]
pub(crate) struct Explore {
    /// How long, all states together
    #[arg(long, default_value_t = 10.0)]
    minutes: f64,
    /// Only from this state; may be repeated
    #[arg(long, value_name = "NAME")]
    state: Vec<String>,
    /// No sequences of more inputs than this
    #[arg(long)]
    depth: Option<usize>,
    /// Threads [default: one a core]
    #[arg(long)]
    workers: Option<usize>,
    /// Print one JSON object in place of the table
    #[arg(long)]
    json: bool,
    /// Try nothing, but tell what happens in this sequence from the one state that is given, sentence by sentence
    #[arg(long, value_name = "KIND,KIND", requires = "state")]
    sequence: Option<String>,
    /// Switch this check of the monitor off, in a build of its own
    #[arg(long)]
    without: Option<String>,
    /// Switch each check off in turn, and tell which the exploration finds
    #[arg(long, conflicts_with_all = ["without", "sequence", "json", "minutes"])]
    every_check: bool,
}

pub(crate) fn explore(arguments: &Explore) -> Result<()> {
    let program = build(arguments.every_check || arguments.without.is_some())?;
    let mut command = Command::new(&program);
    command.current_dir(root()?);
    if arguments.every_check {
        command.arg("--every-check");
    } else {
        command.args(["--minutes", &arguments.minutes.to_string()]);
    }
    for state in &arguments.state {
        command.args(["--state", state]);
    }
    let numbers = [("--depth", arguments.depth), ("--workers", arguments.workers)];
    for (option, value) in numbers {
        if let Some(value) = value {
            command.args([option, &value.to_string()]);
        }
    }
    let texts = [("--sequence", &arguments.sequence), ("--without", &arguments.without)];
    for (option, value) in texts {
        if let Some(value) = value {
            command.args([option, value]);
        }
    }
    if arguments.json {
        command.arg("--json");
    }
    ended(&mut command, &program)
}

/// With mutations it has another name, so that neither is taken for the other.
fn build(mutated: bool) -> Result<PathBuf> {
    let mut arguments = vec!["build", "--release", "--package", "backseat-explore"];
    if mutated {
        arguments.extend(["--features", "mutations"]);
    }
    cargo(&arguments)?;
    let program = target()?.join("release/backseat-explore");
    if !mutated {
        return Ok(program);
    }
    let apart = target()?.join("release/backseat-explore-mutations");
    fs::copy(&program, &apart).with_context(|| apart.display().to_string())?;
    Ok(apart)
}

fn ended(command: &mut Command, program: &Path) -> Result<()> {
    let status = command.status().with_context(|| program.display().to_string())?;
    match status.code() {
        Some(0) => Ok(()),
        Some(1) => bail!("a safety requirement was broken"),
        _ => bail!("{} ended with {status}", program.display()),
    }
}
