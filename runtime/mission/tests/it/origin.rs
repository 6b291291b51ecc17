//! The place from which metres count.
#![expect(clippy::unwrap_used, reason = "a failed unwrap in a test shows where")]

use backseat_mission::{Layers, Mission, MissionError};

const LIMITS: &str = "
[limits]
speed_min_mps = 1.0
speed_max_mps = 2.0
turn_rate_dps = 8.0
current_max_mps = 0.3
";
const FENCE: &str = r#"{"type":"FeatureCollection","features":[{"type":"Feature","properties":{"name":"box","kind":"keep-in","margin_m":10,"depth_max_m":50,"altitude_min_m":3},"geometry":{"type":"Polygon","coordinates":[[[-70.9,42.3],[-70.89,42.3],[-70.89,42.31],[-70.9,42.31],[-70.9,42.3]]]}}]}"#;

fn load(origin: &str) -> Result<Mission, MissionError> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("mission.toml"), format!("{origin}\n{LIMITS}")).unwrap();
    std::fs::write(folder.path().join("fence.geojson"), FENCE).unwrap();
    let layers = Layers {
        set: Vec::new(),
        environment: false,
    };
    Mission::load(folder.path(), &layers)
}

#[test]
fn metres_count_from_the_origin_of_the_mission_or_else_from_the_middle_of_the_fence() {
    let origin = |mission: &Mission| {
        let origin = mission.envelope.fence().frame().origin();
        (origin.latitude.as_deg(), origin.longitude.as_deg())
    };
    let mission = load("[origin]\nlatitude_deg = 42.35\nlongitude_deg = -70.85").unwrap();
    assert_eq!(origin(&mission), (42.35, -70.85));
    let (latitude, longitude) = origin(&load("").unwrap());
    assert!((latitude - 42.305).abs() < 1e-5 && (longitude + 70.895).abs() < 1e-5);
    // The log of a run has the mission as it was resolved.
    assert!(mission.resolved.contains("[origin]"), "{}", mission.resolved);
}

#[test]
fn an_origin_that_cannot_be_used_is_refused_in_one_line() {
    for (origin, words) in [
        (
            "[origin]\nlatitude_deg = 95.0\nlongitude_deg = -70.85",
            "origin is latitude 95 longitude -70.85, expected",
        ),
        (
            "[origin]\nlatitude_deg = 43.35\nlongitude_deg = -70.85",
            "the origin (latitude 43.35 longitude -70.85)",
        ),
        ("[origin]\nlatitude_deg = 42.35", "missing field `longitude_deg`"),
    ] {
        let error = load(origin).err().unwrap().to_string();
        assert!(error.contains("mission.toml") && error.contains(words), "{error}");
        assert!(!error.contains('\n'), "{error}");
    }
}
