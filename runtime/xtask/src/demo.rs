use std::path::PathBuf;

use anyhow::Result;

use crate::cargo::{backseat, cargo, run, target};
use crate::plugins;
use crate::steps::Steps;

/// The first of the README's two commands.
pub(crate) fn demo() -> Result<()> {
    let mut steps = Steps::default();
    steps.run("compile the program", || release().map(|_| ()))?;
    steps.run("compile the plugins", plugins::plugins)?;
    steps.run("fly", fly)?;
    steps.show();
    Ok(())
}

fn fly() -> Result<()> {
    let target = target()?;
    let (log, map) = (target.join("demo/isobath.mcap"), target.join("demo/isobath.svg"));
    std::fs::create_dir_all(target.join("demo"))?;
    println!("> backseat sim missions/isobath");
    run(backseat(&target.join("release/backseat"))
        .args(["sim", "missions/isobath", "--plugins"])
        .arg(plugins::folder()?)
        .arg("--log")
        .arg(&log)
        .arg("--map")
        .arg(&map))?;
    println!("\nThe picture of the dive, for any browser: {}", map.display());
    println!("Its log, for Foxglove or Python's mcap:   {}", log.display());
    Ok(())
}

/// Prints the speed table.
pub(crate) fn bench() -> Result<()> {
    plugins::plugins()?;
    // One of the benchmarks runs the program.
    let _program = release()?;
    cargo(&["bench", "--package", "backseat-bench"])
}

/// The program, built for release together with the one that builds plugins, so that their common dependencies are
/// compiled once.
pub(crate) fn release() -> Result<PathBuf> {
    cargo(&[
        "build",
        "--release",
        "--package",
        "backseat",
        "--package",
        "backseat-componentize",
    ])?;
    Ok(target()?.join("release/backseat"))
}
