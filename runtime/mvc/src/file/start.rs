use backseat_units::Utc;
use serde::de::Error;
use serde::{Deserialize, Deserializer};
use toml::value::{Datetime, Offset};

use crate::error::{MvcError, check};

/// The `[start]` section: when the run starts, and where the vehicle is then. The vehicle is held there until its
/// mission starts.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StartConfig {
    /// UTC at the start of the run, a TOML date-time with an offset: `2026-06-01T08:00:00Z`.
    #[serde(deserialize_with = "utc")]
    pub utc: Utc,
    /// How far the vehicle's own clock is ahead of that, seconds, within a day. Its sentences carry its own clock.
    #[serde(default)]
    pub clock_ahead_s: f64,
    /// Where the vehicle is, metres east of the origin.
    #[serde(default)]
    pub east_m: f64,
    /// Where the vehicle is, metres north of the origin.
    #[serde(default)]
    pub north_m: f64,
    /// How deep the vehicle is, metres, 0 to 6000.
    #[serde(default)]
    pub depth_m: f64,
    /// Where the vehicle points to, degrees from true north.
    #[serde(default)]
    pub heading_deg: f64,
}

impl StartConfig {
    pub(crate) fn validate(&self) -> Result<(), MvcError> {
        check(
            self.clock_ahead_s.abs() <= 86_400.0,
            "start.clock_ahead_s",
            self.clock_ahead_s,
            "within 86400 s",
        )?;
        check(
            self.east_m.abs() <= 50_000.0,
            "start.east_m",
            self.east_m,
            "within 50 km of the origin",
        )?;
        check(
            self.north_m.abs() <= 50_000.0,
            "start.north_m",
            self.north_m,
            "within 50 km of the origin",
        )?;
        check(
            (0.0..=6000.0).contains(&self.depth_m),
            "start.depth_m",
            self.depth_m,
            "0 to 6000 m",
        )?;
        check(
            self.heading_deg.abs() <= 360.0,
            "start.heading_deg",
            self.heading_deg,
            "within 360 degrees",
        )
    }
}

fn utc<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Utc, D::Error> {
    let moment = Datetime::deserialize(deserializer)?;
    let expected = "expected a date and time since 1970 with its offset, such as 2026-06-01T08:00:00Z";
    let (Some(date), Some(time), Some(offset)) = (moment.date, moment.time, moment.offset) else {
        return Err(D::Error::custom(expected));
    };
    let offset_min = match offset {
        Offset::Z => 0,
        Offset::Custom { minutes } => i64::from(minutes),
    };
    let seconds = days_since_1970(i64::from(date.year), i64::from(date.month), i64::from(date.day)) * 86_400
        + i64::from(time.hour) * 3600
        + i64::from(time.minute) * 60
        + i64::from(time.second.unwrap_or(0))
        - offset_min * 60;
    // Before 2200, even the end of a run that lasts for centuries fits into 64 bits of nanoseconds.
    match u64::try_from(seconds) {
        Ok(seconds) if date.year < 2200 => Ok(Utc::from_unix_nanos(
            seconds * 1_000_000_000 + u64::from(time.nanosecond.unwrap_or(0)),
        )),
        Ok(_) | Err(_) => Err(D::Error::custom(expected)),
    }
}

/// Days from 1970-01-01 to a date of the Gregorian calendar (Hinnant, "chrono-compatible low-level date algorithms").
fn days_since_1970(year: i64, month: i64, day: i64) -> i64 {
    let year = if month <= 2 { year - 1 } else { year };
    let era = year.div_euclid(400);
    let year_of_era = year - era * 400;
    let month_from_march = (month + 9) % 12;
    let day_of_year = (153 * month_from_march + 2) / 5 + day - 1;
    let day_of_era = year_of_era * 365 + year_of_era / 4 - year_of_era / 100 + day_of_year;
    era * 146_097 + day_of_era - 719_468
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dates_count_from_1970() {
        assert_eq!(days_since_1970(1970, 1, 1), 0);
        assert_eq!(days_since_1970(2000, 2, 29), 11_016);
        assert_eq!(days_since_1970(2026, 6, 1), 20_605);
    }

    #[test]
    fn an_offset_is_subtracted() {
        let at = |text: &str| toml::from_str::<StartConfig>(text).map(|start| start.utc.as_unix_nanos());
        assert_eq!(at("utc = 1970-01-01T02:00:01.5+02:00").unwrap(), 1_500_000_000);
        for bad in [
            "utc = 1970-01-01T00:00:00+02:00",
            "utc = 2026-06-01",
            "utc = 9999-01-01T00:00:00Z",
            "utc = 3",
        ] {
            assert!(at(bad).is_err(), "{bad}");
        }
    }
}
