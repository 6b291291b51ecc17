use std::env;
use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail};

use crate::cargo::{add_target, run, target};

/// Linked statically, so that the program runs under qemu without a sysroot.
const TARGET: &str = "aarch64-unknown-linux-musl";
/// From PyPI: a C compiler and linker for every platform, and a wrapper that makes Cargo use it.
const PACKAGES: [&str; 2] = ["ziglang==0.17.1", "cargo-zigbuild==0.24.1"];
/// Debian's package of emulators, and the names that they have on a PATH.
const EMULATORS: &str = "qemu-user-static";
const EMULATOR: [&str; 2] = ["qemu-aarch64-static", "qemu-aarch64"];

/// The program for aarch64, built for release.
pub(crate) fn release() -> Result<PathBuf> {
    add_target(TARGET)?;
    let path = zig_first()?;
    println!("> cargo zigbuild --release --package backseat --target {TARGET}");
    run(Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()))
        .args(["zigbuild", "--release", "--package", "backseat", "--target", TARGET])
        .env("PATH", path))?;
    Ok(target()?.join(TARGET).join("release/backseat"))
}

/// A PATH on which `cargo-zigbuild` and its Zig come first.
pub(crate) fn zig_first() -> Result<OsString> {
    let mut path = OsString::from(zig()?);
    if let Some(rest) = env::var_os("PATH") {
        path.push(":");
        path.push(rest);
    }
    Ok(path)
}

/// The folder with `cargo-zigbuild` and its Zig; creates it if it is missing.
fn zig() -> Result<PathBuf> {
    python("zig", &PACKAGES).context("a cross build takes its linker from PyPI")
}

/// The folder with the programs of a Python environment that has these packages of PyPI; creates it if it is missing.
pub(crate) fn python(name: &str, packages: &[&str]) -> Result<PathBuf> {
    let environment = target()?.join("tools").join(name);
    let programs = environment.join("bin");
    // Written last: without it, the environment is not complete, or has other versions.
    let installed = environment.join("packages");
    let wanted = packages.join(" ");
    if std::fs::read_to_string(&installed).is_ok_and(|found| found == wanted) {
        return Ok(programs);
    }
    println!("> python3 -m venv {}", environment.display());
    run(Command::new("python3").args(["-m", "venv"]).arg(&environment)).context("Python 3 with its venv is needed")?;
    println!("> pip install {wanted}");
    run(Command::new(programs.join("python"))
        .args(["-m", "pip", "install", "--quiet", "--disable-pip-version-check"])
        .args(packages))?;
    std::fs::write(&installed, wanted)?;
    Ok(programs)
}

/// The emulator for aarch64 programs; downloaded without root if it is missing.
pub(crate) fn emulator() -> Result<PathBuf> {
    let unpacked = target()?.join("tools/qemu");
    let find = || {
        let path = env::var_os("PATH").unwrap_or_default();
        env::split_paths(&path)
            .chain([unpacked.join("usr/bin")])
            .flat_map(|folder| EMULATOR.map(|name| folder.join(name)))
            .find(|program| program.is_file())
    };
    if let Some(program) = find() {
        return Ok(program);
    }
    if let Err(error) = fetch(&unpacked)
        && find().is_none()
    {
        bail!(
            "{error:#}; install {EMULATORS}, or put {} on the PATH",
            EMULATOR.join(" or ")
        );
    }
    find().with_context(|| format!("{EMULATORS} has no {}", EMULATOR[0]))
}

/// Unpacks Debian's package into a folder of the build.
fn fetch(unpacked: &Path) -> Result<()> {
    let folder = target()?.join("tools/deb");
    std::fs::create_dir_all(&folder)?;
    println!("> apt-get download {EMULATORS}");
    let status = Command::new("apt-get")
        .args(["download", EMULATORS])
        .current_dir(&folder)
        .status()
        .context("no emulator of aarch64, and no apt-get to fetch one")?;
    if !status.success() {
        bail!("no emulator of aarch64, and apt-get ended with {status}");
    }
    for package in std::fs::read_dir(&folder)? {
        run(Command::new("dpkg").arg("-x").arg(package?.path()).arg(unpacked))?;
    }
    std::fs::remove_dir_all(&folder)?;
    Ok(())
}
