use std::env;
use std::ffi::OsString;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail, ensure};
use clap::Args;
use sha2::{Digest as _, Sha256};

use crate::cargo::{add_target, root, run, target};
use crate::cross::zig_first;
use crate::steps::Steps;

/// Tools of crates.io: makes Debian packages, puts the list of dependencies into the program, writes it as a file.
const CARGO_DEB: (&str, &str) = ("cargo-deb", "3.8.0");
const AUDITABLE: (&str, &str) = ("cargo-auditable", "0.7.7");
const CYCLONEDX: (&str, &str) = ("cargo-cyclonedx", "0.5.9");
/// What is built.
const TARGETS: [Target; 2] = [
    Target {
        name: "x86_64-unknown-linux-musl",
        compiles: "compile for x86_64",
        debian: "amd64",
        packs: "the package for amd64",
    },
    Target {
        name: "aarch64-unknown-linux-musl",
        compiles: "compile for aarch64",
        debian: "arm64",
        packs: "the package for arm64",
    },
];
const FEATURES: [&str; 3] = ["--no-default-features", "--features", "sea,console"];
/// The unit, from the root of the workspace.
const UNIT: &str = "runtime/docs/backseat.service";
/// What `systemd-analyze security` says at most, in tenths.
const EXPOSURE_MAX: &str = "20";

/// A processor. The program is linked statically, so that it runs on every Linux of it.
#[derive(Clone, Copy)]
struct Target {
    name: &'static str,
    compiles: &'static str,
    /// Debian's name of the processor.
    debian: &'static str,
    packs: &'static str,
}

#[derive(Debug, Args)]
pub(crate) struct Package {
    /// Build for this computer's processor once more in another folder, from what is committed, and compare the bytes
    #[arg(long)]
    twice: bool,
    /// Build for this computer's processor alone
    #[arg(long)]
    native: bool,
}

/// Builds the program for sea, and Debian packages of it.
pub(crate) fn package(arguments: &Package) -> Result<()> {
    let mut steps = Steps::default();
    let result = package_in(&mut steps, arguments);
    steps.show();
    println!("packages: {}", result?.display());
    Ok(())
}

fn package_in(steps: &mut Steps, arguments: &Package) -> Result<PathBuf> {
    let folder = target()?.join("package");
    std::fs::create_dir_all(&folder)?;
    let native = native()?;
    let build = Build {
        workspace: root()?,
        target: folder.join("build"),
        path: steps.run("tools", || {
            let mut path = OsString::from(tool(AUDITABLE)?.parent().context("a tool is in a folder")?);
            path.push(":");
            path.push(zig_first()?);
            Ok(path)
        })?,
    };
    let mut made = Vec::new();
    let wanted = || {
        TARGETS
            .into_iter()
            .filter(|target| !arguments.native || target.name == native)
    };
    for Target { name, compiles, .. } in wanted() {
        let program = steps.run(compiles, || build.program(name))?;
        let copy = folder.join(format!("backseat-{name}"));
        std::fs::copy(&program, &copy)?;
        made.push(copy);
        if name == native {
            steps.run("man pages and completions", || {
                run(Command::new(&program).arg("generate").arg(&folder))
            })?;
        }
    }
    steps.run("the unit", || unit(&folder))?;
    made.push(steps.run("the list of what is in it", || list(&folder))?);
    let deb = steps.run("cargo-deb", || tool(CARGO_DEB))?;
    for Target {
        name, debian, packs, ..
    } in wanted()
    {
        made.push(steps.run(packs, || {
            let out = folder.join(format!("backseat_{debian}.deb"));
            run(Command::new(&deb)
                .args([
                    "--no-build",
                    "--no-strip",
                    "--package",
                    "backseat",
                    "--target",
                    name,
                    "--output",
                ])
                .arg(&out)
                .env("CARGO_TARGET_DIR", &build.target)
                .current_dir(root()?))?;
            Ok(out)
        })?);
    }
    if arguments.twice {
        steps.run("compile in another folder", || twice(&build, native, &folder))?;
    }
    let mut sums = String::new();
    for file in &made {
        let name = file.file_name().unwrap_or_default().to_string_lossy();
        writeln!(sums, "{}  {name}", hash(file)?)?;
    }
    print!("{sums}");
    std::fs::write(folder.join("SHA256SUMS"), sums)?;
    Ok(folder)
}

/// The target of this computer's processor.
fn native() -> Result<&'static str> {
    let found = TARGETS.iter().find(|target| target.name.starts_with(env::consts::ARCH));
    Ok(found
        .with_context(|| format!("{}: packages are built on x86_64 or aarch64", env::consts::ARCH))?
        .name)
}

