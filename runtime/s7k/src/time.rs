//! 7KTIME: year, day of year, hours, minutes, seconds.

use backseat_units::Utc;

use crate::layout::{Range, layouts};
use crate::wire::Wire;

layouts! {
    /// A time as every 7k header carries it. All zero means that the sender has no time.
    "Volume I, 7KTIME" Time7k time7k {
        /// The year.
        year: u16, "year", Range::new(0.0, 9999.0);
        /// The day of the year, 1 for the first of January.
        day: u16, "day of year", Range::new(0.0, 366.0);
        /// Seconds of the minute. Near 60 a step of the number is 4 microseconds.
        seconds: f32, "s", Range::new(0.0, 61.0);
        /// Hours of the day.
        hours: u8, "h", Range::new(0.0, 23.0);
        /// Minutes of the hour.
        minutes: u8, "min", Range::new(0.0, 59.0);
    }
}

impl Time7k {
    /// No time: all zero.
    pub const NONE: Self = Self {
        year: 0,
        day: 0,
        seconds: 0.0,
        hours: 0,
        minutes: 0,
    };

    /// The time of an instant, to the precision of `seconds`. Seconds are rounded down, so that 59.9999999 does not
    /// become 60.
    #[must_use]
    pub fn from_utc(utc: Utc) -> Self {
        let nanos = utc.as_unix_nanos();
        let days = nanos / NANOS_PER_DAY;
        let (year, day) = year_and_day(days);
        let in_day = nanos % NANOS_PER_DAY;
        let minutes = in_day / NANOS_PER_MINUTE;
        Self {
            year,
            day,
            seconds: seconds_down(in_day % NANOS_PER_MINUTE),
            hours: u8::try_from(minutes / 60).unwrap_or(23),
            minutes: u8::try_from(minutes % 60).unwrap_or(59),
        }
    }

    /// The instant; `None` if there is no time, if a value is outside its range, or before 1970.
    #[must_use]
    pub fn to_utc(&self) -> Option<Utc> {
        let day_of_year = u64::from(self.day.checked_sub(1)?);
        let year = u64::from(self.year);
        let length = if is_leap(year) { 366 } else { 365 };
        let plausible = (1970..=2500).contains(&year)
            && day_of_year < length
            && self.hours < 24
            && self.minutes < 60
            && (0.0..61.0).contains(&self.seconds);
        if !plausible {
            return None;
        }
        let days = days_before(year) - days_before(1970) + day_of_year;
        let minutes = days * 1440 + u64::from(self.hours) * 60 + u64::from(self.minutes);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "0 to 61e9")]
        let seconds = (f64::from(self.seconds) * 1e9) as u64;
        Some(Utc::from_unix_nanos(minutes * NANOS_PER_MINUTE + seconds))
    }

    /// Whether the sender has no time.
    #[must_use]
    pub fn is_none(&self) -> bool {
        *self == Self::NONE
    }
}

impl Default for Time7k {
    fn default() -> Self {
        Self::NONE
    }
}

impl core::fmt::Display for Time7k {
    /// `2026-327T14:05:07.250`, the ordinal form of ISO 8601.
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(
            f,
            "{:04}-{:03}T{:02}:{:02}:{:06.3}",
            self.year, self.day, self.hours, self.minutes, self.seconds
        )
    }
}

impl Wire for Time7k {
    const SIZE: usize = Self::SIZE;
    const TYPE: &'static str = "7KTIME";

    fn get(bytes: &[u8]) -> Self {
        Self {
            year: Wire::get(&bytes[..2]),
            day: Wire::get(&bytes[2..4]),
            seconds: Wire::get(&bytes[4..8]),
            hours: bytes[8],
            minutes: bytes[9],
        }
    }

    fn put(&self, out: &mut Vec<u8>) {
        self.write(out);
    }

    fn is_known(&self) -> bool {
        self.is_none() || self.to_utc().is_some()
    }
}

const NANOS_PER_MINUTE: u64 = 60_000_000_000;
const NANOS_PER_DAY: u64 = 1440 * NANOS_PER_MINUTE;

