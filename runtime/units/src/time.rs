use std::borrow::Cow;

use core::fmt;
use core::ops::{Add, Sub};
use core::str::FromStr;
use core::time::Duration;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

const NANOS_PER_SECOND: u64 = 1_000_000_000;
const SECONDS_PER_DAY: u64 = 86_400;
const NANOS_PER_DAY: u64 = SECONDS_PER_DAY * NANOS_PER_SECOND;

/// Nanoseconds since the start of the run. The deterministic crates read no clock: their callers pass this time in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
pub struct Timestamp(u64);

impl Timestamp {
    /// The start of the run.
    pub const ZERO: Self = Self(0);
    /// Later than every other time. It means never.
    pub const MAX: Self = Self(u64::MAX);

    /// From nanoseconds since the start.
    #[must_use]
    pub const fn from_nanos(nanos: u64) -> Self {
        Self(nanos)
    }

    /// From whole milliseconds since the start.
    #[must_use]
    pub const fn from_millis(millis: u64) -> Self {
        Self(millis * 1_000_000)
    }

    /// From whole seconds since the start.
    #[must_use]
    pub const fn from_secs(seconds: u64) -> Self {
        Self(seconds * NANOS_PER_SECOND)
    }

    /// Nanoseconds since the start.
    #[must_use]
    pub const fn as_nanos(self) -> u64 {
        self.0
    }

    /// Seconds since the start.
    #[must_use]
    pub fn as_secs_f64(self) -> f64 {
        self.0 as f64 / 1e9
    }

    /// How long after `earlier` this is; zero if it is before `earlier`.
    #[must_use]
    pub const fn since(self, earlier: Self) -> Duration {
        Duration::from_nanos(self.0.saturating_sub(earlier.0))
    }
}

impl Add<Duration> for Timestamp {
    type Output = Self;
    /// Saturates at [`Timestamp::MAX`], which means never.
    fn add(self, later: Duration) -> Self {
        let nanos = u64::try_from(later.as_nanos()).unwrap_or(u64::MAX);
        Self(self.0.saturating_add(nanos))
    }
}

impl Sub<Duration> for Timestamp {
    type Output = Self;
    /// Saturates at [`Timestamp::ZERO`].
    fn sub(self, earlier: Duration) -> Self {
        let nanos = u64::try_from(earlier.as_nanos()).unwrap_or(u64::MAX);
        Self(self.0.saturating_sub(nanos))
    }
}

impl fmt::Display for Timestamp {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:.3} s", self.as_secs_f64())
    }
}

/// An instant in UTC: nanoseconds since 1970-01-01T00:00:00 without leap seconds, as in POSIX.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct Utc(u64);

impl Utc {
    /// From nanoseconds since 1970.
    #[must_use]
    pub const fn from_unix_nanos(nanos: u64) -> Self {
        Self(nanos)
    }

    /// Nanoseconds since 1970.
    #[must_use]
    pub const fn as_unix_nanos(self) -> u64 {
        self.0
    }

    /// The time within its day.
    #[must_use]
    pub const fn time_of_day(self) -> TimeOfDay {
        TimeOfDay(self.0 % NANOS_PER_DAY)
    }
}

impl Add<Duration> for Utc {
    type Output = Self;
    fn add(self, later: Duration) -> Self {
        let nanos = u64::try_from(later.as_nanos()).unwrap_or(u64::MAX);
        Self(self.0.saturating_add(nanos))
    }
}

/// A UTC time without a date, like SPI's timestamps (section 4.2, Table 1): nanoseconds since midnight.
///
/// The leap second 23:59:60 is legal and is the last second of its day.
///
/// `Display` writes it as `08:10:25.987`. It is serialised in the same way, but with nine decimals if it is not a whole
/// number of milliseconds. It is parsed with up to nine decimals.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct TimeOfDay(u64);

/// The text is not a time of day.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected a time of day: hh:mm:ss and at most nine decimals")]
pub struct TimeOfDayError;

