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

/// The `[sensors]` section. A *noise* is the standard deviation of one reading; a *bias* is the standard deviation of
/// an error that the seed draws once for the run. 0 is a perfect sensor.
///
/// The keys of the section itself decide what BFNVG, BFNVR and BFCTD report; each other sensor has a section of its own
/// below.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SensorConfig {
    /// Noise of the position in BFNVG, in each direction, metres.
    pub position_noise_m: f64,
    /// How far the position drifts with bottom lock: the standard deviation of a random walk after an hour, in each
    /// direction, metres. Errors of scale, alignment and heading come on top, as a share of the distance. A GPS fix
    /// ends them.
    pub position_drift_m_per_sqrt_h: f64,
    /// Noise of the depth, metres.
    pub depth_noise_m: f64,
    /// Noise of the heading, degrees.
    pub heading_noise_deg: f64,
    /// Noise of roll and pitch, degrees.
    pub attitude_noise_deg: f64,
    /// Noise of the velocity over ground, in each direction, metres a second.
    pub velocity_noise_mps: f64,
    /// Noise of the altitude, metres.
    pub altitude_noise_m: f64,
    /// The greatest altitude with bottom lock, metres. The range of a beam is at most its length at this altitude.
    pub altitude_range_m: f64,
    /// The least altitude with bottom lock, metres.
    pub altitude_blanking_m: f64,
    /// How many times bottom lock is lost in an hour, in the mean.
    pub altitude_dropouts_per_h: f64,
    /// How long such a loss lasts, in the mean, seconds, 0.1 or more.
    pub altitude_dropout_s: f64,
    /// Noise of the temperature, degrees Celsius.
    pub temperature_noise_c: f64,
    /// Noise of the conductivity, microsiemens per centimetre.
    pub conductivity_noise_us_per_cm: f64,
    /// Noise of the pressure, kilopascals.
    pub pressure_noise_kpa: f64,
    /// Bias of the temperature, degrees Celsius. The defaults of this and the next two are the initial accuracy of a
    /// Sea-Bird SBE 49 (data sheet).
    pub temperature_bias_c: f64,
    /// Bias of the conductivity, microsiemens per centimetre.
    pub conductivity_bias_us_per_cm: f64,
    /// Bias of the pressure, kilopascals.
    pub pressure_bias_kpa: f64,
    /// The time from one reading of the CTD to the next, seconds, 0.1 to 3600.
    pub ctd_period_s: f64,
    /// Whether the vehicle has a CTD. Without one, it sends no BFCTD (SPI 6.16).
    pub ctd_fitted: bool,
    /// Inertial navigation system.
    pub ins: InsConfig,
    /// Doppler log.
    pub dvl: DvlConfig,
    /// GPS.
    pub gps: GpsConfig,
    /// Position fixes from payloads.
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
