use std::path::PathBuf;
use std::process::Command;

use anyhow::Result;

use crate::cargo::{add_target, cargo, cargo_test, root, run, target};
use crate::tidy::tidy;

const PLUGINS: [&str; 5] = ["isobath", "plume", "template", "faulty", "prober"];

/// The first of the README's two commands.
pub(crate) fn demo() -> Result<()> {
    let program = release()?;
    plugins()?;
    let target = target()?;
    let (log, map) = (target.join("demo/isobath.mcap"), target.join("demo/isobath.svg"));
    std::fs::create_dir_all(target.join("demo"))?;
    println!("> backseat sim missions/isobath");
    run(Command::new(program)
        .args(["sim", "missions/isobath", "--plugins"])
        .arg(target.join("plugins"))
        .arg("--log")
        .arg(&log)
        .arg("--map")
        .arg(&map))?;
    println!("\nThe picture of the dive, for any browser: {}", map.display());
    println!("Its log, for Foxglove or Python's mcap:   {}", log.display());
    Ok(())
}

/// The second of the README's two commands: everything.
pub(crate) fn test() -> Result<()> {
    cargo(&["fmt", "--all", "--check"])?;
    tidy()?;
    plugins()?;
    cargo(&[
        "clippy",
        "--workspace",
        "--all-targets",
        "--quiet",
        "--",
        "--deny",
        "warnings",
    ])?;
    cargo_test(&["test", "--workspace", "--quiet", "--no-fail-fast"])
}

/// Builds the project's plugins and makes components of them.
pub(crate) fn plugins() -> Result<()> {
    add_target("wasm32-unknown-unknown")?;
    let folder = target()?.join("plugins");
    let built = backseat_componentize::build(&root()?, &PLUGINS, &folder)?;
    for component in built {
        println!("plugin {}", component.display());
    }
    Ok(())
}

/// Prints the speed table.
pub(crate) fn bench() -> Result<()> {
    plugins()?;
    cargo(&["bench", "--package", "backseat-bench"])
}

/// The program, built for release.
pub(crate) fn release() -> Result<PathBuf> {
    cargo(&["build", "--release", "--package", "backseat"])?;
    Ok(target()?.join("release/backseat"))
}
