//! Reads GeoJSON (RFC 7946).

use core::slice;

use geojson::{Feature, GeometryValue};
use serde_json::{Map, Value};

use super::properties::{self, Round, label, shortened};
use super::{GEOMETRY, LONGITUDE_FIRST, RawZone, form, json, kind_of, position};
use crate::error::{FenceError, Place};
use crate::outline::RawRing;
use backseat_units::Position;

/// The features of the document.
pub(super) fn read(text: &str) -> Result<Vec<RawZone>, FenceError> {
    let document = json::parse(text)?;
    let place = || "document".to_owned();
    let Value::Object(mut document) = document else {
        return Err(form(place(), kind_of(&document), "a FeatureCollection"));
    };
    match document.get("type").map(Value::as_str) {
        Some(Some("FeatureCollection")) => {}
        Some(Some(other)) => return Err(form(place(), shortened(other), "a FeatureCollection")),
        Some(None) | None => return Err(form(place(), "no `type`".to_owned(), "`type` of \"FeatureCollection\"")),
    }
    if let Some(system) = document.get("crs").filter(|system| !system.is_null()) {
        coordinate_system(system)?;
    }
    let features = match document.remove("features") {
        Some(Value::Array(features)) => features,
        Some(other) => return Err(form("`features`".to_owned(), kind_of(&other), "an array of features")),
        None => return Err(form(place(), "no `features`".to_owned(), "an array of features")),
    };
    // GDAL writes the last one beside the features.
    let known = ["type", "name", "crs", "bbox", "xy_coordinate_resolution"];
    refuse_unknown(&document, place, &known, "`type`, `name`, `crs`, `bbox` or `features`")?;
    features
        .into_iter()
        .enumerate()
        .map(|(index, feature)| zone(feature, index))
        .collect()
}

/// Accepts only WGS84 in longitude and latitude: in other systems the same numbers mean other places.
fn coordinate_system(system: &Value) -> Result<(), FenceError> {
    let name = system.pointer("/properties/name").and_then(Value::as_str);
    if matches!(
        name,
        Some("urn:ogc:def:crs:OGC:1.3:CRS84" | "urn:ogc:def:crs:OGC::CRS84")
    ) {
        return Ok(());
    }
    Err(form(
        "`crs`".to_owned(),
        shortened(&system.to_string()),
        "urn:ogc:def:crs:OGC:1.3:CRS84, or no `crs`",
    ))
}

fn zone(feature: Value, index: usize) -> Result<RawZone, FenceError> {
    let numbered = || format!("feature {}", index + 1);
    let Value::Object(object) = feature else {
        return Err(form(
            numbered(),
            kind_of(&feature),
            "a Feature with properties and geometry",
        ));
    };
    let label = label(object.get("properties").and_then(Value::as_object), index);
    let place = || label.clone();
    refuse_unknown(
        &object,
        place,
        &["type", "id", "bbox", "properties", "geometry"],
        "`type`, `id`, `bbox`, `properties` or `geometry`",
    )?;
    let round = match object
        .get("geometry")
        .and_then(|geometry| geometry.get("type"))
        .and_then(Value::as_str)
    {
        Some("Point") => Round::Circle,
        Some("LineString") => Round::Corridor,
        Some(_) | None => Round::No,
    };
    let (properties, round_m) = match object.get("properties") {
        Some(Value::Object(map)) => properties::read(map, &label, round)?,
        Some(_) | None => {
            return Err(form(
                place(),
                "no `properties`".to_owned(),
                "an object with `name` and `kind`",
            ));
        }
    };
    if let Some(Value::Object(geometry)) = object.get("geometry") {
        let place = || format!("{label} geometry");
        refuse_unknown(
            geometry,
            place,
            &["type", "coordinates", "bbox"],
            "`type` or `coordinates`",
        )?;
        refuse_strange(geometry, &label)?;
    }
    let feature = serde_json::from_value::<Feature>(Value::Object(object))
        .map_err(|error| form(place(), shortened(&error.to_string()), "a Feature of RFC 7946"))?;
    let polygons = match feature.geometry.map(|geometry| geometry.value) {
        Some(GeometryValue::Polygon { coordinates }) => vec![coordinates],
        Some(GeometryValue::MultiPolygon { coordinates }) => coordinates,
        Some(GeometryValue::Point { coordinates }) => {
            let place = || label.clone();
            let centre = position(coordinates.as_slice(), 0, LONGITUDE_FIRST, &place)?;
            return RawZone::circle(label, properties, centre, round_m);
        }
        Some(GeometryValue::LineString { coordinates }) => {
            let line = positions(&coordinates, &|| label.clone())?;
            return RawZone::corridor(label, properties, &line, round_m);
        }
        Some(
            other @ (GeometryValue::MultiPoint { .. }
            | GeometryValue::MultiLineString { .. }
            | GeometryValue::GeometryCollection { .. }),
        ) => {
            return Err(form(place(), format!("geometry is {}", other.type_name()), GEOMETRY));
        }
        None => return Err(form(place(), "no geometry".to_owned(), GEOMETRY)),
    };
    if polygons.is_empty() || polygons.iter().any(Vec::is_empty) {
        return Err(form(place(), "polygon without rings".to_owned(), "an outer ring"));
    }
    let several = polygons.len() > 1;
    let mut raw = Vec::with_capacity(polygons.len());
    for (number, rings) in polygons.into_iter().enumerate() {
        let mut polygon = Vec::with_capacity(rings.len());
        for (hole, ring) in rings.into_iter().enumerate() {
            let place = || ring_place(&label, several, number, hole);
            polygon.push(RawRing {
                positions: positions(&ring, &|| place().to_string())?,
                numbers: None,
            });
        }
        raw.push(polygon);
    }
    Ok(RawZone {
        label,
        properties,
        polygons: raw,
    })
}

