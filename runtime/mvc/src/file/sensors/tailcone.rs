use serde::Deserialize;

use super::within;
use crate::error::MvcError;

/// The `[sensors.tailcone]` section: thruster, rudder and elevator, as BFRVL and BFERC report them. A hovering vehicle
/// has none.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TailconeConfig {
    /// Noise of the thruster's speed, revolutions a minute, 0 to 1000.
    pub rpm_noise: f64,
    /// Whether BFRVL also gives a speed through the water, computed from the thruster's speed. Otherwise that field is
    /// empty (SPI 6.7).
    pub speed_table: bool,
    /// Bias of that speed, as a share, 0 to 1.
    pub speed_error: f64,
    /// Noise of the angles, degrees, 0 to 90.
    pub angle_noise_deg: f64,
    /// The time from one BFRVL, and from one BFERC, to the next, seconds, 0.01 to 3600.
    pub period_s: f64,
}

impl Default for TailconeConfig {
    fn default() -> Self {
        Self {
            rpm_noise: 1.0,
            speed_table: true,
            speed_error: 0.03,
            angle_noise_deg: 0.05,
            period_s: 0.2,
        }
    }
}

impl TailconeConfig {
    pub(super) fn validate(&self) -> Result<(), MvcError> {
        within("sensors.tailcone.rpm_noise", self.rpm_noise, 0.0..=1000.0, "0 to 1000")?;
        within("sensors.tailcone.speed_error", self.speed_error, 0.0..=1.0, "0 to 1")?;
        let angle = "0 to 90 degrees";
        within(
            "sensors.tailcone.angle_noise_deg",
            self.angle_noise_deg,
            0.0..=90.0,
            angle,
        )?;
        let period = "0.01 to 3600 s";
        within("sensors.tailcone.period_s", self.period_s, 0.01..=3600.0, period)
    }
}

/// The `[sensors.telemetry]` section: the state of the links to the topside (BFTEL). SPI 6.3 says that it is not
/// implemented, so the default is off.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TelemetryConfig {
    /// Whether the vehicle sends BFTEL.
    pub enabled: bool,
    /// How much the acoustic modem can carry to the surface in a minute, kilobytes, 0 to 1000000. The default is 80
    /// bit/s, its most robust rate (WHOI Micro-Modem, rate 0).
    pub acoustic_up_kb: f64,
    /// How much it can carry down in a minute, kilobytes, 0 to 1000000.
    pub acoustic_down_kb: f64,
    /// The time from one BFTEL to the next, seconds, 0.01 to 3600.
    pub period_s: f64,
}

impl Default for TelemetryConfig {
    fn default() -> Self {
        Self {
            enabled: false,
            acoustic_up_kb: 0.6,
            acoustic_down_kb: 0.6,
            period_s: 1.0,
        }
    }
}

impl TelemetryConfig {
    pub(super) fn validate(&self) -> Result<(), MvcError> {
        let most = "0 to 1000000 kB";
        within("sensors.telemetry.acoustic_up_kb", self.acoustic_up_kb, 0.0..=1e6, most)?;
        let down = self.acoustic_down_kb;
        within("sensors.telemetry.acoustic_down_kb", down, 0.0..=1e6, most)?;
        let period = "0.01 to 3600 s";
        within("sensors.telemetry.period_s", self.period_s, 0.01..=3600.0, period)
    }
}
