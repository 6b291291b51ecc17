//! The line of seabed that the fan of a sidescan sonar meets on one side.

use backseat_units::EastNorth;
use backseat_units::math::sin_cos;
use backseat_world::World;

use crate::pose::Pose;

/// The seabed is looked up at most this far apart, metres. Between two of these places a cubic goes through their depths
/// and slopes.
const KNOT_M: f64 = 12.5;
const KNOTS_MIN: f64 = 6.0;

/// The plane across the vehicle in which the sonar looks, and what it stands on.
#[derive(Clone, Copy, Debug)]
pub(super) struct Fan {
    /// Where the plane meets the seabed's frame below the sonar.
    pub(super) origin: EastNorth,
    /// Unit vectors ahead and to starboard.
    pub(super) ahead: EastNorth,
    pub(super) starboard: EastNorth,
    /// How much further the seabed is in a plane that pitch has tilted: 1 / cos(pitch).
    stretch: f64,
    /// What makes the depth of a chart the distance below the sonar, metres.
    datum_m: f64,
    middle: (f64, EastNorth),
}

impl Fan {
    pub(super) fn new(world: &World, pose: &Pose) -> Self {
        let (sin, cos) = sin_cos(pose.heading_deg.to_radians());
        let ahead = EastNorth::new(sin, cos);
        let (sin_pitch, cos_pitch) = sin_cos(pose.pitch_deg.to_radians());
        // Near the vertical the plane meets the seabed nowhere near. The limit keeps all numbers finite.
        let cos_pitch = cos_pitch.max(1e-3);
        let below = world.seabed().depth_and_gradient(pose.at);
        let origin = pose.at + ahead * (pose.altitude_m * sin_pitch / cos_pitch);
        let middle = if origin == pose.at {
            below
        } else {
            world.seabed().depth_and_gradient(origin)
        };
        Self {
            origin,
            ahead,
            starboard: EastNorth::new(cos, -sin),
            stretch: 1.0 / cos_pitch,
            datum_m: pose.altitude_m - below.0,
            middle,
        }
    }
}

#[derive(Clone, Copy, Debug)]
struct Knot {
    /// Distance below the sonar, metres, and its slopes outwards and ahead.
    below_m: f64,
    outwards: f64,
    ahead: f64,
}

/// The seabed on one side, as far as the sonar looks.
#[derive(Clone, Debug, Default)]
pub(super) struct Bed {
    step_m: f64,
    knots: Vec<Knot>,
}

impl Bed {
    /// Looks the seabed up. `side` is 1 for starboard and -1 for port.
    pub(super) fn look(&mut self, world: &World, fan: &Fan, side: f64, range_m: f64) {
        let count = (range_m / KNOT_M).ceil().max(KNOTS_MIN);
        self.step_m = range_m / count;
        let outwards = fan.starboard * side;
        let knot = |(depth_m, gradient): (f64, EastNorth)| Knot {
            below_m: (depth_m + fan.datum_m) * fan.stretch,
            outwards: (gradient.east_m * outwards.east_m + gradient.north_m * outwards.north_m) * fan.stretch,
            ahead: gradient.east_m * fan.ahead.east_m + gradient.north_m * fan.ahead.north_m,
        };
        self.knots.clear();
        self.knots.push(knot(fan.middle));
        for number in 1..=count as u32 {
            let at = fan.origin + outwards * (self.step_m * f64::from(number));
            self.knots.push(knot(world.seabed().depth_and_gradient(at)));
        }
    }

    /// How far apart the places are where the seabed was looked up, metres.
    pub(super) const fn step_m(&self) -> f64 {
        self.step_m
    }

    /// The seabed at a distance outwards: below the sonar in metres, and its slopes outwards and ahead.
    pub(super) fn at(&self, out_m: f64) -> (f64, f64, f64) {
        let scaled = out_m / self.step_m;
        let cell = (scaled.max(0.0) as usize).min(self.knots.len().saturating_sub(2));
        let [near, far] = [self.knots[cell], self.knots[cell + 1]];
        // Hermite's cubic.
        let t = (scaled - cell as f64).clamp(0.0, 1.0);
        let rise_m = far.below_m - near.below_m;
        let (start_m, end_m) = (near.outwards * self.step_m, far.outwards * self.step_m);
        let (b, c) = (3.0 * rise_m - 2.0 * start_m - end_m, start_m + end_m - 2.0 * rise_m);
        let below_m = near.below_m + t * (start_m + t * (b + t * c));
        let outwards = (start_m + t * (2.0 * b + t * 3.0 * c)) / self.step_m;
        (below_m, outwards, near.ahead + t * (far.ahead - near.ahead))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The greatest error of the cubics over many places, metres: of the depth, and of the slope as a ratio.
    fn error(text: &str, range_m: f64) -> (f64, f64) {
        let text = format!("[origin]\nlatitude_deg = 42.3\nlongitude_deg = -70.9\n[seabed]\ndepth_m = 200\n{text}");
        let world = World::new(&toml::from_str(&text).unwrap(), 2).unwrap();
        let (mut depth_m, mut slope) = (0f64, 0f64);
        let mut bed = Bed::default();
        for number in 0..60 {
            let pose = Pose {
                at: backseat_units::EastNorth::new(17.0 * f64::from(number) - 500.0, 3.0 * f64::from(number)),
                depth_m: 0.0,
                altitude_m: 20.0,
                heading_deg: 77.0 * f64::from(number),
                pitch_deg: 0.0,
                roll_deg: 0.0,
            };
            let fan = Fan::new(&world, &pose);
            bed.look(&world, &fan, 1.0, range_m);
            for step in 0..200 {
                let out_m = range_m * f64::from(step) / 200.0;
                let (below_m, outwards, _) = bed.at(out_m);
                let (true_m, gradient) = world.seabed().depth_and_gradient(fan.origin + fan.starboard * out_m);
                let true_slope = gradient.east_m * fan.starboard.east_m + gradient.north_m * fan.starboard.north_m;
                depth_m = depth_m.max((below_m - fan.datum_m - true_m).abs());
                slope = slope.max((outwards - true_slope).abs());
            }
        }
        (depth_m, slope)
    }

    /// The figures are those of the crate's page.
    #[test]
    fn cubics_follow_the_seabed_that_a_seed_draws() {
        let banks = |radius_m: u32| {
            format!(
                "banks = 16\nbank_height_m = 10\nbank_radius_m = {radius_m}\nbank_east_m = [-400, 400]\nbank_north_m = [-400, 400]\n"
            )
        };
        for (text, most_m, most_slope) in [
            (String::new(), 1e-4, 1e-4),
            (banks(50), 1e-3, 1e-3),
            (banks(20), 0.02, 0.01),
            (
                "meander_slope = 0.5\nmeander_wavelength_m = 50\n".to_owned(),
                0.07,
                0.03,
            ),
        ] {
            for range_m in [75.0, 250.0] {
                let (depth_m, slope) = error(&text, range_m);
                assert!(depth_m < most_m && slope < most_slope, "{text:?}: {depth_m} {slope}");
            }
        }
    }
}
