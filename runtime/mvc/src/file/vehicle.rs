use backseat_plan::{VehicleClass, VehicleLimits};
use serde::Deserialize;

use crate::error::{MvcError, check};
use crate::vehicle::performance::Performance;
use crate::vehicle::sixdof::flown;

/// How the vehicle's motion is worked out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
pub enum MotionModel {
    /// First-order lags of speed, turn and depth rate, with the class's limits. Fast.
    #[default]
    #[serde(rename = "kinematic")]
    Kinematic,
    /// A rigid body with six degrees of freedom: the published REMUS 100 with an autopilot of ours, within the class's
    /// limits as far as that body reaches them (it steers and holds its depth from 1 m/s on, and turns slower).
    /// Integrated at 50 Hz whatever `tick_hz` is. Not for a hovering vehicle.
    #[serde(rename = "6-dof")]
    SixDof,
}

/// The `[vehicle]` section: which class, and limits tighter than the class's own.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct VehicleConfig {
    /// Which class.
    pub class: VehicleClass,
    /// How it moves: `kinematic` or `6-dof`.
    pub model: MotionModel,
    /// The deepest that the vehicle goes, whatever is asked, metres; none is the class's rating.
    pub depth_max_m: Option<f64>,
    /// The closest that it goes to the seabed, whatever is asked, metres, 0 to 100.
    pub altitude_min_m: f64,
    /// The fastest that it goes through the water, metres a second; none is the class's.
    pub speed_max_mps: Option<f64>,
    /// Steps of the vehicle and navigation messages a second, 1 to 100. Real vehicles: 10.
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
    /// What the class can do under this section's model, with this section's limits put in.
    #[must_use]
    pub fn performance(&self) -> Performance {
        let performance = *Performance::of(self.class);
        self.under_model(&Performance {
            depth_max_m: self.depth_max_m.unwrap_or(performance.depth_max_m),
            speed_max_mps: self.speed_max_mps.unwrap_or(performance.speed_max_mps),
            ..performance
        })
    }

    /// The part of that which plans are held against.
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
                expected: "\"kinematic\" where vehicle.class is \"hovering\": the body of 6-dof is a torpedo",
            });
        }
        let performance = self.under_model(Performance::of(self.class));
        if let Some(depth) = self.depth_max_m {
            let ok = (1.0..=performance.depth_max_m).contains(&depth);
            check(ok, "vehicle.depth_max_m", depth, "1 m to the class's rating")?;
        }
        if let Some(speed) = self.speed_max_mps {
            let ok = speed > performance.speed_min_mps && speed <= performance.speed_max_mps;
            check(
                ok,
                "vehicle.speed_max_mps",
                speed,
                "above the class's least speed, at most its greatest",
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
