use std::time::Duration;

use backseat_units::{TimeOfDay, Timestamp, Utc};

/// How fast two clocks may drift apart at worst: 100 ppm, about ten times the drift of a plain crystal.
const DRIFT_NANOS_PER_SECOND: i64 = 100_000;
const SECOND_NANOS: i64 = 1_000_000_000;
const HALF_A_DAY_NANOS: i64 = 43_200 * SECOND_NANOS;
/// The time of day at which a leap second begins.
const LEAP_AT_NANOS: i64 = 2 * HALF_A_DAY_NANOS;
/// A timestamp that names a leap second is believed only if its message was on its way no longer than this. A timestamp
/// that names one at another time of the day comes from a wrong clock.
const LEAP_WITHIN_NANOS: i64 = 900_000_000;
/// The new day begins within this time after the leap second was first named.
const LEAP_LASTS: Duration = Duration::from_secs(3);
/// A timestamp of the new day is earlier in its day than this.
const NEW_DAY_NANOS: i64 = 3 * SECOND_NANOS;
/// For this long after a leap second, timestamps from before it may still come.
const LEAP_REMEMBERED: Duration = Duration::from_secs(3600);

/// The two clocks may seem to have moved against each other by this without having been set: a vehicle may give its
/// messages the time when its own cycle began, and at 10 Hz a cycle takes 100 ms.
const STEP_MIN_NANOS: i64 = 100_000_000;
/// A timestamp that is later than now by more than this cannot have been written yet, so it is not from the clock that
/// was measured.
const FUTURE_NANOS: i64 = 250_000_000;

/// The vehicle's clock seen from ours (safety requirement 023).
///
/// The vehicle writes an acknowledgement after the command has left us and before the acknowledgement arrives. So each
/// round trip bounds the offset between the clocks on both sides, and several round trips together bound it more
/// closely. Nothing is learnt from messages of one direction: if all of them are delayed from the first byte on, that
/// looks exactly like a clock that is slow. An age is computed with the bound that makes it the greatest, so it is
/// never less than the true age. The bounds widen by the drift of the clocks.
///
/// Times of day have no date. Offsets are brought within half a day of the first one and then compared as numbers.
///
/// Our clock has no leap seconds. If the vehicle's clock has one, its new day begins a second later than by our clock,
/// and from then on the offset is a second more.
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
pub(crate) struct VehicleClock {
    bounds: Option<Bounds>,
    first: Option<i64>,
    /// How finely acknowledgements give the time, nanoseconds, as far as they have shown it.
    resolution: Option<i64>,
    leap: Leap,
}

/// Our clock minus the vehicle's, nanoseconds: from `least` to `most` when it was last measured, at `at`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
struct Bounds {
    least: i64,
    most: i64,
    at: Timestamp,
}

/// A measured round trip: a command, and what the vehicle wrote in answer to it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
pub(crate) struct Trip {
    /// When the command left.
    pub(crate) sent: Timestamp,
    /// When its first acknowledgement came.
    pub(crate) received: Timestamp,
}

impl Trip {
    /// How long the round trip took. Neither direction took longer.
    pub(crate) const fn lasted(self) -> Duration {
        self.received.since(self.sent)
    }
}

/// How far the vehicle's clock is through a leap second.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
enum Leap {
    #[default]
    None,
    /// A timestamp first named the leap second at this time.
    Begun(Timestamp),
    /// The new day began at this time.
    Over(Timestamp),
}

