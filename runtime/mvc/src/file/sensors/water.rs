use serde::Deserialize;

use super::within;
use crate::error::MvcError;

/// The `[sensors.depth]` section: the pressure sensor. BFRDP reports its raw readings, and the vehicle computes its
/// depth from it.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct DepthSensorConfig {
    /// Bias of the pressure, kilopascals, 0 to 100. 1 kPa is 0.1 m of depth. The default is 0.01 % of a range of 200 m
    /// (Paroscientific Digiquartz 8000, data sheet).
    pub bias_kpa: f64,
    /// Noise of the pressure in BFRDP, kilopascals, 0 to 100. That of the depth in BFNVG is `depth_noise_m` of
    /// `[sensors]`.
    pub noise_kpa: f64,
    /// The time from one BFRDP to the next, seconds, 0.01 to 3600.
    pub period_s: f64,
}

impl Default for DepthSensorConfig {
    fn default() -> Self {
        Self {
            bias_kpa: 0.2,
            noise_kpa: 0.05,
            period_s: 0.2,
        }
    }
}

impl DepthSensorConfig {
    pub(super) fn validate(&self) -> Result<(), MvcError> {
        let hundred = "0 to 100 kPa";
        within("sensors.depth.bias_kpa", self.bias_kpa, 0.0..=100.0, hundred)?;
        within("sensors.depth.noise_kpa", self.noise_kpa, 0.0..=100.0, hundred)?;
        let period = "0.01 to 3600 s";
        within("sensors.depth.period_s", self.period_s, 0.01..=3600.0, period)
    }
}

/// The `[sensors.sound]` section: the speed of sound, which BFSVS reports (SPI 6.4).
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SoundConfig {
    /// Whether the vehicle has a sensor for it. Otherwise BFSVS is an estimate: from a payload's CTD data while they
    /// are new, then from the vehicle's own CTD, then `nominal_mps` (SPI 6.4).
    pub fitted: bool,
    /// The speed that is assumed if nothing is known, metres a second, 1300 to 1700.
    pub nominal_mps: f64,
    /// Noise of the sensor, metres a second, 0 to 100 (AML SV-Xchange, data sheet: accuracy 0.025).
    pub noise_mps: f64,
    /// Bias of the sensor, metres a second, 0 to 100.
    pub bias_mps: f64,
    /// How long the vehicle uses CTD data of a payload (BPCTD, SPI 7.15), seconds, 0 to 86400.
    pub payload_data_for_s: f64,
    /// The time from one BFSVS to the next, seconds, 0.01 to 3600.
    pub period_s: f64,
}

impl Default for SoundConfig {
    fn default() -> Self {
        Self {
            fitted: false,
            nominal_mps: 1500.0,
            noise_mps: 0.02,
            bias_mps: 0.02,
            payload_data_for_s: 60.0,
            period_s: 1.0,
        }
    }
}

impl SoundConfig {
    pub(super) fn validate(&self) -> Result<(), MvcError> {
        let speed = "1300 to 1700 m/s";
        within("sensors.sound.nominal_mps", self.nominal_mps, 1300.0..=1700.0, speed)?;
        let hundred = "0 to 100 m/s";
        within("sensors.sound.noise_mps", self.noise_mps, 0.0..=100.0, hundred)?;
        within("sensors.sound.bias_mps", self.bias_mps, 0.0..=100.0, hundred)?;
        let day = "0 to 86400 s";
        within(
            "sensors.sound.payload_data_for_s",
            self.payload_data_for_s,
            0.0..=86_400.0,
            day,
        )?;
        let period = "0.01 to 3600 s";
        within("sensors.sound.period_s", self.period_s, 0.01..=3600.0, period)
    }
}
