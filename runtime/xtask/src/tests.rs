use std::collections::BTreeSet;
use std::path::Path;
use std::process::{Command, Stdio};

use anyhow::{Result, bail};

use crate::cargo::{cargo_command, root, run};
use crate::compile::{Compiled, with_lints};
use crate::plugins;
use crate::sea;
use crate::workspace::Workspace;

/// The module of a test program that contains its tests in real time. They wait more than they compute, and some check
/// the program's timing, so nothing else may run beside them.
const REAL_TIME: &str = "real_time::";
/// How many of those run at once.
const REAL_TIME_AT_ONCE: &str = "6";
/// The seed of property tests.
const SEED: &str = "PROPTEST_RNG_SEED";

/// The tests to run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Which {
    /// Those that compute.
    Computing,
    /// Those that wait for a clock.
    RealTime,
}

/// Runs the compiled tests of these crates (of all, if none is named): with nextest if it is installed, otherwise one
/// program after the other.
pub(crate) fn run_tests(compiled: &Compiled, crates: Option<&BTreeSet<String>>, which: Which) -> Result<()> {
    if crates.is_some_and(BTreeSet::is_empty) {
        println!("no crate, no tests");
        return Ok(());
    }
    if has_nextest() {
        with_nextest(compiled, crates, which)
    } else {
        one_by_one(compiled, crates, which)
    }
}

/// Runs the examples in the documentation.
pub(crate) fn run_examples(compiled: &Compiled) -> Result<()> {
    let mut command = cargo_command(&["test", "--workspace", "--doc", "--quiet"]);
    with_lints(&mut command)?;
    run(prepare(&mut command, compiled)?)
}

fn has_nextest() -> bool {
    let mut command = Command::new("cargo-nextest");
    command
        .args(["nextest", "--version"])
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    command.status().is_ok_and(|status| status.success())
}

fn with_nextest(compiled: &Compiled, crates: Option<&BTreeSet<String>>, which: Which) -> Result<()> {
    let mut filter = match which {
        Which::Computing => format!("not test(/^{REAL_TIME}/)"),
        Which::RealTime => format!("test(/^{REAL_TIME}/)"),
    };
    if let Some(crates) = crates {
        let packages: Vec<String> = crates.iter().map(|name| format!("package(={name})")).collect();
        filter = format!("({filter}) and ({})", packages.join(" or "));
    }
    let mut arguments = vec![
        "nextest",
        "run",
        "--workspace",
        "--no-fail-fast",
        "--no-tests=pass",
        "-E",
        &filter,
    ];
    if which == Which::RealTime {
        arguments.extend(["--test-threads", REAL_TIME_AT_ONCE]);
    }
    let mut command = cargo_command(&arguments);
    with_lints(&mut command)?;
    run(prepare(&mut command, compiled)?)
}

fn one_by_one(compiled: &Compiled, crates: Option<&BTreeSet<String>>, which: Which) -> Result<()> {
    let workspace = Workspace::read()?;
    let root = root()?;
    let mut failed = Vec::new();
    for test in &compiled.tests {
        let folder = test.folder.strip_prefix(&root).unwrap_or(&test.folder);
        let asked_for = |name: &str| crates.is_none_or(|crates| crates.contains(name));
        if !workspace.owner(folder).is_some_and(asked_for) {
            continue;
        }
        let mut command = Command::new(&test.program);
        command.arg("--quiet");
        // With nextest, a test declares itself that it must run alone. Here it waits for the other tests of its
        // program, and no other program runs.
        match which {
            Which::Computing => command.args(["--skip", REAL_TIME]),
            Which::RealTime => command.args([REAL_TIME, "--test-threads", REAL_TIME_AT_ONCE]),
        };
        println!("> {}", test.program.display());
        if !prepare(&mut command, compiled)?
            .current_dir(&test.folder)
            .status()?
            .success()
        {
            failed.push(test.program.display().to_string());
        }
    }
    if !failed.is_empty() {
        bail!("tests failed in: {}", failed.join(", "));
    }
    Ok(())
}

/// Tells a test where the program and the plugins are. Also fixes the seed of property tests, so that only a change
/// decides whether it passes; `PROPTEST_RNG_SEED` selects another seed.
pub(crate) fn prepare<'a>(command: &'a mut Command, compiled: &Compiled) -> Result<&'a mut Command> {
    if std::env::var_os(SEED).is_none() {
        command.env(SEED, "20261121");
    }
    let program: &Path = &compiled.programs;
    command.env("BACKSEAT_TEST_PROGRAM", program.join("backseat"));
    command.env("BACKSEAT_TEST_SEA_PROGRAM", root()?.join(sea::program()?));
    Ok(command.env("BACKSEAT_TEST_PLUGINS", plugins::folder()?))
}
