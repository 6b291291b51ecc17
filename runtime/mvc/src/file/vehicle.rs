use serde::Deserialize;

use crate::error::{MvcError, check};
use crate::hull::{Hull, HullClass};

/// The `[vehicle]` section: which hull, and limits tighter than the hull's own.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct VehicleConfig {
    /// Which hull.
    pub class: HullClass,
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
            depth_max_m: None,
            altitude_min_m: 2.0,
            speed_max_mps: None,
            tick_hz: 10,
        }
    }
}

impl VehicleConfig {
    /// The hull's data with this section's limits put in.
    #[must_use]
    pub fn hull(&self) -> Hull {
        let hull = *Hull::of(self.class);
        Hull {
            depth_max_m: self.depth_max_m.unwrap_or(hull.depth_max_m),
            speed_max_mps: self.speed_max_mps.unwrap_or(hull.speed_max_mps),
            ..hull
        }
    }

    pub(crate) fn validate(&self) -> Result<(), MvcError> {
        let hull = Hull::of(self.class);
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
