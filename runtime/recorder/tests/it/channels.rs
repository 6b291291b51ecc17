//! Foxglove, Lichtblick and other readers of MCAP can read every channel.
#![expect(clippy::unwrap_used, reason = "a test may panic")]

use backseat_recorder::Rate;
use backseat_spi::{Direction, catalogue};
use serde_json::Value;

use crate::sample::everything;
use crate::viewer::{channels, check};

/// The sentences with a channel of their own.
const SENSORS: &str = "BFTEL BFSVS BFRCM BFRDP BFRVL BFRBS BFERC BFDVL BFDV2 BFIMU BFCTD BFRNV BFPIT BFCNV BFTRM BFBOY";

#[test]
fn every_message_holds_to_its_schema_and_viewers_read_every_schema() {
    for rate in [Rate::Simulation, Rate::Deployed] {
        let channels = channels(&everything(rate));
        check(&channels);
        let mut expected: Vec<String> = [
            "/link/from_vehicle",
            "/measures/0/water_depth",
            "/link/to_vehicle",
            "/core/input",
            "/core/output",
            "/notes",
            "/requests",
            "/control",
            "/navigation",
            "/truth",
            "/vehicle",
            "/position",
            "/log",
            "/map/fence",
            "/map/plan",
            "/map/inserts",
            "/map/requests",
        ]
        .map(str::to_owned)
        .into();
        expected.extend(SENSORS.split(' ').map(|name| format!("/sensors/{name}")));
        expected.sort();
        assert_eq!(channels.keys().cloned().collect::<Vec<_>>(), expected);
    }
}

/// `tables.json` of an export has these texts, so that nobody has to guess what a column means.
#[test]
fn every_property_of_every_schema_says_what_it_means() {
    fn silent(schema: &Value, place: &str, found: &mut Vec<String>) {
        if let Some(properties) = schema["properties"].as_object() {
            for (name, schema) in properties {
                silent(schema, &format!("{place}.{name}"), found);
            }
        } else if schema["items"]["properties"].is_object() {
            silent(&schema["items"], place, found);
        } else if schema["description"].as_str().is_none_or(str::is_empty) {
            found.push(place.to_owned());
        }
    }
    let mut found = Vec::new();
    for (topic, channel) in channels(&everything(Rate::Simulation)) {
        silent(&channel.schema, &topic, &mut found);
    }
    assert_eq!(found, [""; 0]);
}

#[test]
fn a_sentence_is_a_sensor_or_known_to_be_none() {
    let others = "BFMSC BFSHT BFBDL BFSDL BFTOP BFDVT BFVER BFNVG BFNVR BFMBS BFMBE BFMIS BFPLN BFACK BFCTL BFCMA BFCPS \
                  BFCPR";
    let mut named: Vec<&str> = SENSORS.split(' ').chain(others.split(' ')).collect();
    let mut all: Vec<&str> = catalogue()
        .iter()
        .filter(|entry| entry.direction == Direction::FromVehicle)
        .map(|entry| entry.name)
        .collect();
    named.sort_unstable();
    all.sort_unstable();
    assert_eq!(named, all);
}

/// The schemas are those of the npm package `@foxglove/schemas`.
#[test]
fn foxgloves_messages_have_every_field_of_foxgloves_schemas() {
    let channels = channels(&everything(Rate::Deployed));
    let theirs = [
        ("/position", include_str!("../foxglove/LocationFix.json")),
        ("/log", include_str!("../foxglove/Log.json")),
        ("/map/fence", include_str!("../foxglove/GeoJSON.json")),
        ("/map/plan", include_str!("../foxglove/GeoJSON.json")),
        ("/map/inserts", include_str!("../foxglove/GeoJSON.json")),
        ("/map/requests", include_str!("../foxglove/GeoJSON.json")),
    ];
    for (topic, theirs) in theirs {
        let theirs: Value = serde_json::from_str(theirs).unwrap();
        let ours = &channels[topic];
        assert_eq!(theirs["title"], ours.schema_name.as_str());
        same(&theirs, &ours.schema, topic);
        // Each message holds to their schema too, not only to ours.
        let validator = jsonschema::validator_for(&theirs).unwrap();
        for (_, message) in &ours.messages {
            assert!(validator.is_valid(message), "{topic}: {message}");
        }
    }
}

fn same(theirs: &Value, ours: &Value, place: &str) {
    // Their enums are numbers with names.
    let is_enum = theirs["oneOf"]
        .as_array()
        .is_some_and(|cases| cases.iter().all(|case| case["const"].is_u64()));
    if is_enum {
        assert_eq!(ours["type"], "integer", "{place}");
        return;
    }
    assert_eq!(theirs["type"], ours["type"], "{place}");
    if let Some(properties) = theirs["properties"].as_object() {
        let names = |schema: &Value| {
            let mut names: Vec<String> = schema["properties"].as_object().unwrap().keys().cloned().collect();
            names.sort();
            names
        };
        assert_eq!(names(theirs), names(ours), "{place}");
        for (name, property) in properties {
            same(property, &ours["properties"][name], &format!("{place}.{name}"));
        }
    }
    if theirs["type"] == "array" {
        same(&theirs["items"], &ours["items"], &format!("{place}[]"));
    }
}
