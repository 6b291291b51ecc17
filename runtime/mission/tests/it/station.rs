//! The tables of a hovering vehicle in a mission file.
#![expect(clippy::unwrap_used, reason = "a failed unwrap in a test shows where")]

use backseat_mission::{Layers, Mission, MissionError};

const MISSION: &str = r#"
[limits]
speed_min_mps = 1.0
speed_max_mps = 2.0
turn_rate_dps = 8.0
current_max_mps = 0.3

[limits.station]
speed_max_mps = 0.5
sonar_angle_min_deg = -45
sonar_angle_max_deg = 45.0

[limits.station.hull_box]
horizontal_min_m = 0
horizontal_max_m = 120.0
vertical_min_m = 0.0
vertical_max_m = 12.0
distance_min_m = 1.5
distance_max_m = 10.0

[[limits.station.keep_out_hull]]
name = "screw"
horizontal_min_m = 112.0
horizontal_max_m = 120.0
vertical_min_m = 4.0
vertical_max_m = 12.0
distance_min_m = -2.0
distance_max_m = 5.0

[limits.station.bottom_box]
x_min_m = -50.0
x_max_m = 50.0
y_min_m = -50.0
y_max_m = 50.0
depth_min_m = 2.0
depth_max_m = 15.0

[[plugin]]
name = "station"
component = "station"
grants = ["station", "devices"]
"#;
const FENCE: &str = r#"{"type":"FeatureCollection","features":[{"type":"Feature","properties":{"name":"box","kind":"keep-in","margin_m":10,"depth_max_m":50,"altitude_min_m":3},"geometry":{"type":"Polygon","coordinates":[[[-70.9,42.3],[-70.89,42.3],[-70.89,42.31],[-70.9,42.31],[-70.9,42.3]]]}}]}"#;

fn load(mission: &str) -> Result<Mission, MissionError> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("mission.toml"), mission).unwrap();
    std::fs::write(folder.path().join("fence.geojson"), FENCE).unwrap();
    let layers = Layers {
        set: Vec::new(),
        environment: false,
    };
    Mission::load(folder.path(), &layers)
}

#[test]
fn a_mission_states_its_boxes_and_the_rest_has_defaults() {
    let mission = load(MISSION).unwrap();
    let station = mission.envelope.limits().station.clone().unwrap();
    assert_eq!((station.speed_default_mps, station.relative_age_max_s), (1.5, 1.0));
    assert_eq!(station.hull_box.unwrap().distance_min_m, 1.5);
    assert_eq!(station.keep_out_hull[0].name, "screw");
    assert_eq!(station.bottom_box.unwrap().depth_max_m, 15.0);
    assert!(station.keep_out_bottom.is_empty());
}

#[test]
fn a_wrong_key_or_value_of_station_keeping_is_named() {
    let fault = |from: &str, to: &str| {
        let mission = MISSION.replace(from, to);
        assert_ne!(mission, MISSION);
        load(&mission).err().expect("a fault").to_string()
    };
    let unknown = fault("distance_min_m = 1.5", "standoff_m = 1.5");
    assert!(unknown.contains("standoff_m"), "{unknown}");
    let negative = fault("distance_min_m = 1.5", "distance_min_m = -1.5");
    assert!(
        negative.contains("limits.station.hull_box") && negative.contains("-1.5"),
        "{negative}"
    );
    let alone = fault("sonar_angle_max_deg = 45.0", "");
    assert!(alone.contains("expected sonar_angle_max_deg as well"), "{alone}");
}
