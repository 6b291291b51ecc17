use backseat_core::plugin::{LogLevel, LogLine};
use backseat_units::Timestamp;

/// How many log lines of a plugin are kept in a second. As many again may come in a burst.
pub(crate) const LINES_PER_S: u32 = 32;

/// Limits the log lines of one plugin over time: with a cap for each step only, a plugin that steps often could fill a
/// disk. Dropped lines are counted, and the count is logged as a line of its own, at most once a second.
#[derive(Debug)]
pub(crate) struct Lines {
    left: u32,
    refilled_s: u64,
    untold: u64,
    told_s: Option<u64>,
}

impl Default for Lines {
    fn default() -> Self {
        Self {
            left: 2 * LINES_PER_S,
            refilled_s: 0,
            untold: 0,
            told_s: None,
        }
    }
}

impl Lines {
    /// How many lines a step at this time may log.
    pub(crate) fn allowed(&mut self, now: Timestamp) -> usize {
        let second = now.as_nanos() / 1_000_000_000;
        let seconds = second.saturating_sub(self.refilled_s);
        let refill = u32::try_from(seconds).unwrap_or(u32::MAX).saturating_mul(LINES_PER_S);
        self.left = self.left.saturating_add(refill).min(2 * LINES_PER_S);
        self.refilled_s = self.refilled_s.max(second);
        self.left as usize
    }

    /// The lines to keep of a step, of which some more were dropped already. Adds a line with the count of dropped
    /// lines when one is due.
    pub(crate) fn keep(&mut self, now: Timestamp, (mut log, dropped): (Vec<LogLine>, u64)) -> Vec<LogLine> {
        self.left = self.left.saturating_sub(u32::try_from(log.len()).unwrap_or(u32::MAX));
        self.untold += dropped;
        let second = now.as_nanos() / 1_000_000_000;
        if self.untold > 0 && self.told_s.is_none_or(|told| second > told) {
            self.told_s = Some(second);
            log.push(counted(core::mem::take(&mut self.untold)));
        }
        log
    }
}

/// The lines of a start, which do not count against any second.
pub(crate) fn of_start((mut log, dropped): (Vec<LogLine>, u64)) -> Vec<LogLine> {
    if dropped > 0 {
        log.push(counted(dropped));
    }
    log
}

fn counted(lines: u64) -> LogLine {
    LogLine {
        level: LogLevel::Warn,
        text: format!("{lines} more lines were dropped"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_plugin_that_logs_in_every_step_fills_no_disk() {
        let mut lines = Lines::default();
        let (mut kept, mut told) = (0, 0);
        for step in 0..500u64 {
            let now = Timestamp::from_millis(20 * step);
            let allowed = lines.allowed(now).min(32);
            let log = vec![counted(0); allowed];
            let log = lines.keep(now, (log, 32 - allowed as u64));
            kept += allowed;
            told += log.len() - allowed;
        }
        assert!((320..=384).contains(&kept), "{kept} of 16,000 lines in 10 s");
        assert!((9..=11).contains(&told), "{told}");
    }

    #[test]
    fn one_that_logs_a_little_loses_nothing() {
        let mut lines = Lines::default();
        for step in 0..1000u64 {
            let now = Timestamp::from_millis(100 * step);
            assert!(lines.allowed(now) >= 3, "{step}");
            assert_eq!(lines.keep(now, (vec![counted(0); 3], 0)).len(), 3);
        }
    }
}
