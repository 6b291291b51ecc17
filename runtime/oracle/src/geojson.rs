use serde_json::{Map, Value};

use crate::earth::wrap_180;
use crate::error::OracleError;
use crate::plane::Point;
use crate::zone::{Kind, Zone};

/// Far more vertices than a fence has.
const VERTICES_MAX: usize = 1_000_000;
/// Nearer to the poles, the plane of a point is of no use.
const LATITUDE_MAX_DEG: f64 = 85.0;

/// If the name of a property contains one of these words, the property limits when the zone is valid.
const TIMES: [&str; 5] = ["valid", "from", "until", "window", "time"];

/// Reads a feature collection of polygons (RFC 7946). Returns the reference of their longitudes, and the zones.
pub(crate) fn read(text: &str) -> Result<(f64, Vec<Zone>), OracleError> {
    let document: Value = serde_json::from_str(text).map_err(|error| OracleError::Json(error.to_string()))?;
    if document.get("type").and_then(Value::as_str) != Some("FeatureCollection") {
        return Err(OracleError::Document {
            expected: "a FeatureCollection",
        });
    }
    let features = document
        .get("features")
        .and_then(Value::as_array)
        .ok_or(OracleError::Document {
            expected: "a list of features",
        })?;
    let mut reader = Reader {
        index: 0,
        reference: None,
        vertices: 0,
    };
    let mut zones = Vec::with_capacity(features.len());
    for (index, feature) in features.iter().enumerate() {
        reader.index = index;
        zones.push(reader.feature(feature)?);
    }
    if !zones.iter().any(|zone| zone.kind == Kind::KeepIn) {
        return Err(OracleError::Document {
            expected: "at least one keep-in zone",
        });
    }
    Ok((reader.reference.unwrap_or(0.0), zones))
}

struct Reader {
    index: usize,
    reference: Option<f64>,
    vertices: usize,
}

impl Reader {
    fn fail<T>(&self, what: &'static str, expected: &'static str) -> Result<T, OracleError> {
        Err(OracleError::Feature {
            index: self.index,
            what,
            expected,
        })
    }

    fn feature(&mut self, feature: &Value) -> Result<Zone, OracleError> {
        let Some(properties) = feature.get("properties").and_then(Value::as_object) else {
            return self.fail("properties", "an object");
        };
        let Some(name) = properties.get("name").and_then(Value::as_str) else {
            return self.fail("property name", "a text");
        };
        let kind = match properties.get("kind").and_then(Value::as_str) {
            Some("keep-in") => Kind::KeepIn,
            Some("keep-out") => Kind::KeepOut,
            Some(_) | None => return self.fail("property kind", "keep-in or keep-out"),
        };
        let mut zone = Zone::new(
            name.to_owned(),
            kind,
            self.metres(properties, "margin_m")?.unwrap_or(0.0),
            [
                self.metres(properties, "depth_min_m")?.unwrap_or(f64::NEG_INFINITY),
                self.metres(properties, "depth_max_m")?.unwrap_or(f64::INFINITY),
            ],
            self.metres(properties, "altitude_min_m")?.unwrap_or(0.0),
            self.rings(feature)?,
        );
        let names_time = |key: &String| TIMES.iter().any(|part| key.contains(part));
        zone.timed = properties
            .iter()
            .any(|(key, value)| names_time(key) && !value.is_null());
        zone.surfacing = properties.get("surfacing").and_then(Value::as_bool) == Some(true);
        if zone.depth_min_m > zone.depth_max_m {
            return self.fail("property depth_max_m", "at least depth_min_m");
        }
        Ok(zone)
    }

    fn metres(&self, properties: &Map<String, Value>, key: &'static str) -> Result<Option<f64>, OracleError> {
        match properties.get(key) {
            None | Some(Value::Null) => Ok(None),
            Some(value) => match value.as_f64() {
                Some(metres) if (-100.0..=12_000.0).contains(&metres) => Ok(Some(metres)),
                Some(_) | None => self.fail(key, "metres from -100 to 12000"),
            },
        }
    }

    /// The rings of all polygons. Inside and outside alternate over all rings, so holes need no mark.
    fn rings(&mut self, feature: &Value) -> Result<Vec<Vec<Point>>, OracleError> {
        let geometry = feature.get("geometry");
        let coordinates = geometry
            .and_then(|geometry| geometry.get("coordinates"))
            .and_then(Value::as_array);
        let kind = geometry
            .and_then(|geometry| geometry.get("type"))
            .and_then(Value::as_str);
        let mut rings = Vec::new();
        match (kind, coordinates) {
            (Some("Polygon"), Some(polygon)) => self.polygon(polygon, &mut rings)?,
            (Some("MultiPolygon"), Some(polygons)) => {
                for polygon in polygons {
                    let Some(polygon) = polygon.as_array() else {
                        return self.fail("coordinates", "a list of polygons");
                    };
                    self.polygon(polygon, &mut rings)?;
                }
            }
            (Some(_) | None, Some(_) | None) => {
                return self.fail("geometry", "a Polygon or MultiPolygon with coordinates");
            }
        }
        if rings.is_empty() {
            return self.fail("coordinates", "at least one ring");
        }
        Ok(rings)
    }

    fn polygon(&mut self, polygon: &[Value], rings: &mut Vec<Vec<Point>>) -> Result<(), OracleError> {
        for ring in polygon {
            let Some(positions) = ring.as_array() else {
                return self.fail("coordinates", "a list of rings");
            };
            self.vertices += positions.len();
            if positions.len() < 4 || self.vertices > VERTICES_MAX {
                return self.fail(
                    "coordinates",
                    "rings of at least 4 positions, and at most a million positions in all",
                );
            }
            let mut points = Vec::with_capacity(positions.len());
            for position in positions {
                points.push(self.position(position)?);
            }
            if points.first() != points.last() {
                return self.fail("coordinates", "rings that end where they begin");
            }
            rings.push(points);
        }
        Ok(())
    }

    fn position(&mut self, position: &Value) -> Result<Point, OracleError> {
        let number = |at: usize| position.get(at).and_then(Value::as_f64);
        match (number(0), number(1)) {
            (Some(longitude), Some(latitude)) if longitude.abs() <= 180.0 && latitude.abs() <= LATITUDE_MAX_DEG => {
                let reference = *self.reference.get_or_insert(longitude);
                Ok(Point {
                    x: wrap_180(longitude - reference),
                    y: latitude,
                })
            }
            (Some(_) | None, Some(_) | None) => {
                self.fail("coordinates", "longitude within ±180, latitude within ±85 degrees")
            }
        }
    }
}
