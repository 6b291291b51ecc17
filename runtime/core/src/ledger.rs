pub(crate) mod schedule;

use std::collections::{BTreeMap, BTreeSet};

use backseat_spi::BehaviorId;
use backseat_units::Timestamp;
use serde::{Deserialize, Serialize};

use crate::ledger::schedule::Schedule;
use crate::monitor::envelope::Insert;
use crate::owner::Owner;
use crate::plugin::{PluginId, RequestState};
use crate::refusal::{Reason, Refusal};
use crate::session::commands::SETTLED_WITHIN;

/// What kind of request an entry of the ledger is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum RequestKind {
    /// BPRMB.
    Modify,
    /// BPRTK.
    Trackline,
    /// BPRTC.
    Trackcircle,
    /// BPRCN.
    Cancel,
    /// BPRGP.
    GpsHit,
    /// BPRCA.
    CancelAll,
    /// BPRCB.
    CancelCurrent,
    /// BPRCE.
    CancelElement,
    /// BPABT.
    Abort,
    /// BPKIL.
    Kill,
    /// BPSEM.
    StartEmptyMission,
    /// BPTOP.
    Topside,
    /// BPTMR.
    Relay,
    /// BPDVR.
    DvlTrigger,
    /// BPSIL.
    Silent,
    /// BPTRM.
    Trim,
    /// BPBOY.
    Buoyancy,
    /// BPCPD.
    Packet,
    /// BPSUS, BPCON, BPGHP, BPGBP, BPRES: one lease.
    Station,
    /// BPSAN.
    SonarAngle,
    /// BPPTZ.
    Camera,
    /// BPLIT.
    Light,
    /// BPNPU.
    PositionFix,
    /// BPCTD.
    PayloadCtd,
    /// BPRNS.
    RelativeReset,
    /// BPRBO.
    BearingOffset,
}

/// How many requests have come how far. A request counts once in `proposed`, and once in each state that it reached.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct RequestCounts {
    /// Asked for by plugins, the operator, policies and external sources.
    pub proposed: u64,
    /// Refused before they were sent.
    pub rejected: u64,
    /// Written to the link.
    pub sent: u64,
    /// Accepted by the vehicle.
    pub accepted: u64,
    /// Refused by the vehicle, or never answered.
    pub failed: u64,
}

/// A request that is not at its end.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
pub(crate) struct Entry {
    pub(crate) owner: Owner,
    pub(crate) tag: u64,
    pub(crate) kind: RequestKind,
    pub(crate) state: RequestState,
    /// Of an insert that has been sent.
    pub(crate) identifier: Option<BehaviorId>,
    /// Of an insert.
    pub(crate) insert: Option<Insert>,
    /// How long an insert flies at most, seconds.
    pub(crate) duration_s: f64,
    /// By when an insert was judged to be flown, where zones that are valid for a time count.
    pub(crate) schedule: Option<Schedule>,
    /// The vehicle has ended this insert for one that interrupts it, and may take it up again (SPI 7.5 leaves it open).
    pub(crate) interrupted: bool,
    /// When an insert was sent.
    pub(crate) sent_at: Timestamp,
    /// The vehicle's plan, asked for when it had decided on this insert at the latest, does not name it: it does not wait.
    pub(crate) not_queued: bool,
    /// The vehicle may have dropped this insert: it flies another dive since, or has refused to take it back.
    pub(crate) may_be_gone: bool,
}

impl Entry {
    /// Whether the vehicle may yet fly this insert.
    pub(crate) fn is_open_insert(&self) -> bool {
        self.insert.is_some()
    }
}

/// A request has come to another state.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Transition {
    /// The request's number in this run.
    pub request: u64,
    /// Whose it is.
    pub owner: Owner,
    /// The owner's name for it.
    pub tag: u64,
    /// What it is.
    pub kind: RequestKind,
    /// The SPI identifier of an insert.
    pub identifier: Option<u32>,
    /// Its state now.
    pub state: RequestState,
}

/// Every request and its one outcome (safety requirement 009).
///
/// Open entries are kept; an entry that has come to its end is told once and forgotten.
#[derive(Debug, Default)]
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub(crate) struct Ledger {
    open: BTreeMap<u64, Entry>,
    last: u64,
    /// How many orders there have been.
    orders: u64,
    counts: RequestCounts,
    /// Inserts that ended without the vehicle's word: it may fly them yet, so they stay under the caps and the rule
    /// that nothing interrupts what interrupts.
    doubtful: BTreeMap<u64, Entry>,
    /// Inserts that are being taken back.
    recalled: BTreeSet<u64>,
}

