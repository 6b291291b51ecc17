use backseat_sdk::Vertical;
use backseat_sdk::sonar::{DetectorSettings, SettingsError, Sighted};
use serde::Deserialize;

/// The plugin's settings, from the mission file.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Config {
    /// The index of the sidescan in the payload controller; any sidescan unless given.
    #[serde(default)]
    pub sensor: Option<i32>,
    /// An object is circled if its height is at least this, metres, 0.1 to 50.
    pub height_min_m: f64,
    /// And at most this, metres, at least `height_min_m`, at most 100.
    #[serde(default = "default::height_max_m")]
    pub height_max_m: f64,
    /// And if it is at most this long along and across the track, metres, 0.5 to 200.
    #[serde(default = "default::length_max_m")]
    pub length_max_m: f64,
    /// And if it is at most this many times as high as it is long, 0.5 to 100: a stone in front of a dark patch looks high
    /// and short.
    #[serde(default = "default::slender_max")]
    pub slender_max: f64,
    /// The radii of a circle in the order in which they are tried, metres, 8 to 200 each, 1 to 8 of them. The object is at
    /// this ground range during the circle.
    pub radii_m: Vec<f64>,
    /// Altitude of the circle, metres, 2 to 200; either this or `depth_m`.
    #[serde(default)]
    pub altitude_m: Option<f64>,
    /// Depth of the circle, metres, 0 to 6000.
    #[serde(default)]
    pub depth_m: Option<f64>,
    /// Speed through the water, metres per second, 0.3 to 3.
    pub speed_mps: f64,
    /// Number of rounds of a circle, -20 to 20, not between -0.5 and 0.5: positive clockwise.
    #[serde(default = "default::orbits")]
    pub orbits: f64,
    /// The most circles that are flown, 1 to 200.
    pub circles_max: u32,
    /// No circle around what is nearer to an inspected object than this, metres, 1 to 500.
    #[serde(default = "default::apart_m")]
    pub apart_m: f64,
    /// How far two sightings of the same object may be apart, by errors of navigation and of the detector, metres, 0.5 to
    /// 100.
    #[serde(default = "default::error_m")]
    pub error_m: f64,
    /// From how many of the eight sectors around it an object must show to be confirmed, 1 to 8.
    #[serde(default = "default::aspects_min")]
    pub aspects_min: u32,
    /// Whether a circle interrupts the vehicle's leg; if false, it follows it. Needs the grant `interrupt` too.
    #[serde(default)]
    pub interrupt: bool,
    /// Whether the verdicts go to the topside too. Needs the grant `topside`.
    #[serde(default)]
    pub topside: bool,
    /// Settings of the detector.
    #[serde(default)]
    pub detector: DetectorSettings,
}

mod default {
    pub(super) const fn height_max_m() -> f64 {
        20.0
    }
    pub(super) const fn length_max_m() -> f64 {
        40.0
    }
    pub(super) const fn slender_max() -> f64 {
        2.0
    }
    pub(super) const fn orbits() -> f64 {
        1.0
    }
    pub(super) const fn apart_m() -> f64 {
        15.0
    }
    pub(super) const fn error_m() -> f64 {
        4.0
    }
    pub(super) const fn aspects_min() -> u32 {
        3
    }
}

/// An error in a configuration.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ConfigError {
    /// A value outside its range.
    #[error("{key} is {value}: expected {expected}")]
    Range {
        /// The key.
        key: &'static str,
        /// The value.
        value: f64,
        /// The valid range.
        expected: &'static str,
    },
    /// None or both of two keys that exclude each other.
    #[error("expected one of altitude_m and depth_m")]
    Vertical,
    /// A setting of the detector.
    #[error("detector.{0}")]
    Detector(#[from] SettingsError),
}

fn within(key: &'static str, value: f64, least: f64, most: f64, expected: &'static str) -> Result<(), ConfigError> {
    if (least..=most).contains(&value) {
        Ok(())
    } else {
        Err(ConfigError::Range { key, value, expected })
    }
}

