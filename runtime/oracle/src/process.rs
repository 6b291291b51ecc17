use std::time::Duration;

use crate::moment::Moment;

/// The runtime's process: what it could have heard, and when.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Process {
    stopped: Option<Moment>,
    /// The connection is another one than when it was stopped.
    reconnected: bool,
    /// When it was stopped, a lease of its own was alive on this connection.
    steered: bool,
    /// When it last went on: what was said while it was stopped it has heard then.
    woken: Moment,
    slept: Duration,
}

impl Process {
    /// It stands still. `steers` where a lease of its own is alive.
    pub(crate) fn stopped(&mut self, at: Moment, steers: bool) {
        if self.stopped.is_none() {
            self.stopped = Some(at);
            self.steered = steers;
            self.reconnected = false;
        }
    }

    /// The link was lost or made.
    pub(crate) fn link_changed(&mut self) {
        self.reconnected = true;
        self.slept = Duration::ZERO;
    }

    pub(crate) const fn is_stopped(&self) -> bool {
        self.stopped.is_some()
    }

    pub(crate) fn goes_on(&mut self, at: Moment) {
        if let Some(stopped) = self.stopped.take() {
            self.woken = at;
            if self.steered && !self.reconnected {
                self.slept = at.since(stopped);
            }
        }
    }

    /// A new process begins: it has left nothing behind.
    pub(crate) fn begins(&mut self, at: Moment) {
        *self = Self {
            woken: at,
            ..Self::default()
        };
    }

    /// For how long it stood still with a lease of this connection, once.
    pub(crate) fn slept(&mut self) -> Duration {
        core::mem::take(&mut self.slept)
    }

    /// Until when what was said has been heard for sure, where that takes `sure` at most.
    pub(crate) fn heard_until(&self, now: Moment, sure: Duration) -> Moment {
        if self.woken + sure <= now {
            now - sure
        } else {
            Moment::ZERO
        }
    }

    /// When the runtime could hear what was said at a time.
    pub(crate) fn heard(&self, said: Moment) -> Moment {
        said.max(self.woken)
    }
}
