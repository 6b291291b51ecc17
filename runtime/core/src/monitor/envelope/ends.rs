//! Where the ways that belong to a request begin and end, and what lies between (safety requirement 002).

use backseat_fence::Shape;
use backseat_units::EastNorth;
use backseat_units::math::{PI, cos};

use super::{Approach, Track};

/// Where a way begins or ends, in the fence's frame: at a point, or anywhere in an area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum End {
    At(EastNorth),
    Anywhere {
        centre: EastNorth,
        radius_m: f64,
    },
    /// Within `radius_m` of the triangle of three points.
    Within {
        corners: [EastNorth; 3],
        radius_m: f64,
    },
}

impl End {
    /// Anywhere on the straight way from one point to another.
    pub(crate) const fn between(a: EastNorth, b: EastNorth) -> Self {
        Self::Within {
            corners: [a, b, b],
            radius_m: 0.0,
        }
    }

    /// On a track of the plan, or anywhere between the track and another end.
    pub(crate) fn on_or_beside(track: &Track, aside: Option<Self>) -> Self {
        let (start, end) = match *track {
            Track::Line(start, end) => (start, end),
            Track::Approach(Approach { begun, to: [to, _], .. }) => (begun, to),
        };
        let (aside, radius_m) = aside.map_or((start, 0.0), Self::middle_and_radius);
        Self::Within {
            corners: [aside, start, end],
            radius_m: radius_m + track.within_m(),
        }
    }

    /// The point itself, or the middle of the area.
    pub(crate) fn middle(self) -> EastNorth {
        self.middle_and_radius().0
    }

    /// The middle of the area, and how far from it the vehicle may be, metres.
    fn middle_and_radius(self) -> (EastNorth, f64) {
        match self {
            Self::At(point) => (point, 0.0),
            Self::Anywhere { centre, radius_m } => (centre, radius_m),
            Self::Within { corners, radius_m } => {
                let [a, b, c] = corners;
                let centre = (a + b + c) * (1.0 / 3.0);
                let around_m = corners.map(|corner| centre.distance_m(corner));
                (centre, around_m.into_iter().fold(0.0, f64::max) + radius_m)
            }
        }
    }

    /// Points whose convex hull contains the whole area.
    pub(crate) fn corners(self) -> Vec<EastNorth> {
        match self {
            Self::At(point) => vec![point],
            Self::Anywhere { centre, radius_m } => around(centre, radius_m).collect(),
            Self::Within { corners, radius_m: 0.0 } => corners.to_vec(),
            Self::Within { corners, radius_m } => corners
                .into_iter()
                .flat_map(|corner| around(corner, radius_m))
                .collect(),
        }
    }
}

/// The corners of an octagon whose sides touch a circle.
fn around(centre: EastNorth, radius_m: f64) -> impl Iterator<Item = EastNorth> {
    let corner_m = radius_m / cos(PI / 8.0);
    (0..8).map(move |eighth| centre.offset(45.0 * f64::from(eighth), corner_m))
}

/// Shapes that contain every way from one end to another.
pub(super) fn ways(from: End, to: End) -> Vec<Shape> {
    match (from, to) {
        (End::At(from), End::At(to)) => vec![Shape::leg(from, to)],
        (End::At(_) | End::Anywhere { .. } | End::Within { .. }, _) => {
            let mut corners = from.corners();
            corners.extend(to.corners());
            Shape::convex_hulls(&corners)
        }
    }
}

/// The greatest distance from one end to another, metres.
pub(super) fn farthest_m(from: End, to: End) -> f64 {
    let to = to.corners();
    let from = from.corners().into_iter();
    from.flat_map(|from| to.iter().map(move |to| from.distance_m(*to)))
        .fold(0.0, f64::max)
}
