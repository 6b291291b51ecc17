//! `backseat explain`, and the reference against what the program prints.

use std::collections::BTreeSet;

use backseat_reference::{EXITS, Reference};
use backseat_suite::{Backseat, Mission};
use serde_json::Value;

#[test]
fn a_key_is_explained_with_unit_range_default_and_example() {
    let told = Backseat::new().args(["explain", "turn_rate_dps"]).run().exit(0);
    assert_eq!(told.stderr, "");
    for part in [
        "limits.turn_rate_dps",
        "degrees/s",
        "above 0",
        "required",
        "[limits]",
        "turn_rate_dps = 8.0",
    ] {
        assert!(told.stdout.contains(part), "{part}: {told}");
    }
    // As `--set` and campaigns name it.
    let of_world = Backseat::new()
        .args(["explain", "world.current.speed_mps"])
        .run()
        .exit(0);
    assert!(of_world.stdout.contains("current.speed_mps"), "{of_world}");
    let misspelt = Backseat::new().args(["explain", "turn_rate"]).run().refusal();
    assert!(misspelt.contains("did you mean limits.turn_rate_dps"), "{misspelt}");
    let list = Backseat::new().arg("explain").run().exit(0);
    assert!(
        list.stdout.contains("mission.toml") && list.stdout.contains("  limits"),
        "{list}"
    );
}

#[test]
fn the_program_for_sea_explains_too() {
    let told = Backseat::new()
        .for_sea()
        .args(["explain", "navigation_age_max_s"])
        .run()
        .exit(0);
    assert!(told.stdout.contains("stale"), "{told}");
}

#[test]
fn every_exit_code_is_explained() {
    let told = Backseat::new().args(["explain", "exit-codes"]).run().exit(0);
    for exit in EXITS {
        assert!(
            told.stdout
                .lines()
                .any(|line| line.trim_start().starts_with(&exit.code.to_string())),
            "{told}"
        );
    }
}

#[test]
fn a_schema_is_printed_for_editors() {
    let told = Backseat::new()
        .args(["explain", "--schema", "mission.toml"])
        .run()
        .exit(0);
    let schema: Value = serde_json::from_str(&told.stdout).unwrap();
    assert_eq!(
        schema["properties"]["limits"]["properties"]["turn_rate_dps"]["exclusiveMinimum"],
        0.0
    );
    let same = Backseat::new().args(["explain", "--schema", "mission"]).run().exit(0);
    assert_eq!(same.stdout, told.stdout, "by the name of the page too");
    let wrong = Backseat::new()
        .args(["explain", "--schema", "nothing.toml"])
        .run()
        .refusal();
    assert!(wrong.contains("mission.toml"), "{wrong}");
}

/// The keys of an object, those of its tables with dots, as the reference spells them.
fn keys_of(reference: &Reference, table: &str, value: &Value, keys: &mut BTreeSet<String>) {
    let free = reference
        .entry(table)
        .is_some_and(|entry| !table.is_empty() && !entry.is_table());
    if let (Value::Object(map), false) = (value, free) {
        for (name, value) in map {
            let key = if table.is_empty() {
                name.clone()
            } else {
                format!("{table}.{name}")
            };
            keys_of(reference, &key, value, keys);
            keys.insert(key);
        }
    }
    for value in value.as_array().into_iter().flatten() {
        keys_of(reference, table, value, keys);
    }
}

#[test]
fn the_reports_keys_are_those_of_the_reference() {
    let reference = Reference::of("report").expect("the report has a reference");
    let mut keys = BTreeSet::new();
    for mission in ["isobath", "plume", "reinspect", "coverage"].map(Mission::copy) {
        let report = Backseat::new()
            .args(["sim", "--json"])
            .mission(&mission)
            .run()
            .exit(0)
            .json();
        keys_of(reference, "", &report, &mut keys);
    }
    let entries: BTreeSet<String> = reference.entries.iter().map(|entry| entry.key.clone()).collect();
    // No good run has a violation to show.
    let unseen: Vec<_> = entries
        .difference(&keys)
        .filter(|key| !key.starts_with("violations."))
        .collect();
    assert!(unseen.is_empty(), "no report has {unseen:?}");
    let unknown: Vec<_> = keys.difference(&entries).collect();
    assert!(unknown.is_empty(), "no entry for {unknown:?}");
}
