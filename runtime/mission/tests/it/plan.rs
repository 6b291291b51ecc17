//! The front seat's plan that a mission names.
#![expect(clippy::unwrap_used, reason = "a failed unwrap in a test shows where")]

use backseat_mission::{Layers, Mission, MissionError};

const MISSION: &str =
    "[limits]\nspeed_min_mps = 1.0\nspeed_max_mps = 2.0\nturn_rate_dps = 8.0\ncurrent_max_mps = 0.3\n";
const FENCE: &str = r#"{"type":"FeatureCollection","features":[{"type":"Feature","properties":{"name":"box","kind":"keep-in","margin_m":10,"depth_max_m":50,"altitude_min_m":3},"geometry":{"type":"Polygon","coordinates":[[[-70.9,42.3],[-70.89,42.3],[-70.89,42.31],[-70.9,42.31],[-70.9,42.3]]]}}]}"#;
const WAYPOINT: &str =
    "[[plan]]\nkind = \"waypoint\"\nat = { east_m = 0, north_m = 100 }\ndepth_m = 250\nspeed_mps = 1.5\n";
const ORIGIN: &str = "[origin]\nlatitude_deg = 42.305\nlongitude_deg = -70.895\n";

/// Loads a mission with more text in its file and with other files beside it.
fn load(more: &str, files: &[(&str, &str)]) -> Result<Mission, MissionError> {
    let folder = tempfile::tempdir().unwrap();
    let mission = format!("{MISSION}{more}");
    let own = [("mission.toml", mission.as_str()), ("fence.geojson", FENCE)];
    for (file, text) in own.iter().chain(files) {
        std::fs::write(folder.path().join(file), text).unwrap();
    }
    Mission::load(folder.path(), &Layers::default())
}

#[test]
fn an_error_in_the_world_does_not_prevent_reading_a_mission() {
    for world in ["nonsense", "[seabed]\ngrid = \"nowhere.asc\"\n", ""] {
        assert!(load("", &[("world.toml", world)]).is_ok(), "{world}");
    }
    // The same holds if the plan is in the same file.
    let world = format!("[seabed]\nbanks = \"many\"\n\n[nonsense]\n{ORIGIN}\n{WAYPOINT}");
    let mission = load("[plan]\nfile = \"world.toml\"\n", &[("world.toml", &world)]).unwrap();
    assert_eq!(mission.plan.unwrap().behaviors.len(), 1);
}

#[test]
fn a_plan_that_cannot_be_read_is_named_with_its_place() {
    let fault = |more: &str, name: &str, text: &str| {
        let plan = format!("{more}[plan]\nfile = \"{name}\"\n");
        load(&plan, &[(name, text)]).err().expect("a fault").to_string()
    };
    let unknown = fault("", "plan.toml", &format!("{ORIGIN}depth_m = 3\n{WAYPOINT}"));
    assert!(unknown.contains("plan.toml:4: unknown field `depth_m`"), "{unknown}");
    let unknown = fault("", "world.toml", &format!("{ORIGIN}{WAYPOINT}wher = 3\n"));
    assert!(unknown.contains("world.toml:9: unknown field `wher`"), "{unknown}");
    let garbage = fault("", "world.toml", "nonsense");
    assert!(garbage.contains("world.toml:1: "), "{garbage}");
    let missing = load("[plan]\nfile = \"dive.toml\"\n", &[])
        .err()
        .expect("a fault")
        .to_string();
    assert!(
        missing.contains("mission.toml: plan.file is \"dive.toml\": cannot read "),
        "{missing}"
    );
    assert!(
        missing.ends_with("dive.toml: No such file or directory (os error 2)"),
        "{missing}"
    );
    // A world's origin is for simulation only, so a plan needs its own.
    let error = load(
        "[plan]\nfile = \"plan.toml\"\n",
        &[("plan.toml", WAYPOINT), ("world.toml", ORIGIN)],
    );
    let error = error.err().expect("a fault").to_string();
    assert!(
        error.contains("plan.toml: no [origin]: expected latitude_deg"),
        "{error}"
    );
}

#[test]
fn a_plan_is_checked_against_the_class_if_the_mission_names_one() {
    let plan = [("plan.toml", &*format!("{ORIGIN}{WAYPOINT}"))];
    assert!(load("[plan]\nfile = \"plan.toml\"\n", &plan).is_ok());
    let shallow = "[vehicle]\nclass = \"12-inch\"\n[plan]\nfile = \"plan.toml\"\n";
    let error = load(shallow, &plan).err().expect("too deep").to_string();
    assert!(
        error.contains("plan.toml: plan element 1: depth_m is 250, expected 0 to 200"),
        "{error}"
    );
}
