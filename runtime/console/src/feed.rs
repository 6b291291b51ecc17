use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};

use backseat_units::Timestamp;

/// How the inputs of core begin of which the console makes something.
const RETURNED: &[u8] = br#"{"input":"returned""#;
const START: &[u8] = br#"{"input":"start""#;
const LINK: &[u8] = br#"{"input":"link"#;
pub(crate) const PING: &[u8] = br#"{"input":"sonar","report":"ping""#;
pub(crate) const SONAR_EVENT: &[u8] = br#"{"input":"sonar","report":"event""#;

/// Messages that may wait for the console: some seconds of a busy run.
const WAITING_MAX: usize = 8192;

/// A message of a log's channel.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Told {
    /// The run's time.
    pub now: Timestamp,
    /// The channel's topic.
    pub topic: String,
    /// The message, as the log has it.
    pub data: Vec<u8>,
}

impl Told {
    fn new(now: Timestamp, topic: &str, data: &[u8]) -> Self {
        Self {
            now,
            topic: topic.to_owned(),
            data: data.to_vec(),
        }
    }
}

/// The loop's end of the queue to the console.
#[derive(Clone, Debug)]
pub struct Feed {
    queue: SyncSender<Told>,
    lost: Arc<AtomicU64>,
}

/// The console's end.
#[derive(Debug)]
pub(crate) struct Heard {
    pub(crate) queue: Receiver<Told>,
    pub(crate) lost: Arc<AtomicU64>,
}

impl Feed {
    pub(crate) fn new() -> (Self, Heard) {
        let (queue, heard) = sync_channel(WAITING_MAX);
        let lost = Arc::new(AtomicU64::new(0));
        let feed = Self {
            queue,
            lost: Arc::clone(&lost),
        };
        (feed, Heard { queue: heard, lost })
    }

    /// Tells the console of a message, and waits for room: for a simulation, which is not to be shown with gaps.
    pub fn wait(&self, now: Timestamp, topic: &str, data: &[u8]) {
        if wants(topic, data) {
            // The console has ended, and nobody misses it.
            drop(self.queue.send(Told::new(now, topic, data)));
        }
    }

    /// Tells the console of a message, if it wants any of this topic. This never waits: a message that finds no room is
    /// left out and counted.
    pub fn tell(&self, now: Timestamp, topic: &str, data: &[u8]) {
        if !wants(topic, data) {
            return;
        }
        match self.queue.try_send(Told::new(now, topic, data)) {
            Ok(()) => {}
            Err(TrySendError::Full(_)) => {
                self.lost.fetch_add(1, Ordering::Relaxed);
            }
            // The console has ended, and nobody misses it.
            Err(TrySendError::Disconnected(_)) => {}
        }
    }
}

/// Whether the console makes anything of a message.
#[must_use]
pub fn wants(topic: &str, data: &[u8]) -> bool {
    match topic {
        "/link/from_vehicle" | "/link/to_vehicle" | "/notes" | "/requests" | "/control" | "/navigation" | "/truth"
        | "/log" | "/recording" | "/map/plan" | "/map/reach" | "/map/inserts" | "/map/requests" => true,
        "/core/input" => [RETURNED, START, LINK, PING, SONAR_EVENT]
            .iter()
            .any(|begins| data.starts_with(begins)),
        other => other.starts_with("/measures/") || other.starts_with("/sensors/"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_console_that_does_not_read_costs_messages_and_no_time() {
        let (feed, heard) = Feed::new();
        for _ in 0..WAITING_MAX + 5 {
            feed.tell(Timestamp::ZERO, "/control", b"{}");
        }
        feed.tell(Timestamp::ZERO, "/core/output", b"{}");
        assert_eq!(heard.lost.load(Ordering::Relaxed), 5);
        assert_eq!(heard.queue.try_iter().count(), WAITING_MAX);
        drop(heard);
        feed.tell(Timestamp::ZERO, "/control", b"{}");
    }
}
