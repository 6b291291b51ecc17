use backseat_plan::{HullClass, VehicleLimits};
use serde::Deserialize;

use crate::error::{MvcError, check};
use crate::vehicle::hull::Hull;
use crate::vehicle::sixdof::flown;

/// How the vehicle's motion is worked out.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize)]
pub enum MotionModel {
    /// First-order lags of speed, turn and depth rate, with the hull's limits. Fast.
    #[default]
    #[serde(rename = "kinematic")]
    Kinematic,
    /// A rigid body with six degrees of freedom: the published REMUS 100 with an autopilot of ours, within the hull's
    /// limits as far as that body reaches them (it steers and holds its depth from 1 m/s on, and turns slower).
    /// Integrated at 50 Hz whatever `tick_hz` is. Not for a hovering hull.
    #[serde(rename = "6-dof")]
    SixDof,
}

/// The `[vehicle]` section: which hull, and limits tighter than the hull's own.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct VehicleConfig {
    /// Which hull.
    pub class: HullClass,
    /// How it moves: `kinematic` or `6-dof`.
    pub model: MotionModel,
    /// The deepest that the vehicle goes, whatever is asked, metres; none is the hull's rating.
    pub depth_max_m: Option<f64>,
    /// The closest that it goes to the seabed, whatever is asked, metres, 0 to 100.
    pub altitude_min_m: f64,
    /// The fastest that it goes through the water, metres a second; none is the hull's.
    pub speed_max_mps: Option<f64>,
    /// Steps of the vehicle and navigation messages a second, 1 to 100. Real vehicles: 10.
    pub tick_hz: u32,
}

impl Default for VehicleConfig {
    fn default() -> Self {
        Self {
            class: HullClass::default(),
            model: MotionModel::default(),
            depth_max_m: None,
            altitude_min_m: 2.0,
            speed_max_mps: None,
            tick_hz: 10,
        }
    }
}

impl VehicleConfig {
    /// What the hull can do under this section's model, with this section's limits put in.
    #[must_use]
    pub fn hull(&self) -> Hull {
        let hull = *Hull::of(self.class);
        self.under_model(&Hull {
            depth_max_m: self.depth_max_m.unwrap_or(hull.depth_max_m),
            speed_max_mps: self.speed_max_mps.unwrap_or(hull.speed_max_mps),
            ..hull
        })
    }

    /// The part of that which plans are held against.
    #[must_use]
    pub fn limits(&self) -> VehicleLimits {
        let hull = self.hull();
        VehicleLimits {
            speed_min_mps: hull.speed_min_mps,
            speed_max_mps: hull.speed_max_mps,
            yaw_rate_max_dps: hull.yaw_rate_max_dps,
            depth_max_m: hull.depth_max_m,
            altitude_min_m: self.altitude_min_m,
        }
    }

    fn under_model(&self, hull: &Hull) -> Hull {
        match self.model {
            MotionModel::Kinematic => *hull,
            MotionModel::SixDof => flown(hull),
        }
    }

    pub(crate) fn validate(&self) -> Result<(), MvcError> {
        if self.model == MotionModel::SixDof && Hull::of(self.class).hovers {
            return Err(MvcError::Value {
                key: "vehicle.model",
                value: "\"6-dof\"".to_owned(),
                expected: "\"kinematic\" where vehicle.class is \"hovering\": the body of 6-dof is a torpedo",
            });
        }
        let hull = self.under_model(Hull::of(self.class));
        if let Some(depth) = self.depth_max_m {
            let ok = (1.0..=hull.depth_max_m).contains(&depth);
            check(ok, "vehicle.depth_max_m", depth, "1 m to the hull's rating")?;
        }
        if let Some(speed) = self.speed_max_mps {
            let ok = speed > hull.speed_min_mps && speed <= hull.speed_max_mps;
            check(
                ok,
                "vehicle.speed_max_mps",
                speed,
                "above the hull's least speed, at most its greatest",
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
