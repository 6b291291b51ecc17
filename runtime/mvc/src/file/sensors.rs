mod attitude;
mod dvl;
mod navigation;
mod tailcone;
mod water;

use core::ops::RangeInclusive;

use serde::Deserialize;

pub(crate) use attitude::COMPASSES_MAX;
pub use attitude::{CompassConfig, ImuConfig};
pub use dvl::DvlConfig;
pub use navigation::{FixConfig, GpsConfig, InsConfig, WithoutLock};
pub use tailcone::{TailconeConfig, TelemetryConfig};
pub use water::{DepthSensorConfig, SoundConfig};

use crate::error::{MvcError, check};

/// The `[sensors]` section: noise is the standard deviation of one reading. 0 is a perfect sensor.
///
/// The keys of the section itself are what BFNVG, BFNVR and BFCTD are made with; each other sensor has a section below.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SensorConfig {
    /// Position, metres a reading, each way.
    pub position_noise_m: f64,
    /// Drift of the position with bottom lock: a random walk whose standard deviation each way after an hour is this,
    /// metres. Scale, alignment and heading errors come on top, a share of the distance. GPS ends it.
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
    /// The greatest altitude with bottom lock, metres. A beam reaches as far as it is long at this altitude.
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
    /// Standard deviation of the temperature's constant error, which the seed draws, degrees Celsius (Sea-Bird SBE 49, data
    /// sheet: initial accuracy; the next two also).
    pub temperature_bias_c: f64,
    /// The same of the conductivity, microsiemens a centimetre.
    pub conductivity_bias_us_per_cm: f64,
    /// The same of the pressure, kilopascals.
    pub pressure_bias_kpa: f64,
    /// Seconds between CTD readings, 0.1 to 3600.
    pub ctd_period_s: f64,
    /// The vehicle has a CTD; else BFCTD never comes (SPI 6.16).
    pub ctd_fitted: bool,
    /// Inertial system.
    pub ins: InsConfig,
    /// Doppler log.
    pub dvl: DvlConfig,
    /// GPS.
    pub gps: GpsConfig,
    /// Fixes of the payload.
    pub fixes: FixConfig,
    /// Compasses.
    pub compass: CompassConfig,
    /// Gyroscopes and accelerometers.
    pub imu: ImuConfig,
    /// Pressure sensor.
    pub depth: DepthSensorConfig,
    /// Speed of sound.
    pub sound: SoundConfig,
    /// Thruster, rudder and elevator.
    pub tailcone: TailconeConfig,
    /// State of the links to the topside.
    pub telemetry: TelemetryConfig,
}

impl Default for SensorConfig {
    fn default() -> Self {
        Self {
            position_noise_m: 0.03,
            position_drift_m_per_sqrt_h: 3.5,
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
            temperature_bias_c: 0.002,
            conductivity_bias_us_per_cm: 3.0,
            pressure_bias_kpa: 0.2,
            ctd_period_s: 1.0,
            ctd_fitted: true,
            ins: InsConfig::default(),
            dvl: DvlConfig::default(),
            gps: GpsConfig::default(),
            fixes: FixConfig::default(),
            compass: CompassConfig::default(),
            imu: ImuConfig::default(),
            depth: DepthSensorConfig::default(),
            sound: SoundConfig::default(),
            tailcone: TailconeConfig::default(),
            telemetry: TelemetryConfig::default(),
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
            ("sensors.temperature_bias_c", self.temperature_bias_c),
            ("sensors.conductivity_bias_us_per_cm", self.conductivity_bias_us_per_cm),
            ("sensors.pressure_bias_kpa", self.pressure_bias_kpa),
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
        within("sensors.ctd_period_s", period, 0.1..=3600.0, "0.1 to 3600 s")?;
        self.ins.validate()?;
        self.dvl.validate()?;
        self.gps.validate()?;
        self.fixes.validate()?;
        self.compass.validate()?;
        self.imu.validate()?;
        self.depth.validate()?;
        self.sound.validate()?;
        self.tailcone.validate()?;
        self.telemetry.validate()
    }
}

fn within(key: &'static str, value: f64, range: RangeInclusive<f64>, expected: &'static str) -> Result<(), MvcError> {
    check(range.contains(&value), key, value, expected)
}
