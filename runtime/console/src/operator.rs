use std::sync::Arc;

use tokio::sync::mpsc::{Receiver, Sender, channel, error::TrySendError};

/// Acts that may wait for the loop.
const WAITING_MAX: usize = 16;

/// What somebody at the console asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Act {
    /// Nothing that steers is sent until the release.
    Hold,
    /// Plugins may steer again.
    Release,
}

/// An act, and whose.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Asked {
    /// The act.
    pub act: Act,
    /// The name that the person gave.
    pub who: String,
}

/// The console's end of the queue to the loop.
#[derive(Clone, Debug)]
pub(crate) struct Desk(Arc<Sender<Asked>>);

impl Desk {
    pub(crate) fn new() -> (Self, Receiver<Asked>) {
        let (sender, receiver) = channel(WAITING_MAX);
        (Self(Arc::new(sender)), receiver)
    }

    /// Asks the loop; false if it has ended or has too much to do.
    pub(crate) fn ask(&self, asked: Asked) -> bool {
        match self.0.try_send(asked) {
            Ok(()) => true,
            Err(TrySendError::Full(_) | TrySendError::Closed(_)) => false,
        }
    }
}
