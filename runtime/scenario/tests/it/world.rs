//! `world.toml` beside a mission.

use std::path::Path;

use backseat_mission::{Layers, Mission};
use backseat_scenario::Scenario;

/// A copy of the mission of the grid's tests with `world.toml` changed or removed, and with these lines added to
/// `mission.toml`.
fn mission(world: impl FnOnce(String) -> Option<String>, lines: &str) -> (tempfile::TempDir, Mission) {
    let original = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/missions/charted");
    let folder = tempfile::tempdir().unwrap();
    let read = |file: &str| std::fs::read_to_string(original.join(file)).unwrap();
    let write = |file: &str, text: &str| std::fs::write(folder.path().join(file), text).unwrap();
    for file in ["fence.geojson", "bed.asc"] {
        write(file, &read(file));
    }
    write("mission.toml", &format!("{}\n{lines}\n", read("mission.toml")));
    if let Some(world) = world(read("world.toml")) {
        write("world.toml", &world);
    }
    let mission = Mission::load(folder.path(), &Layers::default()).unwrap();
    (folder, mission)
}

#[test]
fn an_invalid_world_is_reported_in_one_line_with_its_place() {
    let fault = |world: &str| {
        let (_folder, mission) = mission(|_| Some(world.to_owned()), "");
        let error = Scenario::load(&mission).unwrap_err().to_string();
        assert!(!error.contains('\n') && error.contains("world.toml: "), "{error}");
        assert!(Scenario::find(&mission).is_err());
        error
    };
    let garbage = fault("nonsense\n");
    assert!(garbage.contains("world.toml: line 1, column "), "{garbage}");
    assert!(fault("").contains("missing field"), "{}", fault(""));
}

#[test]
fn a_mission_without_a_world_cannot_be_simulated() {
    let (_folder, mission) = mission(|_| None, "");
    assert!(Scenario::find(&mission).unwrap().is_none());
    let error = Scenario::load(&mission).unwrap_err().to_string();
    assert!(
        error.ends_with("world.toml: not found: to be simulated, a mission needs this file"),
        "{error}"
    );
}

#[test]
fn the_plan_comes_from_the_given_file_then_the_mission_then_the_world() {
    let (folder, own) = mission(Some, "");
    let scenario = Scenario::load(&own).unwrap();
    assert_eq!(scenario.plan(&own, None).unwrap().behaviors.len(), 2);
    let file = folder.path().join("other.toml");
    let waypoint = "[[plan]]\nkind = \"waypoint\"\nat = { east_m = 0, north_m = 50 }\ndepth_m = 5\nspeed_mps = 1.5\n";
    std::fs::write(&file, waypoint).unwrap();
    // Positions without an origin are relative to this world's origin.
    assert_eq!(scenario.plan(&own, Some(&file)).unwrap().behaviors.len(), 1);
    let (_folder, named) = mission(Some, "[plan]\nfile = \"world.toml\"");
    assert_eq!(scenario.plan(&named, None).unwrap().behaviors.len(), 2);
    // The world's vehicle cannot fly what a vehicle of another class can.
    std::fs::write(&file, waypoint.replace("depth_m = 5", "depth_m = 250")).unwrap();
    let error = scenario.plan(&own, Some(&file)).unwrap_err().to_string();
    assert!(error.contains("other.toml: plan element 1: depth_m is 250"), "{error}");
}
