//! KML 2.3 (OGC 12-007r2): placemarks with polygons, circles and corridors.

use serde_json::{Map, Value};

use super::properties::{self, Round, shortened};
use super::xml::{self, Element};
use super::{RawZone, form, position};
use crate::error::{FenceError, Place};
use crate::outline::{RawPolygon, RawRing};
use crate::terms::Terms;
use backseat_units::Position;

const GEOMETRY: &str = "one Polygon, MultiGeometry of Polygons, Point or LineString";

pub(super) fn read(text: &str, terms: &Terms) -> Result<Vec<RawZone>, FenceError> {
    let root = xml::parse(text)?;
    if root.name != "kml" {
        return Err(form(format!("line {}", root.line), format!("<{}>", root.name), "<kml>"));
    }
    let mut placemarks = Vec::new();
    find(&root, &mut placemarks)?;
    placemarks.into_iter().map(|placemark| zone(placemark, terms)).collect()
}

/// The placemarks in the order of the file, whatever folders they lie in.
fn find<'a>(parent: &'a Element, placemarks: &mut Vec<&'a Element>) -> Result<(), FenceError> {
    for child in &parent.children {
        match child.name.as_str() {
            "Placemark" => placemarks.push(child),
            "Document" | "Folder" => find(child, placemarks)?,
            "NetworkLink" => {
                let place = format!("line {}", child.line);
                return Err(form(place, "<NetworkLink>".to_owned(), "all placemarks in one file"));
            }
            // Styles, views, descriptions.
            _ => {}
        }
    }
    Ok(())
}

fn zone(placemark: &Element, terms: &Terms) -> Result<RawZone, FenceError> {
    let name = placemark.child("name").map(|name| name.text.trim());
    let label = match name {
        Some(name) => format!("line {} placemark '{}'", placemark.line, shortened(name)),
        None => format!("line {} placemark", placemark.line),
    };
    let mut geometries = placemark.children.iter().filter(|child| {
        let geometry = child.name.as_str();
        matches!(
            geometry,
            "Polygon" | "MultiGeometry" | "Point" | "LineString" | "LinearRing" | "Model" | "Track"
        )
    });
    let (geometry, another) = (geometries.next(), geometries.next());
    let (Some(geometry), None) = (geometry, another) else {
        let found = if another.is_some() {
            "several geometries"
        } else {
            "no geometry"
        };
        return Err(form(label, found.to_owned(), GEOMETRY));
    };
    let round = match geometry.name.as_str() {
        "Point" => Round::Circle,
        "LineString" => Round::Corridor,
        _ => Round::No,
    };
    let mut properties = Map::new();
    if let Some(name) = name {
        properties.insert("name".to_owned(), name.into());
    }
    data(placemark, &mut properties, &label)?;
    terms.complete(&mut properties);
    let (properties, round_m) = properties::read(&properties, &label, round)?;
    let polygons = match geometry.name.as_str() {
        "Point" => {
            let line = coordinates(geometry, &label)?;
            let [centre] = *line else {
                return Err(form(
                    label,
                    format!("{} positions", line.len()),
                    "the one position of a Point",
                ));
            };
            return RawZone::circle(label, properties, centre, round_m);
        }
        "LineString" => {
            let line = coordinates(geometry, &label)?;
            return RawZone::corridor(label, properties, &line, round_m);
        }
        "Polygon" => vec![polygon(geometry, None, &label)?],
        "MultiGeometry" => {
            let several = geometry.children.len() > 1;
            let mut polygons = Vec::with_capacity(geometry.children.len());
            for (child, number) in geometry.children.iter().zip(1..) {
                if child.name != "Polygon" {
                    return Err(form(label, format!("<{}> in <MultiGeometry>", child.name), "<Polygon>"));
                }
                polygons.push(polygon(child, several.then_some(number), &label)?);
            }
            polygons
        }
        other => return Err(form(label, format!("<{other}>"), GEOMETRY)),
    };
    if polygons.is_empty() {
        return Err(form(label, "empty <MultiGeometry>".to_owned(), GEOMETRY));
    }
    Ok(RawZone {
        label,
        properties,
        polygons,
    })
}

