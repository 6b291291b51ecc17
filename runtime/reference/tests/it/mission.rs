//! `mission.toml`.

use std::fs;

use backseat_mission::{Layers, Mission};
use backseat_reference::Reference;
use tempfile::TempDir;
use toml::{Table, Value};

use crate::held;

const FENCE: &str = r#"{"type":"FeatureCollection","features":[{"type":"Feature",
"properties":{"name":"bay","kind":"keep-in","margin_m":20,"depth_max_m":40,"altitude_min_m":3},
"geometry":{"type":"Polygon","coordinates":[[[-70.9,42.3],[-70.8,42.3],[-70.8,42.4],[-70.9,42.4],[-70.9,42.3]]]}}]}"#;

/// The same zone, without what the `[fence]` table has.
const KML: &str = r#"<kml xmlns="http://www.opengis.net/kml/2.2"><Document><Placemark><name>bay</name>
<ExtendedData><Data name="kind"><value>keep-in</value></Data></ExtendedData>
<Polygon><outerBoundaryIs><LinearRing><coordinates>-70.9,42.3 -70.8,42.3 -70.8,42.4 -70.9,42.4 -70.9,42.3</coordinates>
</LinearRing></outerBoundaryIs></Polygon></Placemark></Document></kml>"#;

const PLAN: &str = r#"
[[plan]]
kind = "waypoint"
at = { latitude_deg = 42.35, longitude_deg = -70.85 }
depth_m = 5
speed_mps = 1.5
"#;

fn reference() -> &'static Reference {
    Reference::of("mission.toml").expect("it has a reference")
}

/// A sensor for the pings of a plugin.
const SENSOR: &str = "index = 2\ndevice = 11002\nrecords = [3000]\n";

fn read(document: &Table) -> Result<String, String> {
    let mut document = document.clone();
    let pings = |plugin: &Value| plugin.get("ping").is_some();
    let plugins = document.get("plugin").and_then(Value::as_array);
    if plugins.is_some_and(|plugins| plugins.iter().any(pings)) {
        let sensor: Table = SENSOR.parse().expect("it is a table");
        let sensors = Value::Array(vec![Value::Table(sensor)]);
        document.insert(
            "sonar".to_owned(),
            Value::Table(Table::from_iter([("sensor".to_owned(), sensors)])),
        );
    }
    let folder = TempDir::new().expect("a temporary folder");
    let (fence, text) = if document.contains_key("fence") {
        ("fence.kml", KML)
    } else {
        ("fence.geojson", FENCE)
    };
    fs::write(folder.path().join(fence), text).expect("the folder can be written");
    fs::write(folder.path().join("plan.toml"), PLAN).expect("the folder can be written");
    fs::write(
        folder.path().join("mission.toml"),
        toml::to_string(&document).expect("a table is TOML"),
    )
    .expect("the folder can be written");
    match Mission::load(folder.path(), &Layers::default()) {
        Ok(mission) => Ok(format!("{:?}", mission.file)),
        Err(error) => Err(error.to_string()),
    }
}

#[test]
fn every_key_of_mission_toml_has_an_entry() {
    held::none(&held::keys(reference(), &read));
}

#[test]
fn examples_defaults_and_required_keys_of_mission_toml_are_the_codes() {
    held::none(&held::values(reference(), &read));
}

#[test]
fn ranges_of_mission_toml_are_the_codes() {
    // The fence is at one place, and an origin must be near it.
    let near_the_fence = ["origin.latitude_deg", "origin.longitude_deg"];
    held::none(&held::bounds(reference(), &near_the_fence, &read));
}

#[test]
fn keys_of_mission_toml_stand_with_those_that_they_need() {
    held::none(&held::company(reference(), &read));
}
