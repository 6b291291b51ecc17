use std::fmt;

const SECOND_NS: u64 = 1_000_000_000;
const DAY_NS: u64 = 86_400 * SECOND_NS;

/// A time of day in UTC, as SPI's timestamps are (4.2, Table 1): nanoseconds since midnight. The leap second, 23:59:60,
/// is the last of its day.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct TimeOfDay(u64);

impl TimeOfDay {
    /// Midnight, which acknowledgements echo for a command without a time.
    pub const MIDNIGHT: Self = Self(0);

    /// Makes a time from the figures of a clock and the nanoseconds of the second. `None` if no clock shows them.
    #[must_use]
    pub fn new(hour: u8, minute: u8, second: u8, nanos: u32) -> Option<Self> {
        let leap = (hour, minute, second) == (23, 59, 60);
        let exists = hour < 24 && minute < 60 && (second < 60 || leap) && u64::from(nanos) < SECOND_NS;
        let seconds = (u64::from(hour) * 60 + u64::from(minute)) * 60 + u64::from(second);
        exists.then(|| Self(seconds * SECOND_NS + u64::from(nanos)))
    }

    /// Nanoseconds since midnight, less than 86,401 s.
    #[must_use]
    pub const fn as_nanos(self) -> u64 {
        self.0
    }

    /// Cuts off what is finer than a millisecond, because acknowledgements repeat three decimals.
    #[must_use]
    pub const fn to_the_millisecond(self) -> Self {
        Self(self.0 - self.0 % 1_000_000)
    }

    /// Nanoseconds since another time, the shorter way round midnight: at most half a day either way.
    #[must_use]
    pub const fn nanos_since(self, other: Self) -> i64 {
        const HALF: i64 = DAY_NS as i64 / 2;
        (self.0 as i64 - other.0 as i64 + HALF).rem_euclid(DAY_NS as i64) - HALF
    }
}

/// A command's time as an acknowledgement echoes it (SPI 6.21). The vehicle cuts it off or rounds it at the last
/// decimal that it writes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Echo {
    time: TimeOfDay,
    decimals: u8,
}

impl Echo {
    /// The echo of a command without a time.
    pub const NONE: Self = Self {
        time: TimeOfDay::MIDNIGHT,
        decimals: 3,
    };

    /// An echo that was written with this number of decimals. More than three say nothing, because our times are whole
    /// milliseconds.
    #[must_use]
    pub fn new(time: TimeOfDay, decimals: usize) -> Self {
        Self {
            time,
            decimals: u8::try_from(decimals).unwrap_or(u8::MAX).min(3),
        }
    }

    /// Whether the echo is as fine as our times, so that it belongs to one command only.
    #[must_use]
    pub const fn is_precise(self) -> bool {
        self.decimals == 3
    }

    /// The time as it was written.
    #[must_use]
    pub const fn time(self) -> TimeOfDay {
        self.time
    }

    /// Whether the echo says that the command had no time.
    #[must_use]
    pub fn is_none(self) -> bool {
        self.time == TimeOfDay::MIDNIGHT
    }

    /// Whether this may be the echo of a command that was made then.
    #[must_use]
    pub fn echoes(self, created: TimeOfDay) -> bool {
        let unit_ns = 10_i64.pow(9 - u32::from(self.decimals));
        let left_out_ns = created.nanos_since(self.time);
        !self.is_none() && left_out_ns < unit_ns && left_out_ns >= -unit_ns / 2
    }
}

impl fmt::Display for TimeOfDay {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let millis = self.0 % SECOND_NS / 1_000_000;
        let seconds = self.0 / SECOND_NS;
        let minutes = (seconds / 60).min(24 * 60 - 1);
        let (hour, minute, second) = (minutes / 60, minutes % 60, seconds - minutes * 60);
        write!(f, "{hour:02}:{minute:02}:{second:02}.{millis:03}")
    }
}

/// The time of day so many milliseconds after midnight.
#[cfg(test)]
pub(crate) const fn from_millis(millis: u64) -> TimeOfDay {
    TimeOfDay(millis * 1_000_000)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_of_day_is_what_a_clock_shows() {
        for (time, shown) in [
            ((0, 0, 0, 0), Some("00:00:00.000")),
            ((8, 10, 25, 987_654_321), Some("08:10:25.987")),
            ((23, 59, 59, 999_999_999), Some("23:59:59.999")),
            ((23, 59, 60, 500_000_000), Some("23:59:60.500")),
            ((12, 59, 60, 0), None),
            ((24, 0, 0, 0), None),
            ((0, 60, 0, 0), None),
            ((0, 0, 61, 0), None),
            ((0, 0, 0, 1_000_000_000), None),
        ] {
            let (hour, minute, second, nanos) = time;
            let read = TimeOfDay::new(hour, minute, second, nanos).map(|time| time.to_string());
            assert_eq!(read.as_deref(), shown, "{time:?}");
        }
    }

    #[test]
    fn an_echo_matches_within_its_last_decimal() {
        let made = TimeOfDay::new(8, 10, 25, 987_000_000).unwrap();
        for (nanos, decimals, echoes) in [
            (987_000_000, 3, true),
            (987_400_000, 6, true),
            (986_000_000, 3, false),
            (988_000_000, 3, false),
            (980_000_000, 2, true),
            (990_000_000, 2, true),
            (970_000_000, 2, false),
            (900_000_000, 1, true),
            (0, 0, true),
        ] {
            let echo = Echo::new(TimeOfDay::new(8, 10, 25, nanos).unwrap(), decimals);
            assert_eq!(echo.echoes(made), echoes, "{nanos} {decimals}");
        }
        // An echo that was rounded up past midnight.
        let late = TimeOfDay::new(23, 59, 59, 996_000_000).unwrap();
        let rounded = Echo::new(TimeOfDay::new(0, 0, 0, 10_000_000).unwrap(), 2);
        assert!(!rounded.echoes(late) && !Echo::NONE.echoes(TimeOfDay::MIDNIGHT));
    }

    #[test]
    fn differences_go_the_shorter_way_round_midnight() {
        let at = |hour, second| TimeOfDay::new(hour, 59, second, 0).unwrap();
        assert_eq!(at(0, 0).nanos_since(at(23, 59)), 3_541_000_000_000);
        assert_eq!(at(23, 59).nanos_since(at(0, 0)), -3_541_000_000_000);
        assert_eq!(at(23, 60).nanos_since(at(23, 59)), 1_000_000_000);
        assert_eq!(at(12, 1).nanos_since(at(0, 0)), -43_199_000_000_000);
        assert_eq!(at(12, 0).nanos_since(at(0, 0)), -43_200_000_000_000);
        assert_eq!(at(11, 59).nanos_since(at(0, 0)), 39_659_000_000_000);
        let fine = TimeOfDay::new(1, 2, 3, 4_567_890).unwrap();
        assert_eq!(Some(fine.to_the_millisecond()), TimeOfDay::new(1, 2, 3, 4_000_000));
    }
}
