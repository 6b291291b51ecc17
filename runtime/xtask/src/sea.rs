use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail};

use crate::cargo::{root, target};
use crate::compile::compile_with;

/// The crates that only simulation needs, those with which people look at a dive ashore, and those that build plugins.
const ASHORE: [&str; 11] = [
    "backseat-acoustics",
    "backseat-componentize",
    "backseat-log-export",
    "backseat-mvc",
    "backseat-world",
    "backseat-oracle",
    "backseat-plc",
    "backseat-plugin-tools",
    "backseat-scenario",
    "backseat-sim",
    "backseat-picture",
];

/// Checks that the program for sea contains no simulator: none of these crates is in its dependency tree.
pub(crate) fn sea(root: &Path, faults: &mut Vec<String>) -> Result<()> {
    let output = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()))
        .args(["tree", "--locked", "--package", "backseat", "--edges", "normal"])
        .args(["--no-default-features", "--features", "sea,console", "--prefix", "none"])
        .current_dir(root)
        .output()
        .context("cargo tree")?;
    if !output.status.success() {
        bail!("cargo tree: {}", String::from_utf8_lossy(&output.stderr).trim());
    }
    let tree = String::from_utf8_lossy(&output.stdout);
    faults.extend(found(&tree).map(|name| format!("runtime/app: {name} is in the program that goes to sea")));
    Ok(())
}

/// The crates of [`ASHORE`] that are in a tree.
fn found(tree: &str) -> impl Iterator<Item = &'static str> {
    let has = |name: &str| {
        tree.lines()
            .any(|line| line.split(' ').next().is_some_and(|found| found == name))
    };
    ASHORE.into_iter().filter(move |name| has(name))
}

/// Where the program for sea is kept for the tests, because Cargo later puts the whole program in its place.
pub(crate) fn program() -> Result<PathBuf> {
    Ok(target()?.join("sea/backseat"))
}

/// Builds the program for sea, with lints, for the tests. Its dependencies have the features of the whole workspace, so
/// that only the program itself is compiled twice.
pub(crate) fn build() -> Result<()> {
    let arguments = [
        "--workspace",
        "--bin",
        "backseat",
        "--no-default-features",
        "--features",
        "backseat/sea,backseat/console",
    ];
    let compiled = compile_with(&arguments)?;
    let program = root()?.join(program()?);
    if let Some(folder) = program.parent() {
        std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    }
    let built = compiled.programs.join("backseat");
    std::fs::copy(&built, &program).with_context(|| built.display().to_string())?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_simulator_in_the_tree_is_found_at_any_depth() {
        let tree = "backseat v0.1.0 (/w/runtime/app)\nbackseat-core v0.1.0 (/w/runtime/core)\nbackseat-spi v0.1.0\n";
        assert_eq!(found(tree).count(), 0);
        let with =
            format!("{tree}backseat-mvc v0.1.0 (/w/runtime/mvc)\nbackseat-world v0.1.0 (/w/runtime/world) (*)\n");
        assert_eq!(found(&with).collect::<Vec<_>>(), ["backseat-mvc", "backseat-world"]);
    }
}
