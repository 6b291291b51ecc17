use std::time::Duration;

use backseat_units::{TimeOfDay, Timestamp, Utc};

/// How fast two clocks may drift apart at worst: 100 ppm, some ten times a plain crystal's drift.
const DRIFT_NANOS_PER_SECOND: i64 = 100_000;
const SECOND_NANOS: i64 = 1_000_000_000;
const HALF_A_DAY_NANOS: i64 = 43_200 * SECOND_NANOS;
/// Where in its day the leap second begins.
const LEAP_AT_NANOS: i64 = 2 * HALF_A_DAY_NANOS;
/// The leap second is believed of a message that was under way no longer than this: one that names it at another time
/// of the day has a wrong clock.
const LEAP_WITHIN_NANOS: i64 = 900_000_000;
/// The new day comes within this after the leap second was first named.
const LEAP_LASTS: Duration = Duration::from_secs(3);
/// What is written then is not later in its day than this.
const NEW_DAY_NANOS: i64 = 3 * SECOND_NANOS;
/// For so long after a leap second timestamps from before it may be met.
const LEAP_REMEMBERED: Duration = Duration::from_secs(3600);

/// The vehicle's clock seen from ours.
///
/// Each timestamp from the vehicle gives an upper bound of the offset between the clocks: ours at its arrival less the
/// vehicle's at its writing is the offset plus the delay on the way. The smallest seen is the best, so an age counted
/// through it shows the delay of a message that was held up, which its arrival alone hides. The smallest is let rise
/// by the drift of the clocks.
///
/// Times of day have no date. Offsets are brought within half a day of the first one and then compared as numbers: half
/// a day between the clocks, where a little jitter turns the sign, then does no harm, and timestamps that are wrong by
/// hours can only make things look older, however many follow each other.
///
/// Our clock knows no leap seconds. Where the vehicle's has one, its new day begins a second later than ours would have
/// it, and the offset is a second more from there on.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct VehicleClock {
    smallest: Option<(i64, Timestamp)>,
    first: Option<i64>,
    leap: Leap,
}

/// Where the vehicle's clock stands to a leap second.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Leap {
    #[default]
    None,
    /// It was named at this time.
    Begun(Timestamp),
    /// The new day began at this time.
    Over(Timestamp),
}

