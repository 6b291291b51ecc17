//! Shapes on the map, and how viewers are told of them.

use backseat_core::plugin::PositionRequest;
use backseat_units::math::atan2;
use backseat_units::{EastNorth, LocalFrame, Position};
use serde::Serialize;
use serde_json::{Value, json};

use super::{Batch, Topic};

/// A circle is drawn as a line with this many sides.
const SIDES: u32 = 36;
/// A circle that is larger than this is not drawn, metres: the formulas do not hold there.
const RADIUS_MAX_M: f64 = LocalFrame::RADIUS_M;
/// The same for circles that are closer to a pole than this, degrees of latitude.
const LATITUDE_MAX_DEG: f64 = 85.0;

/// A shape.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Shape {
    /// One place.
    Point(Position),
    /// Places one after the other.
    Line(Vec<Position>),
}

impl Shape {
    /// A circle; `None` if it cannot be drawn.
    pub(super) fn circle(centre: Position, radius_m: f64) -> Option<Self> {
        let drawable = radius_m > 0.0 && radius_m <= RADIUS_MAX_M;
        if !drawable || centre.latitude.as_deg().abs() > LATITUDE_MAX_DEG {
            return None;
        }
        let frame = LocalFrame::new(centre);
        let at = |side: u32| {
            let bearing_deg = 360.0 * f64::from(side % SIDES) / f64::from(SIDES);
            frame.to_position(EastNorth::new(0.0, 0.0).offset(bearing_deg, radius_m))
        };
        Some(Self::Line((0..=SIDES).map(at).collect()))
    }

    /// All places within a radius of a line, by their outline; `None` if that cannot be drawn.
    pub(super) fn capsule(frame: &LocalFrame, from: EastNorth, to: EastNorth, radius_m: f64) -> Option<Self> {
        if !(radius_m > 0.0 && radius_m <= RADIUS_MAX_M) {
            return None;
        }
        let bearing_deg = atan2(to.east_m - from.east_m, to.north_m - from.north_m).to_degrees();
        let half = SIDES / 2;
        let around = |end: EastNorth, first_deg: f64| {
            (0..=half).map(move |side| {
                let turned_deg = 180.0 * f64::from(side) / f64::from(half);
                end.offset(first_deg + turned_deg, radius_m)
            })
        };
        let outline = around(to, bearing_deg - 90.0).chain(around(from, bearing_deg + 90.0));
        let mut outline: Vec<Position> = outline.map(|place| frame.to_position(place)).collect();
        outline.extend(outline.first().copied());
        Some(Self::Line(outline))
    }

    /// The feature of GeoJSON, with these properties and a colour.
    pub(super) fn feature(&self, colour: &str, mut properties: Value) -> Value {
        properties["style"] = json!({"color": colour});
        let coordinates = |position: &Position| json!([position.longitude.as_deg(), position.latitude.as_deg()]);
        let geometry = match self {
            Self::Point(position) => json!({"type": "Point", "coordinates": coordinates(position)}),
            Self::Line(positions) => {
                let positions: Vec<Value> = positions.iter().map(coordinates).collect();
                json!({"type": "LineString", "coordinates": positions})
            }
        };
        json!({"type": "Feature", "geometry": geometry, "properties": properties})
    }
}

/// The position that a plugin asked for, if it is one.
pub(super) fn asked(position: PositionRequest) -> Option<Position> {
    Position::from_deg(position.latitude_deg, position.longitude_deg).ok()
}

/// The colour of a request by its state.
pub(super) fn colour(state: &str) -> &'static str {
    match state {
        "rejected" | "failed" | "timed-out" => "#d62728",
        "unknown" => "#ff7f0e",
        "started" => "#2ca02c",
        "ended" | "cancelled" => "#7f7f7f",
        _ => "#1f77b4",
    }
}

/// Adds a message with these features.
pub(super) fn write_features(topic: Topic, features: Vec<Value>, batch: &mut Batch) {
    let collection = json!({"type": "FeatureCollection", "features": features});
    write_geojson(topic, &collection.to_string(), batch);
}

/// Adds a message with this GeoJSON.
pub(super) fn write_geojson(topic: Topic, geojson: &str, batch: &mut Batch) {
    #[derive(Serialize)]
    struct Message<'a> {
        geojson: &'a str,
    }
    batch.add(topic, |out| {
        serde_json::to_writer(out, &Message { geojson }).expect("a Vec takes every string");
    });
}
