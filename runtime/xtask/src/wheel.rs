use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result};

use crate::cargo::{root, run, target};
use crate::cross::python as environment;
use crate::plugins;
use crate::steps::Steps;

/// What builds the wheel. `runtime/python/pyproject.toml` names the same version.
const BUILDER: [&str; 1] = ["maturin==1.16.0"];
/// What the package works with, and what its tests need.
const PACKAGES: [&str; 11] = [
    "pyarrow==26.0.1",
    "pandas==3.1.1",
    "polars==2.1.0",
    "duckdb==2.0.1",
    "xarray==2026.9.0",
    "scipy==1.17.1",
    "matplotlib==3.11.2",
    "nbformat==5.11.1",
    "nbclient==0.11.0",
    "ipykernel==7.4.0",
    "pytest==9.2.0",
];
/// The package, from the root of the workspace.
const PACKAGE: &str = "runtime/python";

/// Builds the wheel of the package `backseat`, and tests it in an environment that has nothing else of this project.
pub(crate) fn wheel(steps: &mut Steps, program: &Path) -> Result<()> {
    let wheel = steps.run("compile the package for Python", build)?;
    let interpreter = environment("python-package", &PACKAGES)?.join("python");
    steps.run("compile the plugins in Rust", plugins::plugins)?;
    steps.run("tests of the package, with its notebook", || {
        test(&interpreter, &wheel, program)
    })
}

/// The wheel for this computer.
fn build() -> Result<PathBuf> {
    let maturin = environment("maturin", &BUILDER)?.join("maturin");
    let wheels = target()?.join("wheels");
    // Of an earlier build, maybe of another version.
    if wheels.exists() {
        std::fs::remove_dir_all(&wheels)?;
    }
    let manifest = root()?.join(PACKAGE).join("Cargo.toml");
    println!("> maturin build --release --manifest-path {PACKAGE}/Cargo.toml");
    run(Command::new(maturin)
        .args([
            "build",
            "--release",
            "--locked",
            "--compatibility",
            "linux",
            "--manifest-path",
        ])
        .arg(manifest)
        .arg("--out")
        .arg(&wheels))?;
    let mut built = std::fs::read_dir(&wheels)?.filter_map(|entry| Some(entry.ok()?.path()));
    built
        .find(|path| path.extension().is_some_and(|extension| extension == "whl"))
        .with_context(|| format!("maturin left no wheel in {}", wheels.display()))
}

/// Runs the package's tests, without leaving files in the tree.
fn test(interpreter: &Path, wheel: &Path, program: &Path) -> Result<()> {
    println!("> pip install {}", wheel.display());
    run(Command::new(interpreter)
        .args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check"])
        .args(["--force-reinstall", "--no-deps", "--no-index"])
        .arg(wheel))?;
    println!("> pytest {PACKAGE}/tests");
    let folder = root()?.join(PACKAGE);
    let mut command = Command::new(interpreter);
    command.args(["-B", "-m", "pytest", "-q", "-p", "no:cacheprovider", "--rootdir"]);
    command.arg(&folder).arg(folder.join("tests"));
    run(command
        .env("BACKSEAT_TEST_PROGRAM", program)
        .env("BACKSEAT_PLUGINS", plugins::folder()?)
        .env("BACKSEAT_CACHE", target()?.join("plugin-cache"))
        .env("PYTHONDONTWRITEBYTECODE", "1"))
}
