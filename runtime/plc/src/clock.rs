//! The controller's own clock.

use core::time::Duration;

use backseat_units::{Timestamp, Utc};

/// A clock that runs a little fast or slow from the instant at which it was set.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Clock {
    set_at: Timestamp,
    utc_nanos: i128,
    drift_ppm: f64,
}

impl Clock {
    /// A clock that shows `utc` plus an offset at the start of the run.
    pub(crate) fn new(utc: Utc, offset_s: f64, drift_ppm: f64) -> Self {
        Self {
            set_at: Timestamp::ZERO,
            utc_nanos: i128::from(utc.as_unix_nanos()) + (offset_s * 1e9) as i128,
            drift_ppm,
        }
    }

    pub(crate) fn utc(&self, now: Timestamp) -> Utc {
        let passed = now.since(self.set_at);
        let drift = passed.as_secs_f64() * self.drift_ppm * 1e3;
        let nanos = self.utc_nanos + passed.as_nanos().cast_signed() + drift as i128;
        Utc::from_unix_nanos(u64::try_from(nanos.max(0)).unwrap_or(u64::MAX))
    }

    /// Sets the clock to this time, `late` after the time was true.
    pub(crate) fn set(&mut self, now: Timestamp, utc: Utc, late: Duration) {
        self.utc_nanos = i128::from(utc.as_unix_nanos()) - late.as_nanos().cast_signed();
        self.set_at = now;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_clock_drifts_from_where_it_was_set() {
        let at = |seconds| Timestamp::from_secs(seconds);
        let start = Utc::from_unix_nanos(1_000_000_000_000);
        let mut clock = Clock::new(start, -2.0, 100.0);
        let after = |clock: &Clock, seconds: u64| {
            clock.utc(at(seconds)).as_unix_nanos().cast_signed() - start.as_unix_nanos().cast_signed()
        };
        assert_eq!(after(&clock, 0), -2_000_000_000);
        // 100 parts in a million of 1000 s are 0.1 s.
        assert_eq!(after(&clock, 1000), 998_100_000_000);
        clock.set(at(1000), start, Duration::from_millis(500));
        assert_eq!(after(&clock, 1000), -500_000_000);
        assert_eq!(after(&clock, 2000), 999_600_000_000);
    }
}
