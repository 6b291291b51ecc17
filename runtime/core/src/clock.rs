use std::time::Duration;

use backseat_units::{TimeOfDay, Timestamp, Utc};

/// How fast two clocks may drift apart at worst: 100 ppm, some ten times a plain crystal's drift.
const DRIFT_NANOS_PER_SECOND: i64 = 100_000;
const HALF_A_DAY_NANOS: i64 = 43_200_000_000_000;

/// The vehicle's clock seen from ours, on one connection.
///
/// Each timestamp from the vehicle gives an upper bound of the offset between the clocks: ours at its arrival less the
/// vehicle's at its writing is the offset plus the delay on the way. The smallest seen is the best, so an age counted
/// through it shows the delay of a message that was held up, which its arrival alone hides. The smallest is let rise
/// by the drift of the clocks.
///
/// Times of day have no date. Offsets are brought within half a day of the first one and then compared as numbers: half
/// a day between the clocks, where a little jitter turns the sign, then does no harm, and timestamps that are wrong by
/// hours can only make things look older, however many follow each other.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct VehicleClock {
    smallest: Option<(i64, Timestamp)>,
    first: Option<i64>,
}

impl VehicleClock {
    /// A timestamp that arrived now. `utc` is ours.
    pub(crate) fn observe(&mut self, now: Timestamp, utc: Utc, written: TimeOfDay) {
        let offset = self.offset_of(utc, written);
        self.first.get_or_insert(offset);
        let smallest = self.offset_nanos(now).map_or(offset, |smallest| smallest.min(offset));
        self.smallest = Some((smallest, now));
    }

    /// How old a thing of the vehicle's time `written` is now; `None` before the first timestamp.
    pub(crate) fn age(&self, now: Timestamp, utc: Utc, written: TimeOfDay) -> Option<Duration> {
        let nanos = self.offset_of(utc, written) - self.offset_nanos(now)?;
        Some(Duration::from_nanos(u64::try_from(nanos).unwrap_or(0)))
    }

    /// Our clock less the vehicle's, nanoseconds, the smallest delay included.
    pub(crate) fn offset_nanos(&self, now: Timestamp) -> Option<i64> {
        let (offset, at) = self.smallest?;
        let elapsed_s = i64::try_from(now.since(at).as_nanos() / 1_000_000).unwrap_or(i64::MAX) as f64 / 1e3;
        Some(offset.saturating_add((elapsed_s * DRIFT_NANOS_PER_SECOND as f64) as i64))
    }
}

impl VehicleClock {
    /// What a timestamp says of the offset, nanoseconds, the first one's day kept.
    fn offset_of(&self, utc: Utc, written: TimeOfDay) -> i64 {
        let offset = utc.time_of_day().nanos_since(written);
        self.first
            .map_or(offset, |first| first + within_half_a_day(offset - first))
    }
}

/// The same difference of times of day, the short way round midnight.
fn within_half_a_day(nanos: i64) -> i64 {
    (nanos + HALF_A_DAY_NANOS).rem_euclid(2 * HALF_A_DAY_NANOS) - HALF_A_DAY_NANOS
}

#[cfg(test)]
mod tests {
    use super::*;

    const START: Utc = Utc::from_unix_nanos(86_399_000_000_000);

    fn vehicle(seconds_of_ours: u64) -> TimeOfDay {
        // The vehicle's clock is two hours ahead.
        (START + Duration::from_secs(seconds_of_ours + 7200)).time_of_day()
    }

    #[test]
    fn a_burst_after_a_stall_is_old_and_the_hours_between_the_clocks_do_not_matter() {
        let mut clock = VehicleClock::default();
        for second in 0..5 {
            let now = Timestamp::from_secs(second);
            clock.observe(now, START + Duration::from_secs(second), vehicle(second));
        }
        let now = Timestamp::from_secs(25);
        let utc = START + Duration::from_secs(25);
        for second in 5..25 {
            clock.observe(now, utc, vehicle(second));
            let age = clock.age(now, utc, vehicle(second)).unwrap();
            assert!(
                age.abs_diff(Duration::from_secs(25 - second)) < Duration::from_millis(5),
                "{age:?}"
            );
        }
    }

    #[test]
    fn timestamps_that_are_wrong_by_hours_make_nothing_look_younger() {
        let mut clock = VehicleClock::default();
        let utc = START + Duration::from_secs(60);
        let now = Timestamp::from_secs(60);
        clock.observe(Timestamp::ZERO, START, vehicle(0));
        for hours in [5, 10, 15, 20, 25, 30] {
            clock.observe(now, utc, vehicle(60 + hours * 3600));
            clock.observe(now, utc, vehicle(50));
            assert!(
                clock.age(now, utc, vehicle(50)).unwrap() > Duration::from_secs(9),
                "{hours} h"
            );
        }
    }

    #[test]
    fn drift_is_followed() {
        let mut clock = VehicleClock::default();
        for second in 0..100_000u64 {
            // The vehicle's clock loses 50 us a second.
            let now = Timestamp::from_secs(second);
            let utc = START + Duration::from_secs(second);
            let written = (START + Duration::from_secs(second + 10).saturating_sub(Duration::from_micros(50 * second)))
                .time_of_day();
            clock.observe(now, utc, written);
            assert!(clock.age(now, utc, written).unwrap() < Duration::from_millis(1));
        }
    }
}