impl TimeOfDay {
    /// Midnight.
    pub const MIDNIGHT: Self = Self(0);

    /// From nanoseconds since midnight; `None` past the end of a leap second.
    #[must_use]
    pub const fn from_nanos(nanos: u64) -> Option<Self> {
        if nanos < NANOS_PER_DAY + NANOS_PER_SECOND {
            Some(Self(nanos))
        } else {
            None
        }
    }

    /// From hours, minutes, seconds and nanoseconds; `None` if that is not a time of day. Second 60 is allowed in
    /// 23:59:60 only.
    #[must_use]
    pub const fn from_hms_nano(hour: u32, minute: u32, second: u32, nanos: u32) -> Option<Self> {
        let leap = hour == 23 && minute == 59 && second == 60;
        if hour > 23 || minute > 59 || (second > 59 && !leap) || nanos >= 1_000_000_000 {
            return None;
        }
        let seconds = hour as u64 * 3600 + minute as u64 * 60 + second as u64;
        Some(Self(seconds * NANOS_PER_SECOND + nanos as u64))
    }

    /// Nanoseconds since midnight, below 86 401 s.
    #[must_use]
    pub const fn as_nanos(self) -> u64 {
        self.0
    }

    /// Hour, minute, second (60 in a leap second) and nanoseconds.
    #[must_use]
    pub const fn hms_nano(self) -> (u32, u32, u32, u32) {
        let seconds = self.0 / NANOS_PER_SECOND;
        let nanos = (self.0 % NANOS_PER_SECOND) as u32;
        if seconds >= SECONDS_PER_DAY {
            return (23, 59, 60, nanos);
        }
        (
            (seconds / 3600) as u32,
            (seconds / 60 % 60) as u32,
            (seconds % 60) as u32,
            nanos,
        )
    }

    /// The same time, truncated to whole milliseconds. Rounding up could reach the next day.
    #[must_use]
    pub const fn truncated_to_millis(self) -> Self {
        Self(self.0 - self.0 % 1_000_000)
    }

    /// Nanoseconds from `earlier` to this, counted the shorter way round the clock: within ±12 h.
    #[must_use]
    pub const fn nanos_since(self, earlier: Self) -> i64 {
        let day = NANOS_PER_DAY as i64;
        let difference = (self.0 as i64 - earlier.0 as i64) % day;
        if difference >= day / 2 {
            difference - day
        } else if difference < -day / 2 {
            difference + day
        } else {
            difference
        }
    }
}

impl Add<Duration> for TimeOfDay {
    type Output = Self;
    /// Wraps at midnight.
    fn add(self, later: Duration) -> Self {
        let nanos = (self.0 as u128 + later.as_nanos()) % NANOS_PER_DAY as u128;
        Self(nanos as u64)
    }
}

impl fmt::Display for TimeOfDay {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (hour, minute, second, nanos) = self.hms_nano();
        write!(f, "{hour:02}:{minute:02}:{second:02}.{:03}", nanos / 1_000_000)
    }
}

impl FromStr for TimeOfDay {
    type Err = TimeOfDayError;

    fn from_str(text: &str) -> Result<Self, TimeOfDayError> {
        let (clock, decimals) = match text.split_once('.') {
            Some((clock, decimals)) if (1..=9).contains(&decimals.len()) => (clock, decimals),
            Some(_) => return Err(TimeOfDayError),
            None => (text, ""),
        };
        let digits = |text: &str| {
            text.bytes()
                .try_fold(0, |value, byte| {
                    byte.is_ascii_digit().then(|| value * 10 + u32::from(byte - b'0'))
                })
                .ok_or(TimeOfDayError)
        };
        let pair = |text: Option<&str>| match text {
            Some(text) if text.len() == 2 => digits(text),
            Some(_) | None => Err(TimeOfDayError),
        };
        let mut parts = clock.split(':');
        let (hour, minute, second) = (pair(parts.next())?, pair(parts.next())?, pair(parts.next())?);
        let nanos = (decimals.len()..9).try_fold(digits(decimals)?, |nanos, _| nanos.checked_mul(10));
        match (parts.next(), nanos) {
            (None, Some(nanos)) => Self::from_hms_nano(hour, minute, second, nanos).ok_or(TimeOfDayError),
            (Some(_), _) | (_, None) => Err(TimeOfDayError),
        }
    }
}

