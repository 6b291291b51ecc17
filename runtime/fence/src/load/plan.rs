//! Reads the fence of a plan file of QGroundControl ("Plan File Format" of its developer guide: `fileType` Plan,
//! version 1; `geoFence` version 2). Latitude comes first, and rings are not closed.

use serde_json::{Map, Value};

use super::properties::{self, Round, shortened};
use super::{RawZone, form, json, kind_of, position};
use crate::error::FenceError;
use crate::outline::RawRing;
use crate::terms::Terms;

pub(super) fn read(text: &str, terms: &Terms) -> Result<Vec<RawZone>, FenceError> {
    let document = json::parse(text)?;
    if document.get("fileType").and_then(Value::as_str) != Some("Plan") {
        return Err(wrong("document", document.get("fileType"), "`fileType` of \"Plan\""));
    }
    let fence = match document.get("geoFence") {
        Some(Value::Object(fence)) => fence,
        other => return Err(wrong("`geoFence`", other, "an object with `polygons` and `circles`")),
    };
    if fence.get("version").and_then(Value::as_u64) != Some(2) {
        return Err(wrong("`geoFence` version", fence.get("version"), "2"));
    }
    let known = ["version", "polygons", "circles", "breachReturn"];
    refuse_unknown(
        fence,
        "`geoFence`",
        &known,
        "`version`, `polygons`, `circles` or `breachReturn`",
    )?;
    let mut zones = Vec::new();
    for (object, number) in list(fence, "polygons")?.iter().zip(1..) {
        zones.push(polygon(object, &format!("polygon {number}"), terms)?);
    }
    for (object, number) in list(fence, "circles")?.iter().zip(1..) {
        zones.push(circle(object, &format!("circle {number}"), terms)?);
    }
    Ok(zones)
}

fn list<'a>(fence: &'a Map<String, Value>, key: &str) -> Result<&'a [Value], FenceError> {
    match fence.get(key) {
        Some(Value::Array(list)) => Ok(list),
        Some(other) => Err(wrong(&format!("`geoFence` `{key}`"), Some(other), "an array")),
        None => Ok(&[]),
    }
}

fn polygon(object: &Value, name: &str, terms: &Terms) -> Result<RawZone, FenceError> {
    let label = format!("geoFence {name}");
    let map = part(object, &label, &["version", "inclusion", "polygon"])?;
    let (properties, _) = properties::read(&described(map, name, &label, terms)?, &label, Round::No)?;
    let Some(Value::Array(corners)) = map.get("polygon") else {
        return Err(wrong(&label, map.get("polygon"), "`polygon`, an array of corners"));
    };
    let mut positions = Vec::with_capacity(corners.len() + 1);
    for (index, corner) in corners.iter().enumerate() {
        positions.push(place(corner, index, &label)?);
    }
    positions.extend(positions.first().copied());
    let ring = RawRing {
        positions,
        numbers: None,
    };
    Ok(RawZone {
        label,
        properties,
        polygons: vec![vec![ring]],
    })
}

fn circle(object: &Value, name: &str, terms: &Terms) -> Result<RawZone, FenceError> {
    let label = format!("geoFence {name}");
    let map = part(object, &label, &["version", "inclusion", "circle"])?;
    let circle = part(map.get("circle").unwrap_or(&Value::Null), &label, &["center", "radius"])?;
    let mut described = described(map, name, &label, terms)?;
    described.insert(
        "radius_m".to_owned(),
        circle.get("radius").cloned().unwrap_or(Value::Null),
    );
    let (properties, radius_m) = properties::read(&described, &label, Round::Circle)?;
    let centre = place(circle.get("center").unwrap_or(&Value::Null), 0, &label)?;
    RawZone::circle(label, properties, centre, radius_m)
}

/// The properties with the keys of the GeoJSON form.
fn described(
    map: &Map<String, Value>,
    name: &str,
    label: &str,
    terms: &Terms,
) -> Result<Map<String, Value>, FenceError> {
    let kind = match map.get("inclusion") {
        Some(Value::Bool(true)) => "keep-in",
        Some(Value::Bool(false)) => "keep-out",
        other => return Err(wrong(&format!("{label} `inclusion`"), other, "true or false")),
    };
    let mut properties = Map::new();
    properties.insert("name".to_owned(), name.into());
    properties.insert("kind".to_owned(), kind.into());
    terms.complete(&mut properties);
    Ok(properties)
}

fn part<'a>(object: &'a Value, label: &str, known: &[&str]) -> Result<&'a Map<String, Value>, FenceError> {
    let Value::Object(map) = object else {
        return Err(wrong(label, Some(object), "an object"));
    };
    refuse_unknown(map, label, known, "the keys of `geoFence` version 2")?;
    // Polygons and circles have a version of their own, 1 so far.
    match map.get("version").map(Value::as_u64) {
        None | Some(Some(1)) => Ok(map),
        Some(_) => Err(wrong(&format!("{label} version"), map.get("version"), "1")),
    }
}

fn place(corner: &Value, index: usize, label: &str) -> Result<backseat_units::Position, FenceError> {
    let numbers: Option<Vec<f64>> = corner
        .as_array()
        .and_then(|numbers| numbers.iter().map(Value::as_f64).collect());
    let Some([latitude, longitude]) = numbers.as_deref() else {
        return Err(FenceError::Vertex {
            place: label.to_owned(),
            vertex: index + 1,
            found: shortened(&corner.to_string()),
            expected: "latitude and longitude",
        });
    };
    position(&[*longitude, *latitude], index, "latitude, then longitude", &|| {
        label.to_owned()
    })
}

fn refuse_unknown(
    map: &Map<String, Value>,
    place: &str,
    known: &[&str],
    expected: &'static str,
) -> Result<(), FenceError> {
    match map.keys().find(|key| !known.contains(&key.as_str())) {
        Some(key) => Err(FenceError::UnknownKey {
            place: place.to_owned(),
            key: shortened(key),
            expected,
        }),
        None => Ok(()),
    }
}

fn wrong(place: &str, found: Option<&Value>, expected: &'static str) -> FenceError {
    let found = match found {
        None => "nothing".to_owned(),
        Some(value @ (Value::Array(_) | Value::Object(_))) => kind_of(value),
        Some(value) => shortened(&value.to_string()),
    };
    form(place.to_owned(), found, expected)
}
