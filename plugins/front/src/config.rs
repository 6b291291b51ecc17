use serde::Deserialize;

use crate::tracker::Settings;

/// The plugin's settings, from the mission file.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Config {
    /// The direction along the front, degrees from the north of the mission's local frame, -360 to 360.
    pub along_deg: f64,
    /// The angle between the legs and that direction, degrees, 20 to 85: steeper legs cross more often and come less far.
    pub cross_deg: f64,
    /// How far beyond the front the vehicle turns back, metres, 20 to 2000: at least the front's width.
    pub beyond_m: f64,
    /// How far to each side of where it began the vehicle searches, metres, 50 to 5000.
    pub search_m: f64,
    /// Waters whose temperatures differ by less than this are the same water, degrees Celsius, 0.05 to 10.
    pub contrast_min_c: f64,
    /// The depth to fly at, metres below the surface, 0 to 6000.
    pub depth_m: f64,
    /// Speed through the water, metres per second, 0.3 to 3.
    pub speed_mps: f64,
    /// If false, the vehicle turns only at `search_m` to each side, whatever it measures: a plain zigzag, to compare with.
    #[serde(default = "yes")]
    pub adaptive: bool,
    /// The temperatures that count as front in the measure `in_front`, degrees Celsius.
    #[serde(default)]
    pub front_c: Option<[f64; 2]>,
}

const fn yes() -> bool {
    true
}

/// An error in a configuration.
#[derive(Clone, Debug, PartialEq)]
pub struct ConfigError {
    key: &'static str,
    value: f64,
    expected: &'static str,
}

impl std::fmt::Display for ConfigError {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { key, value, expected } = self;
        write!(f, "{key} is {value}: expected {expected}")
    }
}

impl Config {
    /// Checks every value, and gives the tracker's settings.
    ///
    /// # Errors
    /// [`ConfigError`] with the key and what was expected.
    pub fn settings(&self) -> Result<Settings, ConfigError> {
        let within = |key, value: f64, least: f64, most: f64, expected| {
            if (least..=most).contains(&value) {
                Ok(())
            } else {
                Err(ConfigError { key, value, expected })
            }
        };
        within("along_deg", self.along_deg, -360.0, 360.0, "-360 to 360 degrees")?;
        within("cross_deg", self.cross_deg, 20.0, 85.0, "20 to 85 degrees")?;
        within("beyond_m", self.beyond_m, 20.0, 2000.0, "20 to 2000 m")?;
        within("search_m", self.search_m, 50.0, 5000.0, "50 to 5000 m")?;
        within(
            "contrast_min_c",
            self.contrast_min_c,
            0.05,
            10.0,
            "0.05 to 10 degrees Celsius",
        )?;
        within("depth_m", self.depth_m, 0.0, 6000.0, "0 to 6000 m")?;
        within("speed_mps", self.speed_mps, 0.3, 3.0, "0.3 to 3 m/s")?;
        if let Some([coldest_c, warmest_c]) = self.front_c {
            within(
                "front_c",
                coldest_c,
                -5.0,
                45.0,
                "two temperatures, the colder one first",
            )?;
            within(
                "front_c",
                warmest_c,
                coldest_c,
                45.0,
                "two temperatures, the colder one first",
            )?;
        }
        Ok(Settings {
            along_deg: self.along_deg,
            cross_deg: self.cross_deg,
            beyond_m: self.beyond_m,
            search_m: self.search_m,
            contrast_min_c: self.contrast_min_c,
            adaptive: self.adaptive,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_invalid_value_is_refused_with_its_key_and_range() {
        let good = Config {
            along_deg: 0.0,
            cross_deg: 60.0,
            beyond_m: 80.0,
            search_m: 400.0,
            contrast_min_c: 0.5,
            depth_m: 15.0,
            speed_mps: 1.5,
            adaptive: true,
            front_c: Some([12.0, 13.0]),
        };
        assert!(good.settings().is_ok());
        let refused = |change: fn(&mut Config)| {
            let mut config = good.clone();
            change(&mut config);
            config.settings().unwrap_err().to_string()
        };
        assert_eq!(
            refused(|config| config.cross_deg = 90.0),
            "cross_deg is 90: expected 20 to 85 degrees"
        );
        assert_eq!(
            refused(|config| config.beyond_m = f64::NAN),
            "beyond_m is NaN: expected 20 to 2000 m"
        );
        assert_eq!(
            refused(|config| config.front_c = Some([13.0, 12.0])),
            "front_c is 12: expected two temperatures, the colder one first"
        );
    }
}
