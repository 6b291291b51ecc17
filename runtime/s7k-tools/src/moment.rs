//! Instants as people write and read them: ISO 8601, with the day as month and day or as day of the year.

use core::fmt;
use core::str::FromStr;

use backseat_s7k::Time7k;
use backseat_units::Utc;
use chrono::{DateTime, NaiveDate, NaiveDateTime, NaiveTime, Timelike};
use serde::{Serialize, Serializer};

/// An instant in UTC. `Display` writes it as `2026-11-23T14:05:07.250Z`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Moment(pub Utc);

/// The text is no instant.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected a time in UTC, such as 2026-11-23T14:05:07.25Z, or with the day of the year, 2026-327T14:05:07.25")]
pub struct MomentError;

const NANOS_PER_SECOND: u64 = 1_000_000_000;

impl Moment {
    /// The instant of a 7k time; `None` if the header has none.
    #[must_use]
    pub fn of(time: &Time7k) -> Option<Self> {
        time.to_utc().map(Self)
    }

    pub(crate) const fn nanos(self) -> u64 {
        self.0.as_unix_nanos()
    }

    /// Seconds from `earlier` to this; negative if it is before.
    #[expect(
        clippy::cast_precision_loss,
        reason = "a recording spans days: differences are exact to 100 ns"
    )]
    pub(crate) fn seconds_since(self, earlier: Self) -> f64 {
        let (now, then) = (self.nanos(), earlier.nanos());
        if now >= then {
            (now - then) as f64 / 1e9
        } else {
            -((then - now) as f64 / 1e9)
        }
    }

    /// The date and the time in it.
    pub(crate) fn calendar(self) -> NaiveDateTime {
        let seconds = i64::try_from(self.nanos() / NANOS_PER_SECOND).unwrap_or_default();
        let nanos = u32::try_from(self.nanos() % NANOS_PER_SECOND).unwrap_or_default();
        DateTime::from_timestamp(seconds, nanos).unwrap_or_default().naive_utc()
    }
}

impl fmt::Display for Moment {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.calendar().format("%Y-%m-%dT%H:%M:%S%.3fZ"))
    }
}

impl Serialize for Moment {
    /// With six decimals: a 7k time resolves 4 microseconds at best.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(&self.calendar().format("%Y-%m-%dT%H:%M:%S%.6fZ"))
    }
}

impl FromStr for Moment {
    type Err = MomentError;

    fn from_str(text: &str) -> Result<Self, MomentError> {
        let text = text.strip_suffix('Z').unwrap_or(text);
        let (date, clock) = text.split_once(['T', ' ']).ok_or(MomentError)?;
        // chrono also takes numbers of fewer digits, and signs.
        let shape = |text: &str| -> String { text.chars().map(|c| if c.is_ascii_digit() { '0' } else { c }).collect() };
        let day = match shape(date).as_str() {
            "0000-00-00" => NaiveDate::parse_from_str(date, "%Y-%m-%d"),
            "0000-000" => NaiveDate::parse_from_str(date, "%Y-%j"),
            _ => return Err(MomentError),
        };
        let (whole, decimals) = clock.split_once('.').unwrap_or((clock, "0"));
        let time = match shape(whole).as_str() {
            "00:00" if !clock.contains('.') => NaiveTime::parse_from_str(whole, "%H:%M"),
            "00:00:00" => NaiveTime::parse_from_str(whole, "%H:%M:%S"),
            _ => return Err(MomentError),
        };
        let (day, time) = day.ok().zip(time.ok()).ok_or(MomentError)?;
        let decimals_fit = decimals.len() <= 9 && decimals.bytes().all(|byte| byte.is_ascii_digit());
        // A second 60 is read as a nanosecond of the one before.
        let plain = time.nanosecond() < 1_000_000_000;
        let seconds = u64::try_from(day.and_time(time).and_utc().timestamp());
        let nanos: Result<u64, _> = format!("{decimals:0<9}").parse();
        match (seconds, nanos) {
            (Ok(seconds), Ok(nanos)) if plain && decimals_fit => {
                Ok(Self(Utc::from_unix_nanos(seconds * NANOS_PER_SECOND + nanos)))
            }
            _ => Err(MomentError),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_forms_of_a_date_are_read_and_one_is_written() {
        for (text, shown) in [
            ("2026-11-23T14:05:07.25Z", "2026-11-23T14:05:07.250Z"),
            ("2026-327T14:05:07.25", "2026-11-23T14:05:07.250Z"),
            ("2024-02-29 00:00", "2024-02-29T00:00:00.000Z"),
            ("2024-366T23:59:59.999999999Z", "2024-12-31T23:59:59.999Z"),
            ("1970-01-01T00:00:00", "1970-01-01T00:00:00.000Z"),
        ] {
            assert_eq!(text.parse::<Moment>().unwrap().to_string(), shown);
        }
        let json = serde_json::to_string(&"2026-327T14:05:07.123456".parse::<Moment>().unwrap()).unwrap();
        assert_eq!(json, "\"2026-11-23T14:05:07.123456Z\"");
    }

    #[test]
    fn what_is_no_time_is_refused() {
        for text in [
            "",
            "now",
            "14:05:07",
            "2026-11-23",
            "2025-02-29T00:00",
            "2026-13-01T00:00",
            "2026-00-01T00:00",
            "2026-000T00:00",
            "2026-366T00:00",
            "2026-11-23T24:00",
            "2026-11-23T14:60",
            "2026-11-23T14:05:60",
            "2026-11-23T14:05:07.1234567891",
            "2026-11-23T14:05:07.x",
            "2026-11-23T14:05:07:1",
            "26-11-23T14:05",
            "2026-11-23T+4:05",
            "1969-01-01T00:00",
        ] {
            assert_eq!(text.parse::<Moment>(), Err(MomentError), "{text}");
        }
    }
}