impl Serialize for TimeOfDay {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let (hour, minute, second, nanos) = self.hms_nano();
        if nanos % 1_000_000 == 0 {
            serializer.collect_str(self)
        } else {
            serializer.collect_str(&format_args!("{hour:02}:{minute:02}:{second:02}.{nanos:09}"))
        }
    }
}

impl<'de> Deserialize<'de> for TimeOfDay {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = <Cow<'de, str>>::deserialize(deserializer)?;
        text.parse().map_err(serde::de::Error::custom)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(hour: u32, minute: u32, second: u32) -> TimeOfDay {
        TimeOfDay::from_hms_nano(hour, minute, second, 0).unwrap()
    }

    #[test]
    fn differences_across_midnight_take_the_short_way() {
        assert_eq!(at(0, 0, 1).nanos_since(at(23, 59, 59)), 2_000_000_000);
        assert_eq!(at(23, 59, 59).nanos_since(at(0, 0, 1)), -2_000_000_000);
        assert_eq!(at(12, 0, 1).nanos_since(at(12, 0, 0)), 1_000_000_000);
    }

    #[test]
    fn the_leap_second_is_legal_only_at_the_end_of_a_day() {
        let leap = at(23, 59, 60);
        assert_eq!(leap.hms_nano(), (23, 59, 60, 0));
        assert_eq!(leap.nanos_since(at(23, 59, 59)), 1_000_000_000);
        assert_eq!(TimeOfDay::from_hms_nano(12, 0, 60, 0), None);
        assert_eq!(TimeOfDay::from_hms_nano(24, 0, 0, 0), None);
    }

    #[test]
    fn time_of_day_follows_utc_over_midnight() {
        let utc = Utc::from_unix_nanos(86_399_500_000_000);
        assert_eq!(utc.time_of_day().to_string(), "23:59:59.500");
        assert_eq!((utc + Duration::from_secs(1)).time_of_day().to_string(), "00:00:00.500");
    }

    #[test]
    fn times_of_day_are_serialised_and_parsed_without_loss() {
        let time = |text: &str| text.parse::<TimeOfDay>();
        for (value, text) in [
            (at(8, 10, 25), "08:10:25.000"),
            (at(23, 59, 60), "23:59:60.000"),
            (TimeOfDay::from_nanos(86_400_987_654_321).unwrap(), "23:59:60.987654321"),
            (TimeOfDay::from_nanos(5_000_000).unwrap(), "00:00:00.005"),
        ] {
            assert_eq!(serde_json::to_string(&value).unwrap(), format!("\"{text}\""));
            assert_eq!(
                serde_json::from_str::<TimeOfDay>(&format!("\"{text}\"")).unwrap(),
                value
            );
        }
        assert_eq!(time("08:10:25"), Ok(at(8, 10, 25)));
        assert_eq!(
            time("08:10:25.5").unwrap().as_nanos(),
            at(8, 10, 25).as_nanos() + 500_000_000
        );
        for bad in [
            "",
            "8:10:25",
            "08:10",
            "08:10:25:01",
            "08:10:25.",
            "08:10:25.0000000001",
            "24:00:00",
            "08:60:00",
            "08:10:60",
            "0é:10:25",
            "+8:10:25",
        ] {
            assert_eq!(time(bad), Err(TimeOfDayError), "{bad}");
        }
    }

    #[test]
    fn timestamps_saturate() {
        assert_eq!(Timestamp::ZERO - Duration::from_secs(1), Timestamp::ZERO);
        assert_eq!(Timestamp::MAX + Duration::from_secs(1), Timestamp::MAX);
        assert_eq!(Timestamp::from_secs(1).since(Timestamp::from_secs(2)), Duration::ZERO);
    }
}
