use backseat_units::math::{hypot, sin_cos};

use super::ship::Ship;
use super::{HoverDemand, Turn, Vehicle};

/// A ship, and how close to it the vehicle may go, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Obstacle {
    pub(crate) ship: Ship,
    pub(crate) safety_m: f64,
}

/// The allowed speed towards a hull for each metre beyond the safety distance, per second. At 0.75 m/s this is a
/// deceleration of 0.15 m/s2, which the thrusters can do.
const CLEARANCE_GAIN_PER_S: f64 = 0.2;

/// Enough to find the speed to one hundredth.
const BISECTIONS: u32 = 7;

impl Vehicle {
    /// Rates of a hovering vehicle: the velocity through the water follows with the same first-order lag in every
    /// direction. The model assumes that the lateral thrusters are as strong as those ahead.
    pub(super) fn hover(&mut self, demand: &HoverDemand, dt_s: f64) {
        let performance = self.performance;
        let limit_mps = demand.speed_max_mps;
        // The vertical speed takes its share of the limit first, because it keeps the vehicle off the bottom.
        let down_mps = self.wanted_heave_mps(demand.vertical).clamp(-limit_mps, limit_mps);
        let left_mps = (limit_mps * limit_mps - down_mps * down_mps).max(0.0).sqrt();
        let (east_mps, north_mps) = capped(demand.ground, left_mps.min(performance.speed_max_mps));
        let (east_mps, north_mps, down_mps) = self.led((east_mps, north_mps, down_mps));
        let wanted = capped(
            (east_mps - self.motion.current.0, north_mps - self.motion.current.1),
            performance.speed_max_mps,
        );
        let (sin, cos) = self.axis;
        let water = (
            self.motion.surge_mps * sin + self.motion.sway_mps * cos,
            self.motion.surge_mps * cos - self.motion.sway_mps * sin,
        );
        let part = self.lags.surge;
        let change = capped(
            ((wanted.0 - water.0) * part, (wanted.1 - water.1) * part),
            performance.surge_accel_mps2 * dt_s,
        );
        let water = (water.0 + change.0, water.1 + change.1);
        self.heave(down_mps);
        let yaw_rate_dps = self.motion.yaw_rate_dps;
        self.yaw(Turn::Heading(demand.heading_deg));
        // The velocity keeps its direction while the vehicle turns.
        let heading_deg = self.motion.heading_deg + 0.5 * (yaw_rate_dps + self.motion.yaw_rate_dps) * dt_s;
        let (sin, cos) = sin_cos(heading_deg.to_radians());
        self.motion.surge_mps = water.0 * sin + water.1 * cos;
        self.motion.sway_mps = water.0 * cos - water.1 * sin;
    }

    pub(super) fn safety_m(&self) -> f64 {
        self.obstacle.map_or(0.0, |obstacle| obstacle.safety_m)
    }

    /// Removes the part of this step's velocity that leads into the ship. Water that meets a hull flows along it, and a
    /// vehicle that drifts in the water does the same.
    pub(super) fn stay_clear(&mut self, safety_m: f64) {
        let (sin, cos) = self.axis;
        let velocity = (self.motion.ground.0, self.motion.ground.1, self.motion.heave_mps);
        let kept = self.kept_clear(velocity, safety_m);
        if kept == velocity {
            return;
        }
        let (east_mps, north_mps, down_mps) = kept;
        let water = (east_mps - self.carried_by.0, north_mps - self.carried_by.1);
        self.motion.ground = (east_mps, north_mps);
        self.motion.heave_mps = down_mps;
        self.motion.surge_mps = water.0 * sin + water.1 * cos;
        self.motion.sway_mps = water.0 * cos - water.1 * sin;
    }

    /// A velocity (east, north, down) that keeps clear of the ship and does not drive the vehicle into the bottom on
    /// the way around it, because under a keel the vehicle cannot climb. If needed, the horizontal speed is reduced,
    /// down to zero.
    fn led(&self, wanted: (f64, f64, f64)) -> (f64, f64, f64) {
        let safety_m = self.safety_m();
        let at_share = |share: f64| self.kept_clear((wanted.0 * share, wanted.1 * share, wanted.2), safety_m);
        let rises_mps = |velocity: (f64, f64, f64)| {
            velocity.0 * self.motion.gradient.east_m + velocity.1 * self.motion.gradient.north_m - velocity.2
        };
        let altitude_m = self.motion.water_depth_m - self.motion.depth_m;
        // If the vehicle would sink faster even without horizontal motion, a lower horizontal speed does not help.
        let least_mps = (CLEARANCE_GAIN_PER_S * (self.altitude_min_m - altitude_m)).min(rises_mps(at_share(0.0)));
        let whole = at_share(1.0);
        if rises_mps(whole) >= least_mps {
            return whole;
        }
        let (mut slow, mut fast) = (0.0, 1.0);
        for _ in 0..BISECTIONS {
            let middle = (slow + fast) / 2.0;
            if rises_mps(at_share(middle)) >= least_mps {
                slow = middle;
            } else {
                fast = middle;
            }
        }
        at_share(slow)
    }

    /// A velocity (east, north, down) that comes no closer to the ship than the safety distance, and leads away from it
    /// if the vehicle is closer already.
    fn kept_clear(&self, velocity: (f64, f64, f64), safety_m: f64) -> (f64, f64, f64) {
        let Some(obstacle) = &self.obstacle else {
            return velocity;
        };
        let (clearance_m, away) = obstacle.ship.clearance(self.motion.at, self.motion.depth_m);
        let least_mps = CLEARANCE_GAIN_PER_S * (safety_m - clearance_m);
        let away_mps = velocity.0 * away.0 + velocity.1 * away.1 + velocity.2 * away.2;
        let more_mps = least_mps - away_mps;
        if more_mps <= 0.0 {
            return velocity;
        }
        (
            velocity.0 + more_mps * away.0,
            velocity.1 + more_mps * away.1,
            velocity.2 + more_mps * away.2,
        )
    }
}

fn capped(vector: (f64, f64), most: f64) -> (f64, f64) {
    let length = hypot(vector.0, vector.1);
    if length <= most {
        return vector;
    }
    (vector.0 * most / length, vector.1 * most / length)
}
