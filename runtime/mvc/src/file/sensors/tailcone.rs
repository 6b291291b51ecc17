use serde::Deserialize;

use super::within;
use crate::error::MvcError;

/// The `[sensors.tailcone]` section: thruster and angles as BFRVL and BFERC give them. A hovering vehicle has none.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TailconeConfig {
    /// Noise of the thruster's turns, a minute, 0 to 1000.
    pub rpm_noise: f64,
    /// BFRVL gives the speed by its table of turns; else that field is empty (SPI 6.7).
    pub speed_table: bool,
    /// Standard deviation of the table's constant scale error, which the seed draws, as a share, 0 to 1.
    pub speed_error: f64,
    /// Noise of the angles, degrees, 0 to 90.
    pub angle_noise_deg: f64,
    /// The furthest that rudder and elevator go, degrees, 1 to 90. The default is a usual stop of small torpedoes.
    pub angle_max_deg: f64,
    /// Seconds between BFRVL, and between BFERC, 0.01 to 3600.
    pub period_s: f64,
}

impl Default for TailconeConfig {
    fn default() -> Self {
        Self {
            rpm_noise: 1.0,
            speed_table: true,
            speed_error: 0.03,
            angle_noise_deg: 0.05,
            angle_max_deg: 15.0,
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
        let angle = "1 to 90 degrees";
        within("sensors.tailcone.angle_max_deg", self.angle_max_deg, 1.0..=90.0, angle)?;
        let period = "0.01 to 3600 s";
        within("sensors.tailcone.period_s", self.period_s, 0.01..=3600.0, period)
    }
}

/// The `[sensors.telemetry]` section: BFTEL, which SPI 6.3 calls not implemented. Off unless it is asked for.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TelemetryConfig {
    /// BFTEL is sent.
    pub enabled: bool,
    /// What the acoustic modem can carry up a minute, kilobytes, 0 to 1000000. The default is 80 bits a second, its
    /// robust rate (WHOI Micro-Modem, rate 0).
    pub acoustic_up_kb: f64,
    /// What it can carry down a minute, kilobytes, 0 to 1000000.
    pub acoustic_down_kb: f64,
    /// Seconds between BFTEL, 0.01 to 3600.
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