impl Config {
    /// Checks that every value is within its range.
    ///
    /// # Errors
    ///
    /// [`ConfigError`] with the first key that is not.
    pub fn validate(&self) -> Result<(), ConfigError> {
        within("height_min_m", self.height_min_m, 0.1, 50.0, "0.1 to 50 m")?;
        let expected = "height_min_m to 100 m";
        within("height_max_m", self.height_max_m, self.height_min_m, 100.0, expected)?;
        within("length_max_m", self.length_max_m, 0.5, 200.0, "0.5 to 200 m")?;
        within("slender_max", self.slender_max, 0.5, 100.0, "0.5 to 100")?;
        within("radii_m", self.radii_m.len() as f64, 1.0, 8.0, "1 to 8 radii")?;
        for radius_m in &self.radii_m {
            within("radii_m", *radius_m, 8.0, 200.0, "8 to 200 m")?;
        }
        match (self.altitude_m, self.depth_m) {
            (Some(altitude_m), None) => within("altitude_m", altitude_m, 2.0, 200.0, "2 to 200 m")?,
            (None, Some(depth_m)) => within("depth_m", depth_m, 0.0, 6000.0, "0 to 6000 m")?,
            (Some(_), Some(_)) | (None, None) => return Err(ConfigError::Vertical),
        }
        within("speed_mps", self.speed_mps, 0.3, 3.0, "0.3 to 3 m/s")?;
        let expected = "-20 to 20, not between -0.5 and 0.5";
        within("orbits", self.orbits.abs(), 0.5, 20.0, expected)?;
        within("circles_max", f64::from(self.circles_max), 1.0, 200.0, "1 to 200")?;
        within("apart_m", self.apart_m, 1.0, 500.0, "1 to 500 m")?;
        within("error_m", self.error_m, 0.5, 100.0, "0.5 to 100 m")?;
        within("aspects_min", f64::from(self.aspects_min), 1.0, 8.0, "1 to 8")?;
        Ok(self.detector.validate()?)
    }

    /// At which depth or altitude a circle is flown.
    #[must_use]
    pub fn vertical(&self) -> Vertical {
        match (self.altitude_m, self.depth_m) {
            (Some(altitude_m), _) => Vertical::Altitude(altitude_m),
            (None, depth_m) => Vertical::Depth(depth_m.unwrap_or_default()),
        }
    }

    /// Whether an object is worth a circle, by its height, its size and its shape.
    #[must_use]
    pub fn wants(&self, object: &Sighted) -> bool {
        let length_m = object.length_m.max(object.highlight_m);
        (self.height_min_m..=self.height_max_m).contains(&object.height_m)
            && length_m <= self.length_max_m
            && object.height_m <= self.slender_max * length_m
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn config(change: &str) -> Result<Config, String> {
        let text = format!(
            r#"{{"height_min_m": 0.6, "radii_m": [25], "altitude_m": 9, "speed_mps": 1.5, "circles_max": 5 {change}}}"#
        );
        let config: Config = serde_json::from_str(&text).map_err(|error| error.to_string())?;
        config.validate().map_err(|error| error.to_string())?;
        Ok(config)
    }

    #[test]
    fn an_object_is_wanted_for_its_height_its_length_and_its_shape() {
        use backseat_sdk::sonar::{Contact, Side, Sightings};
        use backseat_sdk::units::EastNorth;
        let wants = |height_m, length_m, highlight_m| {
            let mut sightings = Sightings::new(4.0, 1);
            let object = sightings.add(&Contact {
                side: Side::Port,
                at: EastNorth::default(),
                latitude_deg: 42.0,
                longitude_deg: -70.0,
                from: EastNorth::new(30.0, 0.0),
                ground_m: 30.0,
                slant_m: 31.0,
                highlight_m,
                shadow_m: 3.0,
                height_m,
                cut: false,
                length_m,
                pings: 10,
                score: 30.0,
            });
            config("").unwrap().wants(object.unwrap())
        };
        assert!(wants(1.0, 1.5, 0.5) && wants(1.0, 0.3, 0.6));
        assert!(!wants(0.5, 1.5, 0.5), "too low");
        assert!(!wants(21.0, 30.0, 5.0), "too high");
        assert!(!wants(3.0, 41.0, 5.0), "too long");
        assert!(!wants(3.0, 0.6, 0.6), "a stone in front of a dark patch");
    }

    #[test]
    fn an_invalid_value_is_refused_with_its_key() {
        assert!(config("").is_ok());
        let refusal = |change| config(change).unwrap_err();
        assert_eq!(refusal(r#", "depth_m": 4"#), "expected one of altitude_m and depth_m");
        assert_eq!(
            refusal(r#", "orbits": 0.1"#),
            "orbits is 0.1: expected -20 to 20, not between -0.5 and 0.5"
        );
        assert_eq!(refusal(r#", "aspects_min": 9"#), "aspects_min is 9: expected 1 to 8");
        assert_eq!(
            refusal(r#", "detector": {"nadir": 9}"#),
            "detector.nadir is 9: expected 0.2 to 5"
        );
        assert!(refusal(r#", "radius_m": 9"#).contains("unknown field `radius_m`"));
        assert!(refusal(r#", "detector": {"celll_m": 9}"#).contains("unknown field `celll_m`"));
    }
}
