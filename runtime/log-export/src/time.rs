//! Times as people and programs read them.

const NANOS: u64 = 1_000_000_000;
const SECONDS_PER_DAY: u64 = 86_400;

/// A time in UTC, nanoseconds since 1970, taken apart.
pub(crate) struct Calendar {
    pub(crate) year: u64,
    /// From 1.
    pub(crate) month: u64,
    /// From 1.
    pub(crate) day: u64,
    /// From 0, which is Sunday.
    pub(crate) weekday: u64,
    pub(crate) hour: u64,
    pub(crate) minute: u64,
    pub(crate) second: u64,
    pub(crate) nano: u64,
}

impl Calendar {
    /// Source: H. Hinnant, "chrono-Compatible Low-Level Date Algorithms", `civil_from_days`.
    pub(crate) fn of(unix_ns: u64) -> Self {
        let seconds = unix_ns / NANOS;
        let days = seconds / SECONDS_PER_DAY;
        let shifted = days + 719_468;
        let era = shifted / 146_097;
        let day_of_era = shifted % 146_097;
        let year_of_era = (day_of_era - day_of_era / 1460 + day_of_era / 36_524 - day_of_era / 146_096) / 365;
        let day_of_year = day_of_era - (365 * year_of_era + year_of_era / 4 - year_of_era / 100);
        let shifted_month = (5 * day_of_year + 2) / 153;
        let month = if shifted_month < 10 {
            shifted_month + 3
        } else {
            shifted_month - 9
        };
        Self {
            year: year_of_era + era * 400 + u64::from(month <= 2),
            month,
            day: day_of_year - (153 * shifted_month + 2) / 5 + 1,
            // 1970-01-01 was a Thursday.
            weekday: (days + 4) % 7,
            hour: seconds / 3600 % 24,
            minute: seconds / 60 % 60,
            second: seconds % 60,
            nano: unix_ns % NANOS,
        }
    }
}

/// RFC 3339 in UTC, always with nine decimals, so that a column of times has one form.
pub(crate) fn rfc3339(unix_ns: u64) -> String {
    let Calendar {
        year,
        month,
        day,
        hour,
        minute,
        second,
        nano,
        ..
    } = Calendar::of(unix_ns);
    format!("{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}.{nano:09}Z")
}

/// `Mon Nov 23 14:05:07 2026`, as `ctime` of C.
pub(crate) fn ctime(unix_ns: u64) -> String {
    const DAYS: [&str; 7] = ["Sun", "Mon", "Tue", "Wed", "Thu", "Fri", "Sat"];
    const MONTHS: [&str; 12] = [
        "Jan", "Feb", "Mar", "Apr", "May", "Jun", "Jul", "Aug", "Sep", "Oct", "Nov", "Dec",
    ];
    let calendar = Calendar::of(unix_ns);
    let day = DAYS.get(calendar.weekday as usize).unwrap_or(&"");
    let month = MONTHS.get(calendar.month as usize - 1).unwrap_or(&"");
    let Calendar {
        year,
        day: date,
        hour,
        minute,
        second,
        ..
    } = calendar;
    format!("{day} {month} {date:2} {hour:02}:{minute:02}:{second:02} {year}")
}

/// Seconds since the start of a run. A message before it, which a log should not have, has a negative time.
pub(crate) fn seconds(unix_ns: u64, start_ns: u64) -> f64 {
    let magnitude = unix_ns.abs_diff(start_ns) as f64 / NANOS as f64;
    if unix_ns < start_ns { -magnitude } else { magnitude }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_are_those_of_the_calendar() {
        for (seconds, text, c) in [
            (0, "1970-01-01T00:00:00.000000000Z", "Thu Jan  1 00:00:00 1970"),
            (
                951_782_399,
                "2000-02-28T23:59:59.000000000Z",
                "Mon Feb 28 23:59:59 2000",
            ),
            (
                951_782_400,
                "2000-02-29T00:00:00.000000000Z",
                "Tue Feb 29 00:00:00 2000",
            ),
            (
                1_795_442_707,
                "2026-11-23T14:05:07.000000000Z",
                "Mon Nov 23 14:05:07 2026",
            ),
            (
                4_107_542_400,
                "2100-03-01T00:00:00.000000000Z",
                "Mon Mar  1 00:00:00 2100",
            ),
        ] {
            assert_eq!(rfc3339(seconds * NANOS), text);
            assert_eq!(ctime(seconds * NANOS), c);
        }
        assert_eq!(rfc3339(1_000_000_007), "1970-01-01T00:00:01.000000007Z");
    }

    #[test]
    fn seconds_count_from_the_start_in_both_directions() {
        assert_eq!(seconds(3_500_000_000, 1_000_000_000), 2.5);
        assert_eq!(seconds(1_000_000_000, 3_500_000_000), -2.5);
    }
}
