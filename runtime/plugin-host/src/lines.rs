use backseat_core::plugin::LogLine;
use backseat_units::Timestamp;

use crate::allowance::{Allowance, warning};

/// How many log lines of a plugin are kept in a second. As many again may come in a burst.
pub(crate) const LINES_PER_S: u32 = 32;

/// Limits the log lines of one plugin over time. The count of dropped lines is logged as a line of its own.
#[derive(Debug)]
pub(crate) struct Lines(Allowance);

impl Default for Lines {
    fn default() -> Self {
        Self(Allowance::per_s(LINES_PER_S))
    }
}

impl Lines {
    /// How many lines a step at this time may log.
    pub(crate) fn allowed(&mut self, now: Timestamp) -> usize {
        self.0.left(now)
    }

    /// The lines to keep of a step, of which some more were dropped already. Adds a line with the count of dropped
    /// lines when one is due.
    pub(crate) fn keep(&mut self, now: Timestamp, (mut log, dropped): (Vec<LogLine>, u64)) -> Vec<LogLine> {
        log.extend(self.0.take(now, log.len(), dropped).map(counted));
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
    warning(format!("{lines} more lines were dropped"))
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
