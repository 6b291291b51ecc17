use std::time::Duration;

use crate::moment::Moment;

/// The runtime's process: what it can have heard, and when.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Process {
    stopped: Option<Moment>,
    /// The connection has changed since the process was stopped.
    reconnected: bool,
    /// When the process was stopped, a lease of its own was alive on this connection.
    steered: bool,
    /// When the process last continued: it has heard then what the vehicle sent while it was stopped.
    woken: Moment,
    slept: Duration,
}

impl Process {
    /// The process is stopped. `steers` is true if a lease of its own is alive.
    pub(crate) fn stopped(&mut self, at: Moment, steers: bool) {
        if self.stopped.is_none() {
            self.stopped = Some(at);
            self.steered = steers;
            self.reconnected = false;
        }
    }

    /// The link went down or came up.
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

    /// A new process begins, with no lease of its own.
    pub(crate) fn begins(&mut self, at: Moment) {
        *self = Self {
            woken: at,
            ..Self::default()
        };
    }

    /// For how long the process was stopped with a lease of this connection. Returns it once, then zero.
    pub(crate) fn slept(&mut self) -> Duration {
        core::mem::take(&mut self.slept)
    }

    /// The time before which the process has certainly heard everything, if hearing takes `sure` at most.
    pub(crate) fn heard_until(&self, now: Moment, sure: Duration) -> Moment {
        if self.woken + sure <= now {
            now - sure
        } else {
            Moment::ZERO
        }
    }

    /// When the runtime could hear what the vehicle sent at a time.
    pub(crate) fn heard(&self, said: Moment) -> Moment {
        said.max(self.woken)
    }
}
