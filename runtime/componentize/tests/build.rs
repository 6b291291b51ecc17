//! Builds real plugin crates: the template here, in another folder, and in a crate outside of any workspace.

#![expect(
    clippy::unwrap_used,
    reason = "the lint exempts test functions only, not the functions that they call"
)]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

fn workspace() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../..")
        .canonicalize()
        .unwrap()
}

/// A folder for this test, empty except for what an earlier run's cargo may reuse.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    fs::create_dir_all(&folder).unwrap();
    folder
}

/// Runs the program with the workspace's target folder, so that crates from the registry are compiled once for all.
fn componentize(from: &Path, out: &Path, packages: &[&str]) -> Output {
    let target = Path::new(env!("CARGO_TARGET_TMPDIR")).parent().unwrap();
    Command::new(env!("CARGO_BIN_EXE_backseat-componentize"))
        .args([from, out])
        .args(packages)
        .env("CARGO_TARGET_DIR", target)
        .output()
        .unwrap()
}

/// The component that the program builds from this package.
fn built(from: &Path, out: &Path, package: &str) -> Vec<u8> {
    let output = componentize(from, out, &[package]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let path = out.join(format!("{package}.wasm"));
    assert_eq!(
        String::from_utf8_lossy(&output.stdout),
        format!("plugin {}\n", path.display())
    );
    fs::read(&path).unwrap()
}

fn copy(from: &Path, to: &Path) {
    if from.is_dir() {
        fs::create_dir_all(to).unwrap();
        for entry in fs::read_dir(from).unwrap() {
            let entry = entry.unwrap();
            copy(&entry.path(), &to.join(entry.file_name()));
        }
    } else {
        fs::copy(from, to).unwrap();
    }
}

fn contains(bytes: &[u8], part: &str) -> bool {
    bytes.windows(part.len()).any(|window| window == part.as_bytes())
}

#[test]
fn the_same_source_gives_the_same_component_wherever_it_is() {
    let here = built(&workspace(), &folder("here"), "template");

    let elsewhere = folder("elsewhere/on the disk");
    // The SDK's own tests hear a simulated sea.
    let members = [
        "runtime/units",
        "runtime/world",
        "runtime/acoustics",
        "plugins/sdk",
        "plugins/template",
    ];
    for part in ["Cargo.lock", "wit"].iter().chain(&members) {
        fs::create_dir_all(elsewhere.join(part).parent().unwrap()).unwrap();
        copy(&workspace().join(part), &elsewhere.join(part));
    }
    let manifest = fs::read_to_string(workspace().join("Cargo.toml")).unwrap();
    let (head, rest) = manifest.split_once("members = [").unwrap();
    let (_, rest) = rest.split_once(']').unwrap();
    fs::write(
        elsewhere.join("Cargo.toml"),
        format!("{head}members = {members:?}{rest}").replace("exclude", "# exclude"),
    )
    .unwrap();
    // If no package is named, the workspace's plugins are built.
    let output = componentize(&elsewhere, &folder("there"), &[]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let there = fs::read(folder("there").join("template.wasm")).unwrap();

    assert!(here == there, "{} and {} bytes that differ", here.len(), there.len());
    let home = std::env::home_dir().unwrap();
    for machine in [&workspace(), &home.join(".cargo"), &home.join(".rustup")] {
        assert!(!contains(&here, machine.to_str().unwrap()), "{}", machine.display());
    }
}

#[test]
fn a_crate_outside_of_the_workspace_is_built_too() {
    let crate_dir = folder("lone");
    let sdk = workspace().join("plugins/sdk");
    let manifest = format!(
        r#"[package]
        name = "lone-plugin"
        version = "0.1.0"
        edition = "2024"
        [lib]
        crate-type = ["cdylib", "rlib"]
        [dependencies]
        backseat-sdk = {{ path = {sdk:?} }}
        serde = {{ version = "1", features = ["derive"] }}
        [workspace]"#
    );
    fs::write(crate_dir.join("Cargo.toml"), manifest).unwrap();
    copy(&workspace().join("Cargo.lock"), &crate_dir.join("Cargo.lock"));
    copy(&workspace().join("plugins/template/src"), &crate_dir.join("src"));
    let component = built(&crate_dir, &folder("lone/out"), "lone-plugin");
    assert_eq!(component[..8], *b"\0asm\x0d\0\x01\0");
    assert!(!contains(&component, workspace().to_str().unwrap()));
}

#[test]
fn a_package_that_is_no_plugin_is_an_error() {
    let output = componentize(&workspace(), &folder("none"), &["backseat-units"]);
    let error = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{error}");
    let last = error.lines().last().unwrap();
    assert!(
        last.contains("package backseat-units has no module") && last.contains("crate-type"),
        "{error}"
    );
}
