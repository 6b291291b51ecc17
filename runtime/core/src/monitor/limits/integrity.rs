use serde::{Deserialize, Serialize};

use crate::monitor::limits::{LimitError, Limits};

/// What navigation may say from one sample to the next: the `[limits.integrity]` table of a mission (safety requirement
/// 024). By the defaults what no vehicle can do; tighter ones find more, and sooner.
///
/// A *step* is what noise and a correction of the solution may do between any two samples; a *drift* is what may come to it
/// for each second between them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct IntegrityLimits {
    /// The greatest speed over ground, m/s. Where absent, half as much again as `speed_max_mps` (3 m/s at least) and the
    /// strongest current together: a vehicle may be built for more than its mission asks.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub speed_max_mps: Option<f64>,
    /// How far the position may step, metres: as much as a jump may have without being one (021).
    pub position_step_m: f64,
    /// How far position and integrated velocity may drift apart in a second, m/s: dead reckoning is that integral, and what
    /// comes on top of it is a correction.
    pub position_drift_mps: f64,
    /// The fastest dive or climb, m/s: 45 degrees of pitch at 3 m/s, and heave.
    pub depth_rate_max_mps: f64,
    /// How far the depth may step, metres: waves at the surface pass over the pressure sensor.
    pub depth_step_m: f64,
    /// How far depth and integrated vertical velocity may drift apart in a second, m/s: they are of two sensors.
    pub depth_drift_mps: f64,
    /// How far the heading may step, degrees: a compass turns when iron passes.
    pub heading_step_deg: f64,
    /// How far heading and integrated yaw rate may drift apart in a second, degrees a second: a yaw rate of the body is not
    /// quite the heading's where the vehicle rolls and pitches.
    pub heading_drift_dps: f64,
    /// How long the position may be the same to its last digit while the velocity is over 0.3 m/s, seconds.
    pub frozen_s: f64,
    /// How long BFNVG may come without BFNVR, seconds.
    pub velocity_gap_s: f64,
    /// How much depth plus altitude may step beside what `seabed_slope_max` lets the seabed rise, metres: wrecks and rocks
    /// stand on it.
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
    /// With the greatest speed worked out.
    pub(crate) fn resolved(self, limits: &Limits) -> Self {
        let speed_max_mps = self
            .speed_max_mps
            .unwrap_or(1.5 * (limits.speed_max_mps.max(3.0) + limits.current_max_mps));
        Self {
            speed_max_mps: Some(speed_max_mps),
            ..self
        }
    }

    /// The greatest speed over ground, m/s; none is too much before it has been worked out.
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
