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

    /// When one more is within `most` a minute; not before now.
    pub(crate) fn room_at(&mut self, now: Timestamp, most: u32) -> Timestamp {
        if self.has_room(now, most) {
            return now;
        }
        let over = self
            .at
            .len()
            .saturating_sub(usize::try_from(most).unwrap_or(usize::MAX));
        self.at.get(over).map_or(now, |at| *at + MINUTE)
    }

    /// Notes that it was done once more. A caller that asks [`LastMinute::has_room`] first keeps the limit.
    pub(crate) fn add(&mut self, now: Timestamp) {
        while self.at.front().is_some_and(|at| now.since(*at) >= MINUTE) {
            self.at.pop_front();
        }
        self.at.push_back(now);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_is_room_a_minute_after_the_oldest_that_counts() {
        let mut last = LastMinute::default();
        let at = Timestamp::from_secs;
        assert_eq!(last.room_at(at(5), 2), at(5));
        for second in [10, 20, 30] {
            last.add(at(second));
        }
        assert_eq!(last.room_at(at(31), 2), at(80));
        assert_eq!(last.room_at(at(31), 3), at(70));
        assert_eq!(last.room_at(at(31), 4), at(31));
    }

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
