use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use backseat_units::Timestamp;
use tokio::sync::mpsc::error::TrySendError;
use tokio::sync::mpsc::{Receiver, Sender, channel};

/// How many messages may wait for the thread that serves them: some seconds of a run.
const WAITING: usize = 4096;

/// A message of the log.
#[derive(Debug)]
pub(crate) struct Told {
    pub(crate) now: Timestamp,
    pub(crate) topic: String,
    pub(crate) data: Vec<u8>,
}

/// The run's end. When the last clone is dropped, the server ends.
#[derive(Clone, Debug)]
pub struct Feed {
    queue: Sender<Told>,
    lost: Arc<AtomicU64>,
}

impl Feed {
    pub(crate) fn new() -> (Self, Receiver<Told>) {
        let (queue, heard) = channel(WAITING);
        let lost = Arc::default();
        (Self { queue, lost }, heard)
    }

    /// Tells viewers of a message of the log. This never waits: a message that finds no room is left out and counted.
    pub fn tell(&self, now: Timestamp, topic: &str, data: &[u8]) {
        let told = Told {
            now,
            topic: topic.to_owned(),
            data: data.to_vec(),
        };
        match self.queue.try_send(told) {
            Ok(()) => {}
            Err(TrySendError::Full(_)) => {
                self.lost.fetch_add(1, Ordering::Relaxed);
            }
            // The thread has ended, and nobody misses it.
            Err(TrySendError::Closed(_)) => {}
        }
    }

    /// How many messages found no room.
    #[must_use]
    pub fn lost(&self) -> u64 {
        self.lost.load(Ordering::Relaxed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_server_that_does_not_read_costs_messages_and_no_time() {
        let (feed, heard) = Feed::new();
        for _ in 0..WAITING + 7 {
            feed.tell(Timestamp::ZERO, "/control", b"{}");
        }
        assert_eq!(feed.lost(), 7);
        drop(heard);
        feed.tell(Timestamp::ZERO, "/control", b"{}");
        assert_eq!(feed.lost(), 7);
    }
}
