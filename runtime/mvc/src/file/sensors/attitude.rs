use serde::Deserialize;

use super::within;
use crate::error::{MvcError, check};

/// The greatest number of compasses of a vehicle.
pub(crate) const COMPASSES_MAX: usize = 4;

/// The `[sensors.compass]` section: magnetic compasses, whose raw readings BFRCM reports.
///
/// The deviation is Archibald Smith's formula: A + B sin h + C cos h + D sin 2h + E cos 2h, where h is the magnetic
/// heading (Bowditch, *The American Practical Navigator*, chapter on compass error). The seed draws the five
/// coefficients for each compass.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CompassConfig {
    /// How many there are, 0 to 4.
    pub count: u32,
    /// Magnetic declination, degrees, positive to the east, within 180. The default is that of Massachusetts Bay in
    /// 2026 (World Magnetic Model 2025): set your own.
    pub declination_deg: f64,
    /// Standard deviation of A, which comes from how the compass is mounted, degrees, 0 to 90.
    pub bias_deg: f64,
    /// Standard deviation of B and of C, which come from the vehicle's permanent magnetism, degrees, 0 to 90.
    pub deviation_deg: f64,
    /// Standard deviation of D and of E, which come from the vehicle's soft iron, degrees, 0 to 90.
    pub soft_iron_deg: f64,
    /// Noise of heading, pitch and roll, degrees, 0 to 90. The default is that of an electronic compass (PNI TCM, data
    /// sheet).
    pub noise_deg: f64,
    /// The time from one BFRCM to the next, seconds, 0.01 to 3600.
    pub period_s: f64,
}

impl Default for CompassConfig {
    fn default() -> Self {
        Self {
            count: 1,
            declination_deg: -14.0,
            bias_deg: 0.3,
            deviation_deg: 1.5,
            soft_iron_deg: 0.5,
            noise_deg: 0.2,
            period_s: 0.2,
        }
    }
}

impl CompassConfig {
    pub(super) fn validate(&self) -> Result<(), MvcError> {
        let count = f64::from(self.count);
        let ok = self.count as usize <= COMPASSES_MAX;
        check(ok, "sensors.compass.count", count, "0 to 4")?;
        within(
            "sensors.compass.declination_deg",
            self.declination_deg,
            -180.0..=180.0,
            "within 180 degrees",
        )?;
        for (key, value) in [
            ("sensors.compass.bias_deg", self.bias_deg),
            ("sensors.compass.deviation_deg", self.deviation_deg),
            ("sensors.compass.soft_iron_deg", self.soft_iron_deg),
            ("sensors.compass.noise_deg", self.noise_deg),
        ] {
            within(key, value, 0.0..=90.0, "0 to 90 degrees")?;
        }
        let period = "0.01 to 3600 s";
        within("sensors.compass.period_s", self.period_s, 0.01..=3600.0, period)
    }
}

/// The `[sensors.imu]` section: gyroscopes and accelerometers, whose raw readings BFIMU reports.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ImuConfig {
    /// Noise of a rotation rate, degrees a second, 0 to 100. The default is the angle random walk of a tactical-grade
    /// unit, 0.1 degrees per square root of an hour, at 10 readings a second (Honeywell HG1700, data sheet).
    pub rate_noise_dps: f64,
    /// Bias of each rotation rate, degrees an hour, 0 to 100000. The default, 1, is from the same data sheet.
    pub rate_bias_dph: f64,
    /// Noise of an acceleration, metres a second squared, 0 to 100.
    pub acceleration_noise_mps2: f64,
    /// Bias of each acceleration, metres a second squared, 0 to 100. The default is 1 milli-g (same data sheet).
    pub acceleration_bias_mps2: f64,
    /// The time from one BFIMU to the next, seconds, 0.01 to 3600.
    pub period_s: f64,
}

impl Default for ImuConfig {
    fn default() -> Self {
        Self {
            rate_noise_dps: 0.005,
            rate_bias_dph: 1.0,
            acceleration_noise_mps2: 0.005,
            acceleration_bias_mps2: 0.01,
            period_s: 0.1,
        }
    }
}

impl ImuConfig {
    pub(super) fn validate(&self) -> Result<(), MvcError> {
        let hundred = "0 to 100";
        within("sensors.imu.rate_noise_dps", self.rate_noise_dps, 0.0..=100.0, hundred)?;
        let bias = "0 to 100000 degrees an hour";
        within("sensors.imu.rate_bias_dph", self.rate_bias_dph, 0.0..=1e5, bias)?;
        within(
            "sensors.imu.acceleration_noise_mps2",
            self.acceleration_noise_mps2,
            0.0..=100.0,
            hundred,
        )?;
        within(
            "sensors.imu.acceleration_bias_mps2",
            self.acceleration_bias_mps2,
            0.0..=100.0,
            hundred,
        )?;
        within("sensors.imu.period_s", self.period_s, 0.01..=3600.0, "0.01 to 3600 s")
    }
}
