use std::time::Duration;

use crate::moment::Moment;

use crate::due::Due;
use crate::process::Process;
use crate::rule::Rule;

/// How soon the operator's hold acts.
const WITHIN: Duration = Duration::from_millis(100);
/// How soon what waits is taken back.
const CANCELS_WITHIN: Duration = Duration::from_secs(1);
/// An acceptance that came so shortly before the hold may be heard after it.
const CANCELS_RACE: Duration = Duration::from_millis(100);

/// The operator's hold.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Operator {
    held: Option<Moment>,
    /// When the cancels of what waited at a time must have been sent.
    cancels: Option<(Moment, Moment)>,
}

impl Operator {
    /// The operator holds. Whether that is new. `hears` where a cancel can be sent.
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

    pub(crate) fn releases(&mut self) {
        self.held = None;
        self.cancels = None;
    }

    /// Nothing can be sent any more.
    pub(crate) fn cut(&mut self) {
        self.cancels = None;
    }

    /// When everything dynamic must have ended.
    pub(crate) fn due(&self, process: &Process) -> Option<Due> {
        self.held.map(|held| Due {
            by: process.heard(held) + WITHIN,
            rule: Rule::OperatorHold,
            why: "the operator holds",
        })
    }

    /// Once, when all cancels must have been sent: of what was taken before the time that is given.
    pub(crate) fn cancels_due(&mut self, now: Moment) -> Option<Moment> {
        self.cancels.take_if(|(due, _)| now > *due).map(|(_, by)| by)
    }
}
