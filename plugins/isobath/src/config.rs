use backseat_sdk::units::math::wrap_180;
use serde::Deserialize;

/// The plugin's settings, from the mission file.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Config {
    /// The water depth to follow, metres, above 0 to 6000.
    pub contour_m: f64,
    /// The depth to fly at, metres below the surface, from 0 to less than `contour_m`.
    pub depth_m: f64,
    /// Speed through the water, metres per second, 0.3 to 3.
    pub speed_mps: f64,
    /// The general direction in which to follow the contour, degrees from north.
    ///
    /// Together with `deeper_toward_deg` it decides on which side the deep water is. The contour itself may then turn
    /// in any direction.
    pub along_deg: f64,
    /// The direction in which the water generally gets deeper, degrees from north; at least 30 degrees away from
    /// `along_deg` and its opposite.
    pub deeper_toward_deg: f64,
    /// How steep the seabed generally is, metres per metre, 0.002 to 0.5.
    #[serde(default = "default::slope")]
    pub slope: f64,
    /// How far along the contour to aim, metres, 5 to 200. With a smaller value the vehicle turns towards the contour
    /// more sharply, with a larger one more calmly.
    #[serde(default = "default::lookahead_m")]
    pub lookahead_m: f64,
    /// The distance over which the estimate of the seabed forgets old samples (their weight falls to 1/e), metres, 5 to
    /// 500.
    #[serde(default = "default::memory_m")]
    pub memory_m: f64,
    /// How long to keep the last heading without bottom lock, seconds, 0 to 600. After that the vehicle steers itself
    /// again.
    #[serde(default = "default::hold_s")]
    pub hold_s: f64,
    /// The duration of each modify, seconds, 6 to 600; at most the mission's `modify_term_max_s`.
    #[serde(default = "default::duration_s")]
    pub duration_s: f64,
    /// How long to wait after the fence has refused a heading, seconds, 1 to 600.
    #[serde(default = "default::retry_s")]
    pub retry_s: f64,
}

mod default {
    pub(super) const fn slope() -> f64 {
        0.03
    }
    pub(super) const fn lookahead_m() -> f64 {
        25.0
    }
    pub(super) const fn memory_m() -> f64 {
        40.0
    }
    pub(super) const fn hold_s() -> f64 {
        30.0
    }
    pub(super) const fn duration_s() -> f64 {
        20.0
    }
    pub(super) const fn retry_s() -> f64 {
        10.0
    }
}

/// An invalid value in the configuration.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{key} is {value}: expected {expected}")]
pub struct ConfigError {
    /// The key.
    pub key: &'static str,
    /// The value.
    pub value: f64,
    /// The valid range.
    pub expected: &'static str,
}

impl Config {
    /// Checks that every value is within its range.
    ///
    /// # Errors
    ///
    /// [`ConfigError`] with the first key that is not.
    pub fn validate(&self) -> Result<(), ConfigError> {
        let ranges = [
            ("contour_m", self.contour_m, 0.1..=6000.0, "above 0 to 6000 m"),
            ("depth_m", self.depth_m, 0.0..=6000.0, "0 to 6000 m"),
            ("speed_mps", self.speed_mps, 0.3..=3.0, "0.3 to 3 m/s"),
            ("along_deg", self.along_deg, -360.0..=360.0, "-360 to 360 degrees"),
            (
                "deeper_toward_deg",
                self.deeper_toward_deg,
                -360.0..=360.0,
                "-360 to 360 degrees",
            ),
            ("slope", self.slope, 0.002..=0.5, "0.002 to 0.5"),
            ("lookahead_m", self.lookahead_m, 5.0..=200.0, "5 to 200 m"),
            ("memory_m", self.memory_m, 5.0..=500.0, "5 to 500 m"),
            ("hold_s", self.hold_s, 0.0..=600.0, "0 to 600 s"),
            ("duration_s", self.duration_s, 6.0..=600.0, "6 to 600 s"),
            ("retry_s", self.retry_s, 1.0..=600.0, "1 to 600 s"),
        ];
        for (key, value, range, expected) in ranges {
            if !range.contains(&value) {
                return Err(ConfigError { key, value, expected });
            }
        }
        if self.depth_m >= self.contour_m {
            return Err(ConfigError {
                key: "depth_m",
                value: self.depth_m,
                expected: "less than contour_m",
            });
        }
        let between_deg = wrap_180(self.deeper_toward_deg - self.along_deg).abs();
        if !(30.0..=150.0).contains(&between_deg) {
            return Err(ConfigError {
                key: "deeper_toward_deg",
                value: self.deeper_toward_deg,
                expected: "a direction 30 degrees or more off the line of along_deg",
            });
        }
        Ok(())
    }

    /// 1 if the deep water is to starboard, -1 if it is to port.
    #[must_use]
    pub fn deep_side(&self) -> f64 {
        if wrap_180(self.deeper_toward_deg - self.along_deg) > 0.0 {
            1.0
        } else {
            -1.0
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SMALL: &str =
        r#"{"contour_m": 30.0, "depth_m": 12.0, "speed_mps": 1.5, "along_deg": 90.0, "deeper_toward_deg": 180.0}"#;

    fn parse(json: &str) -> Result<Config, String> {
        serde_json::from_str::<Config>(json).map_err(|error| error.to_string())
    }

    fn refusal(from: &str, to: &str) -> String {
        assert!(SMALL.contains(from));
        let config = parse(&SMALL.replace(from, to)).unwrap();
        config.validate().unwrap_err().to_string()
    }

    #[test]
    fn the_required_keys_suffice_and_say_on_which_side_deep_water_is() {
        let config = parse(SMALL).unwrap();
        assert_eq!(config.validate(), Ok(()));
        assert_eq!(config.deep_side(), 1.0);
        let other_way = Config {
            along_deg: 270.0,
            ..config
        };
        assert_eq!(other_way.deep_side(), -1.0);
    }

    #[test]
    fn an_invalid_value_is_refused_with_its_key_and_range() {
        assert_eq!(refusal("30.0", "-3.0"), "contour_m is -3: expected above 0 to 6000 m");
        assert_eq!(refusal("12.0", "31.0"), "depth_m is 31: expected less than contour_m");
        assert_eq!(refusal("1.5", "9.0"), "speed_mps is 9: expected 0.3 to 3 m/s");
        assert!(refusal("180.0", "100.0").starts_with("deeper_toward_deg is 100: expected a direction"));
        assert!(
            parse(&SMALL.replace("speed_mps", "speed"))
                .unwrap_err()
                .contains("unknown field `speed`")
        );
    }
}
