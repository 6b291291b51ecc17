//! Missions of which the log once had less than a replay needs.

use std::fs;

use backseat_replay::{Configs, ReplayError};
use backseat_test_support::mission;

use crate::flight::{Flight, copied, unchanged};

/// A plan of the vehicle that the mission expects, in a file of its own.
#[test]
fn the_plan_that_a_mission_names_is_in_its_log() {
    let folder = copied(&mission("isobath"));
    let world = fs::read_to_string(folder.path().join("world.toml")).unwrap();
    let table: toml::Table = toml::from_str(&world).unwrap();
    let plan: toml::Table = table
        .into_iter()
        .filter(|(key, _)| key == "origin" || key == "plan")
        .collect();
    fs::write(folder.path().join("dive.toml"), plan.to_string()).unwrap();
    let file = folder.path().join("mission.toml");
    let text = fs::read_to_string(&file).unwrap();
    fs::write(&file, format!("{text}\n[plan]\nfile = \"dive.toml\"\n")).unwrap();
    let flight = Flight::of(folder.path()).seconds(300);
    let report = flight.log().replay();
    assert_eq!(report.identical, Some(true), "{:#?}", report.first_difference);
    // An earlier version did not write it.
    let log = Flight::of(folder.path()).seconds(60).of_earlier_version().log();
    let error = log
        .replay_with(Vec::new(), Configs::default(), &mut unchanged)
        .err()
        .unwrap();
    assert!(matches!(error, ReplayError::Plan { .. }), "{error}");
    assert!(error.to_string().contains("names the plan dive.toml"), "{error}");

    // The plan of the world is in every simulation's log.
    fs::write(&file, format!("{text}\n[plan]\nfile = \"world.toml\"\n")).unwrap();
    let log = Flight::of(folder.path()).seconds(60).of_earlier_version().log();
    assert_eq!(log.replay().identical, Some(true));
}

/// The GeoJSON that is written from another fence has rounded positions.
#[test]
fn a_fence_of_another_format_is_replayed_from_its_own_file() {
    let folder = copied(&mission("isobath"));
    let fence = folder.path().join("fence.geojson");
    let text = fs::read_to_string(&fence).unwrap();
    let mut document: serde_json::Value = serde_json::from_str(&text).unwrap();
    let features = document["features"].as_array_mut().unwrap();
    // A circle far from the track makes the program write the fence anew.
    let inside = features[0]["geometry"]["coordinates"][0][0].clone();
    features.push(serde_json::json!({
        "type": "Feature",
        "properties": {"name": "buoy", "kind": "keep-out", "margin_m": 1.0, "radius_m": 5.0},
        "geometry": {"type": "Point", "coordinates": inside}
    }));
    fs::write(&fence, document.to_string()).unwrap();
    let log = Flight::of(folder.path()).seconds(300).log();
    assert_eq!(log.reader().fence_as_read().unwrap().0, "fence.geojson");
    let report = log.replay();
    assert_eq!(report.identical, Some(true), "{:#?}", report.first_difference);
}
