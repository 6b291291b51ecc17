//! What tests and benchmarks share: where the project is, and its plugins, built once a process.

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

/// The project's plugins, in the packages that hold them.
const PLUGINS: [&str; 4] = ["isobath", "plume", "template", "faulty"];

/// The workspace's folder.
#[must_use]
pub fn workspace() -> &'static Path {
    static FOLDER: OnceLock<PathBuf> = OnceLock::new();
    FOLDER.get_or_init(|| {
        let here = Path::new(env!("CARGO_MANIFEST_DIR"));
        here.ancestors().nth(2).expect("this crate lies two folders below the workspace").to_path_buf()
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
