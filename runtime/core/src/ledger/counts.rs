//! The numbers of requests: two sums that always hold.

use std::fmt;
use std::ops::AddAssign;

use serde::{Deserialize, Serialize};

use crate::ended::EndKind;
use crate::plugin::RequestState;

/// The numbers of requests. Each request counts once in each of two sums, which always hold:
///
/// - `proposed` = `rejected` + `replaced` + `withdrawn` + `waiting` + `sent`
/// - `sent` = `accepted` + `failed` + `unanswered` + `undecided`
///
/// What became of a request after the vehicle had accepted it does not count here.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct RequestCounts {
    /// Asked for by plugins, the operator, policies and external sources.
    pub proposed: u64,
    /// Refused before they were sent.
    pub rejected: u64,
    /// Ended before they were sent, because another request took their place.
    pub replaced: u64,
    /// Ended before they were sent for any other reason: the plugin ended them or failed, or control, the fence or the
    /// mission no longer allowed them.
    pub withdrawn: u64,
    /// Not sent yet.
    pub waiting: u64,
    /// Written to the link.
    pub sent: u64,
    /// Accepted by the vehicle, or seen to be flown.
    pub accepted: u64,
    /// Refused by the vehicle.
    pub failed: u64,
    /// Ended after they were sent, without an answer that says whether the vehicle took them.
    pub unanswered: u64,
    /// Sent, and the vehicle has not decided yet.
    pub undecided: u64,
}

impl AddAssign for RequestCounts {
    fn add_assign(&mut self, more: Self) {
        self.proposed += more.proposed;
        self.rejected += more.rejected;
        self.replaced += more.replaced;
        self.withdrawn += more.withdrawn;
        self.waiting += more.waiting;
        self.sent += more.sent;
        self.accepted += more.accepted;
        self.failed += more.failed;
        self.unanswered += more.unanswered;
        self.undecided += more.undecided;
    }
}

/// As what a request counts: what the vehicle is known to have decided on it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
pub(super) enum Standing {
    /// Not sent.
    Waiting,
    /// Sent; the vehicle has not decided.
    Undecided,
    /// Counted for good.
    Decided,
}

impl RequestCounts {
    /// Whether both sums hold. They do, unless the ledger has a fault.
    #[must_use]
    pub const fn add_up(&self) -> bool {
        self.proposed == self.rejected + self.replaced + self.withdrawn + self.waiting + self.sent
            && self.sent == self.accepted + self.failed + self.unanswered + self.undecided
    }

    /// The numbers once the process that counted has ended: nothing that it left open gets an answer.
    #[must_use]
    pub const fn of_ended_process(mut self) -> Self {
        self.withdrawn += self.waiting;
        self.waiting = 0;
        self.unanswered += self.undecided;
        self.undecided = 0;
        self
    }

    pub(super) const fn propose(&mut self) {
        self.proposed += 1;
        self.waiting += 1;
    }

    /// Counts a request's next state, and returns as what it counts from then on.
    pub(super) fn count(&mut self, standing: Standing, to: &RequestState) -> Standing {
        use RequestState as S;
        let (left, entered, next) = match (standing, to) {
            (Standing::Decided, _) | (Standing::Undecided, S::Pending | S::Unknown | S::Sent | S::Rejected(_)) => {
                return standing;
            }
            (Standing::Waiting, S::Sent) => (&mut self.waiting, &mut self.sent, Standing::Undecided),
            (Standing::Waiting, S::Rejected(_)) => (&mut self.waiting, &mut self.rejected, Standing::Decided),
            (Standing::Waiting, S::Ended(end)) if end.kind() == EndKind::Replaced => {
                (&mut self.waiting, &mut self.replaced, Standing::Decided)
            }
            (Standing::Waiting, _) => (&mut self.waiting, &mut self.withdrawn, Standing::Decided),
            (Standing::Undecided, S::Accepted | S::Started) => {
                (&mut self.undecided, &mut self.accepted, Standing::Decided)
            }
            (Standing::Undecided, S::Failed(_)) => (&mut self.undecided, &mut self.failed, Standing::Decided),
            (Standing::Undecided, S::Ended(end)) => {
                let counted = match end.kind() {
                    EndKind::Done => &mut self.accepted,
                    EndKind::Refused => &mut self.failed,
                    EndKind::Asked
                    | EndKind::Replaced
                    | EndKind::Term
                    | EndKind::NotAnswered
                    | EndKind::Late
                    | EndKind::Link
                    | EndKind::Control
                    | EndKind::Refusal
                    | EndKind::Fence
                    | EndKind::Navigation
                    | EndKind::Behavior
                    | EndKind::Mission
                    | EndKind::Plugin => &mut self.unanswered,
                };
                (&mut self.undecided, counted, Standing::Decided)
            }
            (Standing::Undecided, S::TimedOut | S::Cancelled) => {
                (&mut self.undecided, &mut self.unanswered, Standing::Decided)
            }
        };
        *left -= 1;
        *entered += 1;
        self.undecided += u64::from(next == Standing::Undecided);
        next
    }
}

