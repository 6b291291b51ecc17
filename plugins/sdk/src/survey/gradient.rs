use std::collections::VecDeque;

use backseat_units::EastNorth;
use backseat_units::math::{atan2, exp, hypot, wrap_360};
use serde::{Deserialize, Serialize};

/// A plane through measurements.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Slope {
    /// At the point for which it was made, in the value's unit.
    pub value: f64,
    /// How fast the value grows to the east, per metre.
    pub east: f64,
    /// How fast it grows to the north, per metre.
    pub north: f64,
    /// Root mean square of what the plane does not explain, in the value's unit.
    pub residual: f64,
}

impl Slope {
    /// How fast the value grows in the steepest direction, per metre.
    #[must_use]
    pub fn steepness(&self) -> f64 {
        hypot(self.east, self.north)
    }

    /// The direction in which the value grows, degrees clockwise from the frame's north, in [0, 360).
    #[must_use]
    pub fn bearing_deg(&self) -> f64 {
        wrap_360(atan2(self.east, self.north).to_degrees())
    }
}

/// A plane through the newest measurements, by weighted least squares: the gradient of a field along a track.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct PlaneFit {
    keep: usize,
    reach_m: f64,
    points: VecDeque<(EastNorth, f64)>,
}

impl PlaneFit {
    /// Keeps the newest `keep` measurements. A measurement weighs less the farther away it is: 61 % at `reach_m` metres,
    /// 14 % at twice of it.
    #[must_use]
    pub const fn new(keep: usize, reach_m: f64) -> Self {
        Self {
            keep,
            reach_m,
            points: VecDeque::new(),
        }
    }

    /// Adds a measurement. A value that is not finite is left out.
    pub fn add(&mut self, place: EastNorth, value: f64) {
        if !value.is_finite() {
            return;
        }
        self.points.push_back((place, value));
        while self.points.len() > self.keep {
            self.points.pop_front();
        }
    }

    /// How many measurements are kept now.
    #[must_use]
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// Whether there is no measurement.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.points.is_empty()
    }

    /// The plane around a place. `None` if the measurements do not determine it, because there are fewer than three or
    /// they lie on a straight line.
    #[must_use]
    pub fn at(&self, place: EastNorth) -> Option<Slope> {
        if self.points.len() < 3 {
            return None;
        }
        // (weight, east, north, value), relative to the place.
        let weighted = || {
            self.points.iter().map(|(point, value)| {
                let off = *point - place;
                let square = (off.east_m * off.east_m + off.north_m * off.north_m) / (self.reach_m * self.reach_m);
                (exp(-0.5 * square), off.east_m, off.north_m, *value)
            })
        };
        let (mut total, mut east, mut north, mut value) = (0.0, 0.0, 0.0, 0.0);
        for (w, x, y, v) in weighted() {
            (total, east, north, value) = (total + w, east + w * x, north + w * y, value + w * v);
        }
        if total.is_nan() || total <= 0.0 {
            return None;
        }
        let (east, north, value) = (east / total, north / total, value / total);
        let (mut xx, mut yy, mut xy, mut xv, mut yv) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for (w, x, y, v) in weighted() {
            let (x, y, v) = (x - east, y - north, v - value);
            (xx, yy, xy, xv, yv) = (
                xx + w * x * x,
                yy + w * y * y,
                xy + w * x * y,
                xv + w * x * v,
                yv + w * y * v,
            );
        }
        let determinant = xx * yy - xy * xy;
        let spread = 0.5 * (xx + yy);
        // On a line, one of the two spreads is nothing beside the other. NaN determines nothing either.
        if determinant.is_nan() || determinant <= 1e-4 * spread * spread {
            return None;
        }
        let (slope_east, slope_north) = ((xv * yy - yv * xy) / determinant, (yv * xx - xv * xy) / determinant);
        let here = value - slope_east * east - slope_north * north;
        let square: f64 = weighted()
            .map(|(w, x, y, v)| {
                let off = v - here - slope_east * x - slope_north * y;
                w * off * off
            })
            .sum();
        Some(Slope {
            value: here,
            east: slope_east,
            north: slope_north,
            residual: (square / total).sqrt(),
        })
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn at(east_m: f64, north_m: f64) -> EastNorth {
        EastNorth::new(east_m, north_m)
    }

    proptest! {
        #[test]
        fn a_plane_is_found_exactly(
            (value, east, north) in (-50.0..50.0f64, -0.1..0.1f64, -0.1..0.1f64),
            points in prop::collection::vec((-300.0..300.0, -300.0..300.0), 10..40),
        ) {
            let mut fit = PlaneFit::new(60, 200.0);
            for (x, y) in points {
                fit.add(at(x, y), value + east * x + north * y);
            }
            let here = at(30.0, -20.0);
            if let Some(slope) = fit.at(here) {
                prop_assert!((slope.value - (value + 30.0 * east - 20.0 * north)).abs() < 1e-6);
                prop_assert!((slope.east - east).abs() < 1e-7 && (slope.north - north).abs() < 1e-7);
                prop_assert!(slope.residual < 1e-6);
            }
        }
    }

    #[test]
    fn a_straight_track_determines_no_plane() {
        let mut fit = PlaneFit::new(60, 200.0);
        assert!(fit.is_empty());
        for step in 0..30 {
            fit.add(at(10.0 * f64::from(step), 5.0 * f64::from(step)), f64::from(step));
        }
        assert_eq!(fit.at(at(0.0, 0.0)), None);
        fit.add(at(0.0, f64::NAN), f64::NAN);
        assert_eq!(fit.len(), 30);
    }

    #[test]
    fn only_the_newest_measurements_count() {
        let mut fit = PlaneFit::new(4, 200.0);
        for (x, y, v) in [
            (0.0, 0.0, 99.0),
            (0.0, 0.0, 5.0),
            (100.0, 0.0, 7.0),
            (0.0, 100.0, 5.0),
            (100.0, 100.0, 7.0),
        ] {
            fit.add(at(x, y), v);
        }
        let slope = fit.at(at(0.0, 0.0)).unwrap();
        assert!((slope.value - 5.0).abs() < 1e-9 && (slope.steepness() - 0.02).abs() < 1e-12);
        assert!((slope.bearing_deg() - 90.0).abs() < 1e-9);
    }
}
