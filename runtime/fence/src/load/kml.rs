//! Reads KML 2.3 (OGC 12-007r2): placemarks with polygons, circles and corridors.

use core::slice;

use serde_json::{Map, Value};

use super::properties::{self, Round, shortened};
use super::xml::{self, Element};
use super::{LONGITUDE_FIRST, RawZone, form, position};
use crate::error::{FenceError, Place};
use crate::outline::{RawPolygon, RawRing};
use crate::terms::Terms;
use backseat_units::Position;

const GEOMETRY: &str = "one Polygon, MultiGeometry of Polygons, Point or LineString";

/// All geometries that a placemark may have, including those that cannot be zones.
const GEOMETRIES: &[&str] = &[
    "Polygon",
    "MultiGeometry",
    "Point",
    "LineString",
    "LinearRing",
    "Model",
    "Track",
    "MultiTrack",
];

/// Elements that any feature may have, for its name, drawing and view. They come from KML, Atom, xAL, and Google's
/// `gx`.
const FEATURE: &[&str] = &[
    "name",
    "visibility",
    "balloonVisibility",
    "open",
    "author",
    "link",
    "address",
    "AddressDetails",
    "phoneNumber",
    "Snippet",
    "snippet",
    "description",
    "LookAt",
    "Camera",
    "styleUrl",
    "Style",
    "StyleMap",
    "CascadingStyle",
    "Carousel",
    "Region",
    "Metadata",
];

/// Elements beside placemarks that contain no placemarks.
const BESIDE: &[&str] = &[
    "Schema",
    "ExtendedData",
    "NetworkLinkControl",
    "Tour",
    "GroundOverlay",
    "ScreenOverlay",
    "PhotoOverlay",
];

/// Elements that say how a geometry is drawn.
const DRAWN: &[&str] = &["extrude", "tessellate", "altitudeMode", "altitudeOffset", "drawOrder"];

pub(super) fn read(text: &str, terms: &Terms) -> Result<Vec<RawZone>, FenceError> {
    let root = xml::parse(text)?;
    if root.name != "kml" {
        return Err(at(&root, format!("<{}>", shortened(&root.name)), "<kml>"));
    }
    let mut placemarks = Vec::new();
    find(&root, &mut placemarks)?;
    placemarks.into_iter().map(|placemark| zone(placemark, terms)).collect()
}

/// Finds the placemarks in the order of the file, in any folder.
fn find<'a>(parent: &'a Element, placemarks: &mut Vec<&'a Element>) -> Result<(), FenceError> {
    let searched = [
        "Placemark",
        "Document",
        "Folder",
        "NetworkLink",
        "TimeSpan",
        "TimeStamp",
    ];
    let expected = "<Placemark>, <Document>, <Folder> or another element that KML 2.3 allows here";
    refuse_unknown(parent, &searched, &[FEATURE, BESIDE], expected)?;
    for child in &parent.children {
        match child.name.as_str() {
            "Placemark" => placemarks.push(child),
            "Document" | "Folder" => find(child, placemarks)?,
            "NetworkLink" => return Err(at(child, "<NetworkLink>".to_owned(), "all placemarks in one file")),
            // In KML the placemarks inherit this time.
            "TimeSpan" | "TimeStamp" => {
                return Err(at(child, inside(child, parent), "<TimeSpan> in each <Placemark>"));
            }
            _ => {}
        }
    }
    Ok(())
}

/// Refuses an unknown element or text: if a misspelt hole, zone or time were ignored, the fence would be laxer.
fn refuse_unknown(
    parent: &Element,
    known: &[&str],
    ignored: &[&[&str]],
    expected: &'static str,
) -> Result<(), FenceError> {
    if let Some(word) = parent.text.split_whitespace().next() {
        let found = format!("text `{}` in <{}>", shortened(word), shortened(&parent.name));
        return Err(at(parent, found, expected));
    }
    for child in &parent.children {
        let name = child.name.as_str();
        if ignored.iter().any(|names| names.contains(&name)) {
            refuse_placemarks(child)?;
        } else if !known.contains(&name) {
            return Err(at(child, inside(child, parent), expected));
        }
    }
    Ok(())
}

/// Refuses placemarks, in upper or lower case, inside elements that are not searched for them.
fn refuse_placemarks(ignored: &Element) -> Result<(), FenceError> {
    for child in &ignored.children {
        if child.name.eq_ignore_ascii_case("Placemark") {
            let expected = "placemarks in <Document> and <Folder> only";
            return Err(at(child, inside(child, ignored), expected));
        }
        refuse_placemarks(child)?;
    }
    Ok(())
}

/// The child with a name. It may be absent and must not occur twice.
fn one<'a>(parent: &'a Element, name: &str) -> Result<Option<&'a Element>, FenceError> {
    let mut named = parent.children.iter().filter(|child| child.name == name);
    let first = named.next();
    match named.next() {
        Some(another) => Err(at(
            another,
            format!("another {}", inside(another, parent)),
            "it only once",
        )),
        None => Ok(first),
    }
}

/// The text of an element that must hold only text.
fn text(element: &Element) -> Result<&str, FenceError> {
    match element.children.first() {
        Some(child) => Err(at(child, inside(child, element), "text only")),
        None => Ok(element.text.trim()),
    }
}

fn at(element: &Element, found: String, expected: &'static str) -> FenceError {
    form(format!("line {}", element.line), found, expected)
}

