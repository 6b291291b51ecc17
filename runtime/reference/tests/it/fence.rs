//! The properties of a zone, in GeoJSON and in KML.

use core::fmt::Write as _;
use std::collections::BTreeSet;

use backseat_fence::{Fence, Terms};
use backseat_reference::{Entry, Reference};
use serde_json::{Value as Json, json};
use toml::{Table, Value};

use crate::document::{self, example, with_of};
use crate::held;

/// What no placemark below leaves to `[fence]`, but the defaults of the keys.
const TERMS: Terms = Terms {
    margin_m: 1.0,
    depth_min_m: 0.0,
    depth_max_m: 1.0,
    altitude_min_m: 1.0,
    surfacing: false,
};

/// The corners of an area, and the ends of a line within it: longitude and latitude.
const AREA: [[f64; 2]; 5] = [
    [-70.9, 42.3],
    [-70.8, 42.3],
    [-70.8, 42.4],
    [-70.9, 42.4],
    [-70.9, 42.3],
];
const LINE: [[f64; 2]; 2] = [[-70.88, 42.35], [-70.82, 42.35]];

/// The keys that a geometry must have, and no other may.
const OF_GEOMETRY: [(&str, &str); 2] = [("radius_m", "Point"), ("half_width_m", "LineString")];

fn reference() -> &'static Reference {
    Reference::of("fence.geojson").expect("it is registered")
}

/// The geometry that has these properties.
fn geometry(properties: &Table) -> &'static str {
    let fits = OF_GEOMETRY.iter().find(|(key, _)| properties.contains_key(*key));
    fits.map_or("Polygon", |(_, geometry)| geometry)
}

fn read(properties: &Table) -> Result<String, String> {
    read_as(properties, geometry(properties))
}

/// The zones of a file with one of these properties and this geometry, and a keep-in zone.
fn read_as(properties: &Table, geometry: &str) -> Result<String, String> {
    for (key, value) in properties {
        if value.as_float().is_some_and(|number| !number.is_finite()) {
            return Err(format!("`{key}`: JSON has no such number"));
        }
    }
    let coordinates = match geometry {
        "Point" => json!(LINE[0]),
        "LineString" => json!(LINE),
        _ => json!([AREA]),
    };
    let zone = json!({
        "type": "Feature",
        "properties": properties,
        "geometry": { "type": geometry, "coordinates": coordinates },
    });
    let another = json!({
        "type": "Feature",
        "properties": { "name": "sea", "kind": "keep-in", "margin_m": 0, "depth_max_m": 50, "altitude_min_m": 0 },
        "geometry": { "type": "Polygon", "coordinates": [AREA.map(|[longitude, latitude]| [longitude, latitude + 0.11])] },
    });
    let document = json!({ "type": "FeatureCollection", "features": [zone, another] });
    zones(Fence::from_geojson(&document.to_string()))
}

/// The same as KML.
fn read_kml(properties: &Table) -> Result<String, String> {
    let places = |places: &[[f64; 2]]| {
        let places = places
            .iter()
            .map(|[longitude, latitude]| format!("{longitude},{latitude}"));
        format!("<coordinates>{}</coordinates>", places.collect::<Vec<_>>().join(" "))
    };
    let area = |places: String| {
        format!("<Polygon><outerBoundaryIs><LinearRing>{places}</LinearRing></outerBoundaryIs></Polygon>")
    };
    let drawn = match geometry(properties) {
        "Point" => format!("<Point>{}</Point>", places(&LINE[..1])),
        "LineString" => format!("<LineString>{}</LineString>", places(&LINE)),
        _ => area(places(&AREA)),
    };
    let mut data = String::new();
    for (key, value) in properties.iter().filter(|(key, _)| *key != "name") {
        let text = value.as_str().map_or_else(|| value.to_string(), str::to_owned);
        let _ = write!(data, "<Data name=\"{key}\"><value>{text}</value></Data>");
    }
    let name = properties.get("name").and_then(Value::as_str).unwrap_or_default();
    let another = area(places(&AREA.map(|[longitude, latitude]| [longitude, latitude + 0.11])));
    let document = format!(
        "<kml xmlns=\"http://www.opengis.net/kml/2.2\"><Document>\
         <Placemark><name>{name}</name><ExtendedData>{data}</ExtendedData>{drawn}</Placemark>\
         <Placemark><name>sea</name><ExtendedData><Data name=\"kind\"><value>keep-in</value></Data>\
         <Data name=\"margin_m\"><value>0</value></Data><Data name=\"depth_max_m\"><value>50</value></Data>\
         <Data name=\"altitude_min_m\"><value>0</value></Data></ExtendedData>{another}</Placemark>\
         </Document></kml>"
    );
    zones(Fence::from_kml(&document, &TERMS))
}

