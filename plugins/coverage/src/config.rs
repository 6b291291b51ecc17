use backseat_sdk::sonar::coverage::{Area, AreaError, Axes, CoverageMap, MapError, Quality};
use backseat_sdk::units::math::{wrap_180, wrap_360};
use backseat_sdk::units::{EastNorth, LocalFrame, Position};
use serde::Deserialize;

/// The plugin's settings, from the mission file.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Config {
    /// The area to survey.
    pub area: AreaConfig,
    /// The direction of the lines, degrees from north, -360 to 360. Default: along the rectangle's longer side; a
    /// polygon needs it. Lines along the contours of the seabed see the most.
    #[serde(default)]
    pub lines_deg: Option<f64>,
    /// The sidescan's index in the payload controller, as in `[[sonar.sensor]]`.
    pub sensor: i32,
    /// The sonar's slant range before the plugin changes it, metres, 5 to 1000.
    pub range_m: f64,
    /// The altitude that is expected on the first line, metres, 1 to 500.
    pub first_altitude_m: f64,
    /// The depth to fly at, metres below the surface, 0 to 6000. Either this or `altitude_m`.
    #[serde(default)]
    pub depth_m: Option<f64>,
    /// The altitude to fly at, metres, 1 to 500.
    #[serde(default)]
    pub altitude_m: Option<f64>,
    /// Speed through the water, metres per second, 0.3 to 3.
    pub speed_mps: f64,
    /// By how much the swaths of two lines overlap, metres, 0 to 100: at least the error of navigation and tracking.
    #[serde(default = "default::overlap_m")]
    pub overlap_m: f64,
    /// How many lines shall see each place, 1 to 3.
    #[serde(default = "default::times")]
    pub times: u8,
    /// Half of the angle straight below the vehicle in which the image is no good, degrees, 0 to 70.
    #[serde(default = "default::nadir_deg")]
    pub nadir_deg: f64,
    /// The least power of the seabed over that of the noise, decibels, -10 to 40. Used if the noise is known.
    #[serde(default = "default::signal_min_db")]
    pub signal_min_db: f64,
    /// The part of a line that may have seen less than what the next line is laid by, 0 to 0.5. Gap lines do the rest.
    #[serde(default = "default::worst_but")]
    pub worst_but: f64,
    /// The size of the map's cells, metres, 1 to 50.
    #[serde(default = "default::cell_m")]
    pub cell_m: f64,
    /// The greatest rate of turn at which images count, degrees a second, 0.1 to 20.
    #[serde(default = "default::turn_max_dps")]
    pub turn_max_dps: f64,
    /// By how much a line is longer than what it shall see, at each end, metres, 0 to 200.
    #[serde(default = "default::run_in_m")]
    pub run_in_m: f64,
    /// A line to fill gaps is worth its way if it sees more than this for the first time, square metres a metre, 0.1 to
    /// 1000.
    #[serde(default = "default::fill_worth_m2_per_m")]
    pub fill_worth_m2_per_m: f64,
    /// The most lines to fill gaps, 0 to 200.
    #[serde(default = "default::fill_lines_max")]
    pub fill_lines_max: u32,
    /// The survey ends when this part of the area was seen, 0.1 to 1.
    #[serde(default = "default::enough")]
    pub enough: f64,
    /// The survey ends before a line with which its way would be longer than this, metres, 100 to 500000.
    #[serde(default = "default::way_max_m")]
    pub way_max_m: f64,
    /// Whether the survey interrupts the current behavior when it begins, or when nothing is queued; if false, it
    /// follows it. Needs the grant `interrupt`.
    #[serde(default)]
    pub interrupt: bool,
    /// Sets the sonar's range by the altitude. Needs the grant `sonar`.
    #[serde(default)]
    pub range: Option<RangeConfig>,
    /// Listens to the noise before the first line. Needs the grant `sonar`, and pings that are decimated by their mean.
    #[serde(default)]
    pub noise: Option<NoiseConfig>,
}

