use backseat_sdk::units::EastNorth;
use backseat_sdk::units::math::{atan, hypot, wrap_360};

use crate::seabed::Estimate;

/// The least slope to steer by, metres per metre. On a flatter seabed the direction of the contour is too uncertain.
const SLOPE_MIN: f64 = 0.004;
/// How far ahead the contour's direction is taken, as seconds of travel, to make up for the lag of the vehicle's turn.
const LEAD_S: f64 = 4.0;

/// Line-of-sight guidance onto a contour.
///
/// The course is the contour's own direction, turned towards it by atan(offset / lookahead): Fossen, *Handbook of
/// Marine Craft Hydrodynamics and Motion Control* (2nd ed. 2021), section 12.3, with the contour's tangent as the path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Guidance {
    /// The water depth to follow, metres.
    pub contour_m: f64,
    /// How far along the contour to aim, metres.
    pub lookahead_m: f64,
    /// 1 if the deep water is to starboard, -1 if it is to port.
    pub deep_side: f64,
    /// Approximate speed over ground, metres per second.
    pub speed_mps: f64,
}

/// The result of guidance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aim {
    /// Course over ground, degrees in [0, 360).
    pub course_deg: f64,
    /// The vehicle's distance from the contour, metres, positive on its deep side: (D - D*) / |grad D|.
    pub offset_m: f64,
}

impl Guidance {
    /// The course from a position where the seabed is as estimated.
    #[must_use]
    pub fn aim(&self, seabed: &Estimate) -> Aim {
        let offset_m = (seabed.depth_m - self.contour_m) / seabed.slope().max(SLOPE_MIN);
        let lead_m = self.speed_mps * LEAD_S;
        // Only close to the contour is the bend here the one that the vehicle will follow.
        let near = (1.0 - offset_m.abs() / (2.0 * self.lookahead_m)).max(0.0);
        let ahead = seabed.gradient_at(self.along(seabed.gradient) * (lead_m * near));
        let gradient = if hypot(ahead.east_m, ahead.north_m) < SLOPE_MIN {
            seabed.gradient
        } else {
            ahead
        };
        let tangent_deg = EastNorth::default().bearing_deg(gradient) - 90.0 * self.deep_side;
        let inwards_deg = atan(offset_m / self.lookahead_m).to_degrees();
        Aim {
            course_deg: wrap_360(tangent_deg - self.deep_side * inwards_deg),
            offset_m,
        }
    }

    /// The unit vector along the contour with deep water on its side; `None` if the seabed is flat.
    fn along(&self, gradient: EastNorth) -> EastNorth {
        let slope = hypot(gradient.east_m, gradient.north_m);
        if slope <= 0.0 {
            return EastNorth::default();
        }
        EastNorth::new(-gradient.north_m, gradient.east_m) * (self.deep_side / slope)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A seabed that gets deeper to the south.
    fn south(depth_m: f64) -> Estimate {
        Estimate {
            depth_m,
            gradient: EastNorth::new(0.0, -0.03),
            bend_per_m: [0.0; 3],
            depth_sigma_m: 0.1,
        }
    }

    fn guidance(deep_side: f64) -> Guidance {
        Guidance {
            contour_m: 30.0,
            lookahead_m: 25.0,
            deep_side,
            speed_mps: 1.5,
        }
    }

    #[test]
    fn on_the_contour_it_follows_it_with_deep_water_on_the_given_side() {
        assert!((guidance(1.0).aim(&south(30.0)).course_deg - 90.0).abs() < 1e-9);
        assert!((guidance(-1.0).aim(&south(30.0)).course_deg - 270.0).abs() < 1e-9);
    }

    #[test]
    fn off_the_contour_it_turns_towards_it() {
        for side in [1.0, -1.0] {
            // The vehicle is 25 m too far south, where it is too deep, so it steers 45 degrees north of the contour's
            // direction.
            let deep = guidance(side).aim(&south(30.75));
            assert!((deep.offset_m - 25.0).abs() < 1e-9);
            assert!(
                (deep.course_deg - if side > 0.0 { 45.0 } else { 315.0 }).abs() < 1e-9,
                "{deep:?}"
            );
            let shallow = guidance(side).aim(&south(21.0));
            assert!((shallow.course_deg - 180.0).abs() < 6.0, "{shallow:?}");
        }
    }

    #[test]
    fn it_turns_before_it_reaches_a_bend() {
        // The gradient turns from south to south-east towards the east, so the contour bends to the left.
        let bend = Estimate {
            bend_per_m: [1e-4, 0.0, 0.0],
            ..south(30.0)
        };
        assert!(guidance(1.0).aim(&bend).course_deg < 89.0);
    }
}