fn zones(fence: Result<Fence, backseat_fence::FenceError>) -> Result<String, String> {
    match fence {
        Ok(fence) => Ok(format!("{:?}", fence.zones().collect::<Vec<_>>())),
        Err(error) => Err(error.to_string()),
    }
}

/// The kinds of zone that take a key.
fn kinds(entry: &Entry) -> Vec<String> {
    let kinds = document::kinds(reference(), "").into_iter();
    kinds.filter(|kind| entry.is_of(Some(kind))).collect()
}

#[test]
fn every_property_of_a_zone_has_an_entry() {
    document::of(reference());
    let mut faults = Vec::new();
    let kind = reference().entry("kind").unwrap();
    for zone in document::kinds(reference(), "") {
        let mut properties = with_of(reference(), kind, Value::String(zone.clone()), None);
        properties.insert(held::NOBODY.to_owned(), Value::Integer(1));
        // The loader lists the keys of this kind of zone, without that of its geometry.
        let listed: BTreeSet<String> = reference()
            .entries
            .iter()
            .filter(|entry| entry.is_of(Some(&zone)) && !OF_GEOMETRY.iter().any(|(key, _)| entry.key == *key))
            .map(|entry| entry.key.clone())
            .collect();
        held::compare(&mut faults, &zone, listed, read(&properties));
    }
    // It puts words into the quotation marks of JSON.
    let nobody = with_of(reference(), kind, Value::String(held::NOBODY.to_owned()), None);
    let answer = read(&nobody).map_err(|error| error.replace('"', "`"));
    let listed = document::kinds(reference(), "").into_iter().collect();
    held::compare(&mut faults, "kind", listed, answer);
    held::none(&faults);
}

#[test]
fn the_length_of_a_round_zone_goes_with_its_geometry() {
    document::of(reference());
    for (key, own) in OF_GEOMETRY {
        let entry = reference().entry(key).unwrap();
        let properties = with_of(reference(), entry, example(entry), None);
        for geometry in ["Polygon", "Point", "LineString"] {
            assert_eq!(
                read_as(&properties, geometry).is_ok(),
                geometry == own,
                "{key} of a {geometry}"
            );
        }
        let mut without = properties.clone();
        without.remove(key);
        let error = read_as(&without, own).unwrap_err();
        assert!(error.contains(key), "{error}");
        let least = with_of(reference(), entry, Value::Float(entry.min.unwrap()), Some("keep-out"));
        assert!(read(&least).is_ok(), "{key}");
    }
}

#[test]
fn examples_defaults_and_required_properties_are_the_codes() {
    held::none(&held::values(reference(), &read));
}

#[test]
fn ranges_of_properties_are_the_codes() {
    // A corridor has a length too: one of this width makes the fence too wide.
    held::none(&held::bounds(reference(), &["half_width_m"], &read));
}

#[test]
fn each_kind_of_zone_takes_its_own_properties_alone() {
    held::none(&held::company(reference(), &read));
}

#[test]
fn a_placemark_has_the_same_properties() {
    document::of(reference());
    for entry in &reference().entries {
        for kind in kinds(entry) {
            let properties = with_of(reference(), entry, example(entry), Some(&kind));
            let (geojson, kml) = (read(&properties), read_kml(&properties));
            assert!(geojson.is_ok(), "{}: {geojson:?}", entry.key);
            assert_eq!(kml, geojson, "{} of {kind}", entry.key);
        }
    }
}

#[test]
fn null_and_an_empty_text_count_as_absent() {
    document::of(reference());
    let entry = reference().entry("valid_from").unwrap();
    let mut properties = with_of(reference(), entry, Value::String(String::new()), None);
    let kml = read_kml(&properties).unwrap();
    properties.remove("valid_from");
    assert_eq!(kml, read(&properties).unwrap());
    let mut document: Json = json!({ "type": "FeatureCollection", "features": [{
        "type": "Feature",
        "properties": properties,
        "geometry": { "type": "Polygon", "coordinates": [AREA] },
    }] });
    let without = zones(Fence::from_geojson(&document.to_string())).unwrap();
    document["features"][0]["properties"]["valid_from"] = Json::Null;
    assert_eq!(zones(Fence::from_geojson(&document.to_string())).unwrap(), without);
}
