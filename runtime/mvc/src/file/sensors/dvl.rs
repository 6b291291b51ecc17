use serde::Deserialize;

use super::within;
use crate::error::MvcError;

/// The `[sensors.dvl]` section: the Doppler log. How far it reaches and how often it loses the bottom are the
/// `altitude_` keys of `[sensors]`, because the altitude is computed from its ranges.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct DvlConfig {
    /// Bias of the scale of its velocity, as a share, 0 to 0.2. The default is a quarter of the 0.2 % of an
    /// uncalibrated log: alignment runs remove the rest (Teledyne RDI Workhorse Navigator 600, data sheet; Kinsey and
    /// Whitcomb, "In Situ Alignment Calibration of Attitude and Doppler Sensors", 2007).
    pub scale_error: f64,
    /// Bias of its angle to the inertial system, degrees, 0 to 30.
    pub misalignment_deg: f64,
    /// Noise of a velocity along each axis, metres a second, 0 to 1 (Workhorse Navigator 600: 0.003 at 1 m/s).
    pub velocity_noise_mps: f64,
    /// Noise of the range of one beam, metres, 0 to 100.
    pub range_noise_m: f64,
    /// Angle of the beams from the log's axis, degrees, 5 to 60.
    pub beam_angle_deg: f64,
    /// How likely one beam of a reading is lost, 0 to 1.
    pub beam_loss: f64,
    /// The greatest roll or pitch with bottom lock, degrees, 1 to 90.
    pub tilt_max_deg: f64,
    /// Whether BFDVL and BFDV2 give the velocity through the water without bottom lock; otherwise they give none. SPI
    /// 6.13 does not say.
    pub water_velocity: bool,
    /// Whether its velocity is right at any speed of sound, as with a phased array. Otherwise it is wrong by the same
    /// share as the vehicle's value for the speed of sound.
    pub phased_array: bool,
    /// Noise of the water temperature that it measures, degrees Celsius, 0 to 10.
    pub temperature_noise_c: f64,
    /// The time from one BFDVL to the next, seconds, 0.01 to 3600.
    pub period_s: f64,
}

impl Default for DvlConfig {
    fn default() -> Self {
        Self {
            scale_error: 0.0005,
            misalignment_deg: 0.03,
            velocity_noise_mps: 0.003,
            range_noise_m: 0.05,
            beam_angle_deg: 30.0,
            beam_loss: 0.001,
            tilt_max_deg: 40.0,
            water_velocity: false,
            phased_array: true,
            temperature_noise_c: 0.2,
            period_s: 0.2,
        }
    }
}

impl DvlConfig {
    pub(super) fn validate(&self) -> Result<(), MvcError> {
        within("sensors.dvl.scale_error", self.scale_error, 0.0..=0.2, "0 to 0.2")?;
        let angle = "0 to 30 degrees";
        within("sensors.dvl.misalignment_deg", self.misalignment_deg, 0.0..=30.0, angle)?;
        let noise = "0 to 1 m/s";
        within(
            "sensors.dvl.velocity_noise_mps",
            self.velocity_noise_mps,
            0.0..=1.0,
            noise,
        )?;
        within(
            "sensors.dvl.range_noise_m",
            self.range_noise_m,
            0.0..=100.0,
            "0 to 100 m",
        )?;
        let angle = "5 to 60 degrees";
        within("sensors.dvl.beam_angle_deg", self.beam_angle_deg, 5.0..=60.0, angle)?;
        within("sensors.dvl.beam_loss", self.beam_loss, 0.0..=1.0, "0 to 1")?;
        let angle = "1 to 90 degrees";
        within("sensors.dvl.tilt_max_deg", self.tilt_max_deg, 1.0..=90.0, angle)?;
        within(
            "sensors.dvl.temperature_noise_c",
            self.temperature_noise_c,
            0.0..=10.0,
            "0 to 10 degrees",
        )?;
        within("sensors.dvl.period_s", self.period_s, 0.01..=3600.0, "0.01 to 3600 s")
    }
}
