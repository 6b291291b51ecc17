use backseat_units::EastNorth;
use backseat_units::math::sin_cos;
use serde::{Deserialize, Serialize};

/// The most corners of an [`Area`].
const CORNERS_MAX: usize = 500;
/// Farther than this from the frame's origin an area is not accepted, metres.
const FAR_M: f64 = 50_000.0;

/// Why a ring of corners is no area.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum AreaError {
    /// Too few or too many corners.
    #[error("{0} corners: expected 3 to 500")]
    Corners(usize),
    /// A corner that is no number or too far away.
    #[error("corner {0} is farther than 50 km from the origin")]
    Corner(usize),
    /// Two edges cross or touch.
    #[error("the edges from corners {0} and {1} meet")]
    Crossing(usize, usize),
    /// Nothing is inside.
    #[error("the area has no inside")]
    Empty,
}

/// A simple polygon in a local frame.
#[derive(Clone, Debug, PartialEq)]
pub struct Area {
    ring: Vec<EastNorth>,
}

impl Area {
    /// A polygon from its corners in order, in either direction. The last corner is not the first one again.
    ///
    /// # Errors
    /// [`AreaError`] if there are fewer than 3 or more than 500 corners, if one is farther than 50 km from the frame's
    /// origin, or if edges meet. Corners count from 1.
    pub fn polygon(ring: Vec<EastNorth>) -> Result<Self, AreaError> {
        if !(3..=CORNERS_MAX).contains(&ring.len()) {
            return Err(AreaError::Corners(ring.len()));
        }
        let near = |at: &EastNorth| at.east_m.abs() <= FAR_M && at.north_m.abs() <= FAR_M;
        if let Some(corner) = ring.iter().position(|at| !near(at)) {
            return Err(AreaError::Corner(corner + 1));
        }
        let area = Self { ring };
        let count = area.ring.len();
        for one in 0..count {
            for other in one + 1..count {
                let neighbours = other == one + 1 || (one == 0 && other == count - 1);
                if !neighbours && meet(area.edge(one), area.edge(other)) {
                    return Err(AreaError::Crossing(one + 1, other + 1));
                }
            }
        }
        // Less than a square metre is no area to survey, and NaN fails the comparison.
        if area.size_m2() >= 1.0 {
            Ok(area)
        } else {
            Err(AreaError::Empty)
        }
    }

    /// A rectangle around a centre, so long in the direction `bearing_deg` and so wide across it.
    ///
    /// # Errors
    /// [`AreaError`] if it has no inside or is farther than 50 km from the origin.
    pub fn rectangle(centre: EastNorth, bearing_deg: f64, length_m: f64, width_m: f64) -> Result<Self, AreaError> {
        let axes = Axes::new(centre, bearing_deg);
        let (along_m, across_m) = (length_m / 2.0, width_m / 2.0);
        let corner = |along: f64, across: f64| {
            axes.local(Place {
                along_m: along * along_m,
                across_m: across * across_m,
            })
        };
        Self::polygon(vec![
            corner(-1.0, -1.0),
            corner(1.0, -1.0),
            corner(1.0, 1.0),
            corner(-1.0, 1.0),
        ])
    }

    /// The corners in order.
    #[must_use]
    pub fn corners(&self) -> &[EastNorth] {
        &self.ring
    }

    /// Its size, square metres.
    #[must_use]
    pub fn size_m2(&self) -> f64 {
        let first = self.ring[0];
        let twice: f64 = self.edges().map(|(from, to)| cross(from - first, to - first)).sum();
        (twice / 2.0).abs()
    }

    /// Whether a point is inside. A point on an edge can count either way.
    #[must_use]
    pub fn contains(&self, at: EastNorth) -> bool {
        let mut inside = false;
        for (from, to) in self.edges() {
            if (from.north_m > at.north_m) != (to.north_m > at.north_m) {
                let part = (at.north_m - from.north_m) / (to.north_m - from.north_m);
                if at.east_m < from.east_m + part * (to.east_m - from.east_m) {
                    inside = !inside;
                }
            }
        }
        inside
    }

    fn edge(&self, index: usize) -> (EastNorth, EastNorth) {
        (self.ring[index], self.ring[(index + 1) % self.ring.len()])
    }

    fn edges(&self) -> impl Iterator<Item = (EastNorth, EastNorth)> {
        (0..self.ring.len()).map(|index| self.edge(index))
    }
}

/// A place in [`Axes`], metres.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Place {
    /// Along the lines.
    pub along_m: f64,
    /// Across them, positive to starboard of a vehicle that flies along them.
    pub across_m: f64,
}

/// A frame with one axis along the survey's lines, and the other one to starboard of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Axes {
    origin: EastNorth,
    /// The unit vector along the lines.
    along: EastNorth,
}

impl Axes {
    /// From an origin and the direction of the lines, degrees clockwise from the local frame's north.
    #[must_use]
    pub fn new(origin: EastNorth, bearing_deg: f64) -> Self {
        let (sin, cos) = sin_cos(bearing_deg.to_radians());
        Self {
            origin,
            along: EastNorth::new(sin, cos),
        }
    }

