use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, Result, bail};
use clap::Args;

use crate::cargo::{backseat, cargo, root, run};
use crate::compile::{Compiled, compile};
use crate::plugins;
use crate::sea;
use crate::steps::Steps;
use crate::tests::{Which, run_examples, run_tests};
use crate::tidy::tidy;
use crate::workspace::Workspace;

/// The version that is installed if none is.
const DENY: (&str, &str) = ("cargo-deny", "0.20.2");
/// Crates that read files which belong to no crate or to another one: in tests or, as `plugin-tools`, into the program.
const READERS: [(&str, &str); 17] = [
    ("wit/", "backseat-plugin-tools"),
    ("plugins/sdk/", "backseat-plugin-tools"),
    ("plugins/template/", "backseat-plugin-tools"),
    ("runtime/units/", "backseat-plugin-tools"),
    ("missions/template/", "backseat-plugin-tools"),
    ("wit/", "backseat-sdk"),
    ("wit/", "backseat-plugin-host"),
    ("runtime/docs/", "backseat-mvc"),
    ("runtime/docs/", "backseat-reference"),
    ("runtime/docs/", "xtask"),
    ("tests/plans/", "backseat-hunt"),
    ("tests/plans/", "backseat-replay"),
    ("missions/", "backseat-reference"),
    ("missions/", "backseat-scenario"),
    ("missions/", "backseat-suite"),
    ("missions/", "backseat-sim"),
    ("missions/", "backseat-replay"),
];
/// The missions that must still fly after every change.
const REFERENCE: [&str; 4] = [
    "missions/isobath",
    "missions/plume",
    "missions/reinspect",
    "missions/coverage",
];

/// The second of the README's two commands: everything except the long runs.
pub(crate) fn test() -> Result<()> {
    let mut steps = Steps::default();
    let result = test_in(&mut steps);
    steps.show();
    result
}

fn test_in(steps: &mut Steps) -> Result<()> {
    steps.run("format", || cargo(&["fmt", "--all", "--check"]))?;
    steps.run("project rules", tidy)?;
    steps.run("dependencies: licences, sources", dependencies)?;
    // Before the whole program, which then takes its place.
    steps.run("compile the program for sea", sea::build)?;
    let compiled = steps.run("compile, with lints", compile)?;
    steps.run("compile the plugins", || plugins::build(&componentize(&compiled)))?;
    // A failure does not prevent the later steps, which may fail too.
    let tests = steps.run("tests", || run_tests(&compiled, None, Which::Computing));
    let real_time = steps.run("tests in real time", || run_tests(&compiled, None, Which::RealTime));
    let examples = steps.run("examples of the documentation", || run_examples(&compiled));
    tests.and(real_time).and(examples)
}

/// The part of `test` that a change needs, in one to three minutes. It leaves out the tests in real time, the
/// documentation's examples and the check of dependencies. A change of a file that affects all crates runs the tests of
/// all crates.
#[derive(Args)]
pub(crate) struct Quick {
    /// The crates that have changed, by name or by folder [default: those in which git sees a change or, without any,
    /// those that the last commit changed]
    crates: Vec<String>,
}

pub(crate) fn quick(arguments: &Quick) -> Result<()> {
    let mut steps = Steps::default();
    let result = quick_in(arguments, &mut steps);
    steps.show();
    result
}

fn quick_in(arguments: &Quick, steps: &mut Steps) -> Result<()> {
    let workspace = Workspace::read()?;
    let changed = if arguments.crates.is_empty() {
        changed_crates(&workspace)?
    } else {
        arguments
            .crates
            .iter()
            .map(|name| workspace.find(name))
            .collect::<Result<_>>()?
    };
    println!("changed: {}", list(&changed));
    let crates = workspace.and_those_above(changed);
    println!("tested: {}", list(&crates));
    steps.run("format", || cargo(&["fmt", "--all", "--check"]))?;
    steps.run("project rules", tidy)?;
    // Before the whole program, which then takes its place.
    steps.run("compile the program for sea", sea::build)?;
    let compiled = steps.run("compile, with lints", compile)?;
    steps.run("compile the plugins", || plugins::build(&componentize(&compiled)))?;
    let tests = steps.run("tests", || run_tests(&compiled, Some(&crates), Which::Computing));
    let missions = steps.run("reference missions", || reference_missions(&compiled));
    tests.and(missions)
}