/// The area: a polygon, or a rectangle by its centre, length, width and bearing. Positions are latitude and longitude in
/// degrees.
#[derive(Clone, Debug, Default, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AreaConfig {
    /// The corners in order, 3 to 500.
    #[serde(default)]
    pub polygon: Option<Vec<[f64; 2]>>,
    /// The centre.
    #[serde(default)]
    pub centre: Option<[f64; 2]>,
    /// Along `bearing_deg`, metres, 50 to 20000.
    #[serde(default)]
    pub length_m: Option<f64>,
    /// Across it, metres, 50 to 20000.
    #[serde(default)]
    pub width_m: Option<f64>,
    /// The direction of the length, degrees from north; 0 if missing.
    #[serde(default)]
    pub bearing_deg: Option<f64>,
}

/// The range of the sonar: a multiple of the altitude. It is set before a line, by the altitude on the line before.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RangeConfig {
    /// Range over altitude, 1 to 50.
    pub per_altitude: f64,
    /// The least range, metres, 5 to 1000.
    pub min_m: f64,
    /// The greatest range, metres, `min_m` to 1000.
    pub max_m: f64,
}

/// Listening to the noise: some pings without transmission.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NoiseConfig {
    /// How many pings, 1 to 500.
    pub pings: u32,
    /// The transmission power afterwards, percent, above 0 and at most 100.
    pub power_percent: f64,
}

