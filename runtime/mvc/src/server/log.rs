use std::collections::VecDeque;

use backseat_units::Timestamp;

use crate::event::{MvcEvent, MvcEventKind};

/// How many events may wait until the driver fetches them.
const EVENTS_MAX: usize = 10_000;

/// The events of the vehicle's log that the driver has not fetched yet.
#[derive(Debug, Default)]
pub(super) struct Log {
    events: VecDeque<MvcEvent>,
    lost: u64,
}

impl Log {
    pub(super) fn note(&mut self, at: Timestamp, kind: MvcEventKind) {
        if self.events.len() < EVENTS_MAX {
            self.events.push_back(MvcEvent { at, kind });
        } else {
            self.lost += 1;
        }
    }

    /// The next line. After the lines that were kept comes a line, with the time `at`, that says how many were lost.
    pub(super) fn poll(&mut self, at: Timestamp) -> Option<MvcEvent> {
        if self.events.is_empty() && self.lost > 0 {
            let lost = core::mem::take(&mut self.lost);
            return Some(MvcEvent {
                at,
                kind: MvcEventKind::EventsLost(lost),
            });
        }
        self.events.pop_front()
    }
}