fn ring_place(label: &str, several: bool, polygon: usize, hole: usize) -> Place {
    Place {
        feature: label.to_owned(),
        polygon: several.then_some(polygon + 1),
        hole: (hole > 0).then_some(hole),
    }
}

/// Refuses a position that is not a list of numbers, and says where, which the parser of features does not.
fn refuse_strange(geometry: &Map<String, Value>, label: &str) -> Result<(), FenceError> {
    let Some(coordinates) = geometry.get("coordinates") else {
        return Ok(());
    };
    let polygons = match geometry.get("type").and_then(Value::as_str) {
        Some("Point") => return numbers(slice::from_ref(coordinates), &|| label.to_owned()),
        Some("LineString") => return numbers(array(coordinates), &|| label.to_owned()),
        Some("Polygon") => slice::from_ref(coordinates),
        Some("MultiPolygon") => array(coordinates),
        Some(_) | None => &[],
    };
    for (polygon, rings) in polygons.iter().enumerate() {
        for (hole, ring) in array(rings).iter().enumerate() {
            let place = || ring_place(label, polygons.len() > 1, polygon, hole).to_string();
            numbers(array(ring), &place)?;
        }
    }
    Ok(())
}

fn array(value: &Value) -> &[Value] {
    value.as_array().map_or(&[], Vec::as_slice)
}

fn numbers(line: &[Value], place: &dyn Fn() -> String) -> Result<(), FenceError> {
    let is_position = |value: &Value| value.as_array().is_some_and(|list| list.iter().all(Value::is_number));
    match line.iter().position(|value| !is_position(value)) {
        Some(index) => Err(FenceError::Vertex {
            place: place(),
            vertex: index + 1,
            found: shortened(&line[index].to_string()),
            expected: "longitude and latitude",
        }),
        None => Ok(()),
    }
}

fn positions(line: &[geojson::Position], place: &dyn Fn() -> String) -> Result<Vec<Position>, FenceError> {
    let numbered = line.iter().enumerate();
    numbered
        .map(|(index, raw)| position(raw.as_slice(), index, LONGITUDE_FIRST, place))
        .collect()
}

fn refuse_unknown(
    object: &Map<String, Value>,
    place: impl Fn() -> String,
    known: &[&str],
    expected: &'static str,
) -> Result<(), FenceError> {
    match object.keys().find(|key| !known.contains(&key.as_str())) {
        Some(key) => Err(FenceError::UnknownKey {
            place: place(),
            key: shortened(key),
            expected,
        }),
        None => Ok(()),
    }
}
