//! When a zone is valid, and the times of a question.

use core::fmt;

use backseat_units::Utc;
use serde::{Deserialize, Serialize};

const NANOS_PER_SECOND: u64 = 1_000_000_000;
const SECONDS_PER_DAY: u64 = 86_400;

/// The times at which a zone is valid, both ends included. Without `from` or `until` it is unlimited on that side.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Window {
    /// The first time; `None` if there is no first.
    pub from: Option<Utc>,
    /// The last time; `None` if there is no last.
    pub until: Option<Utc>,
}

/// A span of time, both ends included.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Span {
    /// The earliest time.
    pub from: Utc,
    /// The latest time, not before `from`.
    pub until: Utc,
}

impl Window {
    /// Whether the zone is valid for the whole of a span. If the time is unknown, only a zone that is always valid is.
    #[must_use]
    pub fn covers(&self, span: Option<Span>) -> bool {
        match span {
            Some(span) => {
                self.from.is_none_or(|from| from <= span.from) && self.until.is_none_or(|until| until >= span.until)
            }
            None => self.from.is_none() && self.until.is_none(),
        }
    }

    /// Whether the zone is valid at any instant of a span. If the time is unknown, every zone may be.
    #[must_use]
    pub fn meets(&self, span: Option<Span>) -> bool {
        span.is_none_or(|span| {
            self.from.is_none_or(|from| from <= span.until) && self.until.is_none_or(|until| until >= span.from)
        })
    }
}

impl fmt::Display for Window {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match (self.from, self.until) {
            (Some(from), Some(until)) => write!(f, "from {} until {}", Rfc3339(from), Rfc3339(until)),
            (Some(from), None) => write!(f, "from {}", Rfc3339(from)),
            (None, Some(until)) => write!(f, "until {}", Rfc3339(until)),
            (None, None) => write!(f, "always"),
        }
    }
}

impl fmt::Display for Span {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} to {}", Rfc3339(self.from), Rfc3339(self.until))
    }
}

/// A time as RFC 3339 text, with decimals of a second if it has any.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rfc3339(pub Utc);

impl fmt::Display for Rfc3339 {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let seconds = self.0.as_unix_nanos() / NANOS_PER_SECOND;
        let (year, month, day) = date_of(seconds / SECONDS_PER_DAY);
        let second = seconds % SECONDS_PER_DAY;
        write!(
            f,
            "{year:04}-{month:02}-{day:02}T{:02}:{:02}:{:02}",
            second / 3600,
            second / 60 % 60,
            second % 60
        )?;
        match self.0.as_unix_nanos() % NANOS_PER_SECOND {
            0 => write!(f, "Z"),
            nanos => write!(f, ".{nanos:09}Z"),
        }
    }
}

/// Reads `2026-05-01T08:00:00Z`, with or without decimals of a second and with `Z` or a numeric offset (RFC 3339,
/// section 5.6). `None` for a text that is not such a time, a leap second, or a time before 1970 or after 2500.
#[must_use]
pub fn utc(text: &str) -> Option<Utc> {
    let bytes = text.as_bytes();
    let number = |from: usize, to: usize| -> Option<u64> {
        let digits = bytes.get(from..to)?;
        digits.iter().try_fold(0, |value, digit| {
            digit.is_ascii_digit().then(|| value * 10 + u64::from(digit - b'0'))
        })
    };
    let is = |at: usize, wanted: &[u8]| bytes.get(at).is_some_and(|byte| wanted.contains(byte));
    let (year, month, day) = (number(0, 4)?, number(5, 7)?, number(8, 10)?);
    let (hour, minute, second) = (number(11, 13)?, number(14, 16)?, number(17, 19)?);
    let marks = is(4, b"-") && is(7, b"-") && is(10, b"Tt ") && is(13, b":") && is(16, b":");
    let in_range = (1970..=2500).contains(&year) && hour < 24 && minute < 60 && second < 60;
    if !marks || !in_range || !(1..=12).contains(&month) || !(1..=days_in(year, month)).contains(&day) {
        return None;
    }
    let mut end = 19;
    let mut nanos = 0;
    if is(end, b".") {
        let decimals = bytes[end + 1..].iter().take_while(|byte| byte.is_ascii_digit()).count();
        if !(1..=9).contains(&decimals) {
            return None;
        }
        nanos = number(end + 1, end + 1 + decimals)? * 10_u64.pow(9 - decimals as u32);
        end += 1 + decimals;
    }
    let seconds = days_before(year, month, day) * SECONDS_PER_DAY + hour * 3600 + minute * 60 + second;
    let seconds = if is(end, b"Zz") {
        (bytes.len() == end + 1).then_some(seconds)?
    } else {
        let (hours, minutes) = (number(end + 1, end + 3)?, number(end + 4, end + 6)?);
        if !is(end, b"+-") || !is(end + 3, b":") || bytes.len() != end + 6 || hours >= 24 || minutes >= 60 {
            return None;
        }
        let offset = hours * 3600 + minutes * 60;
        if is(end, b"+") {
            seconds.checked_sub(offset)?
        } else {
            seconds + offset
        }
    };
    Some(Utc::from_unix_nanos(seconds * NANOS_PER_SECOND + nanos))
}

