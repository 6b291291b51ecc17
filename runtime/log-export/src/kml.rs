//! KML 2.2 with Google's extension for tracks, for Google Earth.
//!
//! Everything is drawn at the surface of the sea: what Google Earth knows of the seabed is too coarse for a track above it.
//! The coordinates have the depth nevertheless, as a negative altitude.

mod words;
mod xml;

use std::io;
use std::path::Path;

use geojson::{Feature, GeometryValue, JsonObject, Position};

use self::words::{described, named};
use self::xml::Xml;
use crate::contents::Contents;
use crate::error::Error;
use crate::flatten::text;
use crate::map::{Fix, Map, Standing, Track};
use crate::output::OutputFile;
use crate::source::Source;
use crate::time::{ctime, rfc3339};
use crate::{Exported, counted};

/// The least time between two positions of a track, seconds. More make Google Earth slow.
const TRACK_S: f64 = 1.0;

/// Styles: name, colour of lines and icons, colour of areas. Colours are alpha, blue, green, red.
const STYLES: [(&str, &str, &str); 8] = [
    ("track", "ff00ffff", "00000000"),
    ("truth", "ffffffff", "00000000"),
    ("keep-in", "ff50c828", "1850c828"),
    ("keep-out", "ff2828dc", "402828dc"),
    ("plan", "ffff9632", "00000000"),
    ("inserts", "fff050d2", "00000000"),
    ("refused", "ff0000ff", "00000000"),
    ("other", "ff14aaff", "00000000"),
];

pub(crate) fn export(source: &Source, every_s: f64, out: &Path) -> Result<Exported, Error> {
    let file = OutputFile::create(out)?;
    let contents = Contents::of(source, |_| false)?;
    let map = Map::of(source, &contents, every_s)?;
    let mut xml = Xml::new(file);
    let written = document(&mut xml, &map, &contents);
    let file = xml.into_inner();
    let placemarks = written.map_err(|error| file.failed(error))?;
    file.commit()?;
    Ok(Exported {
        summary: format!("{}: {}", out.display(), counted(placemarks, "placemark")),
        remarks: [contents.remarks(source), map.remarks(source)].concat(),
    })
}

type Out = Xml<OutputFile>;

fn document(xml: &mut Out, map: &Map, contents: &Contents) -> io::Result<u64> {
    xml.declaration()?;
    let spaces = [
        ("xmlns", "http://www.opengis.net/kml/2.2"),
        ("xmlns:gx", "http://www.google.com/kml/ext/2.2"),
    ];
    let mission = contents.run.get("mission").map_or("run", String::as_str);
    let seed = contents.run.get("seed");
    let mut count = 0;
    xml.within("kml", &spaces, |xml| {
        xml.within("Document", &[], |xml| {
            xml.text("name", &format!("{mission}, {} UTC", ctime(contents.start_ns)))?;
            xml.text("open", "1")?;
            let seed = seed.map_or_else(String::new, |seed| format!("A simulation with seed {seed}. "));
            xml.text(
                "description",
                &format!("{seed}Depths are shown at the surface of the sea."),
            )?;
            STYLES
                .iter()
                .try_for_each(|(name, line, area)| style(xml, name, line, area))?;
            for track in [&map.track, &map.truth] {
                count += whole_track(xml, track)?;
            }
            for layer in &map.layers {
                folder(xml, &capitalised(&layer.name), |xml| {
                    for (number, standing) in layer.features.iter().enumerate() {
                        count += 1;
                        placemark(xml, &layer.name, number + 1, standing)?;
                    }
                    Ok(())
                })?;
            }
            Ok(())
        })
    })?;
    Ok(count)
}

fn folder(xml: &mut Out, name: &str, inner: impl FnOnce(&mut Out) -> io::Result<()>) -> io::Result<()> {
    xml.within("Folder", &[], |xml| {
        xml.text("name", name)?;
        inner(xml)
    })
}

fn style(xml: &mut Out, name: &str, line: &str, area: &str) -> io::Result<()> {
    xml.within("Style", &[("id", name)], |xml| {
        xml.within("IconStyle", &[], |xml| {
            xml.text("color", line)?;
            xml.text("scale", "0.4")?;
            xml.within("Icon", &[], |xml| {
                xml.text("href", "http://maps.google.com/mapfiles/kml/shapes/shaded_dot.png")
            })
        })?;
        // Names appear when the icon is clicked: hundreds of them would hide the map.
        xml.within("LabelStyle", &[], |xml| xml.text("scale", "0"))?;
        xml.within("LineStyle", &[], |xml| {
            xml.text("color", line)?;
            xml.text("width", "2")
        })?;
        xml.within("PolyStyle", &[], |xml| xml.text("color", area))
    })
}

/// The lines of a track, which the time slider plays, and its points. Returns how many placemarks there are.
fn whole_track(xml: &mut Out, track: &Track) -> io::Result<u64> {
    if track.parts.is_empty() {
        return Ok(0);
    }
    let title = if track.name == "truth" { "True track" } else { "Track" };
    folder(xml, title, |xml| {
        for part in &track.parts {
            xml.within("Placemark", &[], |xml| {
                xml.text("name", title)?;
                xml.text("styleUrl", &format!("#{}", track.name))?;
                xml.within("gx:Track", &[], |xml| {
                    xml.text("altitudeMode", "clampToGround")?;
                    thinned(part).try_for_each(|fix| xml.text("when", &rfc3339(fix.log_time)))?;
                    thinned(part).try_for_each(|fix| xml.text("gx:coord", &joined(&fix.position(), " ")))
                })
            })?;
        }
        folder(xml, "Points", |xml| {
            for (fix, properties) in &track.points {
                xml.within("Placemark", &[], |xml| {
                    let time = rfc3339(fix.log_time);
                    xml.text("name", time.get(11..19).unwrap_or(&time))?;
                    xml.text("description", &described(properties))?;
                    xml.within("TimeStamp", &[], |xml| xml.text("when", &time))?;
                    xml.text("styleUrl", &format!("#{}", track.name))?;
                    data(xml, track.name, properties)?;
                    xml.within("Point", &[], |xml| {
                        xml.text("coordinates", &joined(&fix.position(), ","))
                    })
                })?;
            }
            Ok(())
        })
    })?;
    Ok((track.parts.len() + track.points.len()) as u64)
}

