use std::env;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail};

/// The workspace's folder.
pub(crate) fn root() -> Result<PathBuf> {
    // As Cargo runs it: two checkouts that share a target folder share the program too.
    let here =
        env::var_os("CARGO_MANIFEST_DIR").map_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")), PathBuf::from);
    let root = here
        .ancestors()
        .nth(2)
        .context("xtask lies two folders below the workspace")?;
    Ok(root.to_path_buf())
}

/// Where Cargo builds.
pub(crate) fn target() -> Result<PathBuf> {
    let root = root()?;
    let set = env::var_os("CARGO_TARGET_DIR").or_else(|| env::var_os("CARGO_BUILD_TARGET_DIR"));
    Ok(set.map_or_else(|| root.join("target"), |target| root.join(target)))
}

/// Runs Cargo in the workspace; its failure is ours.
pub(crate) fn cargo(arguments: &[&str]) -> Result<()> {
    run(&mut cargo_command(arguments))
}

/// A command of Cargo's, which is told.
pub(crate) fn cargo_command(arguments: &[&str]) -> Command {
    println!("> cargo {}", arguments.join(" "));
    let mut command = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    // Programs are looked for where Cargo puts them for this machine.
    command.args(arguments).env_remove("CARGO_BUILD_TARGET");
    command
}

/// The program, without what the user's environment sets for it: what is flown here is flown as it stands in the tree.
pub(crate) fn backseat(program: &Path) -> Command {
    let mut command = Command::new(program);
    for (name, _) in env::vars_os() {
        if name.to_string_lossy().starts_with("BACKSEAT") {
            command.env_remove(name);
        }
    }
    command
}

/// Runs a command in the workspace; its failure is ours.
pub(crate) fn run(command: &mut Command) -> Result<()> {
    let status = command
        .current_dir(root()?)
        .status()
        .with_context(|| format!("{command:?}"))?;
    if !status.success() {
        bail!("{command:?} ended with {status}");
    }
    Ok(())
}

/// Rustup adds a target's standard library where it is missing. Without rustup the build itself says what is missing.
pub(crate) fn add_target(target: &str) -> Result<()> {
    let installed = Command::new("rustup")
        .args(["target", "list", "--installed"])
        .current_dir(root()?)
        .output();
    let Ok(installed) = installed else { return Ok(()) };
    if String::from_utf8_lossy(&installed.stdout)
        .lines()
        .any(|line| line == target)
    {
        return Ok(());
    }
    println!("> rustup target add {target}");
    run(Command::new("rustup").args(["target", "add", target]))
        .with_context(|| format!("add it by `rustup target add {target}` where the network allows"))
}
