use backseat_world::Span;
use serde::Deserialize;

use crate::error::{MvcError, check};

/// The `[adjustment]` section: the trim and variable buoyancy systems (SPI 6.22, 6.23, 7.23, 7.24).
///
/// The specification says only that "the implementation is vehicle-specific". The rates and ranges are invented, of a
/// plausible size.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct AdjustmentConfig {
    /// Whether the vehicle has a trim system.
    pub trim_equipped: bool,
    /// How far the vehicle is out of trim in pitch at the start, degrees, within 45.
    pub trim_pitch_deg: Span,
    /// How far the vehicle is out of trim in roll at the start, degrees, within 45.
    pub trim_roll_deg: Span,
    /// How fast the trim system works, degrees a second, 0.001 to 10.
    pub trim_rate_dps: f64,
    /// How far out of trim is good enough, degrees, 0.001 to 10.
    pub trim_tolerance_deg: f64,
    /// How far the trim system reaches from where it is at the start, degrees, 0 to 45.
    pub trim_range_deg: f64,
    /// Whether the vehicle has a variable buoyancy system.
    pub buoyancy_equipped: bool,
    /// Buoyancy at the start, newtons, positive up, within 1000.
    pub buoyancy_n: Span,
    /// The buoyancy at which the vehicle floats up as fast as is typical of its class, newtons, 0.1 to 1000.
    pub buoyancy_nominal_n: f64,
    /// How fast the buoyancy system works, newtons a second, 0.001 to 100.
    pub buoyancy_rate_n_per_s: f64,
    /// How far from neutral is good enough, newtons, 0.01 to 100.
    pub buoyancy_tolerance_n: f64,
    /// How far the buoyancy system reaches from where it is at the start, newtons, 0 to 1000.
    pub buoyancy_range_n: f64,
    /// How far each newton of adjusted buoyancy puts the pitch out of trim, degrees, within 10 (SPI 7.24: "may cause
    /// the vehicle to no longer be trimmed").
    pub buoyancy_pitch_deg_per_n: f64,
    /// The speed through the water below which an adjustment that a payload asked for begins to work, metres a second,
    /// 0.01 to 1 (SPI 7.23, 7.24: "after it is detected that the vehicle has stopped moving forward").
    pub stopped_mps: f64,
    /// The longest time that an adjustment may take before it fails, seconds, 1 to 86400 (SPI 7.23, 7.24: "typically 20
    /// minutes").
    pub time_limit_s: f64,
    /// The time from one status message to the next while an adjustment is running, seconds, 0.1 to 3600.
    pub status_period_s: f64,
    /// The time from one BFBOY to the next while no adjustment is running, seconds, 0.1 to 3600 (SPI 6.23).
    pub idle_period_s: f64,
    /// How likely an adjustment fails, 0 to 1.
    pub failure_chance: f64,
    /// When the vehicle adjusts its buoyancy by itself, seconds after the start, in order (SPI 7.24: "implicit").
    pub implicit_at_s: Vec<f64>,
}

impl Default for AdjustmentConfig {
    fn default() -> Self {
        Self {
            trim_equipped: true,
            trim_pitch_deg: Span::fixed(1.5),
            trim_roll_deg: Span::fixed(-0.8),
            trim_rate_dps: 0.05,
            trim_tolerance_deg: 0.1,
            trim_range_deg: 5.0,
            buoyancy_equipped: true,
            buoyancy_n: Span::fixed(20.0),
            buoyancy_nominal_n: 20.0,
            buoyancy_rate_n_per_s: 0.5,
            buoyancy_tolerance_n: 0.5,
            buoyancy_range_n: 40.0,
            buoyancy_pitch_deg_per_n: 0.02,
            stopped_mps: 0.1,
            time_limit_s: 1200.0,
            status_period_s: 1.0,
            idle_period_s: 10.0,
            failure_chance: 0.0,
            implicit_at_s: Vec::new(),
        }
    }
}

impl AdjustmentConfig {
    pub(crate) fn validate(&self) -> Result<(), MvcError> {
        for (key, span, most, expected) in [
            (
                "adjustment.trim_pitch_deg",
                self.trim_pitch_deg,
                45.0,
                "within 45 degrees",
            ),
            (
                "adjustment.trim_roll_deg",
                self.trim_roll_deg,
                45.0,
                "within 45 degrees",
            ),
            ("adjustment.buoyancy_n", self.buoyancy_n, 1000.0, "within 1000 N"),
        ] {
            check(span.least() >= -most, key, span.least(), expected)?;
            check(span.most() <= most, key, span.most(), expected)?;
        }
        for (key, value, least, most, expected) in [
            (
                "adjustment.trim_rate_dps",
                self.trim_rate_dps,
                0.001,
                10.0,
                "0.001 to 10",
            ),
            (
                "adjustment.trim_tolerance_deg",
                self.trim_tolerance_deg,
                0.001,
                10.0,
                "0.001 to 10",
            ),
            ("adjustment.trim_range_deg", self.trim_range_deg, 0.0, 45.0, "0 to 45"),
            (
                "adjustment.buoyancy_nominal_n",
                self.buoyancy_nominal_n,
                0.1,
                1000.0,
                "0.1 to 1000",
            ),
            (
                "adjustment.buoyancy_rate_n_per_s",
                self.buoyancy_rate_n_per_s,
                0.001,
                100.0,
                "0.001 to 100",
            ),
            (
                "adjustment.buoyancy_tolerance_n",
                self.buoyancy_tolerance_n,
                0.01,
                100.0,
                "0.01 to 100",
            ),
            (
                "adjustment.buoyancy_range_n",
                self.buoyancy_range_n,
                0.0,
                1000.0,
                "0 to 1000",
            ),
            (
                "adjustment.buoyancy_pitch_deg_per_n",
                self.buoyancy_pitch_deg_per_n,
                -10.0,
                10.0,
                "-10 to 10",
            ),
            ("adjustment.stopped_mps", self.stopped_mps, 0.01, 1.0, "0.01 to 1 m/s"),
            (
                "adjustment.time_limit_s",
                self.time_limit_s,
                1.0,
                86_400.0,
                "1 to 86400 s",
            ),
            (
                "adjustment.status_period_s",
                self.status_period_s,
                0.1,
                3600.0,
                "0.1 to 3600 s",
            ),
            (
                "adjustment.idle_period_s",
                self.idle_period_s,
                0.1,
                3600.0,
                "0.1 to 3600 s",
            ),
            ("adjustment.failure_chance", self.failure_chance, 0.0, 1.0, "0 to 1"),
        ] {
            check((least..=most).contains(&value), key, value, expected)?;
        }
        super::ordered_times("adjustment.implicit_at_s", &self.implicit_at_s)
    }
}
