use std::time::Duration;

use backseat_units::Timestamp;

use crate::session::commands::Commands;
use crate::session::heartbeat::Heartbeat;
use crate::session::reads::Reads;
use crate::session::subscriptions::Subscriptions;

/// What we know of the connection: whether it is up, which commands wait for an answer, and whether the vehicle hears
/// us.
#[derive(Debug)]
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub(crate) struct Link {
    up: bool,
    pub(crate) commands: Commands,
    pub(crate) heartbeat: Heartbeat,
    pub(crate) subscriptions: Subscriptions,
    reads: Reads,
    /// A request waits until the vehicle answers anything: a beat is due early.
    pub(crate) wants_beat: bool,
}

impl Link {
    pub(crate) fn new(subscriptions: Subscriptions, delay_max: Duration) -> Self {
        Self {
            up: false,
            commands: Commands::default(),
            heartbeat: Heartbeat::new(delay_max),
            subscriptions,
            reads: Reads::default(),
            wants_beat: false,
        }
    }

    pub(crate) const fn is_up(&self) -> bool {
        self.up
    }

    /// A new connection: nothing is subscribed on it, and no command waits for an answer.
    pub(crate) fn begin(&mut self, now: Timestamp) {
        self.up = true;
        self.commands.clear();
        self.subscriptions.begin();
        self.heartbeat.begin(now);
        self.reads.begin(now);
    }

    /// The connection is gone: no answer will come.
    pub(crate) const fn end(&mut self) {
        self.up = false;
    }

    /// Bytes have been read.
    pub(crate) fn read(&mut self, now: Timestamp) {
        self.reads.read(now);
    }

    /// The longest time for which the bytes that are read now can have waited.
    pub(crate) fn waited(&self) -> Duration {
        self.reads.waited()
    }
}
