//! `backseat plugin`, as an author and an operator meet it: in a folder of their own, with nothing of this project.

#![expect(
    clippy::unwrap_used,
    reason = "the lint exempts test functions only, not the functions that they call"
)]

mod admission;
mod c;
mod project;
mod tutorial;

use std::path::{Path, PathBuf};

use backseat_suite::Backseat;

/// `backseat plugin ARGUMENTS` in a folder.
fn plugin(folder: &Path, arguments: &[&str]) -> Backseat {
    Backseat::new()
        .arg("plugin")
        .args(arguments.iter().copied())
        .in_folder(folder)
}

/// The folder of the kit that these tests unpack, once for all of them.
fn kit() -> PathBuf {
    target().join("plugin-kit")
}

/// Where the tests' plugins are compiled. What they have in common is compiled once.
fn target() -> PathBuf {
    backseat_test_support::plugins().parent().unwrap().to_owned()
}

/// A component of this project.
fn built(name: &str) -> PathBuf {
    backseat_test_support::plugins().join(format!("{name}.wasm"))
}
