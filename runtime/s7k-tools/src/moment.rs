//! Instants as people write and read them: ISO 8601, with the day as month and day or as day of the year.

use core::fmt;
use core::str::FromStr;
use core::time::Duration;

use backseat_s7k::Time7k;
use backseat_units::Utc;
use serde::{Serialize, Serializer};

/// An instant in UTC. `Display` writes it as `2026-11-23T14:05:07.250Z`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Moment(pub Utc);

/// The text is no instant.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected a time in UTC, such as 2026-11-23T14:05:07.25Z, or with the day of the year, 2026-327T14:05:07.25")]
pub struct MomentError;

/// A date and the time in it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Calendar {
    pub(crate) year: u16,
    pub(crate) month: u8,
    pub(crate) day: u8,
    pub(crate) day_of_year: u16,
    pub(crate) hour: u8,
    pub(crate) minute: u8,
    pub(crate) second: u8,
    pub(crate) nanos: u32,
}

const NANOS_PER_SECOND: u64 = 1_000_000_000;

const fn month_lengths(year: u16) -> [u16; 12] {
    let leap = year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400));
    [31, if leap { 29 } else { 28 }, 31, 30, 31, 30, 31, 31, 30, 31, 30, 31]
}

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

    pub(crate) fn calendar(self) -> Calendar {
        // Whole seconds survive 7k time exactly.
        let seconds = self.nanos() / NANOS_PER_SECOND;
        let minutes = Time7k::from_utc(Utc::from_unix_nanos(seconds / 60 * 60 * NANOS_PER_SECOND));
        let mut day = minutes.day;
        let mut month = 0;
        for length in month_lengths(minutes.year) {
            if day <= length {
                break;
            }
            day -= length;
            month += 1;
        }
        Calendar {
            year: minutes.year,
            month: month + 1,
            day: u8::try_from(day).unwrap_or(31),
            day_of_year: minutes.day,
            hour: minutes.hours,
            minute: minutes.minutes,
            second: u8::try_from(seconds % 60).unwrap_or(59),
            nanos: u32::try_from(self.nanos() % NANOS_PER_SECOND).unwrap_or(0),
        }
    }
}

impl fmt::Display for Moment {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Calendar {
            year,
            month,
            day,
            hour,
            minute,
            second,
            nanos,
            ..
        } = self.calendar();
        let millis = nanos / 1_000_000;
        write!(
            f,
            "{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}.{millis:03}Z"
        )
    }
}

impl Serialize for Moment {
    /// With six decimals: a 7k time resolves 4 microseconds at best.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let Calendar {
            year,
            month,
            day,
            hour,
            minute,
            second,
            nanos,
            ..
        } = self.calendar();
        let micros = nanos / 1000;
        serializer.collect_str(&format_args!(
            "{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}.{micros:06}Z"
        ))
    }
}

impl FromStr for Moment {
    type Err = MomentError;

    fn from_str(text: &str) -> Result<Self, MomentError> {
        let text = text.strip_suffix('Z').unwrap_or(text);
        let (date, clock) = text.split_once(['T', ' ']).ok_or(MomentError)?;
        let digits = |text: &str, length: usize| -> Option<u16> {
            let whole = text.len() == length && text.bytes().all(|byte| byte.is_ascii_digit());
            whole.then(|| text.parse().ok()).flatten()
        };
        let parse = || -> Option<Self> {
            let mut parts = date.split('-');
            let year = digits(parts.next()?, 4)?;
            let day = match (parts.next()?, parts.next()) {
                (day, None) => digits(day, 3)?,
                (month, Some(day)) => {
                    let (month, day) = (usize::from(digits(month, 2)?), digits(day, 2)?);
                    let lengths = month_lengths(year);
                    let length = *lengths.get(month.checked_sub(1)?)?;
                    (1..=length).contains(&day).then_some(())?;
                    lengths[..month - 1].iter().sum::<u16>() + day
                }
            };
            let mut parts = clock.split(':');
            let (hours, minutes) = (digits(parts.next()?, 2)?, digits(parts.next()?, 2)?);
            let (seconds, decimals) = parts
                .next()
                .map_or(("00", ""), |text| text.split_once('.').unwrap_or((text, "")));
            let seconds = digits(seconds, 2).filter(|seconds| *seconds < 60)?;
            let decimals_fit = decimals.len() <= 9 && decimals.bytes().all(|byte| byte.is_ascii_digit());
            (decimals_fit && parts.next().is_none()).then_some(())?;
            let nanos: u64 = format!("{decimals:0<9}").parse().ok()?;
            let minute = Time7k {
                year,
                day,
                seconds: 0.0,
                hours: u8::try_from(hours).ok()?,
                minutes: u8::try_from(minutes).ok()?,
            };
            let since = Duration::from_nanos(u64::from(seconds) * NANOS_PER_SECOND + nanos);
            Some(Self(minute.to_utc()? + since))
        };
        parse().ok_or(MomentError)
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
