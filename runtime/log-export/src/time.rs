//! Times as people and programs read them.

use chrono::{DateTime, Utc};

const NANOS: u64 = 1_000_000_000;

fn utc(unix_ns: u64) -> DateTime<Utc> {
    let seconds = i64::try_from(unix_ns / NANOS).unwrap_or_default();
    let nanos = u32::try_from(unix_ns % NANOS).unwrap_or_default();
    DateTime::from_timestamp(seconds, nanos).unwrap_or_default()
}

/// RFC 3339 in UTC, always with nine decimals, so that a column of times has one form.
pub(crate) fn rfc3339(unix_ns: u64) -> String {
    utc(unix_ns).format("%Y-%m-%dT%H:%M:%S%.9fZ").to_string()
}

/// `Mon Nov 23 14:05:07 2026`, as `ctime` of C.
pub(crate) fn ctime(unix_ns: u64) -> String {
    utc(unix_ns).format("%a %b %e %H:%M:%S %Y").to_string()
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
