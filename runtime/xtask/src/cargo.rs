use std::env;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail};

/// The workspace's folder.
pub(crate) fn root() -> Result<PathBuf> {
    // As Cargo runs it, because two checkouts that share a target folder share the program too.
    let here =
        env::var_os("CARGO_MANIFEST_DIR").map_or_else(|| PathBuf::from(env!("CARGO_MANIFEST_DIR")), PathBuf::from);
    let root = here
        .ancestors()
        .nth(2)
        .context("xtask lies two folders below the workspace")?;
    Ok(root.to_path_buf())
}

/// The folder in which Cargo builds.
pub(crate) fn target() -> Result<PathBuf> {
    let root = root()?;
    let set = env::var_os("CARGO_TARGET_DIR").or_else(|| env::var_os("CARGO_BUILD_TARGET_DIR"));
    Ok(set.map_or_else(|| root.join("target"), |target| root.join(target)))
}

/// Runs Cargo in the workspace, and fails if it fails.
pub(crate) fn cargo(arguments: &[&str]) -> Result<()> {
    run(&mut cargo_command(arguments))
}

/// Prints and returns a command of Cargo.
pub(crate) fn cargo_command(arguments: &[&str]) -> Command {
    println!("> cargo {}", arguments.join(" "));
    let mut command = Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    // Programs are expected in the folder that Cargo uses for this machine.
    command.args(arguments).env_remove("CARGO_BUILD_TARGET");
    command
}

/// The program, without the user's environment variables for it, so that missions are flown as they are in the tree. It
/// keeps compiled plugins in the target folder, as the tests do.
pub(crate) fn backseat(program: &Path) -> Command {
    let mut command = Command::new(program);
    for (name, _) in env::vars_os() {
        if name.to_string_lossy().starts_with("BACKSEAT") {
            command.env_remove(name);
        }
    }
    if let Ok(target) = target() {
        command.env("BACKSEAT_CACHE", target.join("plugin-cache"));
    }
    command
}

/// Runs a command in its folder, or else in the workspace, and fails if it fails.
pub(crate) fn run(command: &mut Command) -> Result<()> {
    if command.get_current_dir().is_none() {
        command.current_dir(root()?);
    }
    let status = command.status().with_context(|| format!("{command:?}"))?;
    if !status.success() {
        bail!("{command:?} ended with {status}");
    }
    Ok(())
}

/// Lets rustup add a target's standard library if it is missing. Without rustup, the build reports what is missing.
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
        .with_context(|| format!("add it with `rustup target add {target}` on a machine with a network"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_command_runs_in_its_own_folder_if_it_has_one() {
        let folder = tempfile::tempdir().unwrap();
        let place = |command: &mut Command, name: &str| {
            let told = folder.path().join(name);
            run(command.args(["-c", "pwd -P > \"$0\""]).arg(&told)).unwrap();
            PathBuf::from(std::fs::read_to_string(told).unwrap().trim_end())
        };
        let own = place(Command::new("sh").current_dir(folder.path()), "own");
        assert_eq!(own, folder.path().canonicalize().unwrap());
        let workspace = place(&mut Command::new("sh"), "workspace");
        assert_eq!(workspace, root().unwrap().canonicalize().unwrap());
    }
}
