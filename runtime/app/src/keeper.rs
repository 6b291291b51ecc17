//! Writes state to disk for the loop, on a thread of its own (safety requirement 022). Identifiers are reserved on disk
//! before they are sent, and the operator's hold outlives the process, but the loop waits for neither.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use anyhow::Result;
use backseat_core::{Operator, Reservation};
use tokio::sync::mpsc::UnboundedSender;

use crate::aside;
use crate::state::{HoldWatch, Seen, State};

/// How often the thread checks whether the operator has created or deleted the hold's file.
const LOOK_EVERY: Duration = Duration::from_secs(1);
/// How long the end of a run waits for the last writes.
const FAREWELL: Duration = Duration::from_millis(500);

/// The result of a request to the keeper, or an act of the operator.
#[derive(Debug)]
pub(crate) enum Kept {
    /// This reservation is on disk.
    Reserved(Reservation),
    /// The reservation could not be written, and why.
    NotReserved(anyhow::Error),
    /// The operator's act is on disk and outlives the process.
    Held,
    /// The operator's act could not be written and lasts for this run only, and why.
    NotHeld(anyhow::Error),
    /// The operator has created or deleted the hold's file.
    Act(Operator),
    /// Nobody can tell whether the hold's file exists, and why: a hold.
    Blind(String),
    /// Nothing is written any more: the thread has panicked.
    Gone,
}

/// The loop's side: it requests writes, and receives the results as [`Kept`].
#[derive(Debug)]
pub(crate) struct Keeper {
    shared: Arc<Shared>,
}

#[derive(Debug, Default)]
struct Shared {
    wanted: Mutex<Wanted>,
    changed: Condvar,
}

/// What is still to be written. Only the latest request of each kind is kept, so that frequent requests use no more
/// memory.
#[derive(Debug, Default)]
struct Wanted {
    held: Option<bool>,
    reserve: Option<Reservation>,
    /// Write everything once more and then end.
    end: bool,
    ended: bool,
    /// The thread has panicked.
    gone: bool,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Wanted> {
        self.wanted.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn want(&self, change: impl FnOnce(&mut Wanted)) {
        change(&mut self.lock());
        self.changed.notify_all();
    }
}

impl Keeper {
    /// Starts the thread that writes state and watches the hold's file.
    pub(crate) fn start(state: State, held: bool, kept: UnboundedSender<Kept>) -> Result<Self> {
        Self::serving(kept, move |shared, kept| {
            serve(&state, HoldWatch::new(held), shared, kept)
        })
    }

    /// Starts a thread that runs this function.
    fn serving(
        kept: UnboundedSender<Kept>,
        serve: impl FnOnce(&Shared, &UnboundedSender<Kept>) + Send + 'static,
    ) -> Result<Self> {
        let shared = Arc::new(Shared::default());
        let theirs = Arc::clone(&shared);
        aside::spawn("state", move || {
            // The closure owns the state, so the folder's lock is released before anyone learns that the thread has
            // ended.
            let served = catch_unwind(AssertUnwindSafe(|| serve(&theirs, &kept)));
            if served.is_err() {
                // The loop may have ended already and needs no message then.
                let _gone = kept.send(Kept::Gone);
            }
            theirs.want(|wanted| match served {
                Ok(()) => wanted.ended = true,
                Err(_) => wanted.gone = true,
            });
        })?;
        Ok(Self { shared })
    }

    /// A keeper whose thread panics at once.
    #[cfg(test)]
    pub(crate) fn panicking(kept: UnboundedSender<Kept>) -> Result<Self> {
        Self::serving(kept, |_, _| panic!("the test makes the keeper panic"))
    }

    /// Requests that this be reserved; [`Kept::Reserved`] reports when it is on disk.
    pub(crate) fn reserve(&self, reservation: Reservation) {
        self.shared.want(|wanted| wanted.reserve = Some(reservation));
    }

    /// Requests that the hold outlive the process, or that it no longer does.
    pub(crate) fn hold(&self, held: bool) {
        self.shared.want(|wanted| wanted.held = Some(held));
    }

