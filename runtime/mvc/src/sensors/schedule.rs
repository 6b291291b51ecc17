use core::time::Duration;

use backseat_units::Timestamp;

/// When a sensor makes its next reading, and the number of that reading.
#[derive(Clone, Copy, Debug)]
pub(super) struct Schedule {
    next: Timestamp,
    period: Duration,
    count: u64,
}

impl Schedule {
    /// The schedule of a sensor that makes its first reading in the vehicle's first step.
    pub(super) fn every(period_s: f64) -> Self {
        Self {
            next: Timestamp::ZERO,
            period: Duration::from_secs_f64(period_s),
            count: 0,
        }
    }

    /// Sets another period, which begins with the next step.
    pub(super) fn change_period(&mut self, period_s: f64) {
        let period = Duration::from_secs_f64(period_s);
        if period != self.period {
            self.period = period;
            self.next = Timestamp::ZERO;
        }
    }

    /// The number of the reading that is due at this step, if one is. A sensor that is faster than the vehicle's steps
    /// makes one reading a step.
    pub(super) fn due(&mut self, now: Timestamp) -> Option<u64> {
        if now < self.next {
            return None;
        }
        self.next = self.next + self.period;
        if self.next <= now {
            self.next = now + self.period;
        }
        self.count += 1;
        Some(self.count)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn readings_keep_their_rate_between_steps() {
        let count = |period_s, tick_ms: u64| {
            let mut schedule = Schedule::every(period_s);
            (1..=10_000 / tick_ms)
                .filter(|tick| schedule.due(Timestamp::from_millis(tick * tick_ms)).is_some())
                .count()
        };
        // The first reading is at the first step, the others at every whole second.
        assert_eq!(count(1.0, 100), 11);
        // On average there is a reading in two of five steps, although no step is at a quarter of a second.
        assert!((39..=41).contains(&count(0.25, 100)));
        assert_eq!(count(0.01, 100), 100);
        assert_eq!(count(0.1, 100), 100);
    }
}
