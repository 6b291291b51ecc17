//! What plugins may ask of a hovering vehicle: the `[limits.station]` table.

use std::time::Duration;

use serde::{Deserialize, Serialize};

use crate::monitor::limits::{LimitError, seconds};

/// What the operator lets plugins ask of a hovering vehicle's station keeping and devices (SPI 8), and what the vehicle
/// does at worst: the `[limits.station]` table of a mission. Without the table, every request for station keeping or
/// for a device is rejected.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StationLimits {
    /// The greatest speed of a move, m/s.
    pub speed_max_mps: f64,
    /// The vehicle's own speed limit, m/s. The runtime restores it after station keeping has changed it (SPI 8.4).
    #[serde(default = "default::speed_default_mps")]
    pub speed_default_mps: f64,
    /// How wrong relative navigation may be, plus how far the vehicle strays from its way, metres.
    #[serde(default = "default::position_error_m")]
    pub position_error_m: f64,
    /// Relative navigation older than this is stale, seconds.
    #[serde(default = "default::relative_age_max_s")]
    pub relative_age_max_s: f64,
    /// Relative navigation has jumped if it moves by more than the vehicle can, plus this, metres.
    #[serde(default = "default::jump_allowance_m")]
    pub jump_allowance_m: f64,
    /// The longest duration of one request for station keeping, seconds. The plugin must ask again before it is over.
    #[serde(default = "default::term_max_s")]
    pub term_max_s: f64,
    /// The least height above the seabed while the vehicle keeps its station over the bottom, metres.
    #[serde(default = "default::altitude_min_m")]
    pub altitude_min_m: f64,
    /// The least sonar angle, degrees; without it BPSAN is rejected.
    #[serde(default)]
    pub sonar_angle_min_deg: Option<f64>,
    /// The greatest sonar angle, degrees; without it BPSAN is rejected.
    #[serde(default)]
    pub sonar_angle_max_deg: Option<f64>,
    /// Where the vehicle may be relative to the hull (BFRNV, SPI 6.17); without it BPGHP is rejected.
    #[serde(default)]
    pub hull_box: Option<HullBox>,
    /// Where the vehicle may be in its inertial frame (BFCNV, SPI 6.19); without it BPGBP is rejected.
    #[serde(default)]
    pub bottom_box: Option<BottomBox>,
    /// Where the vehicle must not be relative to the hull, such as around a screw.
    #[serde(default)]
    pub keep_out_hull: Vec<HullBox>,
    /// Where the vehicle must not be in its inertial frame.
    #[serde(default)]
    pub keep_out_bottom: Vec<BottomBox>,
}

/// A box relative to the hull, in the coordinates of BFRNV and BPGHP, metres.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HullBox {
    /// Its name in refusals.
    #[serde(default)]
    pub name: String,
    /// Least horizontal position.
    pub horizontal_min_m: f64,
    /// Greatest horizontal position.
    pub horizontal_max_m: f64,
    /// Least vertical position.
    pub vertical_min_m: f64,
    /// Greatest vertical position.
    pub vertical_max_m: f64,
    /// Least distance from the hull. In the allowed box this is the least stand-off.
    pub distance_min_m: f64,
    /// Greatest distance from the hull.
    pub distance_max_m: f64,
}

/// A box in the vehicle's inertial frame, in the coordinates of BFCNV and BPGBP, with depths below the surface, metres.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BottomBox {
    /// Its name in refusals.
    #[serde(default)]
    pub name: String,
    /// Least x.
    pub x_min_m: f64,
    /// Greatest x.
    pub x_max_m: f64,
    /// Least y.
    pub y_min_m: f64,
    /// Greatest y.
    pub y_max_m: f64,
    /// Least depth.
    pub depth_min_m: f64,
    /// Greatest depth.
    pub depth_max_m: f64,
}

mod default {
    pub(super) const fn speed_default_mps() -> f64 {
        1.5
    }
    pub(super) const fn position_error_m() -> f64 {
        0.5
    }
    pub(super) const fn relative_age_max_s() -> f64 {
        1.0
    }
    pub(super) const fn jump_allowance_m() -> f64 {
        2.0
    }
    pub(super) const fn term_max_s() -> f64 {
        60.0
    }
    pub(super) const fn altitude_min_m() -> f64 {
        2.0
    }
}

