//! A loaded component can be started; one that is not loaded is named in the error.
#![expect(clippy::unwrap_used, reason = "a failed unwrap in a test shows where")]

use backseat_mission::{Layers, Mission};
use backseat_plugin_host::Host;
use backseat_plugin_loader::{Components, LoadError};

const MISSION: &str = r#"
[limits]
speed_min_mps = 1.0
speed_max_mps = 2.0
turn_rate_dps = 8.0
current_max_mps = 0.3

[[plugin]]
name = "pilot"
component = "faulty"
grants = ["modify"]
"#;
const FENCE: &str = r#"{"type":"FeatureCollection","features":[{"type":"Feature","properties":{"name":"box","kind":"keep-in","margin_m":10,"depth_max_m":50,"altitude_min_m":3},"geometry":{"type":"Polygon","coordinates":[[[-70.9,42.3],[-70.89,42.3],[-70.89,42.31],[-70.9,42.31],[-70.9,42.3]]]}}]}"#;

fn mission() -> Mission {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("mission.toml"), MISSION).unwrap();
    std::fs::write(folder.path().join("fence.geojson"), FENCE).unwrap();
    Mission::load(folder.path(), &Layers::default()).unwrap()
}

#[test]
fn what_was_not_loaded_is_named_with_what_was() {
    let mission = mission();
    let error = Components::new().start(&mission).err().unwrap();
    assert!(matches!(error, LoadError::Unknown { .. }), "{error}");
    let mut components = Components::new();
    let bytes = std::fs::read(backseat_test_support::plugins().join("template.wasm")).unwrap();
    let host = Host::new().unwrap();
    components.insert(&host, "template", &bytes).unwrap();
    let error = components.start(&mission).err().unwrap().to_string();
    assert_eq!(
        error,
        "plugin `pilot`: component `faulty` is not loaded; loaded are: template"
    );
    assert!(components.insert(&host, "nothing", b"").is_err());
    assert!(
        components
            .start_one("faulty", &mission.file.plugins[0], &mission)
            .is_err()
    );
}

#[test]
fn a_config_that_its_plugin_refuses_is_told_with_its_line() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("fence.geojson"), FENCE).unwrap();
    let mut components = Components::new();
    let bytes = std::fs::read(backseat_test_support::plugins().join("template.wasm")).unwrap();
    let host = Host::new().unwrap();
    components.insert(&host, "template", &bytes).unwrap();
    let head = MISSION.replace("faulty", "template");
    let config = head.lines().count() + 1;
    for (text, line, reason) in [
        (
            "heading_deg = 90.0\ndepth_m = 10.0\nspeed_mps = 1.5\ndepht = 3",
            config + 4,
            "unknown field `depht`",
        ),
        (
            "heading_deg = 90.0\ndepth_m = \"10\"\nspeed_mps = 1.5",
            config + 2,
            "depth_m: ",
        ),
        ("heading_deg = 90.0", config, "missing field"),
        (
            "heading_deg = 90.0\ndepth_m = nan\nspeed_mps = 1.5",
            config + 2,
            "config: depth_m is NaN, expected a finite number",
        ),
        (
            "heading_deg = 90.0\nlegs = [{ speed_mps = 1.0 }, { speed_mps = -inf }]",
            config + 2,
            "config: legs[1].speed_mps is -inf, expected a finite number",
        ),
    ] {
        std::fs::write(
            folder.path().join("mission.toml"),
            format!("{head}[plugin.config]\n{text}\n"),
        )
        .unwrap();
        let mission = Mission::load(folder.path(), &Layers::default()).unwrap();
        let error = components.start(&mission).err().unwrap().to_string();
        assert!(error.contains(reason), "{error}");
        let place = format!("mission.toml, line {line}, or in --set)");
        assert!(error.ends_with(&place), "{error}: expected {place}");
    }
}
