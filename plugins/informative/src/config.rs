use backseat_sdk::survey::{Kernel, Rectangle};
use backseat_sdk::units::EastNorth;
use serde::Deserialize;

use crate::settings::Settings;

/// The plugin's settings, from the mission file. Metres count from the mission's origin.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Config {
    /// The centre of the area.
    pub east_m: f64,
    /// The centre of the area.
    pub north_m: f64,
    /// The length of the area, metres, 100 to 5000.
    pub length_m: f64,
    /// Its width, metres, 100 to 5000, and at most its length.
    pub width_m: f64,
    /// The direction of its length, degrees from the north of the mission's local frame, -360 to 360.
    pub bearing_deg: f64,
    /// Over which distance the field changes, metres, 10 to 2000: 1.4 times the radius of a patch (one standard
    /// deviation of a Gaussian).
    pub scale_m: f64,
    /// By how much it varies around its mean over the whole area: the standard deviation, degrees Celsius, 0.01 to 20. A
    /// smaller value makes the vehicle stay longer at what it has found, a larger one makes it look elsewhere.
    pub deviation_c: f64,
    /// The error of a measurement: the standard deviation, degrees Celsius, 0.001 to 5.
    #[serde(default = "default::noise_c")]
    pub noise_c: f64,
    /// Places that are warmer than this are of interest, degrees Celsius, -5 to 45.
    pub warm_c: f64,
    /// How far the lines of the first search are apart, metres, 20 to 5000.
    pub search_m: f64,
    /// The length of a planned line, metres, 60 to 2000: about twice `scale_m`. A line to a place farther away is longer.
    pub line_m: f64,
    /// How long the way of the survey may be, from the start of the first line on, metres, 100 to 100000.
    pub way_m: f64,
    /// The depth to fly at, metres below the surface, 0 to 6000.
    pub depth_m: f64,
    /// Speed through the water, metres per second, 0.3 to 3.
    pub speed_mps: f64,
    /// If false, the lines are those of a lawnmower over the whole area with the same way, to compare with.
    #[serde(default = "default::adaptive")]
    pub adaptive: bool,
}

mod default {
    pub(super) const fn noise_c() -> f64 {
        0.02
    }
    pub(super) const fn adaptive() -> bool {
        true
    }
}

/// An error in a configuration.
#[derive(Clone, Debug, PartialEq)]
pub struct ConfigError {
    key: &'static str,
    value: f64,
    least: f64,
    most: f64,
}

impl std::fmt::Display for ConfigError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self {
            key,
            value,
            least,
            most,
        } = self;
        write!(f, "{key} is {value}: expected {least} to {most}")
    }
}

impl Config {
    /// Checks every value, and gives the planner's settings.
    ///
    /// # Errors
    /// [`ConfigError`] with the key and what was expected.
    pub fn settings(&self) -> Result<Settings, ConfigError> {
        for (key, value, least, most) in [
            ("east_m", self.east_m, -50_000.0, 50_000.0),
            ("north_m", self.north_m, -50_000.0, 50_000.0),
            ("length_m", self.length_m, 100.0, 5000.0),
            ("width_m", self.width_m, 100.0, self.length_m),
            ("bearing_deg", self.bearing_deg, -360.0, 360.0),
            ("scale_m", self.scale_m, 10.0, 2000.0),
            ("deviation_c", self.deviation_c, 0.01, 20.0),
            ("noise_c", self.noise_c, 0.001, 5.0),
            ("warm_c", self.warm_c, -5.0, 45.0),
            ("search_m", self.search_m, 20.0, 5000.0),
            ("line_m", self.line_m, 60.0, 2000.0),
            ("way_m", self.way_m, 100.0, 100_000.0),
            ("depth_m", self.depth_m, 0.0, 6000.0),
            ("speed_mps", self.speed_mps, 0.3, 3.0),
        ] {
            if !(least..=most).contains(&value) {
                return Err(ConfigError {
                    key,
                    value,
                    least,
                    most,
                });
            }
        }
        let centre = EastNorth::new(self.east_m, self.north_m);
        Ok(Settings {
            area: Rectangle::new(centre, self.length_m, self.width_m, self.bearing_deg),
            kernel: Kernel {
                length_m: self.scale_m,
                deviation: self.deviation_c,
                noise: self.noise_c,
            },
            warm_c: self.warm_c,
            search_m: self.search_m,
            line_m: self.line_m,
            way_m: self.way_m,
            adaptive: self.adaptive,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_invalid_value_is_refused_with_its_key_and_range() {
        let config = |text: &str| serde_json::from_str::<Config>(text).unwrap();
        let good = r#"{"east_m": 0, "north_m": 0, "length_m": 600, "width_m": 400, "bearing_deg": 0, "scale_m": 90,
            "deviation_c": 0.7, "warm_c": 12.5, "search_m": 200, "line_m": 150, "way_m": 3000, "depth_m": 12, "speed_mps": 1.5}"#;
        assert!(config(good).settings().is_ok());
        let refused = |from: &str, to: &str| config(&good.replace(from, to)).settings().unwrap_err().to_string();
        assert_eq!(
            refused("\"width_m\": 400", "\"width_m\": 700"),
            "width_m is 700: expected 100 to 600"
        );
        assert_eq!(refused("1.5", "5"), "speed_mps is 5: expected 0.3 to 3");
    }
}
