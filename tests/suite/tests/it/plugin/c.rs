//! A plugin in C, which nothing of this project has compiled: the boundary is the interface alone.

use std::fs;
use std::path::PathBuf;

use backseat_suite::Backseat;
use backseat_test_support::workspace;
use serde_json::Value;
use sha2::{Digest as _, Sha256};

use super::plugin;

fn folder() -> PathBuf {
    workspace().join("plugins/c")
}

#[test]
fn its_component_is_of_its_source() {
    let hashes = fs::read_to_string(folder().join("steady.sha256")).unwrap();
    let mut names = Vec::new();
    for line in hashes.lines() {
        let (expected, name) = line.split_once("  ").unwrap();
        let hash = Sha256::digest(fs::read(folder().join(name)).unwrap());
        let hash: String = hash.iter().map(|byte| format!("{byte:02x}")).collect();
        assert_eq!(
            hash, expected,
            "{name} has changed: build it anew, as plugins/c/README.md says"
        );
        names.push(name);
    }
    assert_eq!(names, ["steady.c", "steady.wasm"]);
}

#[test]
fn it_imports_nothing_of_wasi() {
    let said = plugin(&folder(), &["inspect", "steady.wasm", "--json"])
        .run()
        .exit(0)
        .json();
    assert_eq!(said["wasi"], Value::Array(vec![]), "{said}");
    let imports = said["imports"].as_array().unwrap();
    let ours = |import: &Value| import.as_str().unwrap().starts_with("backseat:plugin/");
    assert!(!imports.is_empty() && imports.iter().all(ours), "{said}");
}

#[test]
fn it_flies_and_its_dive_is_replayed_to_the_bit() {
    let scratch = tempfile::tempdir().unwrap();
    let log = scratch.path().join("dive.mcap");
    let sim = |arguments: &[&str]| {
        let flight = Backseat::new()
            .args(["sim", "--json", "--seed", "3"])
            .args(arguments.iter().copied());
        flight.arg(folder().join("mission")).run()
    };
    let flown = sim(&["--log", log.to_str().unwrap()]).exit(0).json();
    assert_eq!(
        (&flown["unmet"], &flown["violations"]),
        (&Value::Array(vec![]), &Value::Array(vec![]))
    );
    assert!(flown["requests"]["accepted"].as_u64() > Some(200), "{flown}");
    assert_eq!(flown["faults"], 0, "{flown}");
    let replayed = Backseat::new()
        .args(["replay", "--json"])
        .arg(&log)
        .run()
        .exit(0)
        .json();
    assert_eq!(replayed["identical"], true, "{replayed}");
    for (set, told) in [
        ("plugin.steady.config.deep_m=3.0", "unknown key `deep_m`"),
        ("plugin.steady.config.depth_m=\"ten\"", "depth_m: expected a number"),
        (
            "plugin.steady.config.depth_m=-1.0",
            "depth_m: -1.0 is not within 0 to 12000",
        ),
    ] {
        let refused = sim(&["--set", set]).exit(2);
        assert!(refused.stderr.contains(told), "{refused}");
        assert_eq!(refused.stderr.lines().count(), 1, "{refused}");
    }
}