fn is_leap(year: u64) -> bool {
    year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400))
}

fn days_in(year: u64, month: u64) -> u64 {
    match month {
        2 if is_leap(year) => 29,
        2 => 28,
        4 | 6 | 9 | 11 => 30,
        _ => 31,
    }
}

/// Days from 1970-01-01 to a date.
fn days_before(year: u64, month: u64, day: u64) -> u64 {
    let leaps = |year: u64| year / 4 - year / 100 + year / 400;
    let years = (year - 1970) * 365 + leaps(year - 1) - leaps(1969);
    years + (1..month).map(|month| days_in(year, month)).sum::<u64>() + day - 1
}

/// The year, month and day this many days after 1970-01-01.
fn date_of(days: u64) -> (u64, u64, u64) {
    // This year is never too late, and at most one too early.
    let mut year = 1970 + days / 366;
    while days_before(year + 1, 1, 1) <= days {
        year += 1;
    }
    let mut left = days - days_before(year, 1, 1);
    let mut month = 1;
    while left >= days_in(year, month) {
        left -= days_in(year, month);
        month += 1;
    }
    (year, month, left + 1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seconds(text: &str) -> Option<u64> {
        utc(text).map(|utc| utc.as_unix_nanos() / NANOS_PER_SECOND)
    }

    #[test]
    fn times_are_read_as_rfc_3339_writes_them() {
        // The reference values are those of `date --utc --date=... +%s`.
        assert_eq!(seconds("1970-01-01T00:00:00Z"), Some(0));
        assert_eq!(seconds("2000-02-29T12:34:56Z"), Some(951_827_696));
        assert_eq!(seconds("2026-05-01T08:00:00Z"), Some(1_777_622_400));
        assert_eq!(seconds("2026-05-01T10:00:00+02:00"), Some(1_777_622_400));
        assert_eq!(seconds("2026-05-01t02:30:00-05:30"), Some(1_777_622_400));
        assert_eq!(seconds("2100-03-01T00:00:00Z"), Some(4_107_542_400));
        let decimals = utc("2026-05-01T08:00:00.25Z").unwrap();
        assert_eq!(decimals.as_unix_nanos(), 1_777_622_400_250_000_000);
        for wrong in [
            "",
            "2026-05-01",
            "2026-05-01T08:00:00",
            "2026-5-1T08:00:00Z",
            "2026-02-29T08:00:00Z",
            "2100-02-29T00:00:00Z",
            "2026-13-01T08:00:00Z",
            "2026-00-01T08:00:00Z",
            "2026-05-01T24:00:00Z",
            "2026-05-01T08:60:00Z",
            "2026-12-31T23:59:60Z",
            "2026-05-01T08:00:00.Z",
            "2026-05-01T08:00:00.1234567890Z",
            "2026-05-01T08:00:00+0200",
            "2026-05-01T08:00:00Z ",
            "1969-12-31T23:59:59Z",
            "1970-01-01T00:00:00+01:00",
            "9999-05-01T08:00:00Z",
            "2026-05-01T08:00:0\u{fc}Z",
        ] {
            assert_eq!(utc(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn times_are_written_as_they_are_read() {
        for text in [
            "1970-01-01T00:00:00Z",
            "1999-12-31T23:59:59Z",
            "2024-02-29T06:07:08Z",
            "2024-12-31T00:00:00Z",
            "2400-12-31T00:00:00Z",
            "2026-05-01T08:00:00.000000025Z",
        ] {
            assert_eq!(Rfc3339(utc(text).unwrap()).to_string(), text);
        }
    }
}
