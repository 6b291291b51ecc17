use std::collections::VecDeque;
use std::time::Duration;

use backseat_units::Timestamp;

use crate::mutations::{Check, is_on};

const MINUTE: Duration = Duration::from_secs(60);

/// When something was done in the last minute, for a limit that holds in every span of one minute (safety requirement
/// 019).
#[derive(Debug, Default)]
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub(crate) struct LastMinute {
    at: VecDeque<Timestamp>,
}

impl LastMinute {
    /// Whether one more is within `most` a minute.
    pub(crate) fn has_room(&mut self, now: Timestamp, most: u32) -> bool {
        while self.at.front().is_some_and(|at| now.since(*at) >= MINUTE) {
            self.at.pop_front();
        }
        u32::try_from(self.at.len()).is_ok_and(|count| count < most) || !is_on(Check::MinuteRate)
    }

    /// Notes that it was done once more. A caller that asks [`LastMinute::has_room`] first keeps the limit.
    pub(crate) fn add(&mut self, now: Timestamp) {
        self.at.push_back(now);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_minute_holds_more_than_the_limit() {
        let mut last = LastMinute::default();
        let mut done = Vec::new();
        for second in 0..300 {
            let now = Timestamp::from_secs(second);
            if last.has_room(now, 3) {
                last.add(now);
                done.push(second);
            }
        }
        assert_eq!(done, [0, 1, 2, 60, 61, 62, 120, 121, 122, 180, 181, 182, 240, 241, 242]);
        assert!(!LastMinute::default().has_room(Timestamp::ZERO, 0));
    }
}
