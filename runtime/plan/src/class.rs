use serde::{Deserialize, Serialize};

/// The vehicle classes that the interface covers (SPI 1).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
pub enum VehicleClass {
    /// A small torpedo-shaped vehicle.
    #[serde(rename = "9-inch")]
    NineInch,
    /// A torpedo-shaped survey vehicle.
    #[default]
    #[serde(rename = "12-inch")]
    TwelveInch,
    /// A torpedo-shaped vehicle for deep water.
    #[serde(rename = "21-inch")]
    TwentyOneInch,
    /// A vehicle for hull inspection, which can hover.
    #[serde(rename = "hovering")]
    Hovering,
}

/// What a vehicle can do, as far as plans and limits are checked against it.
///
/// The values of a class are typical of vehicles of its size, estimated from public data sheets. They do not come from
/// the maker and have not been validated on a vehicle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VehicleLimits {
    /// The lowest speed at which it can steer and keep its depth, metres a second; 0 if it can hover.
    pub speed_min_mps: f64,
    /// The highest speed through the water, metres a second.
    pub speed_max_mps: f64,
    /// The fastest turn, degrees a second.
    pub yaw_rate_max_dps: f64,
    /// The greatest depth, metres.
    pub depth_max_m: f64,
    /// The least altitude above the seabed, metres; 0 if only the plan decides.
    pub altitude_min_m: f64,
}

impl VehicleClass {
    /// Its name in `mission.toml` and `world.toml`.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::NineInch => "9-inch",
            Self::TwelveInch => "12-inch",
            Self::TwentyOneInch => "21-inch",
            Self::Hovering => "hovering",
        }
    }

    /// The limits of a vehicle of this class.
    #[must_use]
    pub const fn limits(self) -> VehicleLimits {
        let (speed_min_mps, speed_max_mps, yaw_rate_max_dps, depth_max_m) = match self {
            Self::NineInch => (0.5, 2.5, 15.0, 200.0),
            Self::TwelveInch => (0.5, 2.5, 10.0, 200.0),
            Self::TwentyOneInch => (0.5, 2.3, 6.0, 4500.0),
            Self::Hovering => (0.0, 0.75, 20.0, 60.0),
        };
        VehicleLimits {
            speed_min_mps,
            speed_max_mps,
            yaw_rate_max_dps,
            depth_max_m,
            altitude_min_m: 0.0,
        }
    }
}

impl VehicleLimits {
    /// The limits where the class is unknown: what a vehicle of any class can do.
    #[must_use]
    pub fn of_any_class() -> Self {
        let classes = [
            VehicleClass::NineInch,
            VehicleClass::TwelveInch,
            VehicleClass::TwentyOneInch,
            VehicleClass::Hovering,
        ];
        let widest = |widest: Self, class: VehicleClass| {
            let limits = class.limits();
            Self {
                speed_min_mps: widest.speed_min_mps.min(limits.speed_min_mps),
                speed_max_mps: widest.speed_max_mps.max(limits.speed_max_mps),
                yaw_rate_max_dps: widest.yaw_rate_max_dps.max(limits.yaw_rate_max_dps),
                depth_max_m: widest.depth_max_m.max(limits.depth_max_m),
                altitude_min_m: widest.altitude_min_m.min(limits.altitude_min_m),
            }
        };
        classes.into_iter().fold(VehicleClass::default().limits(), widest)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_vehicle_of_no_class_can_do_what_any_can() {
        let widest = VehicleLimits::of_any_class();
        assert_eq!((widest.speed_min_mps, widest.speed_max_mps), (0.0, 2.5));
        assert_eq!((widest.depth_max_m, widest.altitude_min_m), (4500.0, 0.0));
    }
}
