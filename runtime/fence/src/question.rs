//! The part of a question that is not the shape, and whether its numbers are usable.

use backseat_units::EastNorth;

use crate::sweep::{Shape, Sweep, VerticalExtent};
use crate::verdict::Rule;
use crate::window::Span;
use crate::zone::{Band, Kind, Zone};

/// The thickness of an edge, metres: a shape that comes nearer touches it. It is far above the rounding errors of the
/// distances (1e-11 m at 50 km), and far below the accuracy with which a vehicle knows its position.
pub(crate) const EDGE_THICKNESS_M: f64 = 1e-6;

/// The greatest usable length, metres. Nothing on the earth is longer, and the squares of greater lengths would cost
/// the distances their precision.
pub(crate) const LIMIT_M: f64 = 1e9;

/// The part of a question that is not the shape. Without a vertical extent, margins do not count either.
#[derive(Clone, Copy)]
pub(crate) struct Question {
    pub(crate) radius_m: f64,
    pub(crate) vertical: Option<VerticalExtent>,
    /// The depths that the vehicle may pass, from and to, metres: those at which keep-out zones count.
    pub(crate) passed_m: [f64; 2],
    /// Whether the vehicle surfaces: then only zones that allow it count, and their shallowest depth does not.
    pub(crate) surfacing: bool,
    /// When it happens; `None` if that is unknown.
    pub(crate) span: Option<Span>,
}

impl Question {
    /// Whether a keep-in zone can contain the sweep of this question at all.
    pub(crate) fn may_hold(&self, zone: &Zone) -> bool {
        match zone.kind {
            Kind::KeepIn { surfacing, .. } => surfacing || !self.surfacing,
            Kind::KeepOut { .. } => false,
        }
    }

    /// Whether a keep-in zone is valid for the whole time of this question.
    pub(crate) fn is_open(&self, zone: &Zone) -> bool {
        zone.window.covers(self.span)
    }

    /// How far from the edges of a zone the shape must be, metres.
    pub(crate) fn reach_m(&self, zone: &Zone) -> f64 {
        let margin_m = if self.vertical.is_some() { zone.margin_m } else { 0.0 };
        (margin_m + self.radius_m).max(EDGE_THICKNESS_M)
    }

    /// The worst fault against the vertical limits of a keep-in zone.
    pub(crate) fn vertical_fault(&self, zone: &Zone) -> Option<(Rule, f64)> {
        let (vertical, depth, altitude_min_m) = match (self.vertical, zone.kind) {
            (
                Some(vertical),
                Kind::KeepIn {
                    depth, altitude_min_m, ..
                },
            ) => (vertical, depth, altitude_min_m),
            (None, _) | (Some(_), Kind::KeepOut { .. }) => return None,
        };
        let faults = [
            (Rule::DepthMin, depth.min_m - vertical.depth_min_m),
            (Rule::DepthMax, vertical.depth_max_m - depth.max_m),
            (Rule::AltitudeMin, altitude_min_m - vertical.altitude_min_m),
        ];
        faults
            .into_iter()
            .filter(|(rule, metres)| *metres > 0.0 && !(self.surfacing && *rule == Rule::DepthMin))
            .max_by(|(_, a), (_, b)| a.total_cmp(b))
    }

    /// Whether a zone is a keep-out zone that counts at the time and the depths of this question.
    pub(crate) fn forbids(&self, zone: &Zone) -> bool {
        let at_these_depths = match (self.vertical, zone.kind) {
            (_, Kind::KeepIn { .. }) => false,
            (
                Some(_),
                Kind::KeepOut {
                    depth: Some(Band { min_m, max_m }),
                },
            ) => self.passed_m[0] <= max_m && self.passed_m[1] >= min_m,
            (None, Kind::KeepOut { .. }) | (Some(_), Kind::KeepOut { depth: None }) => true,
        };
        at_these_depths && zone.window.meets(self.span)
    }
}

/// The first number of a sweep that cannot be used.
pub(crate) fn unusable(sweep: &Sweep) -> Option<&'static str> {
    // NaN fails these comparisons.
    let length = |value: f64| (0.0..=LIMIT_M).contains(&value);
    let point = |point: &EastNorth| point.east_m.abs() <= LIMIT_M && point.north_m.abs() <= LIMIT_M;
    if !length(sweep.radius_m) {
        return Some("radius_m of the sweep");
    }
    match &sweep.shape {
        Shape::Convex(convex) => (!convex.points().iter().all(point)).then_some("point of the convex hull"),
        Shape::Rim { centre, radius_m } => match (point(centre), length(*radius_m)) {
            (false, _) => Some("centre of the rim"),
            (true, false) => Some("radius_m of the rim"),
            (true, true) => None,
        },
    }
}

/// The first number of a vertical extent that cannot be used.
pub(crate) fn unusable_vertical(vertical: &VerticalExtent) -> Option<&'static str> {
    let VerticalExtent {
        depth_min_m,
        depth_max_m,
        altitude_min_m,
    } = *vertical;
    let finite = |value: f64| value.abs() <= LIMIT_M;
    match () {
        () if !finite(depth_min_m) => Some("depth_min_m"),
        () if !finite(depth_max_m) => Some("depth_max_m"),
        () if !finite(altitude_min_m) => Some("altitude_min_m"),
        () if depth_min_m > depth_max_m => Some("depth_max_m less than depth_min_m"),
        () => None,
    }
}

/// The description of a span that ends before it begins.
pub(crate) fn unusable_span(span: Option<Span>) -> Option<&'static str> {
    span.and_then(|span| (span.from > span.until).then_some("time that ends before it begins"))
}