    /// A point of the local frame in these axes.
    #[must_use]
    pub fn place(&self, at: EastNorth) -> Place {
        let from = at - self.origin;
        Place {
            along_m: from.east_m * self.along.east_m + from.north_m * self.along.north_m,
            across_m: from.east_m * self.along.north_m - from.north_m * self.along.east_m,
        }
    }

    /// A place of these axes in the local frame.
    #[must_use]
    pub fn local(&self, place: Place) -> EastNorth {
        let (along, Place { along_m, across_m }) = (self.along, place);
        self.origin
            + EastNorth::new(
                along_m * along.east_m + across_m * along.north_m,
                along_m * along.north_m - across_m * along.east_m,
            )
    }
}

fn cross(one: EastNorth, other: EastNorth) -> f64 {
    one.east_m * other.north_m - one.north_m * other.east_m
}

/// Whether two edges have a point in common.
fn meet((a, b): (EastNorth, EastNorth), (c, d): (EastNorth, EastNorth)) -> bool {
    let side = |from: EastNorth, to: EastNorth, at: EastNorth| cross(to - from, at - from);
    let (c_side, d_side) = (side(a, b, c), side(a, b, d));
    let (a_side, b_side) = (side(c, d, a), side(c, d, b));
    let between = |from: EastNorth, to: EastNorth, at: EastNorth| {
        at.east_m >= from.east_m.min(to.east_m)
            && at.east_m <= from.east_m.max(to.east_m)
            && at.north_m >= from.north_m.min(to.north_m)
            && at.north_m <= from.north_m.max(to.north_m)
    };
    (c_side * d_side < 0.0 && a_side * b_side < 0.0)
        || (c_side == 0.0 && between(a, b, c))
        || (d_side == 0.0 && between(a, b, d))
        || (a_side == 0.0 && between(c, d, a))
        || (b_side == 0.0 && between(c, d, b))
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn ring(corners: &[(f64, f64)]) -> Vec<EastNorth> {
        corners
            .iter()
            .map(|(east_m, north_m)| EastNorth::new(*east_m, *north_m))
            .collect()
    }

    #[test]
    fn a_polygon_with_a_bay_has_its_inside_and_its_size() {
        // A square of 100 m with a notch of 40 m by 50 m from the north.
        let corners = [
            (0.0, 0.0),
            (100.0, 0.0),
            (100.0, 100.0),
            (70.0, 100.0),
            (70.0, 50.0),
            (30.0, 50.0),
            (30.0, 100.0),
            (0.0, 100.0),
        ];
        let area = Area::polygon(ring(&corners)).unwrap();
        assert!((area.size_m2() - 8000.0).abs() < 1e-9);
        assert!(area.contains(EastNorth::new(50.0, 49.0)) && area.contains(EastNorth::new(85.0, 90.0)));
        assert!(!area.contains(EastNorth::new(50.0, 51.0)) && !area.contains(EastNorth::new(-1.0, 50.0)));
    }

    #[test]
    fn rings_that_are_no_area_are_refused_with_the_corner() {
        let refused = |corners: &[(f64, f64)]| Area::polygon(ring(corners)).unwrap_err();
        assert_eq!(refused(&[(0.0, 0.0), (1.0, 0.0)]), AreaError::Corners(2));
        assert_eq!(
            refused(&[(0.0, 0.0), (9.0, 0.0), (f64::NAN, 9.0)]),
            AreaError::Corner(3)
        );
        assert_eq!(refused(&[(0.0, 0.0), (9.0, 0.0), (4.0, 0.0)]), AreaError::Empty);
        let bow_tie = refused(&[(0.0, 0.0), (9.0, 9.0), (9.0, 0.0), (0.0, 9.0)]);
        assert_eq!(bow_tie.to_string(), "the edges from corners 1 and 3 meet");
    }

    proptest! {
        #[test]
        fn axes_keep_distances_and_lead_there_and_back(
            bearing in -720.0..720.0f64, east in -5e3..5e3f64, north in -5e3..5e3f64,
        ) {
            let axes = Axes::new(EastNorth::new(120.0, -40.0), bearing);
            let at = EastNorth::new(east, north);
            prop_assert!(axes.local(axes.place(at)).distance_m(at) < 1e-9);
            // A place to starboard of the lines has a bearing of 90 degrees more.
            let starboard = axes.local(Place { along_m: 0.0, across_m: 10.0 });
            let expected = EastNorth::new(120.0, -40.0).offset(bearing + 90.0, 10.0);
            prop_assert!(starboard.distance_m(expected) < 1e-9);
        }

        #[test]
        fn a_rectangle_contains_what_its_axes_say(
            bearing in -180.0..180.0f64, along in -99.0..99.0f64, across in -99.0..99.0f64,
        ) {
            let area = Area::rectangle(EastNorth::new(10.0, 20.0), bearing, 100.0, 50.0).unwrap();
            prop_assert!((area.size_m2() - 5000.0).abs() < 1e-6);
            let at = Axes::new(EastNorth::new(10.0, 20.0), bearing).local(Place { along_m: along, across_m: across });
            let on_edge = (along.abs() - 50.0).abs() < 1e-6 || (across.abs() - 25.0).abs() < 1e-6;
            prop_assert!(on_edge || area.contains(at) == (along.abs() < 50.0 && across.abs() < 25.0));
        }
    }
}
