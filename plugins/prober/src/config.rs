use serde::Deserialize;

/// The plugin's settings, from the mission file.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Config {
    /// The seed of all random numbers.
    pub seed: u64,
    /// The vehicle hovers, so station keeping and devices are requested too.
    #[serde(default)]
    pub hovering: bool,
    /// The west edge of a box that contains the fence and some space outside, metres in the mission's local frame.
    pub east_min_m: f64,
    /// Its east edge, metres.
    pub east_max_m: f64,
    /// Its south edge, metres.
    pub north_min_m: f64,
    /// Its north edge, metres.
    pub north_max_m: f64,
    /// The least and the greatest modest depth, metres below the surface.
    pub depth_m: [f64; 2],
    /// The least and the greatest modest altitude, metres above the seabed; if missing, no altitude is requested.
    #[serde(default)]
    pub altitude_m: Option<[f64; 2]>,
    /// The least and the greatest modest speed, metres per second.
    pub speed_mps: [f64; 2],
    /// The kinds of requests to make; by default all that such a vehicle supports.
    #[serde(default)]
    pub kinds: Option<Vec<Kind>>,
    /// The fraction of requests that aim at an edge, beyond it, or come at a wrong time, 0 to 1.
    #[serde(default = "default::boldness")]
    pub boldness: f64,
    /// The approximate time from an accepted insert to the next request for one, seconds, 1 to 3600.
    #[serde(default = "default::insert_every_s")]
    pub insert_every_s: f64,
    /// The fraction of the time in which the plugin steers, 0 to 1.
    #[serde(default = "default::modify_share")]
    pub modify_share: f64,
}

/// A kind of request.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// Leases by modify, and their end.
    Modify,
    /// Tracklines.
    Trackline,
    /// Trackcircles.
    Trackcircle,
    /// GPS hits.
    GpsHit,
    /// Cancels of its own inserts, and of inserts that do not exist.
    Cancel,
    /// Lines in the vehicle's log.
    Message,
    /// Messages to the topside.
    Topside,
    /// The DVL's triggering.
    Dvl,
    /// Silent mode.
    Silent,
    /// Trim.
    Trim,
    /// Buoyancy.
    Buoyancy,
    /// Acoustic packets.
    Packet,
    /// Station keeping and moves of a hovering vehicle, and their end.
    Station,
    /// Sonar angle, camera and light of a hovering vehicle.
    Devices,
}

mod default {
    pub(super) const fn boldness() -> f64 {
        0.5
    }
    pub(super) const fn insert_every_s() -> f64 {
        60.0
    }
    pub(super) const fn modify_share() -> f64 {
        0.5
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
        let shares = [("boldness", self.boldness), ("modify_share", self.modify_share)];
        for (key, value) in shares {
            check(key, value, (0.0..=1.0).contains(&value), "0 to 1")?;
        }
        let every_s = self.insert_every_s;
        let expected = "1 to 3600";
        check("insert_every_s", every_s, (1.0..=3600.0).contains(&every_s), expected)?;
        let ranges = [
            ("depth_m", self.depth_m),
            ("altitude_m", self.altitude_m.unwrap_or_default()),
            ("speed_mps", self.speed_mps),
        ];
        for (key, [min, max]) in ranges {
            check(key, min, (0.0..=6000.0).contains(&min), "0 to 6000")?;
            check(key, max, (min..=6000.0).contains(&max), "the least, then the greatest")?;
        }
        let sides = [
            ("east_max_m", self.east_min_m, self.east_max_m),
            ("north_max_m", self.north_min_m, self.north_max_m),
        ];
        for (key, min, max) in sides {
            let wide = min.abs() <= 50_000.0 && max.abs() <= 50_000.0 && max - min >= 50.0;
            check(key, max, wide, "at least 50 m beyond the other side, within 50 km")?;
        }
        Ok(())
    }

    /// Whether the plugin makes requests of this kind.
    #[must_use]
    pub fn asks_for(&self, kind: Kind) -> bool {
        match &self.kinds {
            Some(kinds) => kinds.contains(&kind),
            None => self.hovering || !matches!(kind, Kind::Station | Kind::Devices),
        }
    }
}

fn check(key: &'static str, value: f64, holds: bool, expected: &'static str) -> Result<(), ConfigError> {
    if holds {
        Ok(())
    } else {
        Err(ConfigError { key, value, expected })
    }
}
