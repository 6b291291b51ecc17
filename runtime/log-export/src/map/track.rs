use geojson::{Feature, GeometryValue, JsonObject};
use serde_json::Value;

use super::{feature, point, stamped};
use crate::contents::{Gap, Message};
use crate::flatten::flatten;

/// Its height is above the sea's surface, so a depth is negative.
const LOCATION_FIX: &str = "foxglove.LocationFix";
/// What a point's position says already, and in [`LOCATION_FIX`] what does not describe the vehicle.
const LEFT_OUT: [&str; 4] = ["timestamp.", "frame_id", "position_covariance", "altitude"];

/// A position of the vehicle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Fix {
    /// Nanoseconds since 1970.
    pub(crate) log_time: u64,
    /// Seconds of the run.
    pub(crate) t_s: f64,
    pub(crate) longitude_deg: f64,
    pub(crate) latitude_deg: f64,
    pub(crate) depth_m: f64,
}

impl Fix {
    /// Navigation has its position at the top, the truth in an object of its own, and Foxglove's schema other names.
    pub(crate) fn of(message: &Message<'_>) -> Option<Self> {
        let value = &message.value;
        let position = value.get("position").unwrap_or(value);
        let [longitude, latitude] = if message.schema == LOCATION_FIX {
            ["longitude", "latitude"]
        } else {
            ["longitude_deg", "latitude_deg"]
        };
        let angle = |name: &str, most: f64| {
            let angle = position.get(name).and_then(Value::as_f64)?;
            (angle.abs() <= most).then_some(angle)
        };
        let depth_m = if message.schema == LOCATION_FIX {
            value.get("altitude").and_then(Value::as_f64).map(|altitude| -altitude)
        } else {
            let depth = value.get("depth_m").or_else(|| position.get("depth_m"));
            depth.and_then(Value::as_f64)
        };
        Some(Self {
            log_time: message.log_time,
            t_s: message.t_s,
            longitude_deg: angle(longitude, 180.0)?,
            latitude_deg: angle(latitude, 90.0)?,
            depth_m: depth_m?,
        })
    }

    /// Longitude, latitude, height above the surface.
    pub(crate) fn position(self) -> [f64; 3] {
        // Zero and not minus zero at the surface.
        [self.longitude_deg, self.latitude_deg, 0.0 - self.depth_m]
    }
}

/// Where the vehicle was.
#[derive(Debug)]
pub(crate) struct Track {
    /// The name of its layer.
    pub(crate) name: &'static str,
    /// All positions, apart where records are missing between two.
    pub(crate) parts: Vec<Vec<Fix>>,
    /// A position each so many seconds, with everything else that its message has.
    pub(crate) points: Vec<(Fix, JsonObject)>,
    every_s: f64,
    next_s: f64,
    /// What another channel says of the next point.
    described: Option<JsonObject>,
    /// The gaps that are still to come, the next one last.
    gaps: Vec<Gap>,
}

impl Track {
    pub(super) fn new(name: &'static str, every_s: f64, gaps: &[Gap]) -> Self {
        let mut gaps = gaps.to_vec();
        gaps.sort_by(|a, b| b.until_s.total_cmp(&a.until_s));
        Self {
            name,
            parts: Vec::new(),
            points: Vec::new(),
            every_s,
            next_s: f64::NEG_INFINITY,
            described: None,
            gaps,
        }
    }

    pub(super) fn last(&self) -> Option<Fix> {
        self.parts.last()?.last().copied()
    }

    pub(super) fn add(&mut self, message: &Message<'_>) {
        let Some(fix) = Fix::of(message) else { return };
        let last = self.last();
        let mut apart = last.is_none();
        while self.gaps.last().is_some_and(|gap| gap.until_s <= fix.t_s) {
            self.gaps.pop();
            apart = true;
        }
        // A line may not cross the date line (RFC 7946, section 3.1.9).
        apart |= last.is_some_and(|last| (fix.longitude_deg - last.longitude_deg).abs() > 180.0);
        if apart {
            self.parts.push(Vec::new());
        }
        if let Some(part) = self.parts.last_mut() {
            part.push(fix);
        }
        if fix.t_s >= self.next_s {
            // Counted from zero, so that the tracks have their points at the same times.
            self.next_s = ((fix.t_s / self.every_s).floor() + 1.0) * self.every_s;
            let mut properties = self.described.take().unwrap_or_else(|| description(message));
            properties.extend(stamped(message));
            self.points.push((fix, properties));
        }
    }

    /// Takes what another channel says of the vehicle at its next position.
    pub(super) fn describe(&mut self, message: &Message<'_>) {
        if message.t_s >= self.next_s {
            self.described = Some(description(message));
        }
    }

    /// The lines and points, for GeoJSON.
    pub(crate) fn features(&self) -> impl Iterator<Item = Feature> {
        let many = self.parts.len() > 1;
        let lines = self.parts.iter().filter(|part| part.len() > 1).enumerate();
        let lines = lines.map(move |(number, part)| {
            let line = part.iter().map(|fix| fix.position().into()).collect();
            let mut properties = JsonObject::new();
            if many {
                properties.insert("part".to_owned(), (number + 1).into());
            }
            for (name, fix) in [("from", part.first()), ("until", part.last())] {
                if let Some(fix) = fix {
                    properties.insert(name.to_owned(), crate::time::rfc3339(fix.log_time).into());
                    properties.insert(format!("{name}_s"), fix.t_s.into());
                }
            }
            feature(GeometryValue::LineString { coordinates: line }, properties)
        });
        let points = self.points.iter();
        lines.chain(points.map(|(fix, properties)| feature(point(*fix), properties.clone())))
    }
}

/// What a message says of the vehicle beside its position.
fn description(message: &Message<'_>) -> JsonObject {
    let is_fix = message.schema == LOCATION_FIX;
    let mut properties = JsonObject::new();
    flatten(&message.value, &mut |path, value| {
        let is_position = ["latitude_deg", "longitude_deg", "latitude", "longitude"]
            .iter()
            .any(|name| path.ends_with(name));
        let is_left_out = is_fix && LEFT_OUT.iter().any(|start| path.starts_with(start));
        if !is_position && !is_left_out {
            properties.insert(path.to_owned(), value.clone());
        }
    });
    if let Some(fix) = Fix::of(message).filter(|_| is_fix) {
        properties.insert("depth_m".to_owned(), fix.depth_m.into());
    }
    properties
}