impl StationLimits {
    /// Checks that every value is in its range.
    ///
    /// # Errors
    /// [`LimitError`] names the first key whose value is not.
    pub(crate) fn validate(&self) -> Result<(), LimitError> {
        let positive = [
            ("station.speed_max_mps", self.speed_max_mps),
            ("station.speed_default_mps", self.speed_default_mps),
            ("station.relative_age_max_s", self.relative_age_max_s),
            ("station.term_max_s", self.term_max_s),
        ];
        for (key, value) in positive {
            within(key, value, value > 0.0 && value < 1e6, "a number above 0")?;
        }
        let not_negative = [
            ("station.position_error_m", self.position_error_m),
            ("station.jump_allowance_m", self.jump_allowance_m),
            ("station.altitude_min_m", self.altitude_min_m),
        ];
        for (key, value) in not_negative {
            within(key, value, (0.0..1e6).contains(&value), "0 or more")?;
        }
        let age_s = self.relative_age_max_s;
        let expected = "at most 2: station keeping lapses after 2 s";
        within("station.relative_age_max_s", age_s, age_s <= 2.0, expected)?;
        match (self.sonar_angle_min_deg, self.sonar_angle_max_deg) {
            (None, None) => {}
            (Some(min), Some(max)) => {
                let turn = "within -360 to 360";
                within(
                    "station.sonar_angle_min_deg",
                    min,
                    (-360.0..=360.0).contains(&min),
                    turn,
                )?;
                within(
                    "station.sonar_angle_max_deg",
                    max,
                    (-360.0..=360.0).contains(&max),
                    turn,
                )?;
                let expected = "at least sonar_angle_min_deg";
                within("station.sonar_angle_max_deg", max, min <= max, expected)?;
            }
            (Some(alone), None) => within(
                "station.sonar_angle_min_deg",
                alone,
                false,
                "sonar_angle_max_deg as well",
            )?,
            (None, Some(alone)) => within(
                "station.sonar_angle_max_deg",
                alone,
                false,
                "sonar_angle_min_deg as well",
            )?,
        }
        if let Some(allowed) = &self.hull_box {
            allowed.validate("station.hull_box")?;
            let standoff_m = allowed.distance_min_m;
            within(
                "station.hull_box",
                standoff_m,
                standoff_m >= 0.0,
                "a distance_min_m of 0 or more",
            )?;
        }
        if let Some(allowed) = &self.bottom_box {
            allowed.validate("station.bottom_box")?;
        }
        for kept in &self.keep_out_hull {
            kept.validate("station.keep_out_hull")?;
        }
        for kept in &self.keep_out_bottom {
            kept.validate("station.keep_out_bottom")?;
        }
        Ok(())
    }

    pub(crate) fn relative_age_max(&self) -> Duration {
        seconds(self.relative_age_max_s)
    }

    pub(crate) fn term_max(&self) -> Duration {
        seconds(self.term_max_s)
    }
}

impl HullBox {
    fn validate(&self, key: &'static str) -> Result<(), LimitError> {
        ordered(key, self.horizontal_min_m, self.horizontal_max_m)?;
        ordered(key, self.vertical_min_m, self.vertical_max_m)?;
        ordered(key, self.distance_min_m, self.distance_max_m)
    }
}

impl BottomBox {
    fn validate(&self, key: &'static str) -> Result<(), LimitError> {
        ordered(key, self.x_min_m, self.x_max_m)?;
        ordered(key, self.y_min_m, self.y_max_m)?;
        ordered(key, self.depth_min_m, self.depth_max_m)
    }
}

fn ordered(key: &'static str, min: f64, max: f64) -> Result<(), LimitError> {
    let sound = |value: f64| value.abs() < 1e6;
    within(key, min, sound(min), "above -1000000 and below 1000000")?;
    within(key, max, sound(max) && max > min, "each max_m above its min_m")
}

fn within(key: &'static str, value: f64, holds: bool, expected: &'static str) -> Result<(), LimitError> {
    if holds {
        Ok(())
    } else {
        Err(LimitError { key, value, expected })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn limits() -> StationLimits {
        StationLimits {
            speed_max_mps: 0.5,
            speed_default_mps: 1.5,
            position_error_m: 0.5,
            relative_age_max_s: 1.0,
            jump_allowance_m: 2.0,
            term_max_s: 60.0,
            altitude_min_m: 2.0,
            sonar_angle_min_deg: Some(-90.0),
            sonar_angle_max_deg: Some(90.0),
            hull_box: Some(hull_box()),
            bottom_box: None,
            keep_out_hull: vec![hull_box()],
            keep_out_bottom: Vec::new(),
        }
    }

    fn hull_box() -> HullBox {
        HullBox {
            name: String::new(),
            horizontal_min_m: 0.0,
            horizontal_max_m: 50.0,
            vertical_min_m: 0.0,
            vertical_max_m: 10.0,
            distance_min_m: 1.0,
            distance_max_m: 10.0,
        }
    }

    #[test]
    fn an_invalid_limit_is_named() {
        assert_eq!(limits().validate(), Ok(()));
        type Break = fn(&mut StationLimits);
        let broken: [(&str, Break); 11] = [
            ("station.speed_max_mps", |limits| limits.speed_max_mps = 0.0),
            ("station.speed_default_mps", |limits| {
                limits.speed_default_mps = f64::NAN
            }),
            ("station.relative_age_max_s", |limits| limits.relative_age_max_s = 2.5),
            ("station.term_max_s", |limits| limits.term_max_s = f64::INFINITY),
            ("station.position_error_m", |limits| limits.position_error_m = -1.0),
            ("station.jump_allowance_m", |limits| limits.jump_allowance_m = f64::NAN),
            ("station.altitude_min_m", |limits| limits.altitude_min_m = -0.1),
            ("station.sonar_angle_min_deg", |limits| {
                limits.sonar_angle_max_deg = None
            }),
            ("station.sonar_angle_max_deg", |limits| {
                limits.sonar_angle_min_deg = Some(91.0)
            }),
            ("station.hull_box", |limits| {
                let allowed = limits.hull_box.as_mut().unwrap();
                allowed.distance_min_m = -1.0;
            }),
            ("station.keep_out_hull", |limits| {
                limits.keep_out_hull[0].vertical_max_m = f64::NAN
            }),
        ];
        for (key, break_it) in broken {
            let mut limits = limits();
            break_it(&mut limits);
            assert_eq!(limits.validate().unwrap_err().key, key);
        }
    }
}
