//! Events with a quota: a controller that alternates or repeats itself must not fill the log.

use std::time::Duration;

use super::Sonar;
use crate::counts::Counts;
use crate::event::Event;
use crate::record::first;

/// How long a quota of events lasts, and how often counts are reported at most.
pub(super) const WINDOW: Duration = Duration::from_secs(10);
/// How many events of the controller's doing are reported in that time.
const QUOTA: u32 = 64;
/// How much of an error's text is reported, bytes.
const TEXT_BYTES: usize = 300;

/// What has been reported in this window.
#[derive(Debug, Default)]
pub(super) struct Report {
    used: u32,
    /// There were more, so the state was not reported as it is.
    over: bool,
    malformed: bool,
    counts: Counts,
}

impl Report {
    /// Whether the end of the window has something to do.
    pub(super) fn is_in_use(&self, counts: &Counts) -> bool {
        self.used > 0 || self.malformed || self.counts != *counts
    }
}

impl Sonar {
    /// Reports what the client itself does, or what has a rate of its own.
    pub(super) fn tell(&mut self, event: Event) {
        self.outbox.event(event, &mut self.counts);
    }

    /// Reports what the controller makes happen, up to the quota.
    pub(super) fn report(&mut self, event: Event) {
        if self.report.used >= QUOTA {
            self.report.over = true;
            self.counts.dropped_events += 1;
            return;
        }
        self.report.used += 1;
        self.tell(event);
    }

    /// Something cannot be read. The first one in a window is reported with its text.
    pub(super) fn malformed(&mut self, error: &dyn std::fmt::Display) {
        self.counts.malformed += 1;
        self.note_malformed(error);
    }

    pub(super) fn note_malformed(&mut self, error: &dyn std::fmt::Display) {
        if !self.report.malformed {
            self.report.malformed = true;
            let text = first(&error.to_string(), TEXT_BYTES);
            self.tell(Event::Malformed { text });
        }
    }

    /// The window is over: reports the counts if they have grown, and the state if events of it were dropped.
    pub(super) fn end_window(&mut self) {
        let over = self.report.over;
        let grown = self.report.counts != self.counts;
        self.report = Report {
            counts: self.counts,
            ..Report::default()
        };
        if grown {
            self.tell(Event::Counts { counts: self.counts });
        }
        if over {
            let alarms = self.alarms.active().cloned().collect();
            self.tell(Event::ActiveAlarms { alarms });
            if let Some(details) = self.logging.known().cloned() {
                let missing = self.logging.is_missing();
                self.tell(Event::Logging { details, missing });
            }
            if !self.health.is_empty() {
                let sensors = self.health.clone();
                self.tell(Event::Health { sensors });
            }
        }
    }
}