impl Ledger {
    /// Enters a request; its number.
    pub(crate) fn propose(&mut self, owner: impl Into<Owner>, tag: u64, kind: RequestKind) -> u64 {
        self.last += 1;
        self.counts.proposed += 1;
        let entry = Entry {
            owner: owner.into(),
            tag,
            kind,
            state: PROPOSED,
            identifier: None,
            insert: None,
            duration_s: 0.0,
            schedule: None,
            interrupted: false,
            sent_at: Timestamp::ZERO,
            not_queued: false,
            may_be_gone: false,
        };
        self.open.insert(self.last, entry);
        self.last
    }

    /// Enters an order of the operator's, which has no tag but its number.
    pub(crate) fn propose_order(&mut self, kind: RequestKind) -> u64 {
        self.orders += 1;
        self.propose(Owner::Operator, self.orders, kind)
    }

    pub(crate) fn get_mut(&mut self, request: u64) -> Option<&mut Entry> {
        self.open.get_mut(&request)
    }

    pub(crate) fn get(&self, request: u64) -> Option<&Entry> {
        self.open.get(&request)
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = (u64, &Entry)> + '_ {
        self.open.iter().map(|(request, entry)| (*request, entry))
    }

    pub(crate) fn iter_mut(&mut self) -> impl Iterator<Item = (u64, &mut Entry)> + '_ {
        self.open.iter_mut().map(|(request, entry)| (*request, entry))
    }

    /// The open request that the vehicle knows by an identifier.
    pub(crate) fn by_identifier(&self, identifier: BehaviorId) -> Option<u64> {
        self.iter()
            .find(|(_, entry)| entry.identifier == Some(identifier))
            .map(|(request, _)| request)
    }

    /// Whether an open request is a GPS hit.
    pub(crate) fn is_gps_hit(&self, request: Option<u64>) -> bool {
        let insert = request.and_then(|request| self.get(request)?.insert);
        insert.is_some_and(|insert| insert.surfaces())
    }

    pub(crate) const fn counts(&self) -> RequestCounts {
        self.counts
    }

    /// How many inserts the vehicle may yet fly.
    pub(crate) fn open_inserts(&self) -> u32 {
        u32::try_from(self.flyable().count()).unwrap_or(u32::MAX)
    }

    /// How many of a plugin's inserts the vehicle may yet fly.
    pub(crate) fn open_inserts_of(&self, plugin: PluginId) -> u32 {
        let own = self.flyable().filter(|entry| entry.owner == plugin);
        u32::try_from(own.count()).unwrap_or(u32::MAX)
    }

    /// How long they fly at most, seconds.
    pub(crate) fn open_duration_of_s(&self, plugin: PluginId) -> f64 {
        let own = self.flyable().filter(|entry| entry.owner == plugin);
        own.fold(0.0, |all, entry| all + entry.duration_s)
    }

    /// How long all of them fly at most, seconds.
    pub(crate) fn open_duration_s(&self) -> f64 {
        // An empty sum would be -0.
        self.flyable().fold(0.0, |all, entry| all + entry.duration_s)
    }

    /// Whether another insert waits that interrupts: what ends now may be taken up again after it.
    pub(crate) fn awaits_interrupter(&self, ended: u64) -> bool {
        self.iter().any(|(request, entry)| {
            request != ended
                && entry.insert.is_some_and(|insert| insert.interrupt)
                && entry.state != RequestState::Started
        })
    }

    /// An insert begins that interrupts what was flown.
    pub(crate) fn interrupt_all_but(&mut self, begun: Option<BehaviorId>) {
        for entry in self.open.values_mut() {
            let was_flown = entry.is_open_insert() && entry.state == RequestState::Started;
            if was_flown && entry.identifier != begun {
                entry.interrupted = true;
            }
        }
    }

    /// Whether the vehicle may yet fly an insert that interrupts.
    pub(crate) fn interrupts(&self) -> bool {
        self.flyable()
            .any(|entry| entry.insert.is_some_and(|insert| insert.interrupt))
    }

    /// Whether the vehicle may yet fly a GPS hit.
    pub(crate) fn surfaces(&self) -> bool {
        self.flyable()
            .any(|entry| entry.insert.is_some_and(|insert| insert.surfaces()))
    }

    /// The inserts that the vehicle may yet fly, as far as is known.
    fn flyable(&self) -> impl Iterator<Item = &Entry> + '_ {
        self.open
            .values()
            .filter(|entry| entry.is_open_insert())
            .chain(self.doubtful.values())
    }

    /// The inserts that ended without the vehicle's word.
    pub(crate) fn doubtful(&self) -> impl Iterator<Item = &Entry> + '_ {
        self.doubtful.values()
    }

    /// The same, with their requests.
    pub(crate) fn doubtful_requests(&self) -> impl Iterator<Item = (u64, &Entry)> + '_ {
        self.doubtful.iter().map(|(request, entry)| (*request, entry))
    }

    /// Whether an insert ended without the vehicle's word.
    pub(crate) fn is_doubtful(&self, request: u64) -> bool {
        self.doubtful.contains_key(&request)
    }

    /// The vehicle has said that it no longer has this insert, which had ended without its word.
    pub(crate) fn settle_doubt(&mut self, request: u64) {
        self.doubtful.remove(&request);
    }

    /// The vehicle has said that a behavior with this identifier has ended.
    pub(crate) fn settle_doubt_of(&mut self, identifier: BehaviorId) {
        self.doubtful.retain(|_, entry| entry.identifier != Some(identifier));
    }

    /// The vehicle has told a plan that was asked for then: what it names is there; inserts without its word that are not in
    /// it do not wait, where it had decided on them.
    pub(crate) fn heard_plan(&mut self, asked_at: Timestamp, has: impl Fn(BehaviorId) -> bool) {
        for entry in self.open.values_mut() {
            entry.may_be_gone &= !entry.identifier.is_some_and(&has);
        }
        for entry in self.doubtful.values_mut() {
            let named = entry.identifier.is_none_or(&has);
            entry.not_queued = !named && asked_at >= entry.sent_at + SETTLED_WITHIN;
        }
    }

    /// The vehicle has said that it has none of these any more.
    pub(crate) fn settle_doubt_if(&mut self, gone: impl Fn(&Entry) -> bool) {
        self.doubtful.retain(|_, entry| !gone(entry));
    }

    /// The mission is over, and all that it held.
    pub(crate) fn settle_all_doubt(&mut self) {
        self.doubtful.clear();
    }

    /// An insert is being taken back, or no longer.
    pub(crate) fn set_recalled(&mut self, request: u64, recalled: bool) {
        if recalled {
            self.recalled.insert(request);
        } else {
            self.recalled.remove(&request);
        }
    }

    /// Whether an insert is being taken back.
    pub(crate) fn is_recalled(&self, request: u64) -> bool {
        self.recalled.contains(&request)
    }

    /// Whether an insert is in doubt: no further one is sent until the vehicle has named it.
    pub(crate) fn in_doubt(&self) -> bool {
        self.iter()
            .any(|(_, entry)| entry.is_open_insert() && entry.state == RequestState::Unknown)
    }

    /// Takes a request to another state. `None` where it is at its end already or cannot go there: what came too late
    /// or twice changes nothing.
    pub(crate) fn transition(&mut self, request: u64, to: RequestState) -> Option<Transition> {
        let entry = self.open.get_mut(&request)?;
        if !may_follow(&entry.state, &to, entry.is_open_insert()) {
            return None;
        }
        match &to {
            RequestState::Rejected(_) => self.counts.rejected += 1,
            RequestState::Sent => self.counts.sent += 1,
            RequestState::Accepted if entry.state != RequestState::Unknown => self.counts.accepted += 1,
            RequestState::Failed(_) | RequestState::TimedOut => self.counts.failed += 1,
            RequestState::Accepted
            | RequestState::Pending
            | RequestState::Unknown
            | RequestState::Started
            | RequestState::Ended(_)
            | RequestState::Cancelled => {}
        }
        entry.state = to.clone();
        let transition = Transition {
            request,
            owner: entry.owner,
            tag: entry.tag,
            kind: entry.kind,
            identifier: entry.identifier.map(BehaviorId::get),
            state: to,
        };
        if is_end(&transition.state)
            && let Some(entry) = self.open.remove(&request)
            && transition.state == RequestState::TimedOut
            && entry.is_open_insert()
        {
            self.doubtful.insert(request, entry);
        }
        Some(transition)
    }
}

