use backseat_sdk::units::{EastNorth, LocalFrame, Position};
use serde::{Deserialize, Serialize};

use crate::area::Area;

/// The plugin's settings, from the mission file.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Config {
    /// The area to search.
    #[serde(rename = "box")]
    pub area: BoxConfig,
    /// The distance between the lines of the first map, metres, 10 to 1000. It should not exceed the plume's radius by
    /// much.
    pub line_spacing_m: f64,
    /// The depth to fly at, metres below the surface, 0 to 6000.
    pub depth_m: f64,
    /// Speed through the water, metres per second, 0.3 to 3.
    pub speed_mps: f64,
    /// The quantity whose maximum to find.
    #[serde(default)]
    pub channel: Channel,
    /// Radius of the circle around the maximum, metres, 10 to 1000.
    #[serde(default = "default::circle_radius_m")]
    pub circle_radius_m: f64,
    /// Number of rounds of the circle, above 0 and at most 20.
    #[serde(default = "default::orbits")]
    pub orbits: f64,
    /// Half the length of the cross through the first estimate, metres, 30 to 1000.
    #[serde(default = "default::cross_m")]
    pub cross_m: f64,
    /// Whether the survey interrupts the current behavior when it begins; if false, it follows it.
    #[serde(default)]
    pub interrupt: bool,
    /// If false, no cross is flown, and the maximum is that of the even lines alone, to compare with.
    #[serde(default = "default::adaptive")]
    pub adaptive: bool,
}

/// A quantity that the CTD measures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Channel {
    /// Degrees Celsius.
    #[default]
    Temperature,
    /// Microsiemens per centimetre.
    Conductivity,
}

impl Channel {
    /// The unit, for logs.
    #[must_use]
    pub const fn unit(self) -> &'static str {
        match self {
            Self::Temperature => "C",
            Self::Conductivity => "uS/cm",
        }
    }
}

/// The box to survey: `south_west` and `north_east`, or `centre`, `width_m`, `height_m` and, if it is turned,
/// `orientation_deg`. Positions are latitude and longitude in degrees.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BoxConfig {
    /// One corner.
    #[serde(default)]
    pub south_west: Option<[f64; 2]>,
    /// The opposite corner.
    #[serde(default)]
    pub north_east: Option<[f64; 2]>,
    /// The centre.
    #[serde(default)]
    pub centre: Option<[f64; 2]>,
    /// Across `orientation_deg`, metres, 50 to 20000.
    #[serde(default)]
    pub width_m: Option<f64>,
    /// Along `orientation_deg`, metres, 50 to 20000.
    #[serde(default)]
    pub height_m: Option<f64>,
    /// The direction of the box's own north, degrees from north; 0 if missing.
    #[serde(default)]
    pub orientation_deg: Option<f64>,
}

