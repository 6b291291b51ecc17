//! How the vehicle moves at worst: how wide it turns, how long that takes, how fast it is, its cross-track allowance
//! (safety requirement 002).

use super::Envelope;

impl Envelope {
    /// The cross-track allowance: how far the vehicle may be beside a way or a line, metres. It is the sum of the
    /// errors, the width of a whole turn, and the drift in the current during that turn, because the vehicle's next
    /// target may be behind it or abeam.
    pub(super) fn cross_track_m(&self, speed_mps: f64) -> f64 {
        let limits = &self.limits;
        limits.tracking_error_m
            + limits.navigation_error_m
            + self.turn_away_m(speed_mps)
            + limits.current_max_mps * self.turn_away_s()
    }

    /// The width of a whole turn, metres.
    pub(super) fn turn_away_m(&self, speed_mps: f64) -> f64 {
        2.0 * turn_radius_m(speed_mps, self.limits.turn_rate_dps) + speed_mps * self.limits.turn_lag_s
    }

    /// How long half a circle takes, seconds.
    pub(super) fn turn_away_s(&self) -> f64 {
        180.0 / self.limits.turn_rate_dps + self.limits.turn_lag_s
    }

    /// The greatest speed at which the vehicle flies, m/s: a request of ours, or its own plan.
    pub(super) fn fastest_mps(&self, seen_mps: f64) -> f64 {
        let of_plan_mps = match self.limits.plan_speed_max_mps {
            // If even the strongest current does not explain the speed over ground, the plan is faster than the mission
            // says.
            Some(told_mps) => told_mps.max(seen_mps - self.limits.current_max_mps),
            None => seen_mps,
        };
        self.limits.speed_max_mps.max(of_plan_mps)
    }
}

pub(super) fn turn_radius_m(speed_mps: f64, turn_rate_dps: f64) -> f64 {
    speed_mps / turn_rate_dps.to_radians()
}