/// A proposed request stands as rejected-for-no-reason until something is decided, so that nothing can take an
/// undecided one for a good one.
const PROPOSED: RequestState = RequestState::Rejected(Refusal::State(Reason::Undecided));

/// Whether a state is an end.
pub(crate) fn is_end(state: &RequestState) -> bool {
    match state {
        RequestState::Rejected(_)
        | RequestState::Failed(_)
        | RequestState::TimedOut
        | RequestState::Ended(_)
        | RequestState::Cancelled => true,
        RequestState::Sent
        | RequestState::Pending
        | RequestState::Accepted
        | RequestState::Unknown
        | RequestState::Started => false,
    }
}

/// The matrix of transitions: rows are where a request stands, columns where it may go. An insert that has begun only
/// ends: a refusal that comes after its BFMBS does not take it from under the caps. What is no insert and has begun, an
/// adjustment, can fail or never be heard of again.
fn may_follow(from: &RequestState, to: &RequestState, insert: bool) -> bool {
    use RequestState as S;
    match from {
        // Proposed; a real rejection is an end and no longer open.
        S::Rejected(_) => matches!(to, S::Rejected(_) | S::Sent | S::Ended(_)),
        S::Sent => !matches!(to, S::Rejected(_) | S::Sent),
        S::Pending => !matches!(to, S::Rejected(_) | S::Sent | S::Pending),
        S::Unknown => matches!(to, S::Accepted | S::Started | S::Failed(_) | S::TimedOut | S::Ended(_)),
        // Another dive leaves an insert that waited in doubt.
        S::Accepted if insert && *to == S::Unknown => true,
        S::Accepted => matches!(to, S::Started | S::Ended(_) | S::Cancelled | S::Failed(_) | S::TimedOut),
        S::Started => match to {
            S::Ended(_) => true,
            S::Failed(_) | S::TimedOut => !insert,
            S::Rejected(_) | S::Sent | S::Pending | S::Accepted | S::Unknown | S::Started | S::Cancelled => false,
        },
        S::Failed(_) | S::TimedOut | S::Ended(_) | S::Cancelled => false,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::ended::Failure;
    use backseat_units::{Depth, Position, Speed};

    use crate::monitor::envelope::{Flight, InsertPath, Vertical};

    fn insert() -> Insert {
        let place = Position::from_deg(42.0, -70.0).unwrap();
        Insert {
            path: InsertPath::Line {
                start: place,
                end: place,
                flight: Flight {
                    vertical: Vertical::Depth(Depth::from_m(5.0).unwrap()),
                    speed: Speed::from_mps(1.5).unwrap(),
                },
            },
            interrupt: false,
        }
    }

    #[test]
    fn a_request_has_one_end_and_late_answers_change_nothing() {
        let mut ledger = Ledger::default();
        let request = ledger.propose(PluginId(0), 1, RequestKind::Trackline);
        assert!(
            ledger.transition(request, RequestState::Accepted).is_none(),
            "not sent yet"
        );
        assert!(ledger.transition(request, RequestState::Sent).is_some());
        assert!(
            ledger
                .transition(request, RequestState::Failed(Failure::Vehicle("no".to_owned())))
                .is_some()
        );
        assert!(ledger.transition(request, RequestState::Accepted).is_none());
        assert_eq!(
            ledger.counts(),
            RequestCounts {
                proposed: 1,
                rejected: 0,
                sent: 1,
                accepted: 0,
                failed: 1
            }
        );
        assert_eq!(ledger.iter().count(), 0);
    }

    #[test]
    fn what_has_begun_fails_only_where_it_is_no_insert() {
        for (kind, fails) in [(RequestKind::Trim, true), (RequestKind::Trackline, false)] {
            let mut ledger = Ledger::default();
            let request = ledger.propose(PluginId(0), 1, kind);
            ledger.get_mut(request).unwrap().insert = (!fails).then(insert);
            ledger.transition(request, RequestState::Sent);
            ledger.transition(request, RequestState::Started);
            let failed = ledger.transition(request, RequestState::Failed(Failure::Vehicle("no".to_owned())));
            assert_eq!(
                (failed.is_some(), ledger.iter().count() == 0),
                (fails, fails),
                "{kind:?}"
            );
        }
    }

    #[test]
    fn an_unanswered_insert_stays_under_the_cap() {
        let mut ledger = Ledger::default();
        let request = ledger.propose(PluginId(0), 1, RequestKind::Trackline);
        ledger.get_mut(request).unwrap().insert = Some(insert());
        ledger.transition(request, RequestState::Sent);
        ledger.transition(request, RequestState::TimedOut);
        assert_eq!(ledger.open_inserts(), 1);
    }

    #[test]
    fn an_unknown_one_is_in_doubt_until_the_vehicle_names_it() {
        let mut ledger = Ledger::default();
        let request = ledger.propose(PluginId(0), 1, RequestKind::Trackline);
        ledger.get_mut(request).unwrap().insert = Some(insert());
        ledger.transition(request, RequestState::Sent);
        ledger.transition(request, RequestState::Unknown);
        assert!(ledger.in_doubt());
        ledger.transition(request, RequestState::Accepted);
        assert!(!ledger.in_doubt());
    }
}
