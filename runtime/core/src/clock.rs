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
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct VehicleClock {
    smallest: Option<(i64, Timestamp)>,
}

impl VehicleClock {
    /// A timestamp that arrived now. `utc` is ours.
    pub(crate) fn observe(&mut self, now: Timestamp, utc: Utc, written: TimeOfDay) {
        let offset = utc.time_of_day().nanos_since(written);
        // Where the clocks lie half a day apart, offsets a little apart have either sign: they are compared the short way.
        let smallest = match self.offset_nanos(now) {
            Some(smallest) if within_half_a_day(offset - smallest) >= 0 => smallest,
            Some(_) | None => offset,
        };
        self.smallest = Some((smallest, now));
    }

    /// How old a thing of the vehicle's time `written` is now; `None` before the first timestamp.
    pub(crate) fn age(&self, now: Timestamp, utc: Utc, written: TimeOfDay) -> Option<Duration> {
        let nanos = within_half_a_day(utc.time_of_day().nanos_since(written) - self.offset_nanos(now)?);
        Some(Duration::from_nanos(u64::try_from(nanos).unwrap_or(0)))
    }

    /// Our clock less the vehicle's, nanoseconds, the smallest delay included.
    pub(crate) fn offset_nanos(&self, now: Timestamp) -> Option<i64> {
        let (offset, at) = self.smallest?;
        let elapsed_s = i64::try_from(now.since(at).as_nanos() / 1_000_000).unwrap_or(i64::MAX) as f64 / 1e3;
        Some(offset.saturating_add((elapsed_s * DRIFT_NANOS_PER_SECOND as f64) as i64))
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
