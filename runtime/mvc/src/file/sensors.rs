use serde::Deserialize;

use crate::error::{MvcError, check};

/// The `[sensors]` section: noise is the standard deviation of one reading. 0 is a perfect sensor.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SensorConfig {
    /// Position, metres a reading, each way.
    pub position_noise_m: f64,
    /// Drift of the position under water: a random walk whose standard deviation each way after an hour is this,
    /// metres. It ends on the surface.
    pub position_drift_m_per_sqrt_h: f64,
    /// Depth, metres.
    pub depth_noise_m: f64,
    /// Heading, degrees.
    pub heading_noise_deg: f64,
    /// Roll and pitch, degrees.
    pub attitude_noise_deg: f64,
    /// Velocity over ground, metres a second each way.
    pub velocity_noise_mps: f64,
    /// Altitude, metres.
    pub altitude_noise_m: f64,
    /// The greatest altitude with bottom lock, metres.
    pub altitude_range_m: f64,
    /// The least altitude with bottom lock, metres.
    pub altitude_blanking_m: f64,
    /// Losses of bottom lock an hour.
    pub altitude_dropouts_per_h: f64,
    /// Mean length of a loss of bottom lock, seconds, 0.1 or more.
    pub altitude_dropout_s: f64,
    /// Temperature, degrees Celsius.
    pub temperature_noise_c: f64,
    /// Conductivity, microsiemens a centimetre.
    pub conductivity_noise_us_per_cm: f64,
    /// Pressure, kilopascals.
    pub pressure_noise_kpa: f64,
    /// Seconds between CTD readings, 0.1 to 3600.
    pub ctd_period_s: f64,
}

impl Default for SensorConfig {
    fn default() -> Self {
        Self {
            position_noise_m: 0.03,
            position_drift_m_per_sqrt_h: 4.0,
            depth_noise_m: 0.01,
            heading_noise_deg: 0.05,
            attitude_noise_deg: 0.05,
            velocity_noise_mps: 0.005,
            altitude_noise_m: 0.05,
            altitude_range_m: 200.0,
            altitude_blanking_m: 0.5,
            altitude_dropouts_per_h: 4.0,
            altitude_dropout_s: 0.8,
            temperature_noise_c: 0.002,
            conductivity_noise_us_per_cm: 3.0,
            pressure_noise_kpa: 0.1,
            ctd_period_s: 1.0,
        }
    }
}

impl SensorConfig {
    pub(crate) fn validate(&self) -> Result<(), MvcError> {
        for (key, value) in [
            ("sensors.position_noise_m", self.position_noise_m),
            ("sensors.position_drift_m_per_sqrt_h", self.position_drift_m_per_sqrt_h),
            ("sensors.depth_noise_m", self.depth_noise_m),
            ("sensors.heading_noise_deg", self.heading_noise_deg),
            ("sensors.attitude_noise_deg", self.attitude_noise_deg),
            ("sensors.velocity_noise_mps", self.velocity_noise_mps),
            ("sensors.altitude_noise_m", self.altitude_noise_m),
            ("sensors.altitude_range_m", self.altitude_range_m),
            ("sensors.altitude_blanking_m", self.altitude_blanking_m),
            ("sensors.altitude_dropouts_per_h", self.altitude_dropouts_per_h),
            ("sensors.temperature_noise_c", self.temperature_noise_c),
            (
                "sensors.conductivity_noise_us_per_cm",
                self.conductivity_noise_us_per_cm,
            ),
            ("sensors.pressure_noise_kpa", self.pressure_noise_kpa),
        ] {
            check((0.0..=1000.0).contains(&value), key, value, "0 to 1000")?;
        }
        let dropout = self.altitude_dropout_s;
        check(
            (0.1..=3600.0).contains(&dropout),
            "sensors.altitude_dropout_s",
            dropout,
            "0.1 to 3600 s",
        )?;
        let period = self.ctd_period_s;
        check(
            (0.1..=3600.0).contains(&period),
            "sensors.ctd_period_s",
            period,
            "0.1 to 3600 s",
        )
    }
}