/// The properties that a placemark bears beside its name.
fn data(placemark: &Element, properties: &mut Map<String, Value>, label: &str) -> Result<(), FenceError> {
    let mut add = |key: &str, text: &str| {
        let text = text.trim();
        let value: Value = match text.parse::<f64>() {
            // What is no number stays a text, so that it is refused and not taken for absent.
            Ok(number) if number.is_finite() => number.into(),
            _ if text == "true" => true.into(),
            _ if text == "false" => false.into(),
            // Geographic information systems write every column for every placemark.
            _ if text.is_empty() => return Ok(()),
            _ => text.into(),
        };
        match properties.insert(key.to_owned(), value) {
            None => Ok(()),
            Some(_) => Err(form(
                label.to_owned(),
                format!("`{}` given twice", shortened(key)),
                "it once",
            )),
        }
    };
    for child in &placemark.children {
        let entries: Vec<_> = match child.name.as_str() {
            "ExtendedData" => child.children.iter().flat_map(schema_data).collect(),
            "TimeSpan" => {
                for (element, key) in [("begin", "valid_from"), ("end", "valid_until")] {
                    if let Some(time) = child.child(element) {
                        add(key, &time.text)?;
                    }
                }
                continue;
            }
            "TimeStamp" => {
                let found = "<TimeStamp>".to_owned();
                return Err(form(
                    label.to_owned(),
                    found,
                    "<TimeSpan>, `valid_from` or `valid_until`",
                ));
            }
            _ => continue,
        };
        for entry in entries {
            let Some(key) = &entry.name_attribute else {
                let place = format!("{label} line {}", entry.line);
                return Err(form(
                    place,
                    format!("<{}> without name", entry.name),
                    "an attribute `name`",
                ));
            };
            let text = match entry.name.as_str() {
                "Data" => entry.child("value").map_or("", |value| value.text.as_str()),
                _ => entry.text.as_str(),
            };
            add(key, text)?;
        }
    }
    Ok(())
}

/// The data of a schema, or the one that stands alone.
fn schema_data(element: &Element) -> &[Element] {
    if element.name == "SchemaData" {
        &element.children
    } else {
        core::slice::from_ref(element)
    }
}

fn polygon(element: &Element, number: Option<usize>, label: &str) -> Result<RawPolygon, FenceError> {
    let (mut outer, mut holes) = (None, Vec::new());
    for child in &element.children {
        let inner = match child.name.as_str() {
            "outerBoundaryIs" => false,
            "innerBoundaryIs" => true,
            // How it is drawn.
            _ => continue,
        };
        for ring in &child.children {
            let place = Place {
                feature: label.to_owned(),
                polygon: number,
                hole: inner.then_some(holes.len() + 1),
            };
            if ring.name != "LinearRing" {
                return Err(form(place.to_string(), format!("<{}>", ring.name), "<LinearRing>"));
            }
            let ring = RawRing {
                positions: coordinates(ring, &place.to_string())?,
                numbers: None,
            };
            if inner {
                holes.push(ring);
            } else if outer.replace(ring).is_some() {
                return Err(form(
                    place.to_string(),
                    "several outer rings".to_owned(),
                    "one <outerBoundaryIs>",
                ));
            }
        }
    }
    let Some(outer) = outer else {
        return Err(form(
            label.to_owned(),
            "polygon without outer ring".to_owned(),
            "<outerBoundaryIs> with a <LinearRing>",
        ));
    };
    let mut rings = vec![outer];
    rings.append(&mut holes);
    Ok(rings)
}

/// Longitude, latitude and perhaps a height, with commas between them and blanks around.
fn coordinates(element: &Element, place: &str) -> Result<Vec<Position>, FenceError> {
    let text = element
        .child("coordinates")
        .map_or("", |coordinates| coordinates.text.as_str());
    let numbered = text.split_ascii_whitespace().enumerate();
    numbered
        .map(|(index, tuple)| {
            let numbers: Option<Vec<f64>> = tuple.split(',').map(|number| number.parse().ok()).collect();
            match numbers.as_deref() {
                Some([longitude, latitude] | [longitude, latitude, _]) => {
                    position(&[*longitude, *latitude], index, &|| place.to_owned())
                }
                _ => Err(FenceError::Vertex {
                    place: place.to_owned(),
                    vertex: index + 1,
                    found: shortened(tuple),
                    expected: "longitude,latitude",
                }),
            }
        })
        .collect()
}