    /// Records only the identifiers that were used, so that a restart costs the mission no insert. Waits for all
    /// writes, at most [`FAREWELL`], and returns whether they are done.
    pub(crate) fn finish(self, used: Option<Reservation>) -> bool {
        self.shared.want(|wanted| {
            wanted.reserve = used.or(wanted.reserve);
            wanted.end = true;
        });
        let wanted = self.shared.lock();
        let waited = self
            .shared
            .changed
            .wait_timeout_while(wanted, FAREWELL, |wanted| !wanted.ended && !wanted.gone);
        waited.unwrap_or_else(PoisonError::into_inner).0.ended
    }
}

fn serve(state: &State, mut watch: HoldWatch, shared: &Shared, kept: &UnboundedSender<Kept>) {
    // The loop may have ended already and needs no message then.
    let tell = |what: Kept| drop(kept.send(what));
    loop {
        let (held, reserve, end) = {
            let idle = |wanted: &mut Wanted| wanted.held.is_none() && wanted.reserve.is_none() && !wanted.end;
            let waited = shared.changed.wait_timeout_while(shared.lock(), LOOK_EVERY, idle);
            let mut wanted = waited.unwrap_or_else(PoisonError::into_inner).0;
            (wanted.held.take(), wanted.reserve.take(), wanted.end)
        };
        // The hold comes first, because a person waits for it.
        if let Some(held) = held {
            let result = state.set_held(held);
            watch.follow(state, held);
            tell(match result {
                Ok(()) => Kept::Held,
                Err(error) => Kept::NotHeld(error),
            });
        } else if let Some(seen) = watch.look(state) {
            tell(match seen {
                Seen::Act(act) => Kept::Act(act),
                Seen::Blind(why) => Kept::Blind(why),
            });
        }
        if let Some(reservation) = reserve {
            tell(match state.reserve(&reservation) {
                Ok(()) => Kept::Reserved(reservation),
                Err(error) => Kept::NotReserved(error),
            });
        }
        if end {
            return;
        }
    }
}

#[cfg(test)]
mod tests {
    use std::process::Command;

    use backseat_core::Identifiers;
    use tokio::sync::mpsc::unbounded_channel;

    use super::*;

    fn reservation(below: u32) -> Reservation {
        Reservation {
            below,
            inserts: 0,
            gps_hits: 0,
        }
    }

    #[test]
    fn what_is_asked_is_kept_and_what_was_used_is_kept_last() {
        let folder = tempfile::tempdir().unwrap();
        let state = State::open(folder.path(), None).unwrap();
        let identifiers = state.identifiers(Some(1)).unwrap().unwrap();
        state.begin_record(&identifiers).unwrap();
        let (sender, mut kept) = unbounded_channel();
        let keeper = Keeper::start(state, false, sender).unwrap();
        keeper.reserve(reservation(65));
        keeper.hold(true);
        let told: Vec<Kept> = std::iter::from_fn(|| kept.blocking_recv()).take(2).collect();
        assert!(told.iter().any(|kept| matches!(kept, Kept::Held)), "{told:?}");
        assert!(
            told.iter()
                .any(|kept| matches!(kept, Kept::Reserved(kept) if kept.below == 65)),
            "{told:?}"
        );
        assert!(keeper.finish(Some(reservation(3))));
        let state = State::open(folder.path(), None).unwrap();
        assert!(state.held());
        let identifiers: Option<Identifiers> = state.identifiers(None).unwrap();
        assert_eq!(identifiers.unwrap().next, 3);
    }

    #[test]
    fn sr_022_a_keeper_that_panics_says_so_and_is_waited_for_by_nobody() {
        let (sender, mut kept) = unbounded_channel();
        let keeper = Keeper::panicking(sender).unwrap();
        assert!(matches!(kept.blocking_recv(), Some(Kept::Gone)));
        keeper.hold(true);
        keeper.reserve(reservation(65));
        assert!(!keeper.finish(None), "it returns that the state is not written");
    }

    #[test]
    fn sr_022_a_stuck_state_folder_is_waited_for_by_nobody() {
        let folder = tempfile::tempdir().unwrap();
        let state = State::open(folder.path(), None).unwrap();
        let identifiers = state.identifiers(Some(1)).unwrap().unwrap();
        state.begin_record(&identifiers).unwrap();
        // A named pipe that no process opens.
        let pipe = folder.path().join("identifiers.new");
        assert!(Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        let (sender, mut kept) = unbounded_channel();
        let keeper = Keeper::start(state, false, sender).unwrap();
        for below in 65..10_000 {
            keeper.reserve(reservation(below));
            keeper.hold(below % 2 == 0);
        }
        while let Ok(told) = kept.try_recv() {
            assert!(matches!(told, Kept::Held), "the identifier is not reserved: {told:?}");
        }
        assert!(!keeper.finish(None), "it returns that the state is not written");
        // Let the thread end.
        std::fs::read(&pipe).unwrap();
    }
}
