use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use tokio::sync::mpsc::{Receiver, Sender, channel, error::TrySendError};
use tokio::time::Instant;

/// Acts that may wait for the loop.
const WAITING_MAX: usize = 16;
/// A release is taken at most this often.
const RELEASED_EVERY: Duration = Duration::from_secs(1);

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

/// Why an act was not taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub(crate) enum NotAsked {
    /// Each release and the hold before it are news for every plugin: somebody who clicks fast, or several who contradict
    /// each other, would have them work through all of it before they steer again.
    #[error("a release was asked for less than a second ago: ask again")]
    Soon,
    #[error("{WAITING_MAX} acts wait for the run already: ask again")]
    Full,
    #[error("the run has ended")]
    Ended,
}

/// The console's end of the queue to the loop.
#[derive(Clone, Debug)]
pub(crate) struct Desk {
    queue: Sender<Asked>,
    /// When a release was taken last.
    released: Arc<Mutex<Option<Instant>>>,
}

impl Desk {
    pub(crate) fn new() -> (Self, Receiver<Asked>) {
        let (queue, receiver) = channel(WAITING_MAX);
        let released = Arc::default();
        (Self { queue, released }, receiver)
    }

    /// Asks the loop. A hold is taken at any time, a release once a second.
    pub(crate) fn ask(&self, asked: Asked, now: Instant) -> Result<(), NotAsked> {
        let mut released = self.released.lock().unwrap_or_else(PoisonError::into_inner);
        let is_release = asked.act == Act::Release;
        if is_release && released.is_some_and(|then| now.duration_since(then) < RELEASED_EVERY) {
            return Err(NotAsked::Soon);
        }
        self.queue.try_send(asked).map_err(|unsent| match unsent {
            TrySendError::Full(_) => NotAsked::Full,
            TrySendError::Closed(_) => NotAsked::Ended,
        })?;
        if is_release {
            *released = Some(now);
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn asked(act: Act) -> Asked {
        let who = "Ann".to_owned();
        Asked { act, who }
    }

    #[test]
    fn a_hold_is_taken_at_any_time_and_a_release_once_a_second() {
        let (desk, mut acts) = Desk::new();
        let begun = Instant::now();
        let after = |ms| begun + Duration::from_millis(ms);
        assert_eq!(desk.ask(asked(Act::Release), begun), Ok(()));
        assert_eq!(desk.ask(asked(Act::Hold), after(1)), Ok(()));
        assert_eq!(desk.ask(asked(Act::Release), after(999)), Err(NotAsked::Soon));
        assert_eq!(desk.ask(asked(Act::Hold), after(999)), Ok(()));
        assert_eq!(desk.ask(asked(Act::Release), after(1000)), Ok(()));
        let mut taken = Vec::new();
        while let Ok(asked) = acts.try_recv() {
            taken.push(asked.act);
        }
        assert_eq!(taken, [Act::Release, Act::Hold, Act::Hold, Act::Release]);
    }

    #[test]
    fn an_act_that_is_not_taken_is_told_with_the_true_reason() {
        let (desk, acts) = Desk::new();
        let now = Instant::now();
        for _ in 0..WAITING_MAX {
            assert_eq!(desk.ask(asked(Act::Hold), now), Ok(()));
        }
        assert_eq!(desk.ask(asked(Act::Hold), now), Err(NotAsked::Full));
        // A release that was not taken does not count.
        assert_eq!(desk.ask(asked(Act::Release), now), Err(NotAsked::Full));
        drop(acts);
        assert_eq!(desk.ask(asked(Act::Release), now), Err(NotAsked::Ended));
        assert_eq!(
            NotAsked::Full.to_string(),
            "16 acts wait for the run already: ask again"
        );
    }
}
