use backseat_spi::Text;
use backseat_units::{EastNorth, Timestamp};

use super::Executive;
use super::dives::{ABORTED, ENDED, LoadableDive};
use crate::event::mission::MissionEvent;
use crate::event::{MvcEventKind, Status};
use crate::file::InvalidFile;
use crate::vehicle::Vertical;

/// Loads a dive, starts it, and calls it off at its time.
impl Executive {
    /// Loads a dive in place of the one before, of which nothing stays. It is ready, unless one of its files is invalid.
    pub(crate) fn load(&mut self, dive: LoadableDive, at: Timestamp) {
        self.limits.wrap_up = dive.wrap_up;
        (self.index, self.element, self.empty) = (0, 0, false);
        self.cruise = (Vertical::Depth(0.0), self.performance.speed_max_mps / 2.0);
        self.used.clear();
        self.modify_refused = None;
        (self.ends_at, self.called_off_at) = (None, None);
        self.called_off = dive.called_off;
        self.starts_at = dive.start_after.map(|after| at + after);
        self.log
            .push(MvcEventKind::Executive(MissionEvent::DiveLoaded(dive.file)));
        let (status, details) = match dive.invalid {
            None => (Status::Ready, ""),
            Some(InvalidFile::Dive) => (Status::InvalidDiveFile, "the dive file cannot be read"),
            Some(InvalidFile::Wrapup) => (Status::InvalidWrapupFile, "the wrapup file cannot be read"),
        };
        self.plan = if dive.invalid.is_some() { Vec::new() } else { dive.plan };
        self.details = Text::cleaned(details);
        self.set_status(status, details);
    }

    /// Starts the dive that is ready. Its times count from `at`.
    pub(crate) fn start(&mut self, at: Timestamp, now: Timestamp, place: EastNorth) {
        self.released = true;
        self.starts_at = None;
        self.ends_at = self.limits.time_limit.map(|limit| at + limit);
        self.called_off_at = self.called_off.map(|(after, _)| at + after);
        self.set_status(Status::Running, "");
        self.begin_planned(0, now, place);
    }

    /// The operator ends or aborts the dive, if the time for that has come.
    pub(super) fn call_off(&mut self, now: Timestamp) {
        let due = self.is_running() && self.called_off_at.is_some_and(|at| now >= at);
        if due && let Some((_, abort)) = self.called_off {
            self.end_mission(abort, if abort { ABORTED } else { ENDED });
        }
    }
}