/// Both sums, as in `12, of which 2 rejected, 1 replaced, 9 sent; of these 8 accepted, 1 unanswered`. What is always zero in a
/// run without troubles is left out where it is zero.
impl fmt::Display for RequestCounts {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}, of which {} rejected", self.proposed, self.rejected)?;
        for (count, name) in [
            (self.replaced, "replaced"),
            (self.withdrawn, "withdrawn"),
            (self.waiting, "not sent yet"),
        ] {
            if count > 0 {
                write!(f, ", {count} {name}")?;
            }
        }
        write!(
            f,
            ", {} sent; of these {} accepted, {} failed",
            self.sent, self.accepted, self.failed
        )?;
        for (count, name) in [(self.unanswered, "unanswered"), (self.undecided, "undecided")] {
            if count > 0 {
                write!(f, ", {count} {name}")?;
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ended::{EndCause, Failure};
    use crate::refusal::{Reason, Refusal};

    /// Every state after every state that is possible before it, as the ledger would count them.
    #[test]
    fn both_sums_hold_after_any_states() {
        let states = [
            RequestState::Rejected(Refusal::State(Reason::Undecided)),
            RequestState::Sent,
            RequestState::Pending,
            RequestState::Unknown,
            RequestState::Accepted,
            RequestState::Started,
            RequestState::Failed(Failure::Vehicle("no".to_owned())),
            RequestState::TimedOut,
            RequestState::Cancelled,
            RequestState::Ended(EndCause::Replaced.into()),
            RequestState::Ended(EndCause::Done.into()),
            RequestState::Ended(EndCause::NotAcknowledged.into()),
            RequestState::Ended(EndCause::VehicleRefused.into()),
        ];
        for first in &states {
            for second in &states {
                for third in &states {
                    let mut counts = RequestCounts::default();
                    counts.propose();
                    let mut standing = Standing::Waiting;
                    for state in [first, second, third] {
                        standing = counts.count(standing, state);
                        assert!(counts.add_up(), "{first:?} {second:?} {third:?}: {counts:?}");
                        assert!(counts.of_ended_process().add_up());
                    }
                }
            }
        }
    }

    #[test]
    fn what_was_not_sent_is_replaced_or_withdrawn() {
        for (end, replaced, withdrawn) in [(EndCause::Replaced, 1, 0), (EndCause::PluginEnded, 0, 1)] {
            let mut counts = RequestCounts::default();
            counts.propose();
            counts.count(Standing::Waiting, &RequestState::Ended(end.into()));
            assert_eq!(
                (counts.replaced, counts.withdrawn, counts.waiting),
                (replaced, withdrawn, 0)
            );
        }
    }

    #[test]
    fn a_request_that_the_vehicle_took_counts_once() {
        let mut counts = RequestCounts::default();
        counts.propose();
        let mut standing = Standing::Waiting;
        for state in [
            RequestState::Sent,
            RequestState::Unknown,
            RequestState::Started,
            RequestState::Failed(Failure::Vehicle("later".to_owned())),
        ] {
            standing = counts.count(standing, &state);
        }
        assert_eq!((counts.sent, counts.accepted, counts.failed), (1, 1, 0));
        assert_eq!(
            counts.to_string(),
            "1, of which 0 rejected, 1 sent; of these 1 accepted, 0 failed"
        );
    }
}
