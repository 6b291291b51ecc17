use serde::Deserialize;

use crate::error::{MvcError, check};

/// The `[sensors.ins]` section: the inertial navigation system, with its heading and its velocity without bottom lock.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct InsConfig {
    /// Bias of the heading, degrees, 0 to 30. The default is the 0.02 degrees of a fibre-optic gyrocompass times the
    /// secant of a middle latitude (iXblue Phins, data sheet).
    pub heading_bias_deg: f64,
    /// How fast the velocity becomes wrong without bottom lock: the standard deviation of a random walk after a second,
    /// in each direction, metres a second, 0 to 1. The default grows to 0.02 m/s in a minute, as accelerometers of 50
    /// micro-g give (same data sheet).
    pub velocity_walk_mps_per_sqrt_s: f64,
    /// What navigation relies on without bottom lock.
    pub without_lock: WithoutLock,
}

/// What navigation relies on without bottom lock.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum WithoutLock {
    /// The accelerometers: the last velocity over ground, with an error that grows as a random walk.
    #[default]
    Inertial,
    /// The velocity through the water and the last known current, with an error that grows as a random walk.
    Water,
}

impl Default for InsConfig {
    fn default() -> Self {
        Self {
            heading_bias_deg: 0.03,
            velocity_walk_mps_per_sqrt_s: 0.003,
            without_lock: WithoutLock::Inertial,
        }
    }
}

impl InsConfig {
    pub(super) fn validate(&self) -> Result<(), MvcError> {
        let bias = self.heading_bias_deg;
        check(
            (0.0..=30.0).contains(&bias),
            "sensors.ins.heading_bias_deg",
            bias,
            "0 to 30 degrees",
        )?;
        let walk = self.velocity_walk_mps_per_sqrt_s;
        check(
            (0.0..=1.0).contains(&walk),
            "sensors.ins.velocity_walk_mps_per_sqrt_s",
            walk,
            "0 to 1",
        )
    }
}

/// The `[sensors.gps]` section: the GPS receiver, which corrects the position at the surface.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct GpsConfig {
    /// The depth above which the antenna is out of the water, metres, 0.01 to 5.
    pub antenna_depth_m: f64,
    /// The time from when the antenna is out of the water to the first fix, seconds, 0 to 3600. The default is that of
    /// a warm receiver, including the time that the filter waits; a hot start takes 1 s, a cold one 26 s (u-blox M8,
    /// data sheet).
    pub acquisition_s: f64,
    /// The error of a fix: a standard deviation in each direction, metres, 0 to 100. The default is that of a receiver
    /// with satellite-based augmentation: 95 % within 1.8 m (FAA, *WAAS Performance Analysis Report*).
    pub error_m: f64,
    /// How long the error of a fix lasts until the next ones have another, seconds, 0 to 3600. With 0, every fix has an
    /// error of its own.
    pub correlation_s: f64,
    /// The time from one fix to the next, seconds, 0.1 to 60.
    pub period_s: f64,
}

impl Default for GpsConfig {
    fn default() -> Self {
        Self {
            antenna_depth_m: 0.3,
            acquisition_s: 5.0,
            error_m: 0.7,
            correlation_s: 60.0,
            period_s: 1.0,
        }
    }
}

impl GpsConfig {
    pub(super) fn validate(&self) -> Result<(), MvcError> {
        let depth = self.antenna_depth_m;
        let ok = (0.01..=5.0).contains(&depth);
        check(ok, "sensors.gps.antenna_depth_m", depth, "0.01 to 5 m")?;
        let ok = (0.0..=3600.0).contains(&self.acquisition_s);
        check(ok, "sensors.gps.acquisition_s", self.acquisition_s, "0 to 3600 s")?;
        let ok = (0.0..=100.0).contains(&self.error_m);
        check(ok, "sensors.gps.error_m", self.error_m, "0 to 100 m")?;
        let ok = (0.0..=3600.0).contains(&self.correlation_s);
        check(ok, "sensors.gps.correlation_s", self.correlation_s, "0 to 3600 s")?;
        let ok = (0.1..=60.0).contains(&self.period_s);
        check(ok, "sensors.gps.period_s", self.period_s, "0.1 to 60 s")
    }
}

/// The `[sensors.fixes]` section: how the vehicle treats position fixes that a payload sends (BPNPU, SPI 7.21).
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FixConfig {
    /// A fix that is off by more standard deviations than this, of the solution and the fix together, is refused unless
    /// it is forced; 1 to 1000.
    pub outlier_sigma: f64,
    /// The greatest age of a fix, seconds, 0 to 120. An older fix is refused.
    pub age_max_s: f64,
    /// How much each second of its age adds to the standard deviation of a fix, metres, 0 to 10.
    pub age_error_mps: f64,
}

impl Default for FixConfig {
    fn default() -> Self {
        Self {
            outlier_sigma: 5.0,
            age_max_s: 60.0,
            age_error_mps: 0.02,
        }
    }
}

impl FixConfig {
    pub(super) fn validate(&self) -> Result<(), MvcError> {
        let ok = (1.0..=1000.0).contains(&self.outlier_sigma);
        check(ok, "sensors.fixes.outlier_sigma", self.outlier_sigma, "1 to 1000")?;
        let ok = (0.0..=120.0).contains(&self.age_max_s);
        check(ok, "sensors.fixes.age_max_s", self.age_max_s, "0 to 120 s")?;
        let ok = (0.0..=10.0).contains(&self.age_error_mps);
        check(ok, "sensors.fixes.age_error_mps", self.age_error_mps, "0 to 10 m/s")
    }
}
