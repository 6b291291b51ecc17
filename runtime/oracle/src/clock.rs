use std::collections::VecDeque;
use std::time::Duration;

use crate::flaws::{Flaw, STEADY, What};
use crate::moment::Moment;
use crate::time_of_day::TimeOfDay;

const DAY_NS: i64 = 86_400_000_000_000;
/// If the bounds of two answers are further apart than this, the clock was set between them: a tenth of a second by
/// which two clocks may drift apart, and the rounding of times with few decimals.
const SET_MIN_NS: i64 = 500_000_000;

/// The vehicle's clock compared with the run's clock: the vehicle made each answer after the command left us and before
/// the answer came.
#[derive(Clone, Debug, Default)]
pub(crate) struct Clock {
    /// The least and the greatest possible difference between the run's time and the vehicle's time of day,
    /// nanoseconds.
    bounds: Option<[i64; 2]>,
    /// When the answers of the last seconds came, oldest first, with the bounds that each gives by itself, if it gives
    /// any. The first answer may be older.
    recent: VecDeque<(Moment, Option<[i64; 2]>)>,
}

impl Clock {
    /// More answers within 10 s than a vehicle gives.
    const RECENT_MAX: usize = 256;

    /// Forgets what is known of the vehicle's clock.
    pub(crate) fn forget(&mut self) {
        self.bounds = None;
        self.recent.clear();
    }

    pub(crate) const fn is_known(&self) -> bool {
        self.bounds.is_some()
    }

    /// An answer came, but the oracle does not know which command it answers, or when the runtime read it. The runtime
    /// may know.
    pub(crate) fn unmeasured(&mut self, came: Moment) {
        self.remember(came, None);
    }

    /// An answer came that the vehicle made at its time `made`, to a command that left at `left`. Returns a flaw if its
    /// bounds contradict those of the answers before.
    pub(crate) fn answered(&mut self, left: Moment, came: Moment, made: TimeOfDay) -> Option<Flaw> {
        let made_ns = nanos(made.as_nanos());
        let mut measured = [left, came].map(|at| nanos(at.as_nanos()) - made_ns);
        let Some([least, most]) = self.bounds else {
            self.bounds = Some(measured);
            self.remember(came, Some(measured));
            return None;
        };
        // Counts the time on the same day as the answers before.
        let days = (measured[0] - least + DAY_NS / 2).div_euclid(DAY_NS);
        measured = measured.map(|bound| bound - days * DAY_NS);
        self.remember(came, Some(measured));
        let met = [least.max(measured[0]), most.min(measured[1])];
        let apart_ns = apart(measured, [least, most]);
        if apart_ns <= 0 {
            self.bounds = Some(met);
            return None;
        }
        if apart_ns <= SET_MIN_NS {
            self.bounds = Some([least.min(measured[0]), most.max(measured[1])]);
            return None;
        }
        self.bounds = Some(measured);
        Some(Flaw {
            since: self.set_since(measured).unwrap_or(came),
            told: came,
            what: What::ClockSet {
                by_s: apart_ns as f64 / 1e9,
            },
        })
    }

    /// How old something with the vehicle's time `made` is at least, by the answers. `None` before the first of them.
    pub(crate) fn age_at_least(&self, now: Moment, made: TimeOfDay) -> Option<Duration> {
        let [_, most] = self.bounds?;
        let age_ns = nanos(now.as_nanos()) - nanos(made.as_nanos()) - most;
        // The short way round midnight.
        let age_ns = (age_ns + DAY_NS / 2).rem_euclid(DAY_NS) - DAY_NS / 2;
        Some(Duration::from_nanos(u64::try_from(age_ns).unwrap_or(0)))
    }

    fn remember(&mut self, came: Moment, bounds: Option<[i64; 2]>) {
        while self.recent.get(1).is_some_and(|(next, _)| came.since(*next) > STEADY) {
            self.recent.pop_front();
        }
        // If there are too many, the answers that are kept date the setting of the clock too early, and never too late.
        if self.recent.len() < Self::RECENT_MAX {
            self.recent.push_back((came, bounds));
        }
    }

    /// When the first answer came that the vehicle can have made by the clock of these bounds. The runtime may have
    /// seen then what the oracle sees only later: it measures some answers more closely, and measures some that the
    /// oracle cannot.
    fn set_since(&self, measured: [i64; 2]) -> Option<Moment> {
        let other = |bounds: &[i64; 2]| apart(measured, *bounds) > SET_MIN_NS;
        let of_it = self.recent.iter().rev();
        let of_it = of_it.take_while(|(_, bounds)| !bounds.as_ref().is_some_and(other));
        of_it.last().map(|(came, _)| *came)
    }
}

/// How far apart two bounds are, nanoseconds; zero or negative if they meet.
fn apart(one: [i64; 2], other: [i64; 2]) -> i64 {
    one[0].max(other[0]) - one[1].min(other[1])
}

fn nanos(nanos: u64) -> i64 {
    i64::try_from(nanos).unwrap_or(i64::MAX / 4)
}
