//! What tests and benchmarks share: where the project is, its program and its plugins.
//!
//! `cargo xtask` builds both before the tests and says where they are (`BACKSEAT_TEST_PROGRAM`, `BACKSEAT_TEST_PLUGINS`).
//! Where it does not, under `cargo test` by hand, each test program builds them once.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

/// The workspace's folder.
#[must_use]
pub fn workspace() -> &'static Path {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER.get_or_init(|| {
        let here = Path::new(env!("CARGO_MANIFEST_DIR"));
        here.ancestors()
            .nth(2)
            .expect("this crate lies two folders below the workspace")
            .to_path_buf()
    })
}

/// A mission of the project.
#[must_use]
pub fn mission(name: &str) -> PathBuf {
    workspace().join("missions").join(name)
}

/// The folder with the project's plugins as components, built from what is in the tree: every package in the folder
/// `plugins` that is one.
///
/// # Panics
/// Where they cannot be built; the message says why.
#[must_use]
pub fn plugins() -> &'static Path {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER.get_or_init(|| {
        if let Some(folder) = std::env::var_os("BACKSEAT_TEST_PLUGINS") {
            return folder.into();
        }
        let target = std::env::var_os("CARGO_TARGET_DIR")
            .map_or_else(|| workspace().join("target"), |target| workspace().join(target));
        let folder = target.join("plugins");
        let built = backseat_componentize::plugins(workspace()).and_then(|packages| {
            let packages: Vec<&str> = packages.iter().map(String::as_str).collect();
            backseat_componentize::build(workspace(), &packages, &folder)
        });
        match built {
            Ok(_) => folder,
            Err(error) => panic!("the plugins cannot be built: {error}"),
        }
    })
}

/// The program `backseat`, built from what is in the tree, in the target folder and with the profile of the test that
/// asks. (Cargo tells a test where a program is only where both are of one package.)
///
/// # Panics
/// Where it cannot be built; the message says why.
#[must_use]
pub fn program() -> &'static Path {
    static PROGRAM: OnceLock<PathBuf> = OnceLock::new();
    PROGRAM.get_or_init(|| match std::env::var_os("BACKSEAT_TEST_PROGRAM") {
        Some(program) => program.into(),
        None => build("backseat").join("backseat"),
    })
}

/// The program as it goes to sea, without the simulation, in the same way. Built by hand it has a target folder of its own,
/// beside that of the test, for both programs have one name.
///
/// # Panics
/// Where it cannot be built; the message says why.
#[must_use]
pub fn sea_program() -> &'static Path {
    static PROGRAM: OnceLock<PathBuf> = OnceLock::new();
    PROGRAM.get_or_init(|| match std::env::var_os("BACKSEAT_TEST_SEA_PROGRAM") {
        Some(program) => program.into(),
        None => build_in("backseat", &["--no-default-features", "--features", "sea"], Some("sea")).join("backseat"),
    })
}

/// The program that builds plugins. It lies beside the program.
///
/// # Panics
/// Where it cannot be built; the message says why.
#[must_use]
pub fn componentize() -> &'static Path {
    static PROGRAM: OnceLock<PathBuf> = OnceLock::new();
    PROGRAM.get_or_init(|| {
        let name = "backseat-componentize";
        match std::env::var_os("BACKSEAT_TEST_PROGRAM") {
            Some(program) => Path::new(&program).with_file_name(name),
            None => build(name).join(name),
        }
    })
}

/// The library of `tests/stall`, which makes files hang for a program that loads it. It lies beside the program.
///
/// # Panics
/// Where it cannot be built; the message says why.
#[must_use]
pub fn stall() -> &'static Path {
    static LIBRARY: OnceLock<PathBuf> = OnceLock::new();
    LIBRARY.get_or_init(|| {
        let name = "libbackseat_stall.so";
        let library = match std::env::var_os("BACKSEAT_TEST_PROGRAM") {
            Some(program) => Path::new(&program).with_file_name(name),
            None => build("backseat-stall").join(name),
        };
        // The loader goes on without a library that it does not find, and the test would show nothing.
        assert!(
            library.is_file(),
            "{}: not there; `cargo build --package backseat-stall` builds it",
            library.display()
        );
        library
    })
}

/// Builds a package in the target folder and with the profile of the program that asks. Gives the folder with what it built.
fn build(package: &str) -> PathBuf {
    build_in(package, &[], None)
}

/// The same with more arguments, and in a folder of the target folder where one is given.
fn build_in(package: &str, arguments: &[&str], own: Option<&str>) -> PathBuf {
    // TARGET/PROFILE/deps/TEST, or one folder less where the test is a program itself.
    let test = std::env::current_exe().expect("a running program has a path");
    let folder = test
        .ancestors()
        .skip(1)
        .find(|folder| !folder.ends_with("deps"))
        .expect("a program lies in a folder");
    let name = folder.file_name().map_or("debug".into(), |name| name.to_string_lossy());
    let profile = if name == "debug" { "dev" } else { &name };
    let target = folder.parent().expect("a profile's folder lies in the target folder");
    let target = own.map_or_else(|| target.to_path_buf(), |own| target.join(own));
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let built = Command::new(cargo)
        .args(["build", "--quiet", "--package", package, "--profile", profile])
        .arg("--target-dir")
        .arg(&target)
        .args(arguments)
        .current_dir(workspace())
        .status();
    match built {
        Ok(status) if status.success() => target.join(&*name),
        Ok(status) => panic!("{package} cannot be built: cargo ended with {status}"),
        Err(error) => panic!("{package} cannot be built: cargo does not start: {error}"),
    }
}