impl VehicleClock {
    /// An acknowledgement that the vehicle wrote at `written` ends a round trip now, when our clock says `utc`. If the
    /// trip shows another offset than those before it, one of the two clocks has been set: returns by how much,
    /// nanoseconds.
    pub(crate) fn measure(&mut self, trip: Trip, utc: Utc, written: TimeOfDay) -> Option<i64> {
        let now = trip.received;
        self.follow_leap(now, utc, written);
        let offset = self.offset_of(utc, written);
        self.first.get_or_insert(offset);
        let resolution = resolution_nanos(written).min(self.resolution.unwrap_or(i64::MAX));
        self.resolution = Some(resolution);
        let lasted = i64::try_from(trip.lasted().as_nanos()).unwrap_or(i64::MAX / 4);
        let measured = Bounds {
            least: offset - lasted - resolution,
            most: offset + resolution / 2,
            at: now,
        };
        let Some(known) = self.bounds_at(now) else {
            self.bounds = Some(measured);
            return None;
        };
        let (least, most) = (known.least.max(measured.least), known.most.min(measured.most));
        let (least, most, step) = if least <= most {
            (least, most, None)
        } else if least - most <= STEP_MIN_NANOS {
            (known.least.min(measured.least), known.most.max(measured.most), None)
        } else {
            let step = if measured.least > known.most {
                measured.least - known.most
            } else {
                measured.most - known.least
            };
            (measured.least, measured.most, Some(step))
        };
        self.bounds = Some(Bounds { least, most, at: now });
        step
    }

    /// A timestamp that arrives now says nothing about the offset, but it may name a leap second. `utc` is ours.
    pub(crate) fn heard(&mut self, now: Timestamp, utc: Utc, written: TimeOfDay) {
        self.follow_leap(now, utc, written);
    }

    /// How old something with the vehicle's time `written` is now at most. `None` before the first round trip, and if
    /// the clock that was measured has not reached `written` yet.
    pub(crate) fn age(&self, now: Timestamp, utc: Utc, written: TimeOfDay) -> Option<Duration> {
        let nanos = self.offset_of(utc, written) - self.bounds_at(now)?.least;
        (nanos >= -FUTURE_NANOS).then(|| Duration::from_nanos(u64::try_from(nanos).unwrap_or(0)))
    }

    /// Our clock minus the vehicle's, nanoseconds: the middle between the bounds.
    pub(crate) fn offset_nanos(&self, now: Timestamp) -> Option<i64> {
        let bounds = self.bounds_at(now)?;
        Some(bounds.least + (bounds.most - bounds.least) / 2)
    }

    /// By how much our clock and the vehicle's differ at most, the short way round midnight; `None` before the first
    /// round trip. Our clock may have been set since the start, by `set_nanos` nanoseconds.
    pub(crate) fn apart(&self, now: Timestamp, set_nanos: i64) -> Option<Duration> {
        let bounds = self.bounds_at(now)?;
        let side = |side: i64| within_half_a_day(side.saturating_add(set_nanos)).unsigned_abs();
        let sides = [side(bounds.least), side(bounds.most)];
        Some(Duration::from_nanos(sides[0].max(sides[1])))
    }

    /// The bounds, widened by how far the clocks may have drifted since they were measured.
    fn bounds_at(&self, now: Timestamp) -> Option<Bounds> {
        let Bounds { least, most, at } = self.bounds?;
        let elapsed_s = i64::try_from(now.since(at).as_nanos() / 1_000_000).unwrap_or(i64::MAX) as f64 / 1e3;
        let drift = (elapsed_s * DRIFT_NANOS_PER_SECOND as f64) as i64;
        Some(Bounds {
            least: least.saturating_sub(drift),
            most: most.saturating_add(drift),
            at: now,
        })
    }

    /// The offset that a timestamp shows, nanoseconds, within half a day of the first one.
    fn offset_of(&self, utc: Utc, written: TimeOfDay) -> i64 {
        let mut offset = utc.time_of_day().nanos_since(written);
        if matches!(self.leap, Leap::Over(_)) && nanos(written) >= HALF_A_DAY_NANOS {
            // It was written before the new day, so the leap second lies between.
            offset += SECOND_NANOS;
        }
        self.first
            .map_or(offset, |first| first + within_half_a_day(offset - first))
    }

