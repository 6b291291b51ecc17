use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail};

use crate::cargo::{root, run, target};
use crate::steps::Steps;

/// Makes Debian packages.
const CARGO_DEB: (&str, &str) = ("cargo-deb", "3.8.0");
/// The unit, from the root of the workspace.
const UNIT: &str = "runtime/docs/backseat.service";
/// What `systemd-analyze security` says at most, in tenths.
const EXPOSURE_MAX: &str = "20";

/// Builds a Debian package of the program for sea: with its unit, man pages and completions.
pub(crate) fn package() -> Result<()> {
    let mut steps = Steps::default();
    let result = package_in(&mut steps);
    steps.show();
    println!("package: {}", result?.display());
    Ok(())
}

fn package_in(steps: &mut Steps) -> Result<PathBuf> {
    let folder = target()?.join("package");
    std::fs::create_dir_all(&folder)?;
    let program = steps.run("compile the program for sea", || {
        let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
        run(Command::new(cargo)
            .args(["build", "--release", "--locked", "--package", "backseat"])
            .args(["--no-default-features", "--features", "sea,console"])
            .current_dir(root()?))?;
        Ok(target()?.join("release/backseat"))
    })?;
    steps.run("man pages and completions", || {
        run(Command::new(&program).arg("generate").arg(&folder))
    })?;
    steps.run("the unit", || unit(&folder))?;
    let deb = steps.run("cargo-deb", || tool(CARGO_DEB))?;
    steps.run("the package", || {
        let out = folder.join("backseat.deb");
        run(Command::new(deb)
            .args(["--no-build", "--package", "backseat", "--output"])
            .arg(&out)
            .current_dir(root()?))?;
        Ok(out)
    })
}

/// The unit with the package's paths, if it is hardened as it should be.
fn unit(folder: &Path) -> Result<()> {
    let text = std::fs::read_to_string(root()?.join(UNIT)).with_context(|| UNIT.to_owned())?;
    let path = folder.join("backseat.service");
    std::fs::write(&path, text.replace("/usr/local/", "/usr/"))?;
    let judged = Command::new("systemd-analyze")
        .args(["security", "--offline=true", "--no-pager", "--threshold", EXPOSURE_MAX])
        .arg(&path)
        .output();
    match judged {
        Ok(output) => {
            let text = String::from_utf8_lossy(&output.stdout);
            println!("{}", text.lines().last().unwrap_or_default().trim());
            if !output.status.success() {
                bail!("{UNIT}: systemd-analyze security finds more than {EXPOSURE_MAX} tenths of exposure");
            }
        }
        // A computer without systemd can make the package all the same.
        Err(error) => println!("systemd-analyze: {error}: the unit was not judged"),
    }
    Ok(())
}

/// A tool from crates.io, installed once beside what is built.
fn tool((name, version): (&str, &str)) -> Result<PathBuf> {
    let folder = target()?.join("tools").join(format!("{name}-{version}"));
    let program = folder.join("bin").join(name);
    if !program.is_file() {
        println!("> cargo install {name} --version {version}");
        let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
        run(Command::new(cargo)
            .args(["install", "--locked", "--quiet", name, "--version", version, "--root"])
            .arg(&folder))?;
    }
    Ok(program)
}
