use serde::{Deserialize, Serialize};

use crate::monitor::limits::{LimitError, Limits};

/// What navigation may report from one sample to the next: the `[limits.integrity]` table of a mission (safety
/// requirement 024). The defaults are what no vehicle can do. Tighter limits find more faults, and find them sooner.
///
/// A *step* is what noise and a correction of the solution may do between any two samples. A *drift* is what may be
/// added to it for each second between them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct IntegrityLimits {
    /// The greatest speed over ground, m/s. If absent: 1.5 times the sum of `speed_max_mps` (at least 3 m/s) and the
    /// strongest current, because a vehicle may be built for more speed than its mission asks for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub speed_max_mps: Option<f64>,
    /// How far the position may step, metres. The default is what the check for jumps (021) allows in addition to the
    /// vehicle's motion.
    pub position_step_m: f64,
    /// How fast position and integrated velocity may drift apart, m/s. Dead reckoning is that integral, so what differs
    /// from it is a correction.
    pub position_drift_mps: f64,
    /// The fastest dive or climb, m/s. The default is 45 degrees of pitch at 3 m/s, and some heave.
    pub depth_rate_max_mps: f64,
    /// How far the depth may step, metres: at the surface, waves pass over the pressure sensor.
    pub depth_step_m: f64,
    /// How fast depth and integrated vertical velocity may drift apart, m/s: they come from two sensors.
    pub depth_drift_mps: f64,
    /// How far the heading may step, degrees: iron turns a compass as the vehicle passes it.
    pub heading_step_deg: f64,
    /// How fast heading and integrated yaw rate may drift apart, degrees a second: the body's yaw rate is not quite the
    /// heading's while the vehicle rolls and pitches.
    pub heading_drift_dps: f64,
    /// How long the position may be the same to its last digit while the velocity is 0.3 m/s or more, seconds.
    pub frozen_s: f64,
    /// How long BFNVG may come without BFNVR, seconds.
    pub velocity_gap_s: f64,
    /// How far depth plus altitude may step in addition to what `seabed_slope_max` lets the seabed rise, metres: wrecks
    /// and rocks stand on the seabed.
    pub seabed_step_m: f64,
}

impl Default for IntegrityLimits {
    fn default() -> Self {
        Self {
            speed_max_mps: None,
            position_step_m: 10.0,
            position_drift_mps: 0.3,
            depth_rate_max_mps: 2.5,
            depth_step_m: 5.0,
            depth_drift_mps: 0.5,
            heading_step_deg: 60.0,
            heading_drift_dps: 5.0,
            frozen_s: 8.0,
            velocity_gap_s: 1.5,
            seabed_step_m: 15.0,
        }
    }
}

impl IntegrityLimits {
    /// The same limits with `speed_max_mps` set.
    pub(crate) fn resolved(self, limits: &Limits) -> Self {
        let speed_max_mps = self
            .speed_max_mps
            .unwrap_or(1.5 * (limits.speed_max_mps.max(3.0) + limits.current_max_mps));
        Self {
            speed_max_mps: Some(speed_max_mps),
            ..self
        }
    }

    /// The greatest speed over ground, m/s. It is 0 before `resolved` has set it, so that every speed exceeds it.
    pub(crate) fn speed_max_mps(&self) -> f64 {
        self.speed_max_mps.unwrap_or(0.0)
    }

    pub(crate) fn validate(&self) -> Result<(), LimitError> {
        let keys = [
            ("integrity.speed_max_mps", self.speed_max_mps.unwrap_or(1.0)),
            ("integrity.position_step_m", self.position_step_m),
            ("integrity.position_drift_mps", self.position_drift_mps),
            ("integrity.depth_rate_max_mps", self.depth_rate_max_mps),
            ("integrity.depth_step_m", self.depth_step_m),
            ("integrity.depth_drift_mps", self.depth_drift_mps),
            ("integrity.heading_step_deg", self.heading_step_deg),
            ("integrity.heading_drift_dps", self.heading_drift_dps),
            ("integrity.frozen_s", self.frozen_s),
            ("integrity.velocity_gap_s", self.velocity_gap_s),
            ("integrity.seabed_step_m", self.seabed_step_m),
        ];
        for (key, value) in keys {
            if !(value > 0.0 && value < 1e6) {
                return Err(LimitError {
                    key,
                    value,
                    expected: "a number above 0",
                });
            }
        }
        Ok(())
    }
}