    /// Notices a leap second, and its end by the first timestamp after it.
    fn follow_leap(&mut self, now: Timestamp, utc: Utc, written: TimeOfDay) {
        match self.leap {
            Leap::None if nanos(written) >= LEAP_AT_NANOS => {
                let late = self
                    .bounds_at(now)
                    .map(|bounds| self.offset_of(utc, written) - bounds.least);
                if late.is_some_and(|late| late.abs() <= LEAP_WITHIN_NANOS) {
                    self.leap = Leap::Begun(now);
                }
            }
            Leap::Begun(since) if now.since(since) > LEAP_LASTS => self.leap = Leap::None,
            Leap::Begun(_) if nanos(written) < NEW_DAY_NANOS => {
                self.bounds = self.bounds.map(|bounds| Bounds {
                    least: bounds.least + SECOND_NANOS,
                    most: bounds.most + SECOND_NANOS,
                    ..bounds
                });
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

/// The coarsest unit in which a time may have been written, nanoseconds: a time that ends in zeros may have had no more
/// decimals.
fn resolution_nanos(time: TimeOfDay) -> i64 {
    let nanos = nanos(time);
    let resolutions = [SECOND_NANOS, SECOND_NANOS / 10, SECOND_NANOS / 100];
    let coarse = resolutions.into_iter().find(|resolution| nanos % resolution == 0);
    coarse.unwrap_or(SECOND_NANOS / 1000)
}

/// From one time of the vehicle's clock to another, nanoseconds, negative if the second is earlier: the short way round
/// midnight. It includes the leap second if the earlier one is in it and the later one in the new day.
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

/// A difference of times of day, brought within half a day: the short way round midnight.
fn within_half_a_day(nanos: i64) -> i64 {
    (nanos + HALF_A_DAY_NANOS).rem_euclid(2 * HALF_A_DAY_NANOS) - HALF_A_DAY_NANOS
}

#[cfg(test)]
mod tests {
    use super::*;

    const START: Utc = Utc::from_unix_nanos(86_399_000_000_000);

    /// The vehicle's clock is two hours ahead.
    fn vehicle(millis_of_ours: u64) -> TimeOfDay {
        (START + Duration::from_millis(millis_of_ours + 7_200_000)).time_of_day()
    }

    /// A round trip: when the command leaves us, when the vehicle answers it, and when the answer arrives,
    /// milliseconds.
    fn trip(clock: &mut VehicleClock, sent: u64, written: u64, received: u64) -> Option<i64> {
        measured(clock, sent, vehicle(written), received)
    }

    fn measured(clock: &mut VehicleClock, sent: u64, written: TimeOfDay, received: u64) -> Option<i64> {
        let trip = Trip {
            sent: Timestamp::from_millis(sent),
            received: Timestamp::from_millis(received),
        };
        clock.measure(trip, START + Duration::from_millis(received), written)
    }

    fn age_s(clock: &VehicleClock, written: u64, now: u64) -> Option<f64> {
        let (at, utc) = (Timestamp::from_millis(now), START + Duration::from_millis(now));
        let age = clock.age(at, utc, vehicle(written));
        age.map(|age| age.as_secs_f64())
    }

    #[test]
    fn sr_023_without_a_round_trip_nothing_has_an_age() {
        let mut clock = VehicleClock::default();
        for second in 0..100 {
            let now = Timestamp::from_secs(second);
            clock.heard(now, START + Duration::from_secs(second), vehicle(second * 1000));
        }
        assert_eq!(age_s(&clock, 99_000, 100_000), None);
        assert_eq!(clock.offset_nanos(Timestamp::from_secs(100)), None);
    }

    #[test]
    fn sr_023_an_age_is_never_less_than_the_true_one_whatever_each_way_takes() {
        for (forth, back) in [(0, 800), (800, 0), (400, 400), (3, 5)] {
            let mut clock = VehicleClock::default();
            for second in 1..20 {
                let sent = second * 1000 + 7;
                assert_eq!(trip(&mut clock, sent, sent + forth, sent + forth + back), None);
            }
            for true_age in [0u64, 100, 8000] {
                let age = age_s(&clock, 25_003 - true_age, 25_003).unwrap() - true_age as f64 / 1e3;
                assert!(age >= 0.0 && age < forth as f64 / 1e3 + 0.012, "{forth} {back}: {age}");
            }
        }
    }

    #[test]
    fn sr_023_a_link_that_becomes_slow_after_one_quick_trip_is_noticed() {
        let mut clock = VehicleClock::default();
        trip(&mut clock, 1003, 1005, 1007);
        for second in 2..60u64 {
            // From now on every message of the vehicle is delayed by 8 s.
            let sent = second * 1000 + 3;
            assert_eq!(trip(&mut clock, sent, sent + 2, sent + 8004), None);
            let age = age_s(&clock, sent + 2, sent + 8004).unwrap();
            assert!(age > 8.0 && age < 8.03, "{age}");
        }
    }

    #[test]
    fn sr_023_a_clock_that_is_set_is_reported_and_followed() {
        for step_ms in [-10_000i64, -300, 300, 10_000] {
            let mut clock = VehicleClock::default();
            for second in 1..10 {
                assert_eq!(
                    trip(&mut clock, second * 1000 + 3, second * 1000 + 5, second * 1000 + 7),
                    None
                );
            }
            let at = 10_003u64;
            let written = (at + 2).checked_add_signed(step_ms).unwrap();
            // A time that is later than now has no age.
            assert_eq!(age_s(&clock, written, at).is_none(), step_ms > 250);
            let step = trip(&mut clock, at, written, at + 4).expect("the step is reported");
            let error = step + step_ms * 1_000_000;
            assert!(error.abs() < 20_000_000, "{step}");
            let age = age_s(&clock, written, at + 10).unwrap();
            assert!((0.0..0.03).contains(&age), "{age}");
            assert_eq!(trip(&mut clock, at + 1000, written + 1000, at + 1004), None);
        }
    }

    #[test]
    fn stamps_of_the_beginning_of_a_cycle_are_no_clock_step() {
        let mut clock = VehicleClock::default();
        for beat in 1..600u64 {
            let sent = beat * 1007;
            let cycle = (sent + 1) / 100 * 100;
            assert_eq!(trip(&mut clock, sent, cycle, sent + 2), None, "beat {beat}");
        }
    }

    #[test]
    fn stamps_with_two_decimals_or_less_are_no_clock_step() {
        for decimals in 0..3 {
            let mut clock = VehicleClock::default();
            let unit = 10u64.pow(3 - decimals);
            for beat in 1..600u64 {
                let sent = beat * 1007;
                let cut = (sent + 1) / unit * unit;
                assert_eq!(
                    trip(&mut clock, sent, cut, sent + 2),
                    None,
                    "{decimals} decimals, beat {beat}"
                );
            }
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
    fn ages_stay_right_over_a_leap_second() {
        // Our clock is half an hour ahead of the vehicle's and has no leap second.
        let ours = |millis: u64| Utc::from_unix_nanos((86_340_000 + 1_800_000 + millis) * 1_000_000);
        let mut clock = VehicleClock::default();
        for millis in (50_000..75_000).step_by(100) {
            let now = Timestamp::from_millis(millis);
            // Written now, and solved up to 140 ms earlier.
            for age_ms in [0, 40, 140] {
                clock.heard(now, ours(millis), leap_day(millis - age_ms));
            }
            if millis % 1000 == 300 {
                let trip = Trip {
                    sent: Timestamp::from_millis(millis - 2),
                    received: now,
                };
                assert_eq!(clock.measure(trip, ours(millis), leap_day(millis - 1)), None);
            }
            if millis < 51_000 {
                continue;
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
            trip(&mut clock, 0, 0, 0);
            clock.heard(Timestamp::from_secs(1), START + Duration::from_secs(1), leap);
            clock.heard(Timestamp::from_secs(2), START + Duration::from_secs(2), vehicle(2000));
            assert!(age_s(&clock, 0, 2000).unwrap() > 1.99);
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
            let utc = START + Duration::from_secs(second);
            let written = (START + Duration::from_secs(second + 10).saturating_sub(Duration::from_micros(50 * second)))
                .time_of_day();
            assert_eq!(measured(&mut clock, second * 1000, written, second * 1000 + 2), None);
            let age = clock.age(Timestamp::from_secs(second), utc, written).unwrap();
            // The first timestamp has no decimals, so it may have been cut to the second.
            assert!(second == 0 || age < Duration::from_millis(15), "{age:?}");
        }
    }
}