mod default {
    pub(super) const fn circle_radius_m() -> f64 {
        60.0
    }
    pub(super) const fn orbits() -> f64 {
        2.0
    }
    pub(super) const fn cross_m() -> f64 {
        150.0
    }
    pub(super) const fn adaptive() -> bool {
        true
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
    /// Keys of the box that exclude each other.
    #[error("box: expected south_west and north_east, or centre, width_m and height_m")]
    Box,
}

fn within(
    key: &'static str,
    value: f64,
    range: core::ops::RangeInclusive<f64>,
    expected: &'static str,
) -> Result<(), ConfigError> {
    if range.contains(&value) {
        Ok(())
    } else {
        Err(ConfigError::Range { key, value, expected })
    }
}

fn position(key: &'static str, [latitude, longitude]: [f64; 2]) -> Result<Position, ConfigError> {
    within(
        key,
        latitude,
        -85.0..=85.0,
        "a latitude of -85 to 85 degrees, then a longitude",
    )?;
    Position::from_deg(latitude, longitude).map_err(|error| ConfigError::Range {
        key,
        value: error.value,
        expected: "a latitude, then a longitude of -180 to 180 degrees",
    })
}

impl BoxConfig {
    /// The box as an area.
    ///
    /// # Errors
    ///
    /// [`ConfigError`] with the key that is missing, unexpected or out of range.
    pub fn area(&self) -> Result<Area, ConfigError> {
        const SIDE: &str = "a side of 50 to 20000 m";
        let (centre, width_m, height_m, orientation_deg) = match (self.south_west, self.north_east, self.centre) {
            (Some(south_west), Some(north_east), None)
                if self.width_m.is_none() && self.height_m.is_none() && self.orientation_deg.is_none() =>
            {
                let south_west = position("box.south_west", south_west)?;
                let north_east = position("box.north_east", north_east)?;
                let across = LocalFrame::new(south_west).to_local(north_east);
                let centre = LocalFrame::new(south_west).to_position(across * 0.5);
                let half = LocalFrame::new(centre).to_local(north_east);
                within("box.north_east", half.east_m * 2.0, 50.0..=20_000.0, SIDE)?;
                within("box.north_east", half.north_m * 2.0, 50.0..=20_000.0, SIDE)?;
                (centre, half.east_m * 2.0, half.north_m * 2.0, 0.0)
            }
            (None, None, Some(centre)) => {
                let (Some(width_m), Some(height_m)) = (self.width_m, self.height_m) else {
                    return Err(ConfigError::Box);
                };
                let orientation_deg = self.orientation_deg.unwrap_or(0.0);
                (position("box.centre", centre)?, width_m, height_m, orientation_deg)
            }
            _ => return Err(ConfigError::Box),
        };
        within("box.width_m", width_m, 50.0..=20_000.0, SIDE)?;
        within("box.height_m", height_m, 50.0..=20_000.0, SIDE)?;
        within(
            "box.orientation_deg",
            orientation_deg,
            -360.0..=360.0,
            "-360 to 360 degrees",
        )?;
        Ok(Area::new(centre, EastNorth::new(width_m, height_m), orientation_deg))
    }
}

impl Config {
    /// Checks that every value is within its range.
    ///
    /// # Errors
    ///
    /// [`ConfigError`] with the first key that is not.
    pub fn validate(&self) -> Result<(), ConfigError> {
        self.area.area()?;
        within("line_spacing_m", self.line_spacing_m, 10.0..=1000.0, "10 to 1000 m")?;
        within("depth_m", self.depth_m, 0.0..=6000.0, "0 to 6000 m")?;
        within("speed_mps", self.speed_mps, 0.3..=3.0, "0.3 to 3 m/s")?;
        within("circle_radius_m", self.circle_radius_m, 10.0..=1000.0, "10 to 1000 m")?;
        within("orbits", self.orbits, 0.1..=20.0, "0.1 to 20")?;
        within("cross_m", self.cross_m, 30.0..=1000.0, "30 to 1000 m")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SMALL: &str = r#"{"box": {"south_west": [42.0, -70.0], "north_east": [42.0045, -69.9927]},
        "line_spacing_m": 70, "depth_m": 15, "speed_mps": 1.5}"#;

    fn config(from: &str, to: &str) -> Result<Config, String> {
        assert!(SMALL.contains(from));
        let config: Config = serde_json::from_str(&SMALL.replace(from, to)).map_err(|error| error.to_string())?;
        config.validate().map_err(|error| error.to_string())?;
        Ok(config)
    }

    #[test]
    fn a_box_is_given_by_its_corners_or_its_centre() {
        let area = config("70,", "70,").unwrap().area.area().unwrap();
        assert!(
            (area.rectangle().length_m() - 605.0).abs() < 2.0 && (area.rectangle().width_m() - 500.0).abs() < 1.0,
            "{area:?}"
        );
        let corners = r#""south_west": [42.0, -70.0], "north_east": [42.0045, -69.9927]"#;
        let middle = r#""centre": [42.0, -70.0], "width_m": 300, "height_m": 600, "orientation_deg": 30"#;
        let area = config(corners, middle).unwrap().area.area().unwrap();
        assert!(
            (area.rectangle().length_m() - 600.0).abs() < 1e-9,
            "lines along the longer side: {area:?}"
        );
        assert_eq!(
            config(corners, r#""centre": [42.0, -70.0], "width_m": 300"#).unwrap_err(),
            "box: expected south_west and north_east, or centre, width_m and height_m"
        );
    }

    #[test]
    fn an_invalid_value_is_refused_with_its_key_and_range() {
        assert_eq!(
            config(": 70", ": 7").unwrap_err(),
            "line_spacing_m is 7: expected 10 to 1000 m"
        );
        assert_eq!(config("1.5", "5").unwrap_err(), "speed_mps is 5: expected 0.3 to 3 m/s");
        assert!(
            config("[42.0, ", "[142.0, ")
                .unwrap_err()
                .starts_with("box.south_west is 142: expected a latitude")
        );
        assert!(
            config("42.0045", "41.99")
                .unwrap_err()
                .starts_with("box.north_east is -1")
        );
        assert!(
            config("depth_m", "deep_m")
                .unwrap_err()
                .contains("unknown field `deep_m`")
        );
    }
}