fn thinned(part: &[Fix]) -> impl Iterator<Item = &Fix> {
    let mut next_s = f64::NEG_INFINITY;
    part.iter().filter(move |fix| {
        let due = fix.t_s >= next_s;
        if due {
            next_s = (fix.t_s / TRACK_S).floor() * TRACK_S + TRACK_S;
        }
        due
    })
}

fn placemark(xml: &mut Out, layer: &str, number: usize, standing: &Standing) -> io::Result<()> {
    let feature = standing.stamped();
    let properties = feature.properties.clone().unwrap_or_default();
    xml.within("Placemark", &[], |xml| {
        xml.text("name", &named(layer, number, &properties))?;
        xml.text("description", &described(&properties))?;
        // The fence is there before the run begins.
        if layer != "fence" {
            xml.within("TimeSpan", &[], |xml| {
                xml.text("begin", &rfc3339(standing.from.log_time))?;
                match standing.until {
                    Some(until) => xml.text("end", &rfc3339(until.log_time)),
                    None => Ok(()),
                }
            })?;
        }
        xml.text("styleUrl", &format!("#{}", style_of(layer, &feature)))?;
        data(xml, layer, &properties)?;
        match &feature.geometry {
            Some(shape) => geometry(xml, &shape.value),
            None => Ok(()),
        }
    })
}

fn style_of(layer: &str, feature: &Feature) -> &'static str {
    let is = |name: &str, values: &[&str]| {
        let value = feature.property(name).and_then(serde_json::Value::as_str);
        value.is_some_and(|value| values.contains(&value))
    };
    let state_refused = is("state", &["rejected", "failed", "timed-out"]);
    match layer {
        "fence" if is("kind", &["keep-out"]) => "keep-out",
        "fence" => "keep-in",
        "plan" => "plan",
        _ if state_refused => "refused",
        "inserts" => "inserts",
        _ => "other",
    }
}

/// The properties, for programs.
fn data(xml: &mut Out, layer: &str, properties: &JsonObject) -> io::Result<()> {
    xml.within("ExtendedData", &[], |xml| {
        let mut put = |name: &str, value: &str| xml.within("Data", &[("name", name)], |xml| xml.text("value", value));
        put("layer", layer)?;
        let mut present = properties.iter().filter(|(_, value)| !value.is_null());
        present.try_for_each(|(name, value)| put(name, &text(value)))
    })
}

fn geometry(xml: &mut Out, value: &GeometryValue) -> io::Result<()> {
    let many = |xml: &mut Out, inner: &dyn Fn(&mut Out) -> io::Result<()>| xml.within("MultiGeometry", &[], inner);
    match value {
        GeometryValue::Point { coordinates } => point(xml, coordinates),
        GeometryValue::LineString { coordinates } => line(xml, "LineString", coordinates),
        GeometryValue::Polygon { coordinates } => polygon(xml, coordinates),
        GeometryValue::MultiPoint { coordinates } => {
            many(xml, &|xml| coordinates.iter().try_for_each(|place| point(xml, place)))
        }
        GeometryValue::MultiLineString { coordinates } => many(xml, &|xml| {
            coordinates
                .iter()
                .try_for_each(|places| line(xml, "LineString", places))
        }),
        GeometryValue::MultiPolygon { coordinates } => {
            many(xml, &|xml| coordinates.iter().try_for_each(|rings| polygon(xml, rings)))
        }
        GeometryValue::GeometryCollection { geometries } => many(xml, &|xml| {
            geometries.iter().try_for_each(|part| geometry(xml, &part.value))
        }),
    }
}

fn point(xml: &mut Out, place: &Position) -> io::Result<()> {
    xml.within("Point", &[], |xml| {
        xml.text("coordinates", &joined(place.as_slice(), ","))
    })
}

/// A line or a ring. Tessellated, it follows the surface of the sea.
fn line(xml: &mut Out, element: &str, places: &[Position]) -> io::Result<()> {
    let places: Vec<String> = places.iter().map(|place| joined(place.as_slice(), ",")).collect();
    xml.within(element, &[], |xml| {
        xml.text("tessellate", "1")?;
        xml.text("coordinates", &places.join(" "))
    })
}

fn polygon(xml: &mut Out, rings: &[Vec<Position>]) -> io::Result<()> {
    xml.within("Polygon", &[], |xml| {
        xml.text("tessellate", "1")?;
        for (number, ring) in rings.iter().enumerate() {
            let boundary = if number == 0 {
                "outerBoundaryIs"
            } else {
                "innerBoundaryIs"
            };
            xml.within(boundary, &[], |xml| line(xml, "LinearRing", ring))?;
        }
        Ok(())
    })
}

fn joined(numbers: &[f64], between: &str) -> String {
    // KML has longitude, latitude and altitude; GeoJSON can have more.
    let numbers: Vec<String> = numbers.iter().take(3).map(f64::to_string).collect();
    numbers.join(between)
}

fn capitalised(name: &str) -> String {
    let mut characters = name.chars();
    match characters.next() {
        Some(first) => first.to_uppercase().chain(characters).collect(),
        None => String::new(),
    }
}