fn inside(child: &Element, parent: &Element) -> String {
    format!("<{}> in <{}>", shortened(&child.name), shortened(&parent.name))
}

fn zone(placemark: &Element, terms: &Terms) -> Result<RawZone, FenceError> {
    let expected = "a geometry, <ExtendedData>, <TimeSpan> or another element that KML 2.3 allows here";
    let known = [GEOMETRIES, &["ExtendedData", "TimeSpan", "TimeStamp"]].concat();
    refuse_unknown(placemark, &known, &[FEATURE], expected)?;
    let name = one(placemark, "name")?.map(text).transpose()?;
    let label = match name {
        Some(name) => format!("line {} placemark '{}'", placemark.line, shortened(name)),
        None => format!("line {} placemark", placemark.line),
    };
    let children = placemark.children.iter();
    let mut geometries = children.filter(|child| GEOMETRIES.contains(&child.name.as_str()));
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
                    "exactly one position for a Point",
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
            refuse_unknown(geometry, &["Polygon"], &[], "<Polygon>")?;
            let several = geometry.children.len() > 1;
            let mut polygons = Vec::with_capacity(geometry.children.len());
            for (child, number) in geometry.children.iter().zip(1..) {
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

/// Reads the properties that a placemark has besides its name.
fn data(placemark: &Element, properties: &mut Map<String, Value>, label: &str) -> Result<(), FenceError> {
    let mut add = |key: &str, text: &str| {
        let value: Value = match text.parse::<f64>() {
            // A text that is not a number stays a text, so that it is refused and not taken for absent.
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
                "it only once",
            )),
        }
    };
    if placemark.children.iter().any(|child| child.name == "TimeStamp") {
        let expected = "<TimeSpan>, `valid_from` or `valid_until`";
        return Err(form(label.to_owned(), "<TimeStamp>".to_owned(), expected));
    }
    if let Some(span) = one(placemark, "TimeSpan")? {
        let expected = "<begin>, <end> or both";
        refuse_unknown(span, &["begin", "end"], &[], expected)?;
        if span.children.is_empty() {
            return Err(at(span, "empty <TimeSpan>".to_owned(), expected));
        }
        for (element, key) in [("begin", "valid_from"), ("end", "valid_until")] {
            let Some(time) = one(span, element)? else { continue };
            if text(time)?.is_empty() {
                return Err(at(time, format!("empty <{element}>"), "a time"));
            }
            add(key, text(time)?)?;
        }
    }
    for extended in placemark.children.iter().filter(|child| child.name == "ExtendedData") {
        let known = ["Data", "SchemaData", "SimpleData"];
        refuse_unknown(extended, &known, &[], "<Data> or <SchemaData>")?;
        for child in &extended.children {
            let entries = if child.name == "SchemaData" {
                refuse_unknown(child, &["Data", "SimpleData"], &[], "<SimpleData>")?;
                &child.children
            } else {
                slice::from_ref(child)
            };
            for entry in entries {
                add(key(entry, label)?, value(entry)?)?;
            }
        }
    }
    Ok(())
}

fn key<'a>(entry: &'a Element, label: &str) -> Result<&'a str, FenceError> {
    entry.name_attribute.as_deref().ok_or_else(|| {
        let place = format!("{label} line {}", entry.line);
        form(place, format!("<{}> without name", entry.name), "an attribute `name`")
    })
}

fn value(data: &Element) -> Result<&str, FenceError> {
    if data.name == "SimpleData" {
        return text(data);
    }
    let expected = "one <value>";
    refuse_unknown(data, &["value"], &[&["displayName"]], expected)?;
    match one(data, "value")? {
        Some(value) => text(value),
        None => Err(at(data, "<Data> without <value>".to_owned(), expected)),
    }
}

fn polygon(element: &Element, number: Option<usize>, label: &str) -> Result<RawPolygon, FenceError> {
    let expected = "<outerBoundaryIs>, <innerBoundaryIs> or a drawing element such as <extrude>";
    refuse_unknown(element, &["outerBoundaryIs", "innerBoundaryIs"], &[DRAWN], expected)?;
    let (mut outer, mut holes) = (None, Vec::new());
    for child in &element.children {
        let inner = match child.name.as_str() {
            "outerBoundaryIs" => false,
            "innerBoundaryIs" => true,
            _ => continue,
        };
        refuse_unknown(child, &["LinearRing"], &[], "<LinearRing>")?;
        if child.children.is_empty() {
            return Err(at(child, format!("empty <{}>", child.name), "<LinearRing>"));
        }
        for ring in &child.children {
            let place = Place {
                feature: label.to_owned(),
                polygon: number,
                hole: inner.then_some(holes.len() + 1),
            };
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

/// Reads positions: longitude, latitude and optionally a height, separated by commas, with blanks between positions.
fn coordinates(element: &Element, place: &str) -> Result<Vec<Position>, FenceError> {
    refuse_unknown(
        element,
        &["coordinates"],
        &[DRAWN],
        "<coordinates> or a drawing element such as <extrude>",
    )?;
    let text = one(element, "coordinates")?.map_or(Ok(""), text)?;
    let numbered = text.split_ascii_whitespace().enumerate();
    numbered
        .map(|(index, tuple)| {
            let numbers: Option<Vec<f64>> = tuple.split(',').map(|number| number.parse().ok()).collect();
            match numbers.as_deref() {
                Some([longitude, latitude] | [longitude, latitude, _]) => {
                    position(&[*longitude, *latitude], index, LONGITUDE_FIRST, &|| place.to_owned())
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
