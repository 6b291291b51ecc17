use std::time::Duration;

use crate::moment::Moment;

use crate::due::Due;
use crate::process::Process;
use crate::rule::Rule;

/// How soon the operator's hold must take effect.
const WITHIN: Duration = Duration::from_millis(100);
/// How soon the waiting inserts must be cancelled.
const CANCELS_WITHIN: Duration = Duration::from_secs(1);
/// An acceptance that came within this time before the hold may be heard after it.
const CANCELS_RACE: Duration = Duration::from_millis(100);

/// The operator's hold.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Operator {
    held: Option<Moment>,
    /// When the cancels must have been sent, and the time before which the vehicle had accepted the inserts that they
    /// cancel.
    cancels: Option<(Moment, Moment)>,
    /// The same of inserts that the vehicle has named to a new process during the hold.
    named: Option<(Moment, Moment)>,
    /// The vehicle has named such inserts while the runtime was stopped.
    unread: bool,
}

impl Operator {
    /// The operator begins a hold. Returns whether that is new. `hears` is true if a cancel can be sent.
    pub(crate) fn holds(&mut self, at: Moment, hears: bool) -> bool {
        if self.held.is_some() {
            return false;
        }
        self.held = Some(at);
        if hears && let Some(by) = at.as_nanos().checked_sub(CANCELS_RACE.as_nanos() as u64) {
            self.cancels = Some((at + CANCELS_WITHIN, Moment::from_nanos(by)));
        }
        true
    }

    /// The vehicle names a waiting insert of a previous process. During a hold it must be cancelled; by a stopped
    /// runtime, when it continues.
    pub(crate) fn named(&mut self, at: Moment, stopped: bool) {
        if self.held.is_none() {
            return;
        }
        if stopped {
            self.unread = true;
        } else {
            self.named = Some((at + CANCELS_WITHIN, at));
        }
    }

    /// A runtime that was stopped reads what the vehicle sent meanwhile.
    pub(crate) fn goes_on(&mut self, at: Moment) {
        if std::mem::take(&mut self.unread) {
            self.named(at, false);
        }
    }

    pub(crate) fn releases(&mut self) {
        self.held = None;
        self.cut();
    }

    /// Nothing can be sent any more.
    pub(crate) fn cut(&mut self) {
        self.cancels = None;
        self.named = None;
        self.unread = false;
    }

    /// When every dynamic request must have ended.
    pub(crate) fn due(&self, process: &Process) -> Option<Due> {
        self.held.map(|held| Due {
            by: process.heard(held) + WITHIN,
            rule: Rule::OperatorHold,
            why: "the operator's hold was on",
        })
    }

    /// Returns once, when all cancels must have been sent, the time before which their inserts had been accepted.
    pub(crate) fn cancels_due(&mut self, now: Moment) -> Option<Moment> {
        let due = |(due, _): &mut (Moment, Moment)| now > *due;
        let taken = [self.cancels.take_if(due), self.named.take_if(due)];
        taken.into_iter().flatten().map(|(_, by)| by).max()
    }
}
