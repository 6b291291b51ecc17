use backseat_units::Timestamp;

/// The runtime's process: what it could have heard, and when.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Process {
    stopped: Option<Timestamp>,
    /// When it last went on: what was said while it was stopped it has heard then.
    woken: Timestamp,
}

impl Process {
    pub(crate) fn stopped(&mut self, at: Timestamp) {
        self.stopped.get_or_insert(at);
    }

    pub(crate) const fn is_stopped(&self) -> bool {
        self.stopped.is_some()
    }

    pub(crate) fn goes_on(&mut self, at: Timestamp) {
        if self.stopped.take().is_some() {
            self.woken = at;
        }
    }

    /// When the runtime could hear what was said at a time.
    pub(crate) fn heard(&self, said: Timestamp) -> Timestamp {
        said.max(self.woken)
    }
}
