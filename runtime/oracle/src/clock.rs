use crate::flaws::{Flaw, What};
use crate::moment::Moment;
use crate::time_of_day::TimeOfDay;

const DAY_NS: i64 = 86_400_000_000_000;
/// Bounds of two answers that lie further apart than this are of a clock that was set meanwhile: a tenth of a second that
/// two clocks may move against each other, and what times of few decimals leave open.
const SET_MIN_NS: i64 = 500_000_000;

/// The vehicle's clock against the run's: each answer was made after its command left and before it came itself.
#[derive(Clone, Debug, Default)]
pub(crate) struct Clock {
    /// The run's time less the vehicle's time of day, nanoseconds: neither less nor more.
    bounds: Option<[i64; 2]>,
}

impl Clock {
    /// Nothing is known of it.
    pub(crate) fn forget(&mut self) {
        self.bounds = None;
    }

    pub(crate) const fn is_known(&self) -> bool {
        self.bounds.is_some()
    }

    /// An answer that was made at the vehicle's time `made` came, to what left before. A flaw where it tells of another
    /// offset than those before it.
    pub(crate) fn answered(&mut self, left: Moment, came: Moment, made: TimeOfDay) -> Option<Flaw> {
        let made_ns = nanos(made.as_nanos());
        let mut measured = [left, came].map(|at| nanos(at.as_nanos()) - made_ns);
        let Some([least, most]) = self.bounds else {
            self.bounds = Some(measured);
            return None;
        };
        // The same day as that of those before it.
        let days = (measured[0] - least + DAY_NS / 2).div_euclid(DAY_NS);
        measured = measured.map(|bound| bound - days * DAY_NS);
        let met = [least.max(measured[0]), most.min(measured[1])];
        let apart_ns = met[0] - met[1];
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
            since: came,
            told: came,
            what: What::ClockSet {
                by_s: apart_ns as f64 / 1e9,
            },
        })
    }
}

fn nanos(nanos: u64) -> i64 {
    i64::try_from(nanos).unwrap_or(i64::MAX / 4)
}
