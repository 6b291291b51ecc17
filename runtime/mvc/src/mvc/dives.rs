use backseat_units::Timestamp;

use super::Mvc;
use crate::error::DiveError;

/// What an operator does at the vehicle's own computer. SPI has no sentence for it; clients hear of it through BFMIS
/// (SPI 6.11). Each call takes `now` as every input does, and does first what is due by then. A call that is refused
/// changes nothing.
impl Mvc {
    /// The names of the dive files on the vehicle, in the order of `world.toml`: those of its `[[dive]]` tables, or
    /// without any that of `[mission]`.
    pub fn dives(&self) -> impl Iterator<Item = &str> {
        self.mission.dives()
    }

    /// Loads the dive with this name (`dive.file`), in place of one that is ready or over. BFMIS then says `Ready`, or
    /// `Invalid Dive File` or `Invalid Wrapup File` for a dive with such a file. The dive starts by its own
    /// `start_after_s`, if it has one, or when [`Mvc::start_dive`] starts it. The dive of `[mission]` starts by itself
    /// only once in a run.
    ///
    /// If it is the dive that would have been loaded next without an operator, that one is not loaded again.
    ///
    /// # Errors
    /// [`DiveError`] in one line if there is no such dive, or if the vehicle is offline or flies a mission.
    pub fn load_dive(&mut self, now: Timestamp, file: &str) -> Result<(), DiveError> {
        self.handle_timeout(now);
        let mut parts = self.parts(now);
        let loaded = parts.mission.load_dive(&mut parts.ctx, file);
        self.settle(now);
        loaded
    }

    /// Starts the dive that is ready.
    ///
    /// # Errors
    /// [`DiveError`] in one line if none is ready.
    pub fn start_dive(&mut self, now: Timestamp) -> Result<(), DiveError> {
        self.handle_timeout(now);
        let mut parts = self.parts(now);
        let started = parts.mission.start_dive(&mut parts.ctx);
        self.settle(now);
        started
    }

    /// Ends the dive that runs as successful: its wrapup begins, if it has one, and BFMIS says `Completed` at the end.
    ///
    /// # Errors
    /// [`DiveError`] in one line if none runs.
    pub fn end_dive(&mut self, now: Timestamp) -> Result<(), DiveError> {
        self.handle_timeout(now);
        let mut parts = self.parts(now);
        let ended = parts.mission.end_dive(&mut parts.ctx);
        self.settle(now);
        ended
    }

    /// Aborts the dive that runs: its wrapup begins, if it has one, and BFMIS says `Aborted` at the end. Also takes back
    /// a dive that is ready, and cuts short a wrapup.
    ///
    /// # Errors
    /// [`DiveError`] in one line if there is nothing to abort.
    pub fn abort_dive(&mut self, now: Timestamp) -> Result<(), DiveError> {
        self.handle_timeout(now);
        let mut parts = self.parts(now);
        let aborted = parts.mission.abort_dive(&mut parts.ctx);
        self.settle(now);
        aborted
    }
}
