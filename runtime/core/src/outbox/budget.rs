use std::time::Duration;

use backseat_units::Timestamp;

/// How many lines about one source are logged in a second; twice as many may come at once.
const LINES_PER_S: u32 = 20;

/// Limits the log lines about one source to so many a second, and counts the rest (safety requirement 022). Neither
/// what a peer says nor what a plugin is refused may fill the log.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
pub(crate) struct LineBudget {
    per_s: u32,
    left: u32,
    refilled: Timestamp,
    untold: u64,
}

impl Default for LineBudget {
    fn default() -> Self {
        Self::of(LINES_PER_S)
    }
}

impl LineBudget {
    pub(crate) const fn of(per_s: u32) -> Self {
        Self {
            per_s,
            left: 2 * per_s,
            refilled: Timestamp::ZERO,
            untold: 0,
        }
    }

    /// Whether one more line is logged now; otherwise it is counted.
    pub(crate) fn take(&mut self, now: Timestamp) -> bool {
        let seconds = now.since(self.refilled).as_secs();
        if seconds > 0 {
            let refill = u32::try_from(seconds).unwrap_or(u32::MAX).saturating_mul(self.per_s);
            self.left = self.left.saturating_add(refill).min(2 * self.per_s);
            self.refilled = self.refilled + Duration::from_secs(seconds);
        }
        let told = self.left > 0;
        if told {
            self.left -= 1;
        } else {
            self.untold += 1;
        }
        told
    }

    /// How many lines were only counted since the last call.
    pub(crate) fn take_dropped(&mut self) -> u64 {
        core::mem::take(&mut self.untold)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_flood_is_logged_in_part_and_the_rest_is_counted() {
        let mut budget = LineBudget::default();
        let mut told = 0;
        for millis in 0..10_000 {
            told += u64::from(budget.take(Timestamp::from_millis(millis)));
        }
        assert!((200..=240).contains(&told), "{told}");
        assert_eq!(budget.take_dropped(), 10_000 - told);
        assert_eq!(budget.take_dropped(), 0);
        let slow = (0..100).all(|second| budget.take(Timestamp::from_secs(20 + second)));
        assert!(slow, "a line a second is always logged");
    }
}
