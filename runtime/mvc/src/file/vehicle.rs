use backseat_plan::{VehicleClass, VehicleLimits};
use serde::Deserialize;

use crate::error::{MvcError, check};
use crate::vehicle::performance::Performance;
use crate::vehicle::sixdof::flown;

/// How the vehicle's motion is computed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
pub enum MotionModel {
    /// First-order lags of speed, turn and depth rate, within the limits of the class. Fast to compute.
    #[default]
    #[serde(rename = "kinematic")]
    Kinematic,
    /// A rigid body with six degrees of freedom: the published REMUS 100 under an autopilot of our own. It keeps the
    /// class's limits as far as that body reaches them: it needs at least 1 m/s to steer and to hold its depth, and
    /// turns more slowly. It is integrated at 50 Hz, whatever `tick_hz` is. Not for a hovering vehicle.
    #[serde(rename = "6-dof")]
    SixDof,
}

/// The `[vehicle]` section: the class, and limits tighter than those of the class.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct VehicleConfig {
    /// The class of the vehicle.
    pub class: VehicleClass,
    /// How it moves: `kinematic` or `6-dof`.
    pub model: MotionModel,
    /// The greatest depth to which the vehicle goes, whatever is asked, metres; `None` for the class's rating.
    pub depth_max_m: Option<f64>,
    /// The least height above the seabed that the vehicle keeps, whatever is asked, metres, 0 to 100.
    pub altitude_min_m: f64,
    /// The greatest speed through the water, metres a second; `None` for that of the class.
    pub speed_max_mps: Option<f64>,
    /// How many steps of the vehicle, and how many BFNVG and BFNVR, there are in a second, 1 to 100. Real vehicles send
    /// 10.
    pub tick_hz: u32,
}

impl Default for VehicleConfig {
    fn default() -> Self {
        Self {
            class: VehicleClass::default(),
            model: MotionModel::default(),
            depth_max_m: None,
            altitude_min_m: 2.0,
            speed_max_mps: None,
            tick_hz: 10,
        }
    }
}

impl VehicleConfig {
    /// What the vehicle can do: the class's performance under this section's model and limits.
    #[must_use]
    pub fn performance(&self) -> Performance {
        let performance = *Performance::of(self.class);
        self.under_model(&Performance {
            depth_max_m: self.depth_max_m.unwrap_or(performance.depth_max_m),
            speed_max_mps: self.speed_max_mps.unwrap_or(performance.speed_max_mps),
            ..performance
        })
    }

    /// The part of [`VehicleConfig::performance`] against which plans are checked.
    #[must_use]
    pub fn limits(&self) -> VehicleLimits {
        let performance = self.performance();
        VehicleLimits {
            speed_min_mps: performance.speed_min_mps,
            speed_max_mps: performance.speed_max_mps,
            yaw_rate_max_dps: performance.yaw_rate_max_dps,
            depth_max_m: performance.depth_max_m,
            altitude_min_m: self.altitude_min_m,
        }
    }

    fn under_model(&self, performance: &Performance) -> Performance {
        match self.model {
            MotionModel::Kinematic => *performance,
            MotionModel::SixDof => flown(performance),
        }
    }

    pub(crate) fn validate(&self) -> Result<(), MvcError> {
        if self.model == MotionModel::SixDof && Performance::of(self.class).hovers {
            return Err(MvcError::Value {
                key: "vehicle.model",
                value: "\"6-dof\"".to_owned(),
                expected: "\"kinematic\" with the class \"hovering\": the body of 6-dof is a torpedo",
            });
        }
        let performance = self.under_model(Performance::of(self.class));
        if let Some(depth) = self.depth_max_m {
            let ok = (1.0..=performance.depth_max_m).contains(&depth);
            check(ok, "vehicle.depth_max_m", depth, "1 m to the rating of the class")?;
        }
        if let Some(speed) = self.speed_max_mps {
            let ok = speed > performance.speed_min_mps && speed <= performance.speed_max_mps;
            check(
                ok,
                "vehicle.speed_max_mps",
                speed,
                "above the least speed of the class, at most its greatest",
            )?;
        }
        let altitude = self.altitude_min_m;
        check(
            (0.0..=100.0).contains(&altitude),
            "vehicle.altitude_min_m",
            altitude,
            "0 to 100 m",
        )?;
        let tick = self.tick_hz;
        check(
            (1..=100).contains(&tick),
            "vehicle.tick_hz",
            f64::from(tick),
            "1 to 100",
        )
    }
}
