//! Boxes with edges parallel to the axes: whether one contains what the vehicle may reach, and whether that is clear of
//! another one.

use crate::monitor::limits::station::{BottomBox, HullBox};
use crate::mutations::{Check, is_on};
use crate::refusal::{BoxBreach, BoxEdge, Refusal, Stretch};

/// One axis of a box: its name, the keys of its bounds, the bounds, and the least and the greatest coordinate that the
/// vehicle may reach.
pub(super) struct Axis {
    name: &'static str,
    keys: [&'static str; 2],
    bounds_m: [f64; 2],
    span_m: [f64; 2],
}

pub(super) fn hull_axes(bounds: &HullBox, spans_m: [[f64; 2]; 3]) -> [Axis; 3] {
    [
        Axis {
            name: "horizontal position",
            keys: ["horizontal_min_m", "horizontal_max_m"],
            bounds_m: [bounds.horizontal_min_m, bounds.horizontal_max_m],
            span_m: spans_m[0],
        },
        Axis {
            name: "vertical position",
            keys: ["vertical_min_m", "vertical_max_m"],
            bounds_m: [bounds.vertical_min_m, bounds.vertical_max_m],
            span_m: spans_m[1],
        },
        Axis {
            name: "distance from the hull",
            keys: ["distance_min_m", "distance_max_m"],
            bounds_m: [bounds.distance_min_m, bounds.distance_max_m],
            span_m: spans_m[2],
        },
    ]
}

pub(super) fn bottom_axes(bounds: &BottomBox, spans_m: [[f64; 2]; 3]) -> [Axis; 3] {
    [
        Axis {
            name: "x",
            keys: ["x_min_m", "x_max_m"],
            bounds_m: [bounds.x_min_m, bounds.x_max_m],
            span_m: spans_m[0],
        },
        Axis {
            name: "y",
            keys: ["y_min_m", "y_max_m"],
            bounds_m: [bounds.y_min_m, bounds.y_max_m],
            span_m: spans_m[1],
        },
        Axis {
            name: "depth",
            keys: ["depth_min_m", "depth_max_m"],
            bounds_m: [bounds.depth_min_m, bounds.depth_max_m],
            span_m: spans_m[2],
        },
    ]
}

/// The least and the greatest value, moved outwards by `grown_m`. If any value is NaN, both are NaN.
pub(super) fn span(values: impl Iterator<Item = f64>, grown_m: f64) -> [f64; 2] {
    let (mut min, mut max) = (f64::INFINITY, f64::NEG_INFINITY);
    for value in values {
        if value.is_nan() {
            return [f64::NAN; 2];
        }
        (min, max) = (min.min(value), max.max(value));
    }
    [min - grown_m, max + grown_m]
}

/// Checks that what the vehicle may reach is within the bounds on every axis. Returns the least distance to a bound,
/// metres.
pub(super) fn contain(stretch: Stretch, key: &str, axes: &[Axis; 3]) -> Result<f64, Refusal> {
    let mut least_m = f64::MAX;
    for axis in axes {
        let room_m = [axis.span_m[0] - axis.bounds_m[0], axis.bounds_m[1] - axis.span_m[1]];
        for (edge, room_m) in room_m.into_iter().enumerate() {
            // NaN is not inside any box.
            if (room_m.is_nan() || room_m < 0.0) && is_on(Check::StationBox) {
                return Err(left(Left {
                    stretch,
                    name: key,
                    axis: axis.name,
                    key: axis.keys[edge],
                    reached_m: axis.span_m[edge],
                    bound_m: axis.bounds_m[edge],
                    missing_m: -room_m,
                }));
            }
            least_m = least_m.min(room_m);
        }
    }
    Ok(least_m)
}

/// Checks that what the vehicle may reach is clear of a keep-out box on at least one axis. Returns the greatest gap,
/// metres.
pub(super) fn avoid(stretch: Stretch, key: &str, name: &str, axes: &[Axis; 3]) -> Result<f64, Refusal> {
    let mut clear_m = f64::NEG_INFINITY;
    let mut edge = "";
    for axis in axes {
        let gaps_m = [axis.bounds_m[0] - axis.span_m[1], axis.span_m[0] - axis.bounds_m[1]];
        for (gap_m, key) in gaps_m.into_iter().zip(axis.keys) {
            if gap_m > clear_m {
                (clear_m, edge) = (gap_m, key);
            }
        }
    }
    if clear_m > 0.0 || !is_on(Check::StationBox) {
        return Ok(clear_m);
    }
    Err(Refusal::from(BoxBreach {
        name: name.to_owned(),
        stretch,
        missing_m: finite(-clear_m),
        edge: BoxEdge::Entered {
            list: key.to_owned(),
            key: edge.to_owned(),
        },
    }))
}

/// A bound that the vehicle would go beyond.
pub(super) struct Left<'a> {
    pub(super) stretch: Stretch,
    pub(super) name: &'a str,
    pub(super) axis: &'a str,
    pub(super) key: &'a str,
    pub(super) reached_m: f64,
    pub(super) bound_m: f64,
    pub(super) missing_m: f64,
}

pub(super) fn left(left: Left<'_>) -> Refusal {
    Refusal::from(BoxBreach {
        name: left.name.to_owned(),
        stretch: left.stretch,
        missing_m: finite(left.missing_m),
        edge: BoxEdge::Kept {
            axis: left.axis.to_owned(),
            key: left.key.to_owned(),
            reached_m: finite(left.reached_m),
            bound_m: left.bound_m,
        },
    })
}

fn finite(metres: f64) -> Option<f64> {
    metres.is_finite().then_some(metres)
}
