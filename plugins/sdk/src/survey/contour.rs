use backseat_units::math::{atan2, wrap_360};
use serde::{Deserialize, Serialize};

use super::Slope;

/// The heading that brings a vehicle onto a contour of a field and along it: line-of-sight guidance (Fossen, *Handbook of
/// Marine Craft Hydrodynamics and Motion Control*, 2011, section 10.3.2) onto the contour of a [`Slope`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ContourFollower {
    /// The value of the contour.
    pub level: f64,
    /// Whether the value is higher to starboard.
    pub higher_to_starboard: bool,
    /// How far ahead on the contour to aim, metres: smaller turns in sooner and is less steady.
    pub lookahead_m: f64,
    /// The steepest angle at which it approaches, degrees, 0 to 90.
    pub approach_max_deg: f64,
    /// With a flatter gradient, there is no heading; in the value's unit per metre.
    pub steepness_min: f64,
}

impl ContourFollower {
    /// For a contour of this value: aims 60 m ahead, approaches at 60 degrees at most.
    #[must_use]
    pub const fn new(level: f64, higher_to_starboard: bool) -> Self {
        Self {
            level,
            higher_to_starboard,
            lookahead_m: 60.0,
            approach_max_deg: 60.0,
            steepness_min: 1e-6,
        }
    }

    /// How far the contour is from the place of the slope, metres, positive uphill; `None` if the slope is too flat.
    #[must_use]
    pub fn offset_m(&self, slope: &Slope) -> Option<f64> {
        // NaN is too flat.
        (slope.steepness() >= self.steepness_min).then(|| (self.level - slope.value) / slope.steepness())
    }

    /// The heading, degrees from the frame's north, in [0, 360); `None` if the slope is too flat.
    #[must_use]
    pub fn heading_deg(&self, slope: &Slope) -> Option<f64> {
        let offset_m = self.offset_m(slope)?;
        let side = if self.higher_to_starboard { 1.0 } else { -1.0 };
        let along_deg = slope.bearing_deg() - 90.0 * side;
        let approach_deg = atan2(offset_m, self.lookahead_m).to_degrees();
        let approach_deg = approach_deg.clamp(-self.approach_max_deg, self.approach_max_deg);
        Some(wrap_360(along_deg + side * approach_deg))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Grows by 1 in 10 m to the north, and is 20 here.
    const NORTHWARDS: Slope = Slope {
        value: 20.0,
        east: 0.0,
        north: 0.1,
        residual: 0.0,
    };

    fn heading_deg(level: f64, higher_to_starboard: bool) -> f64 {
        let follower = ContourFollower::new(level, higher_to_starboard);
        follower.heading_deg(&NORTHWARDS).unwrap()
    }

    #[test]
    fn it_goes_along_the_contour_with_the_higher_side_where_it_was_asked() {
        assert!((heading_deg(20.0, true) - 270.0).abs() < 1e-9);
        assert!((heading_deg(20.0, false) - 90.0).abs() < 1e-9);
    }

    #[test]
    fn it_approaches_the_contour_from_both_sides_and_not_too_steeply() {
        // 60 m uphill with 60 m of lookahead: 45 degrees.
        assert!((heading_deg(26.0, true) - 315.0).abs() < 1e-9);
        assert!((heading_deg(26.0, false) - 45.0).abs() < 1e-9);
        assert!((heading_deg(14.0, false) - 135.0).abs() < 1e-9);
        assert!((heading_deg(900.0, false) - 30.0).abs() < 1e-9);
        let follower = ContourFollower::new(26.0, true);
        assert!((follower.offset_m(&NORTHWARDS).unwrap() - 60.0).abs() < 1e-9);
    }

    #[test]
    fn a_flat_field_has_no_contour() {
        let follower = ContourFollower::new(20.0, true);
        let flat = |north| Slope { north, ..NORTHWARDS };
        assert_eq!(follower.heading_deg(&flat(0.0)), None);
        assert_eq!(follower.heading_deg(&flat(f64::NAN)), None);
    }
}