/// How a program is built so that the same sources give the same bytes.
struct Build {
    workspace: PathBuf,
    target: PathBuf,
    /// With the tools first.
    path: OsString,
}

impl Build {
    fn program(&self, name: &str) -> Result<PathBuf> {
        add_target(name)?;
        let home = env::var_os("CARGO_HOME").map(PathBuf::from);
        let home = home.or_else(|| env::home_dir().map(|home| home.join(".cargo")));
        let home = home.context("no home folder")?;
        // Paths of this computer would be in messages of panics, and in what C asserts. Where several fit, the compiler takes
        // the last, and the target folder may be inside the workspace.
        let renamed = [
            (&home, "/cargo"),
            (&self.workspace, "/backseat"),
            (&self.target, "/target"),
        ];
        let flags = |option: &str| {
            let flags = renamed.map(|(from, to)| format!("{option}={}={to}", from.display()));
            flags.join(" ")
        };
        println!("> cargo auditable zigbuild --release --target {name}");
        run(Command::new(env::var_os("CARGO").unwrap_or_else(|| "cargo".into()))
            .args([
                "auditable",
                "zigbuild",
                "--release",
                "--locked",
                "--package",
                "backseat",
            ])
            .args(FEATURES)
            .args(["--target", name])
            .env("PATH", &self.path)
            .env("CARGO_TARGET_DIR", &self.target)
            .env("CARGO_INCREMENTAL", "0")
            .env("CARGO_PROFILE_RELEASE_LTO", "thin")
            .env("CARGO_PROFILE_RELEASE_DEBUG", "false")
            .env("CARGO_PROFILE_RELEASE_STRIP", "symbols")
            .env("RUSTFLAGS", flags("--remap-path-prefix"))
            .env("CFLAGS", flags("-ffile-prefix-map"))
            .env_remove("RUSTC_WORKSPACE_WRAPPER")
            .current_dir(&self.workspace))?;
        Ok(self.target.join(name).join("release/backseat"))
    }
}

/// Builds what is committed in another folder, and compares.
fn twice(build: &Build, name: &str, folder: &Path) -> Result<()> {
    let status = Command::new("git")
        .args(["status", "--porcelain"])
        .current_dir(root()?)
        .output()?;
    ensure!(
        status.status.success() && status.stdout.is_empty(),
        "--twice compares with what is committed: commit first"
    );
    let other = env::temp_dir().join(format!("backseat-again-{}", std::process::id()));
    run(Command::new("git").args(["clone", "--quiet"]).arg(root()?).arg(&other))?;
    let again = Build {
        target: other.join("built-again"),
        workspace: other.clone(),
        path: build.path.clone(),
    };
    let compared = again.program(name).and_then(|program| {
        let (first, second) = (hash(&folder.join(format!("backseat-{name}")))?, hash(&program)?);
        ensure!(
            first == second,
            "the same sources gave {first} and, in {}, {second}",
            other.display()
        );
        println!("the same bytes: {first}");
        Ok(())
    });
    if compared.is_ok() {
        std::fs::remove_dir_all(&other)?;
    }
    compared
}

fn hash(file: &Path) -> Result<String> {
    let bytes = std::fs::read(file).with_context(|| file.display().to_string())?;
    Ok(Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect())
}

/// A list of all that is in the program, in CycloneDX's JSON.
fn list(folder: &Path) -> Result<PathBuf> {
    let program = tool(CYCLONEDX)?;
    let app = root()?.join("runtime/app");
    let name = "backseat-sbom";
    run(Command::new(program)
        .args(["cyclonedx", "--format", "json", "--quiet", "--manifest-path"])
        .arg(app.join("Cargo.toml"))
        .args(FEATURES)
        .args(["--target", native()?, "--override-filename", name]))?;
    // It writes a list beside the manifest of each crate of the workspace.
    let made = app.join(format!("{name}.json"));
    let list = folder.join("backseat.cdx.json");
    std::fs::rename(&made, &list).with_context(|| made.display().to_string())?;
    for rooms in ["runtime", "plugins", "tests"] {
        for crates in std::fs::read_dir(root()?.join(rooms))? {
            let other = crates?.path().join(format!("{name}.json"));
            if other.is_file() {
                std::fs::remove_file(other)?;
            }
        }
    }
    Ok(list)
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
        let cargo = env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
        run(Command::new(cargo)
            .args(["install", "--locked", "--quiet", name, "--version", version, "--root"])
            .arg(&folder)
            .env_remove("RUSTC_WORKSPACE_WRAPPER"))?;
    }
    Ok(program)
}