impl VehicleClock {
    /// A timestamp that arrived now. `utc` is ours.
    pub(crate) fn observe(&mut self, now: Timestamp, utc: Utc, written: TimeOfDay) {
        self.follow_leap(now, utc, written);
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

    /// By how much our clock and the vehicle's differ, the short way round midnight; `None` before the first timestamp.
    pub(crate) fn apart(&self, now: Timestamp) -> Option<Duration> {
        let nanos = within_half_a_day(self.offset_nanos(now)?);
        Some(Duration::from_nanos(nanos.unsigned_abs()))
    }

    /// What a timestamp says of the offset, nanoseconds, the first one's day kept.
    fn offset_of(&self, utc: Utc, written: TimeOfDay) -> i64 {
        let mut offset = utc.time_of_day().nanos_since(written);
        if matches!(self.leap, Leap::Over(_)) && nanos(written) >= HALF_A_DAY_NANOS {
            // From before the new day, with the leap second between.
            offset += SECOND_NANOS;
        }
        self.first
            .map_or(offset, |first| first + within_half_a_day(offset - first))
    }

    /// Takes note of a leap second and of its end, from the first timestamp after it.
    fn follow_leap(&mut self, now: Timestamp, utc: Utc, written: TimeOfDay) {
        match self.leap {
            Leap::None if nanos(written) >= LEAP_AT_NANOS => {
                let late = self
                    .offset_nanos(now)
                    .map(|smallest| self.offset_of(utc, written) - smallest);
                if late.is_some_and(|late| late.abs() <= LEAP_WITHIN_NANOS) {
                    self.leap = Leap::Begun(now);
                }
            }
            Leap::Begun(since) if now.since(since) > LEAP_LASTS => self.leap = Leap::None,
            Leap::Begun(_) if nanos(written) < NEW_DAY_NANOS => {
                self.smallest = self.smallest.map(|(offset, at)| (offset + SECOND_NANOS, at));
                self.first = self.first.map(|first| first + SECOND_NANOS);
                self.leap = Leap::Over(now);
            }
            Leap::Over(since) if now.since(since) > LEAP_REMEMBERED => self.leap = Leap::None,
            Leap::None | Leap::Begun(_) | Leap::Over(_) => {}
        }
    }
}

fn nanos(time: TimeOfDay) -> i64 {
    i64::try_from(time.as_nanos()).expect("a time of day is below 86 401 s")
}

/// From one time of the vehicle's clock to another that was written after it, nanoseconds: the short way round midnight,
/// with the leap second where the earlier one is in it.
pub(crate) fn elapsed_nanos(from: TimeOfDay, to: TimeOfDay) -> i64 {
    let elapsed = to.nanos_since(from);
    if nanos(from) >= LEAP_AT_NANOS && nanos(to) < HALF_A_DAY_NANOS {
        elapsed + SECOND_NANOS
    } else if nanos(to) >= LEAP_AT_NANOS && nanos(from) < HALF_A_DAY_NANOS {
        elapsed - SECOND_NANOS
    } else {
        elapsed
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

    fn leap_day(millis_from_2359: u64) -> TimeOfDay {
        let since_midnight = 86_340_000 + millis_from_2359;
        // 61 s in the last minute, then the new day.
        let millis = if since_midnight < 86_401_000 {
            since_midnight
        } else {
            since_midnight - 86_401_000
        };
        TimeOfDay::from_nanos(millis * 1_000_000).unwrap()
    }

    #[test]
    fn over_a_leap_second_ages_stay_what_they_are() {
        // Ours, half an hour ahead of the vehicle's, has no leap second.
        let ours = |millis: u64| Utc::from_unix_nanos((86_340_000 + 1_800_000 + millis) * 1_000_000);
        let mut clock = VehicleClock::default();
        for millis in (50_000..75_000).step_by(100) {
            let now = Timestamp::from_millis(millis);
            // Written now, and solved a while before.
            for age_ms in [0, 40, 140] {
                clock.observe(now, ours(millis), leap_day(millis - age_ms));
            }
            for age_ms in [0, 40, 140, 3000] {
                let age = clock.age(now, ours(millis), leap_day(millis - age_ms)).unwrap();
                let error = age.abs_diff(Duration::from_millis(age_ms));
                assert!(
                    error < Duration::from_millis(5),
                    "{age:?} for {age_ms} ms at {millis} ms"
                );
            }
        }
    }

    #[test]
    fn a_leap_second_at_another_time_of_the_day_makes_nothing_look_younger() {
        for wrong in [86_400_500, 86_400_000] {
            let mut clock = VehicleClock::default();
            let leap = TimeOfDay::from_nanos(wrong * 1_000_000).unwrap();
            clock.observe(Timestamp::ZERO, START, vehicle(0));
            clock.observe(Timestamp::from_secs(1), START + Duration::from_secs(1), leap);
            let (now, utc) = (Timestamp::from_secs(2), START + Duration::from_secs(2));
            clock.observe(now, utc, vehicle(2));
            assert!(clock.age(now, utc, vehicle(0)).unwrap() > Duration::from_millis(1990));
        }
    }

    #[test]
    fn elapsed_time_counts_the_leap_second() {
        let steps = [59_900, 60_000, 60_100, 60_900, 61_000, 61_100].map(leap_day);
        for (from, to, millis) in [
            (0, 1, 100),
            (1, 2, 100),
            (2, 3, 800),
            (3, 4, 100),
            (4, 5, 100),
            (3, 2, -800),
            (4, 3, -100),
        ] {
            assert_eq!(elapsed_nanos(steps[from], steps[to]), millis * 1_000_000);
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
