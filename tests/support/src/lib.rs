//! What tests and benchmarks share: where the project is, its program and its plugins, built once a process.

use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::OnceLock;

/// The project's plugins, in the packages that hold them.
const PLUGINS: [&str; 5] = ["isobath", "plume", "template", "faulty", "prober"];

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

/// The folder with the project's plugins as components, built from what is in the tree.
///
/// # Panics
/// Where they cannot be built; the message says why.
#[must_use]
pub fn plugins() -> &'static Path {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER.get_or_init(|| {
        let target = std::env::var_os("CARGO_TARGET_DIR")
            .map_or_else(|| workspace().join("target"), |target| workspace().join(target));
        let folder = target.join("plugins");
        match backseat_componentize::build(workspace(), &PLUGINS, &folder) {
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
    PROGRAM.get_or_init(|| {
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
        let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
        let built = Command::new(cargo)
            .args([
                "build",
                "--quiet",
                "--package",
                "backseat",
                "--bin",
                "backseat",
                "--profile",
                profile,
            ])
            .arg("--target-dir")
            .arg(target)
            .current_dir(workspace())
            .status();
        match built {
            Ok(status) if status.success() => folder.join("backseat"),
            Ok(status) => panic!("the program cannot be built: cargo ended with {status}"),
            Err(error) => panic!("the program cannot be built: cargo does not start: {error}"),
        }
    })
}