fn list(crates: &BTreeSet<String>) -> String {
    if crates.is_empty() {
        return "no crate".to_owned();
    }
    crates.iter().map(String::as_str).collect::<Vec<_>>().join(", ")
}

/// The crates in which git sees a change.
fn changed_crates(workspace: &Workspace) -> Result<BTreeSet<String>> {
    let mut files = git(&["diff", "--name-only", "--no-renames", "--relative", "-z", "HEAD"])?;
    files.extend(git(&["ls-files", "--others", "--exclude-standard", "-z"])?);
    if files.is_empty() {
        println!("git sees no change, so the changes of the last commit are used");
        files = git(&[
            "diff",
            "--name-only",
            "--no-renames",
            "--relative",
            "-z",
            "HEAD^1",
            "HEAD",
        ])?;
    }
    let mut changed = BTreeSet::new();
    for file in &files {
        for (_, reader) in READERS.iter().filter(|(place, _)| file.starts_with(place)) {
            changed.insert(workspace.find(reader)?);
        }
        match workspace.owner(Path::new(file)) {
            Some(owner) => {
                changed.insert(owner.to_owned());
            }
            // A file that affects how all crates are compiled or tested. (A new plugin's name in the lock file changes
            // no other crate.)
            None if file.ends_with(".toml") && !file.starts_with("missions/") && !file.starts_with("tests/") => {
                return Ok(workspace.all());
            }
            None if file == "Cargo.lock" && lock_changes_others()? => return Ok(workspace.all()),
            None => {}
        }
    }
    Ok(changed)
}

/// Whether the lock file has changed in more than the names of our own crates.
fn lock_changes_others() -> Result<bool> {
    let changed = git(&["diff", "--unified=0", "HEAD", "--", "Cargo.lock"])?.join("\n");
    Ok(changed
        .lines()
        .any(|line| line.starts_with(['+', '-']) && line.contains("source = ")))
}

/// The output of git, split at each NUL.
fn git(arguments: &[&str]) -> Result<Vec<String>> {
    let output = Command::new("git")
        .args(arguments)
        .current_dir(root()?)
        .output()
        .context("git is needed to find what has changed; or name the crates")?;
    if !output.status.success() {
        let said = String::from_utf8_lossy(&output.stderr);
        bail!(
            "git {}: {}",
            arguments.join(" "),
            said.lines().next().unwrap_or_default()
        );
    }
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    Ok(text
        .split('\0')
        .filter(|file| !file.is_empty())
        .map(str::to_owned)
        .collect())
}

/// One seed of each reference mission must meet its expectations.
fn reference_missions(compiled: &Compiled) -> Result<()> {
    for mission in REFERENCE {
        run(backseat(&compiled.programs.join("backseat"))
            .args(["sim", mission, "--plugins"])
            .arg(plugins::folder()?))?;
    }
    Ok(())
}

/// Checks that the licences of dependencies are allowed, and that they come from known sources. (`cargo deny check
/// advisories` looks for known vulnerabilities, but needs a network.)
fn dependencies() -> Result<()> {
    let (name, version) = DENY;
    let mut installed = Command::new(name);
    installed.arg("--version").stdout(Stdio::null()).stderr(Stdio::null());
    if !installed.status().is_ok_and(|status| status.success()) {
        cargo(&["install", "--locked", "--quiet", name, "--version", version])?;
    }
    cargo(&[
        "deny",
        "--locked",
        "check",
        "--hide-inclusion-graph",
        "bans",
        "licenses",
        "sources",
    ])
}

/// The program that builds plugins, from what was compiled for the tests.
fn componentize(compiled: &Compiled) -> PathBuf {
    compiled.programs.join("backseat-componentize")
}
