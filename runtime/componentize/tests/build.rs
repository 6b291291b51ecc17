//! Builds real plugin crates: the template here, in another folder, and in a crate outside of any workspace.

#![expect(
    clippy::unwrap_used,
    reason = "the lint knows only test functions as tests, not what they call"
)]

use std::fs;
use std::path::{Path, PathBuf};

use backseat_componentize::{Error, build};

fn workspace() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .join("../..")
        .canonicalize()
        .unwrap()
}

/// A folder of this test's own, empty but for what an earlier run's cargo may use again.
fn folder(name: &str) -> PathBuf {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    fs::create_dir_all(&folder).unwrap();
    folder
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
    let here = build(&workspace(), &["template"], &folder("here")).unwrap();
    let here = fs::read(&here[0]).unwrap();

    let elsewhere = folder("elsewhere/on the disk");
    for part in ["Cargo.lock", "wit", "runtime/units", "plugins/sdk", "plugins/template"] {
        fs::create_dir_all(elsewhere.join(part).parent().unwrap()).unwrap();
        copy(&workspace().join(part), &elsewhere.join(part));
    }
    let manifest = fs::read_to_string(workspace().join("Cargo.toml")).unwrap();
    let (head, rest) = manifest.split_once("members = [").unwrap();
    let (_, rest) = rest.split_once(']').unwrap();
    let members = r#"members = ["runtime/units", "plugins/sdk", "plugins/template"]"#;
    fs::write(
        elsewhere.join("Cargo.toml"),
        format!("{head}{members}{rest}").replace("exclude", "# exclude"),
    )
    .unwrap();
    let there = build(&elsewhere, &["template"], &folder("there")).unwrap();
    let there = fs::read(&there[0]).unwrap();

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
    let paths = build(&crate_dir, &[], &folder("lone/out")).unwrap();
    assert_eq!(paths, [folder("lone/out").join("lone-plugin.wasm")]);
    let component = fs::read(&paths[0]).unwrap();
    assert_eq!(component[..8], *b"\0asm\x0d\0\x01\0");
    assert!(!contains(&component, workspace().to_str().unwrap()));
}

#[test]
fn a_package_that_is_no_plugin_is_an_error() {
    let error = build(&workspace(), &["backseat-units"], &folder("none")).unwrap_err();
    assert!(matches!(error, Error::NoModule(_)), "{error}");
    assert!(error.to_string().contains("crate-type"), "{error}");
}
