//! The paths that tests and benchmarks need: the project, its program and its plugins.
//!
//! `cargo xtask` builds program and plugins before the tests, and passes their paths in `BACKSEAT_TEST_PROGRAM` and
//! `BACKSEAT_TEST_PLUGINS`. Without these, as with plain `cargo test`, each test program builds them once.

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

/// The folder of one of the project's missions.
#[must_use]
pub fn mission(name: &str) -> PathBuf {
    workspace().join("missions").join(name)
}

/// The folder with the project's plugins as components, built from the tree: every package in the folder `plugins` that
/// is a plugin.
///
/// # Panics
///
/// If they cannot be built; the message has the reason.
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

/// The folder in which tests keep compiled plugins, beside [`plugins`]: not the user's. (A test of the cache has a folder
/// of its own.)
#[must_use]
pub fn cache() -> PathBuf {
    plugins().with_file_name("plugin-cache")
}

/// The room for logs that `check` and `doctor` ask for in tests (`BACKSEAT_LOG_ROOM`), so that what they find does not
/// depend on how full the machine's disk is.
pub const LOG_ROOM: &str = "1MB";

/// The program `backseat`, built from the tree, in the target folder and with the profile of the calling test. (Cargo
/// only tells a test where a program is if both are in the same package.)
///
/// # Panics
///
/// If it cannot be built; the message has the reason.
#[must_use]
pub fn program() -> &'static Path {
    static PROGRAM: OnceLock<PathBuf> = OnceLock::new();
    PROGRAM.get_or_init(|| match std::env::var_os("BACKSEAT_TEST_PROGRAM") {
        Some(program) => program.into(),
        None => build("backseat").join("backseat"),
    })
}

/// The same for the program for sea, without the simulation. Without `cargo xtask` it is built in a separate target
/// folder beside the test's, because both programs have the same name.
///
/// # Panics
///
/// If it cannot be built; the message has the reason.
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
///
/// If it cannot be built; the message has the reason.
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

/// The library of `tests/stall`, which makes files hang for a program that loads it. It is in the folder of the
/// program.
///
/// # Panics
///
/// If it cannot be built; the message has the reason.
#[must_use]
pub fn stall() -> &'static Path {
    static LIBRARY: OnceLock<PathBuf> = OnceLock::new();
    LIBRARY.get_or_init(|| {
        let name = "libbackseat_stall.so";
        let library = match std::env::var_os("BACKSEAT_TEST_PROGRAM") {
            Some(program) => Path::new(&program).with_file_name(name),
            None => build("backseat-stall").join(name),
        };
        // The loader ignores a library that it does not find, and the test would then show nothing.
        assert!(
            library.is_file(),
            "{}: not found; `cargo build --package backseat-stall` builds it",
            library.display()
        );
        library
    })
}

/// Builds a package in the target folder and with the profile of the calling program. Returns the folder with the
/// result.
fn build(package: &str) -> PathBuf {
    build_in(package, &[], None)
}

/// The same with more arguments, and in a subfolder of the target folder if one is given.
fn build_in(package: &str, arguments: &[&str], own: Option<&str>) -> PathBuf {
    // The path is TARGET/PROFILE/deps/TEST, or one folder less if the test is a program itself.
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
