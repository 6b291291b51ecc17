//! How many log lines or published values of a plugin are kept over time.

use backseat_core::plugin::{LogLevel, LogLine};
use backseat_units::Timestamp;

/// So many a second, with a burst of twice as many: with a cap for each step only, a plugin that steps often could fill
/// a disk. What was dropped is counted, and the count is told at most once a second.
#[derive(Debug)]
pub(crate) struct Allowance {
    per_s: u32,
    left: u32,
    refilled_s: u64,
    untold: u64,
    told_s: Option<u64>,
}

impl Allowance {
    pub(crate) const fn per_s(per_s: u32) -> Self {
        Self {
            per_s,
            left: 2 * per_s,
            refilled_s: 0,
            untold: 0,
            told_s: None,
        }
    }

    /// How many are left at this time.
    pub(crate) fn left(&mut self, now: Timestamp) -> usize {
        let second = now.as_nanos() / 1_000_000_000;
        let seconds = second.saturating_sub(self.refilled_s);
        let refill = u32::try_from(seconds).unwrap_or(u32::MAX).saturating_mul(self.per_s);
        self.left = self.left.saturating_add(refill).min(2 * self.per_s);
        self.refilled_s = self.refilled_s.max(second);
        self.left as usize
    }

    /// Takes what was kept of a step, and counts what was dropped. Returns the count of all that were dropped since it
    /// was told last, when it is due.
    pub(crate) fn take(&mut self, now: Timestamp, kept: usize, dropped: u64) -> Option<u64> {
        self.left = self.left.saturating_sub(u32::try_from(kept).unwrap_or(u32::MAX));
        self.untold += dropped;
        let second = now.as_nanos() / 1_000_000_000;
        if self.untold == 0 || self.told_s.is_some_and(|told| second <= told) {
            return None;
        }
        self.told_s = Some(second);
        Some(core::mem::take(&mut self.untold))
    }
}

/// A line of the host's own among the plugin's.
pub(crate) fn warning(text: String) -> LogLine {
    LogLine {
        level: LogLevel::Warn,
        text,
    }
}
