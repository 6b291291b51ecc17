//! A simulation's log opens in Foxglove and Lichtblick: every channel has a schema that they read.

use std::collections::BTreeMap;

use backseat_suite::{Backseat, Mission};

#[path = "../../../../runtime/recorder/tests/it/viewer.rs"]
pub(crate) mod viewer;

use viewer::{Channel, channels, check};

fn flown(name: &str) -> BTreeMap<String, Channel> {
    let mission = Mission::copy(name);
    let path = mission.beside("run.mcap");
    let _report = Backseat::new()
        .args(["sim", "--seed", "1", "--log"])
        .arg(&path)
        .mission(&mission)
        .run()
        .exit(0);
    let channels = channels(&std::fs::read(path).expect("the run has a log"));
    check(&channels);
    channels
}

/// Number of messages.
fn counts(channels: &BTreeMap<String, Channel>) -> Vec<(&str, usize)> {
    let counts = channels
        .iter()
        .map(|(topic, channel)| (topic.as_str(), channel.messages.len()));
    counts.collect()
}

#[test]
fn a_log_has_every_channel_that_it_should_have() {
    let channels = flown("isobath");
    let topics: Vec<&str> = counts(&channels).into_iter().map(|(topic, _)| topic).collect();
    // This mission has no inserts, and its plugin asks for no sensor.
    let expected = [
        "/control",
        "/core/input",
        "/core/output",
        "/link/from_vehicle",
        "/link/to_vehicle",
        "/log",
        "/map/fence",
        "/map/plan",
        "/measures/isobath/contour_offset",
        "/measures/isobath/slope",
        "/navigation",
        "/notes",
        "/position",
        "/requests",
        "/truth",
        "/vehicle",
    ];
    assert_eq!(topics, expected);
    // The names by which the viewers' panels know what they can show.
    for (topic, schema) in [
        ("/position", "foxglove.LocationFix"),
        ("/log", "foxglove.Log"),
        ("/map/fence", "foxglove.GeoJSON"),
    ] {
        assert_eq!(channels[topic].schema_name, schema);
    }
    let count = |topic: &str| channels[topic].messages.len();
    assert_eq!(count("/position"), count("/navigation"));
    let lines = count("/notes") + count("/control") + count("/vehicle");
    assert!((lines..lines + 10).contains(&count("/log")), "{:?}", counts(&channels));
    assert_eq!((count("/map/fence"), count("/map/plan")), (1, 1));
}

#[test]
fn inserts_and_sensors_are_there_too() {
    let channels = flown("plume");
    let count = |topic: &str| channels.get(topic).map_or(0, |channel| channel.messages.len());
    let seconds = count("/navigation");
    assert!(
        count("/map/requests") > 0 && count("/map/inserts") > 1,
        "{:?}",
        counts(&channels)
    );
    let ctd = count("/sensors/BFCTD");
    assert!(ctd > seconds / 2 && ctd <= seconds + 1, "{:?}", counts(&channels));
    let inserts = &channels["/map/inserts"].messages.last().unwrap().1;
    let geojson: serde_json::Value = serde_json::from_str(inserts["geojson"].as_str().unwrap()).unwrap();
    let features = geojson["features"].as_array().unwrap();
    let of = |kind: &str| features.iter().any(|feature| feature["properties"]["kind"] == kind);
    assert!(of("trackline") && of("trackcircle"), "{geojson:#}");
}
