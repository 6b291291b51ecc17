use std::time::Duration;

use backseat_units::Timestamp;

/// Passes the first message of each period, counted from time zero: the first of each second, not one a second after
/// another, so that channels stay in step.
pub(crate) struct Decimation {
    period: Duration,
    next: Timestamp,
}

impl Decimation {
    pub(crate) const fn new(period: Duration) -> Self {
        Self {
            period,
            next: Timestamp::ZERO,
        }
    }

    pub(crate) fn is_due(&self, now: Timestamp) -> bool {
        now >= self.next
    }

    pub(crate) fn take(&mut self, now: Timestamp) -> bool {
        if !self.is_due(now) {
            return false;
        }
        if !self.period.is_zero() {
            let period_ns = u64::try_from(self.period.as_nanos()).unwrap_or(u64::MAX);
            let begun = Timestamp::from_nanos(now.as_nanos() / period_ns * period_ns);
            self.next = begun + self.period;
        }
        true
    }
}