mod default {
    pub(super) const fn overlap_m() -> f64 {
        8.0
    }
    pub(super) const fn times() -> u8 {
        1
    }
    /// The lower edge of a beam that is 55 degrees wide and points 30 degrees down.
    pub(super) const fn nadir_deg() -> f64 {
        32.5
    }
    pub(super) const fn signal_min_db() -> f64 {
        3.0
    }
    pub(super) const fn worst_but() -> f64 {
        0.05
    }
    pub(super) const fn cell_m() -> f64 {
        5.0
    }
    pub(super) const fn turn_max_dps() -> f64 {
        1.5
    }
    pub(super) const fn run_in_m() -> f64 {
        10.0
    }
    pub(super) const fn fill_worth_m2_per_m() -> f64 {
        10.0
    }
    pub(super) const fn fill_lines_max() -> u32 {
        20
    }
    pub(super) const fn enough() -> f64 {
        0.995
    }
    pub(super) const fn way_max_m() -> f64 {
        100_000.0
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
    /// Keys of the area that exclude each other, or that are missing.
    #[error("area: expected polygon, or centre, length_m and width_m")]
    Area,
    /// The corners make no area.
    #[error("area.polygon: {0}")]
    Polygon(#[from] AreaError),
    /// A polygon without the direction of its lines.
    #[error("lines_deg is missing: a polygon needs it")]
    Lines,
    /// Neither or both.
    #[error("expected depth_m or altitude_m, and not both")]
    Vertical,
    /// The map cannot be made.
    #[error("area with cell_m: {0}")]
    Map(#[from] MapError),
}

/// What the configuration means on the ground.
#[derive(Clone, Debug)]
pub(crate) struct Ground {
    /// A local frame around the area's centre.
    pub(crate) frame: LocalFrame,
    pub(crate) map: CoverageMap,
    pub(crate) lines_deg: f64,
}

impl Config {
    /// Checks every value and lays out the area.
    pub(crate) fn ground(&self) -> Result<Ground, ConfigError> {
        self.check()?;
        let (frame, area, longer_deg) = self.area.area()?;
        let lines_deg = wrap_360(self.lines_deg.or(longer_deg).ok_or(ConfigError::Lines)?);
        let map = CoverageMap::new(&area, Axes::new(EastNorth::default(), lines_deg), self.cell_m)?;
        Ok(Ground { frame, map, lines_deg })
    }

    /// What makes an image good. A hole in it may be as long as a shadow of something a few metres high.
    pub(crate) const fn quality(&self) -> Quality {
        Quality {
            nadir_deg: self.nadir_deg,
            signal_min_db: self.signal_min_db,
            hole_max_m: 15.0,
        }
    }

    fn check(&self) -> Result<(), ConfigError> {
        within(
            "lines_deg",
            self.lines_deg.unwrap_or(0.0),
            -360.0,
            360.0,
            "-360 to 360 degrees",
        )?;
        within("range_m", self.range_m, 5.0, 1000.0, "5 to 1000 m")?;
        within("first_altitude_m", self.first_altitude_m, 1.0, 500.0, "1 to 500 m")?;
        match (self.depth_m, self.altitude_m) {
            (Some(depth_m), None) => within("depth_m", depth_m, 0.0, 6000.0, "0 to 6000 m")?,
            (None, Some(altitude_m)) => within("altitude_m", altitude_m, 1.0, 500.0, "1 to 500 m")?,
            (Some(_), Some(_)) | (None, None) => return Err(ConfigError::Vertical),
        }
        within("speed_mps", self.speed_mps, 0.3, 3.0, "0.3 to 3 m/s")?;
        within("overlap_m", self.overlap_m, 0.0, 100.0, "0 to 100 m")?;
        within("times", f64::from(self.times), 1.0, 3.0, "1 to 3")?;
        within("nadir_deg", self.nadir_deg, 0.0, 70.0, "0 to 70 degrees")?;
        within("signal_min_db", self.signal_min_db, -10.0, 40.0, "-10 to 40 dB")?;
        within("worst_but", self.worst_but, 0.0, 0.5, "0 to 0.5")?;
        within("cell_m", self.cell_m, 1.0, 50.0, "1 to 50 m")?;
        within(
            "turn_max_dps",
            self.turn_max_dps,
            0.1,
            20.0,
            "0.1 to 20 degrees a second",
        )?;
        within("run_in_m", self.run_in_m, 0.0, 200.0, "0 to 200 m")?;
        within(
            "fill_worth_m2_per_m",
            self.fill_worth_m2_per_m,
            0.1,
            1000.0,
            "0.1 to 1000 m2 a metre",
        )?;
        within("fill_lines_max", f64::from(self.fill_lines_max), 0.0, 200.0, "0 to 200")?;
        within("enough", self.enough, 0.1, 1.0, "0.1 to 1")?;
        within("way_max_m", self.way_max_m, 100.0, 500_000.0, "100 to 500000 m")?;
        if let Some(range) = self.range {
            within("range.per_altitude", range.per_altitude, 1.0, 50.0, "1 to 50")?;
            within("range.min_m", range.min_m, 5.0, 1000.0, "5 to 1000 m")?;
            within("range.max_m", range.max_m, range.min_m, 1000.0, "range.min_m to 1000 m")?;
        }
        if let Some(noise) = self.noise {
            within("noise.pings", f64::from(noise.pings), 1.0, 500.0, "1 to 500")?;
            within(
                "noise.power_percent",
                noise.power_percent,
                0.01,
                100.0,
                "above 0 and at most 100 percent",
            )?;
        }
        Ok(())
    }
}

impl AreaConfig {
    /// The frame, the area in it, and the direction of a rectangle's longer side.
    fn area(&self) -> Result<(LocalFrame, Area, Option<f64>), ConfigError> {
        const SIDE: &str = "50 to 20000 m";
        match (&self.polygon, self.centre) {
            (Some(polygon), None)
                if self.length_m.is_none() && self.width_m.is_none() && self.bearing_deg.is_none() =>
            {
                let corners = polygon.iter().map(|corner| position("area.polygon", *corner));
                let corners = corners.collect::<Result<Vec<Position>, ConfigError>>()?;
                let first = *corners.first().ok_or(ConfigError::Area)?;
                // The centre is the mean of the corners, in a frame around the first one.
                let around = LocalFrame::new(first);
                let sum = corners
                    .iter()
                    .map(|corner| around.to_local(*corner))
                    .fold(EastNorth::default(), |sum, at| sum + at);
                let frame = LocalFrame::new(around.to_position(sum * (1.0 / corners.len() as f64)));
                let ring = corners.iter().map(|corner| frame.to_local(*corner)).collect();
                Ok((frame, Area::polygon(ring)?, None))
            }
            (None, Some(centre)) => {
                let (Some(length_m), Some(width_m)) = (self.length_m, self.width_m) else {
                    return Err(ConfigError::Area);
                };
                let bearing_deg = self.bearing_deg.unwrap_or(0.0);
                within("area.length_m", length_m, 50.0, 20_000.0, SIDE)?;
                within("area.width_m", width_m, 50.0, 20_000.0, SIDE)?;
                within("area.bearing_deg", bearing_deg, -360.0, 360.0, "-360 to 360 degrees")?;
                let frame = LocalFrame::new(position("area.centre", centre)?);
                let area = Area::rectangle(EastNorth::default(), bearing_deg, length_m, width_m)?;
                let longer_deg = if length_m >= width_m {
                    bearing_deg
                } else {
                    wrap_180(bearing_deg + 90.0)
                };
                Ok((frame, area, Some(longer_deg)))
            }
            (Some(_), Some(_)) | (Some(_), None) | (None, None) => Err(ConfigError::Area),
        }
    }
}

fn within(key: &'static str, value: f64, least: f64, most: f64, expected: &'static str) -> Result<(), ConfigError> {
    if (least..=most).contains(&value) {
        Ok(())
    } else {
        Err(ConfigError::Range { key, value, expected })
    }
}

fn position(key: &'static str, [latitude, longitude]: [f64; 2]) -> Result<Position, ConfigError> {
    within(
        key,
        latitude,
        -85.0,
        85.0,
        "a latitude of -85 to 85 degrees, then a longitude",
    )?;
    Position::from_deg(latitude, longitude).map_err(|error| ConfigError::Range {
        key,
        value: error.value,
        expected: "a latitude, then a longitude of -180 to 180 degrees",
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const SMALL: &str = r#"{"area": {"centre": [42.0, -70.0], "length_m": 500, "width_m": 800}, "sensor": 2,
        "range_m": 100, "first_altitude_m": 20, "depth_m": 15, "speed_mps": 1.5}"#;

    fn ground(from: &str, to: &str) -> Result<Ground, String> {
        assert!(SMALL.contains(from));
        let config: Config = serde_json::from_str(&SMALL.replace(from, to)).map_err(|error| error.to_string())?;
        config.ground().map_err(|error| error.to_string())
    }

    #[test]
    fn an_area_is_a_rectangle_or_a_polygon() {
        let ground = ground("70.0", "70.0").unwrap();
        assert_eq!(ground.lines_deg, 90.0, "along the longer side");
        assert!((ground.map.size_m2() - 400_000.0).abs() < 1e-6);
        let rectangle = r#"{"centre": [42.0, -70.0], "length_m": 500, "width_m": 800}"#;
        let polygon = r#"{"polygon": [[42.0, -70.0], [42.0045, -70.0], [42.0, -69.9940]]}, "lines_deg": 30"#;
        let ground = self::ground(rectangle, polygon).unwrap();
        // Half of 500 m by 497 m.
        assert!(
            (ground.map.size_m2() - 124_200.0).abs() < 2000.0,
            "{}",
            ground.map.size_m2()
        );
        let no_lines = r#"{"polygon": [[42.0, -70.0], [42.0045, -70.0], [42.0, -69.9940]]}"#;
        assert_eq!(
            self::ground(rectangle, no_lines).unwrap_err(),
            "lines_deg is missing: a polygon needs it"
        );
        let both = r#"{"centre": [42.0, -70.0], "polygon": []}"#;
        assert_eq!(
            self::ground(rectangle, both).unwrap_err(),
            "area: expected polygon, or centre, length_m and width_m"
        );
    }

    #[test]
    fn an_invalid_value_is_refused_with_its_key_and_range() {
        let refused = |from, to| ground(from, to).unwrap_err();
        assert_eq!(refused("1.5", "5"), "speed_mps is 5: expected 0.3 to 3 m/s");
        assert_eq!(
            refused("\"depth_m\": 15", "\"cell_m\": 5"),
            "expected depth_m or altitude_m, and not both"
        );
        assert_eq!(refused("500", "5"), "area.length_m is 5: expected 50 to 20000 m");
        assert!(refused("42.0", "142.0").starts_with("area.centre is 142: expected a latitude"));
        assert!(refused("sensor", "senser").contains("unknown field `senser`"));
        assert!(refused("\"length_m\": 500", "\"length_m\": 20000, \"bearing_deg\": 3").contains("at most 262144"));
        let range = r#""range_m": 100, "range": {"per_altitude": 5, "min_m": 50, "max_m": 40}"#;
        assert_eq!(
            refused("\"range_m\": 100", range),
            "range.max_m is 40: expected range.min_m to 1000 m"
        );
    }
}
