//! Where the ways that belong to a request begin and end, and what lies between (safety requirement 002).

use backseat_fence::{Shape, Sweep};
use backseat_units::EastNorth;

use super::{Approach, Track};

/// Where a way begins or ends, in the fence's frame: a point, or anywhere where the vehicle chooses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum End {
    At(EastNorth),
    Anywhere {
        centre: EastNorth,
        radius_m: f64,
    },
    /// On a line, or between it and a place or what is around that.
    Within {
        corners: [EastNorth; 3],
        radius_m: f64,
    },
}

impl End {
    /// The point itself, or the middle of where it may be.
    pub(crate) fn point(self) -> EastNorth {
        point_and_radius(self).0
    }

    /// On a track of the plan's, or between it and another end.
    pub(crate) fn on_or_beside(track: &Track, aside: Option<Self>) -> Self {
        let (start, end) = match *track {
            Track::Line(start, end) => (start, end),
            Track::Approach(Approach { begun, to: [to, _], .. }) => (begun, to),
        };
        let (aside, radius_m) = aside.map_or((start, 0.0), point_and_radius);
        Self::Within {
            corners: [aside, start, end],
            radius_m: radius_m + track.within_m(),
        }
    }
}

/// The middle of where an end may be, and how far it may be from there.
pub(super) fn point_and_radius(end: End) -> (EastNorth, f64) {
    match end {
        End::At(point) => (point, 0.0),
        End::Anywhere { centre, radius_m } => (centre, radius_m),
        End::Within { corners, radius_m } => {
            let [a, b, c] = corners;
            let centre = (a + b + c) * (1.0 / 3.0);
            let around_m = corners.map(|corner| centre.distance_m(corner));
            (centre, around_m.into_iter().fold(0.0, f64::max) + radius_m)
        }
    }
}

/// Every way from one end to another, so far beside it.
pub(super) fn between(from: End, to: End, strayed_m: f64) -> Sweep {
    let (to, to_m) = point_and_radius(to);
    match from {
        End::At(_) | End::Anywhere { .. } => {
            let (from, from_m) = point_and_radius(from);
            Sweep::new(Shape::leg(from, to), strayed_m + from_m.max(to_m))
        }
        End::Within { corners, radius_m } => {
            let [a, b, c] = corners;
            Sweep::new(Shape::quadrilateral([a, b, c, to]), strayed_m + radius_m.max(to_m))
        }
    }
}

/// How far it is from one end to another at most, metres.
pub(super) fn farthest_m(from: End, to: End) -> f64 {
    let (to, to_m) = point_and_radius(to);
    match from {
        End::At(_) | End::Anywhere { .. } => {
            let (from, from_m) = point_and_radius(from);
            from.distance_m(to) + from_m + to_m
        }
        End::Within { corners, radius_m } => {
            let farthest_m = corners.map(|corner| corner.distance_m(to));
            farthest_m.into_iter().fold(0.0, f64::max) + radius_m + to_m
        }
    }
}
