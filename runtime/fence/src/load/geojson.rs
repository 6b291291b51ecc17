//! GeoJSON (RFC 7946).

use geojson::{Feature, GeometryValue};
use serde_json::{Map, Value};

use super::properties::{self, Round, label, shortened};
use super::{GEOMETRY, RawZone, form, json, kind_of, position};
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
    // The last one is what GDAL writes beside the features.
    let known = ["type", "name", "crs", "bbox", "xy_coordinate_resolution"];
    refuse_unknown(&document, place, &known, "`type`, `name`, `crs`, `bbox` or `features`")?;
    features
        .into_iter()
        .enumerate()
        .map(|(index, feature)| zone(feature, index))
        .collect()
}

/// Only WGS84 in longitude and latitude: the same numbers mean other places elsewhere.
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
    }
    let feature = serde_json::from_value::<Feature>(Value::Object(object))
        .map_err(|error| form(place(), shortened(&error.to_string()), "a Feature of RFC 7946"))?;
    let polygons = match feature.geometry.map(|geometry| geometry.value) {
        Some(GeometryValue::Polygon { coordinates }) => vec![coordinates],
        Some(GeometryValue::MultiPolygon { coordinates }) => coordinates,
        Some(GeometryValue::Point { coordinates }) => {
            let place = || label.clone();
            let centre = position(coordinates.as_slice(), 0, &place)?;
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
            let place = || Place {
                feature: label.clone(),
                polygon: several.then_some(number + 1),
                hole: (hole > 0).then_some(hole),
            };
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

fn positions(line: &[geojson::Position], place: &dyn Fn() -> String) -> Result<Vec<Position>, FenceError> {
    let numbered = line.iter().enumerate();
    numbered
        .map(|(index, raw)| position(raw.as_slice(), index, place))
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