/// Seconds below 60 as the nearest `f32` that is not later.
fn seconds_down(nanos: u64) -> f32 {
    #[expect(
        clippy::cast_precision_loss,
        clippy::cast_possible_truncation,
        reason = "rounded down below"
    )]
    let nearest = (nanos as f64 / 1e9) as f32;
    #[expect(clippy::cast_precision_loss, reason = "below 6e10")]
    let late = f64::from(nearest) * 1e9 > nanos as f64;
    if late { nearest.next_down() } else { nearest }
}

const fn is_leap(year: u64) -> bool {
    year.is_multiple_of(4) && (!year.is_multiple_of(100) || year.is_multiple_of(400))
}

/// Days from the first of January of the year 1 to that of `year`.
const fn days_before(year: u64) -> u64 {
    let past = year - 1;
    past * 365 + past / 4 - past / 100 + past / 400
}

/// The year, and the day in it from 1, of a day counted from 1970.
fn year_and_day(days: u64) -> (u16, u16) {
    let absolute = days + days_before(1970);
    // At most a year too high: the mean year is longer than 365 days.
    let mut year = 1 + absolute / 365;
    while days_before(year) > absolute {
        year -= 1;
    }
    let day = absolute - days_before(year) + 1;
    (
        u16::try_from(year).unwrap_or(u16::MAX),
        u16::try_from(day).unwrap_or(366),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn utc(seconds: u64, nanos: u64) -> Utc {
        Utc::from_unix_nanos(seconds * 1_000_000_000 + nanos)
    }

    #[test]
    fn known_instants_have_their_7k_time() {
        for (seconds, shown) in [
            (0, "1970-001T00:00:00.000"),
            (1_709_210_096, "2024-060T12:34:56.000"),
            (1_735_689_599, "2024-366T23:59:59.000"),
            (1_735_689_600, "2025-001T00:00:00.000"),
            (4_107_542_400, "2100-060T00:00:00.000"),
        ] {
            let time = Time7k::from_utc(utc(seconds, 0));
            assert_eq!(time.to_string(), shown);
            assert_eq!(time.to_utc(), Some(utc(seconds, 0)));
        }
    }

    #[test]
    fn seconds_never_round_up_to_sixty() {
        let time = Time7k::from_utc(utc(59, 999_999_999));
        assert!(time.seconds < 60.0 && time.minutes == 0, "{time:?}");
        let back = time.to_utc().unwrap().as_unix_nanos();
        assert!((59_999_990_000..=59_999_999_999).contains(&back), "{back}");
    }

    #[test]
    fn a_time_that_no_clock_shows_is_no_instant() {
        let good = Time7k {
            year: 2026,
            day: 327,
            seconds: 1.5,
            hours: 14,
            minutes: 5,
        };
        assert!(good.to_utc().is_some() && good.is_known());
        for bad in [
            Time7k {
                year: 2026,
                day: 366,
                ..good
            },
            Time7k { day: 0, ..good },
            Time7k { year: 0, ..good },
            Time7k { hours: 24, ..good },
            Time7k { minutes: 60, ..good },
            Time7k {
                seconds: f32::NAN,
                ..good
            },
            Time7k { seconds: -1.0, ..good },
        ] {
            assert!(bad.to_utc().is_none() && !bad.is_known(), "{bad:?}");
        }
        assert!(Time7k::NONE.to_utc().is_none() && Time7k::NONE.is_known());
    }

    #[test]
    fn any_instant_returns_within_the_precision_of_its_seconds() {
        let mut nanos = 1_u64;
        for _ in 0..2000 {
            nanos = nanos
                .wrapping_mul(6_364_136_223_846_793_005)
                .wrapping_add(1_442_695_040_888_963_407);
            let instant = Utc::from_unix_nanos(nanos % (500 * 365 * NANOS_PER_DAY));
            let back = Time7k::from_utc(instant).to_utc().unwrap();
            let lost = instant.as_unix_nanos() - back.as_unix_nanos();
            assert!(lost < 4_000, "{instant:?} lost {lost} ns");
        }
    }
}
