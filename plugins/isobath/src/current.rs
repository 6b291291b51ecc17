use backseat_sdk::units::math::{asin, hypot, sin_cos, wrap_360};
use serde::{Deserialize, Serialize};

/// The memory of the estimate, seconds.
const MEMORY_S: f64 = 30.0;
/// The fastest turn in which samples are used, degrees per second. In faster turns the vehicle slips sideways, which
/// looks like a current.
const TURN_MAX_DPS: f64 = 4.0;
/// The strongest current that is believed, metres per second. A stronger one is an error in the data.
const CURRENT_MAX_MPS: f64 = 1.5;

/// Estimates the current as velocity over ground minus velocity through the water, low-pass filtered.
///
/// The velocity through the water is assumed to be the requested one. If it is not, the error lies along the heading.
/// The part across the heading, which decides the crab angle, is still right.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct CurrentEstimate {
    east_mps: f64,
    north_mps: f64,
    /// For how long data has been received, seconds, up to [`MEMORY_S`].
    heard_s: f64,
}

impl CurrentEstimate {
    /// Takes in a heading and a velocity over ground (east, north) that lasted for `over_s` seconds.
    pub fn measure(
        &mut self,
        heading_deg: f64,
        speed_mps: f64,
        ground_mps: (f64, f64),
        yaw_rate_dps: f64,
        over_s: f64,
    ) {
        let (sin, cos) = sin_cos(heading_deg.to_radians());
        let seen = (ground_mps.0 - speed_mps * sin, ground_mps.1 - speed_mps * cos);
        let plausible = hypot(seen.0, seen.1) <= CURRENT_MAX_MPS;
        if !plausible || yaw_rate_dps.abs() > TURN_MAX_DPS || !(over_s > 0.0 && over_s < 60.0) {
            return;
        }
        // A mean at first, a low-pass filter after that.
        self.heard_s = (self.heard_s + over_s).min(MEMORY_S);
        let gain = over_s / self.heard_s;
        self.east_mps += gain * (seen.0 - self.east_mps);
        self.north_mps += gain * (seen.1 - self.north_mps);
    }

    /// The current's velocity, metres per second east and north.
    #[must_use]
    pub const fn mps(&self) -> (f64, f64) {
        (self.east_mps, self.north_mps)
    }

    /// The heading that results in a course over ground, degrees in [0, 360).
    ///
    /// The crab angle of Fossen, *Handbook of Marine Craft Hydrodynamics and Motion Control* (2nd ed. 2021), chapter
    /// 12: the heading at which the vehicle's velocity across the course cancels the current's.
    #[must_use]
    pub fn heading_deg(&self, course_deg: f64, speed_mps: f64) -> f64 {
        let (sin, cos) = sin_cos(course_deg.to_radians());
        let set_right_mps = self.east_mps * cos - self.north_mps * sin;
        wrap_360(course_deg - asin((set_right_mps / speed_mps).clamp(-0.8, 0.8)).to_degrees())
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn the_heading_leads_to_the_course(
            east in -0.3..0.3f64, north in -0.3..0.3f64, heading in 0.0..360.0f64, course in 0.0..360.0f64,
        ) {
            let mut current = CurrentEstimate::default();
            let (sin, cos) = sin_cos(heading.to_radians());
            for _ in 0..20 {
                current.measure(heading, 1.5, (1.5 * sin + east, 1.5 * cos + north), 0.0, 0.5);
            }
            let (sin, cos) = sin_cos(current.heading_deg(course, 1.5).to_radians());
            let ground = (1.5 * sin + east, 1.5 * cos + north);
            let (sin, cos) = sin_cos(course.to_radians());
            prop_assert!((ground.0 * cos - ground.1 * sin).abs() < 1e-9);
        }
    }

    #[test]
    fn turns_and_invalid_samples_do_not_change_the_current() {
        let mut current = CurrentEstimate::default();
        current.measure(0.0, 1.5, (0.5, 1.5), 9.0, 0.5);
        current.measure(0.0, 1.5, (9.0, 1.5), 0.0, 0.5);
        current.measure(0.0, 1.5, (f64::NAN, 1.5), 0.0, 0.5);
        assert_eq!(current.mps(), (0.0, 0.0));
    }
}
