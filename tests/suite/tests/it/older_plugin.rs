//! A plugin that was built for an earlier version of the interface flies as it did.

use std::fs;

use backseat_suite::{Backseat, Mission};
use serde_json::Value;

/// `plugins/isobath`, built before `wit/v0.2.0`. It is never built again.
const ISOBATH: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/components/isobath-0.1.0.wasm");

fn fly(mission: &Mission) -> Value {
    Backseat::new()
        .args(["sim", "--json", "--seed", "3"])
        .mission(mission)
        .run()
        .exit(0)
        .json()
}

#[test]
fn a_plugin_for_wit_0_1_0_flies_as_the_present_one() {
    let mission = Mission::copy("isobath");
    let present = fly(&mission);
    let folder = mission.path().join("older");
    fs::create_dir(&folder).expect("a folder");
    fs::copy(ISOBATH, folder.join("isobath.wasm")).expect("the component is in the repository");
    let older = mission.edit(
        "mission.toml",
        "component = \"isobath\"",
        "component = \"older/isobath.wasm\"",
    );
    let flown = fly(&older);
    assert_eq!(flown["unmet"], Value::Array(vec![]));
    assert_eq!(flown["violations"], Value::Array(vec![]));
    // The two were not compiled from the same SDK, so their steps use different amounts of fuel, and end some microseconds
    // apart. The link is not the same to the byte.
    assert_eq!(flown["requests"], present["requests"]);
}
