mod counts;
pub(crate) mod schedule;

use std::collections::{BTreeMap, BTreeSet};

use backseat_spi::BehaviorId;
use backseat_units::Timestamp;
use serde::{Deserialize, Serialize};

pub use crate::ledger::counts::RequestCounts;
use crate::ledger::counts::Standing;
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
    /// A setting of a sonar.
    SonarSet,
    /// The sonars' logging.
    SonarLog,
    /// BPNPU.
    PositionFix,
    /// BPCTD.
    PayloadCtd,
    /// BPRNS.
    RelativeReset,
    /// BPRBO.
    BearingOffset,
}

impl RequestKind {
    /// Whether it goes to the sonars' payload controller, and not to the vehicle.
    pub(crate) const fn is_of_sonar(self) -> bool {
        matches!(self, Self::SonarSet | Self::SonarLog)
    }
}

/// A request that has not ended.
#[derive(Clone, Debug)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
pub(crate) struct Entry {
    pub(crate) owner: Owner,
    pub(crate) tag: u64,
    pub(crate) kind: RequestKind,
    pub(crate) state: RequestState,
    /// The identifier of an insert that was sent.
    pub(crate) identifier: Option<BehaviorId>,
    /// The insert that was sent; `None` for other requests.
    pub(crate) insert: Option<Insert>,
    /// How long an insert flies at most, seconds.
    pub(crate) duration_s: f64,
    /// The times that an insert was judged for, if zones that are valid for a limited time matter to it.
    pub(crate) schedule: Option<Schedule>,
    /// The vehicle has ended this insert for one that interrupts it, and may resume it (SPI 7.5 leaves that open).
    pub(crate) interrupted: bool,
    /// When an insert was sent.
    pub(crate) sent_at: Timestamp,
    /// The vehicle's plan does not name this insert, which timed out, or which we have cancelled, or which may have begun
    /// unheard. Core asked for that plan after the vehicle must have decided on it: so the insert does not wait.
    pub(crate) not_queued: bool,
    /// The vehicle may have dropped this insert: it has flown another dive since, its plan lacks the insert, or a cancel was
    /// sent. A plan that was asked for at this time or later, and names the insert, shows that it has not.
    pub(crate) may_be_gone: Option<Timestamp>,
    /// A message or the link was lost while this insert waited. It may have begun then, and ended.
    unheard_since: Option<Timestamp>,
    /// The same, also if the vehicle had not decided on it yet.
    unheard: bool,
    /// A cancel was sent. The vehicle has decided on it by then.
    cancelled_by: Option<Timestamp>,
    /// As what the request counts.
    standing: Standing,
}

impl Entry {
    /// Whether this insert may have begun while nobody heard it.
    pub(crate) const fn may_have_begun(&self) -> bool {
        self.unheard
    }

    /// Whether the vehicle may still fly this insert.
    pub(crate) fn is_open_insert(&self) -> bool {
        self.insert.is_some()
    }
}

/// A request has changed its state.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Transition {
    /// The request's number in this run.
    pub request: u64,
    /// The owner of the request.
    pub owner: Owner,
    /// The owner's tag for the request.
    pub tag: u64,
    /// The kind of the request.
    pub kind: RequestKind,
    /// The SPI identifier, if it is an insert.
    pub identifier: Option<u32>,
    /// The new state.
    pub state: RequestState,
}

/// All requests, each with exactly one outcome (safety requirement 009).
///
/// The ledger keeps open entries. When an entry ends, the ledger reports that once and forgets the entry.
#[derive(Debug, Default)]
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub(crate) struct Ledger {
    open: BTreeMap<u64, Entry>,
    last: u64,
    /// How many orders the operator has given.
    orders: u64,
    counts: RequestCounts,
    /// Inserts that timed out. The vehicle may still fly them, so they stay under the caps and under the rule that
    /// nothing interrupts an insert that interrupts.
    doubtful: BTreeMap<u64, Entry>,
    /// The newest inserts that the vehicle has refused, in case it accepts one after all.
    refused: BTreeMap<u64, Entry>,
    /// Inserts that the runtime is cancelling.
    recalled: BTreeSet<u64>,
    /// The insert that the vehicle flew last, if it has reported the end of it, and nothing has begun since.
    flown_last: Option<Entry>,
    /// Inserts of which the vehicle has reported the end before it began one that core did not ask for. That one may have
    /// interrupted them, so the vehicle may take them up again until its plan goes on.
    left: Vec<Entry>,
}

/// How many refused inserts are remembered.
const REFUSED_MAX: usize = 64;

impl Ledger {
    /// Enters a request, and returns its number.
    pub(crate) fn propose(&mut self, owner: impl Into<Owner>, tag: u64, kind: RequestKind) -> u64 {
        self.last += 1;
        self.counts.propose();
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
            may_be_gone: None,
            unheard_since: None,
            unheard: false,
            cancelled_by: None,
            standing: Standing::Waiting,
        };
        self.open.insert(self.last, entry);
        self.last
    }

    /// Enters an order of the operator. Its tag is the number of the order.
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

    /// How many inserts the vehicle may still fly.
    pub(crate) fn open_inserts(&self) -> u32 {
        u32::try_from(self.flyable().count()).unwrap_or(u32::MAX)
    }

    /// How many of a plugin's inserts the vehicle may still fly.
    pub(crate) fn open_inserts_of(&self, plugin: PluginId) -> u32 {
        let own = self.flyable().filter(|entry| entry.owner == plugin);
        u32::try_from(own.count()).unwrap_or(u32::MAX)
    }

    /// How long a plugin's inserts fly at most together, seconds.
    pub(crate) fn open_duration_of_s(&self, plugin: PluginId) -> f64 {
        let own = self.flyable().filter(|entry| entry.owner == plugin);
        own.fold(0.0, |all, entry| all + entry.duration_s)
    }

    /// How long all inserts fly at most together, seconds.
    pub(crate) fn open_duration_s(&self) -> f64 {
        // A sum of nothing would be -0.
        self.flyable().fold(0.0, |all, entry| all + entry.duration_s)
    }

    /// The insert that the vehicle knows by an identifier, and may still fly.
    pub(crate) fn sent(&self, identifier: BehaviorId) -> Option<&Entry> {
        self.flyable().find(|entry| entry.identifier == Some(identifier))
    }

    /// The vehicle has reported the end of an insert that it flew.
    pub(crate) fn flown(&mut self, request: u64) {
        self.flown_last = self.get(request).cloned();
    }

    /// The vehicle begins a behavior: an insert with this identifier, or one of its plan. Returns the insert that is over
    /// by that.
    pub(crate) fn begins(&mut self, insert: Option<BehaviorId>) -> Option<BehaviorId> {
        let last = self.flown_last.take();
        match insert {
            None => self.left.clear(),
            Some(insert) if self.sent(insert).is_some() => return last?.identifier,
            Some(_) => self.left.extend(last),
        }
        None
    }

    /// A message or the link was lost, and with it perhaps a begin: that of an insert that waits, or, if another payload
    /// inserts too (`shared`), that of one of which core knows nothing. Returns whether inserts of ours wait.
    pub(crate) fn lost_begin(&mut self, now: Timestamp, shared: bool) -> bool {
        if shared {
            self.left.extend(self.flown_last.take());
        }
        let mut waits = self.doubtful.values().any(|entry| !entry.not_queued);
        for entry in self.open.values_mut() {
            entry.unheard |= entry.is_open_insert() && entry.state != RequestState::Started;
            if entry.is_open_insert() && entry.state == RequestState::Accepted {
                entry.unheard_since.get_or_insert(now);
                waits = true;
            }
        }
        waits
    }

    /// The refused inserts that the vehicle's plan names.
    pub(crate) fn refused_that(&self, named: impl Fn(BehaviorId) -> bool) -> Vec<u64> {
        let refused = self.refused.iter();
        let named = refused.filter(|(_, entry)| entry.identifier.is_some_and(&named));
        named.map(|(request, _)| *request).collect()
    }

    /// The inserts that the vehicle had accepted and that are over if it flies a behavior of its plan now: it may have
    /// carried out a cancel of ours or may have flown them, unheard, and its plan lacks them. With whether they were cancelled.
    pub(crate) fn over_unheard(&self) -> Vec<(u64, bool)> {
        let gone = |entry: &Entry| {
            entry.not_queued
                && entry.state == RequestState::Accepted
                && entry.insert.is_some_and(|insert| !insert.surfaces())
        };
        let open = self.iter().filter(|(_, entry)| gone(entry));
        open.map(|(request, entry)| (request, entry.cancelled_by.is_some()))
            .collect()
    }

    /// The inserts that have ended, but that the vehicle may take up again.
    pub(crate) fn left(&self) -> impl Iterator<Item = &Entry> + '_ {
        self.left.iter()
    }

    /// Whether another insert waits that interrupts. If so, the vehicle may resume after it what ends now.
    pub(crate) fn awaits_interrupter(&self, ended: u64) -> bool {
        let others = self.open.iter().chain(&self.doubtful);
        others.filter(|(request, _)| **request != ended).any(|(_, entry)| {
            entry.insert.is_some_and(|insert| insert.interrupt) && entry.state != RequestState::Started
        })
    }

    /// An insert that interrupts has begun: marks every other insert that was flown as interrupted.
    pub(crate) fn interrupt_all_but(&mut self, begun: BehaviorId) {
        for entry in self.open.values_mut() {
            let was_flown = entry.is_open_insert() && entry.state == RequestState::Started;
            if was_flown && entry.identifier != Some(begun) {
                entry.interrupted = true;
            }
        }
    }

    /// An insert has begun that interrupts nothing. If another one that does is open, and nobody heard it begin, the
    /// vehicle may have flown it before: marks what was flown as interrupted.
    pub(crate) fn interrupt_where_an_interrupter_waits(&mut self, begun: BehaviorId) {
        let waits = |request: &u64| self.awaits_interrupter(*request);
        if self.open.keys().any(waits) {
            self.interrupt_all_but(begun);
        }
    }

    /// Whether the vehicle may still fly an insert that interrupts.
    pub(crate) fn interrupts(&self) -> bool {
        self.flyable()
            .any(|entry| entry.insert.is_some_and(|insert| insert.interrupt))
    }

    /// Whether the vehicle may still fly a GPS hit.
    pub(crate) fn surfaces(&self) -> bool {
        self.flyable()
            .any(|entry| entry.insert.is_some_and(|insert| insert.surfaces()))
    }

    /// The inserts that the vehicle may still fly, as far as core knows.
    fn flyable(&self) -> impl Iterator<Item = &Entry> + '_ {
        self.open
            .values()
            .filter(|entry| entry.is_open_insert())
            .chain(self.doubtful.values())
    }

    /// The inserts that timed out, and that the vehicle may still fly.
    pub(crate) fn doubtful(&self) -> impl Iterator<Item = &Entry> + '_ {
        self.doubtful.values()
    }

    /// The same inserts, with the numbers of their requests.
    pub(crate) fn doubtful_requests(&self) -> impl Iterator<Item = (u64, &Entry)> + '_ {
        self.doubtful.iter().map(|(request, entry)| (*request, entry))
    }

    /// Whether this insert timed out, and the vehicle may still fly it.
    pub(crate) fn is_doubtful(&self, request: u64) -> bool {
        self.doubtful.contains_key(&request)
    }

    /// The identifier of an insert that is open, or that the vehicle may fly although its request has ended.
    pub(crate) fn identifier_of(&self, request: u64) -> Option<BehaviorId> {
        let entry = self.open.get(&request).or_else(|| self.doubtful.get(&request));
        entry?.identifier
    }

    /// Whether this insert timed out, or was accepted after its refusal, and may wait in the vehicle's plan.
    pub(crate) fn may_wait(&self, request: u64) -> bool {
        self.doubtful.get(&request).is_some_and(|entry| !entry.not_queued)
    }

    /// The vehicle has reported that it no longer has this insert, which had timed out.
    pub(crate) fn settle_doubt(&mut self, request: u64) {
        self.doubtful.remove(&request);
    }

    /// The vehicle has reported the end of the behavior with this identifier.
    pub(crate) fn settle_doubt_of(&mut self, identifier: BehaviorId) {
        let mut of = self
            .doubtful
            .extract_if(.., |_, entry| entry.identifier == Some(identifier));
        if let Some((_, entry)) = of.next() {
            self.flown_last = Some(entry);
        }
    }

    /// A cancel of this insert is sent, or of all inserts. The vehicle may drop them, whatever becomes of its answer.
    pub(crate) fn cancel_sent(&mut self, now: Timestamp, insert: Option<u64>) {
        for (request, entry) in &mut self.open {
            if entry.is_open_insert() && insert.is_none_or(|insert| insert == *request) {
                entry.may_be_gone = Some(now + SETTLED_WITHIN);
                entry.cancelled_by = entry.may_be_gone;
            }
        }
    }

    /// By when the vehicle has decided on each cancel of an insert that it had accepted.
    pub(crate) fn cancels_decided_by(&self) -> Option<Timestamp> {
        let accepted = self.open.values().filter(|entry| entry.state == RequestState::Accepted);
        accepted.filter_map(|entry| entry.cancelled_by).max()
    }

    /// The vehicle has sent its plan, for which core asked at `asked_at`. Open inserts that the plan names are there.
    /// An insert that timed out, that it does not name, and that the vehicle must have decided on before `asked_at`,
    /// does not wait.
    pub(crate) fn heard_plan(&mut self, asked_at: Timestamp, has: impl Fn(BehaviorId) -> bool) {
        for entry in self.open.values_mut() {
            let decided = asked_at >= entry.sent_at + SETTLED_WITHIN;
            let named = entry.identifier.is_some_and(&has);
            let since = |then: Option<Timestamp>| then.is_some_and(|then| then <= asked_at);
            entry.not_queued = !named && (since(entry.cancelled_by) || since(entry.unheard_since));
            if named {
                entry.unheard_since = entry.unheard_since.filter(|lost| asked_at < *lost);
                entry.unheard &= entry.unheard_since.is_some();
                entry.may_be_gone = entry.may_be_gone.filter(|since| asked_at < *since);
            } else if entry.is_open_insert() && decided {
                entry.may_be_gone = entry.may_be_gone.max(Some(asked_at));
            }
        }
        for entry in self.doubtful.values_mut() {
            let named = entry.identifier.is_none_or(&has);
            entry.not_queued = !named && asked_at >= entry.sent_at + SETTLED_WITHIN;
        }
    }

    /// The vehicle no longer has those of the inserts that timed out for which `gone` is true.
    pub(crate) fn settle_doubt_if(&mut self, gone: impl Fn(&Entry) -> bool) {
        self.doubtful.retain(|_, entry| !gone(entry));
    }

    /// The mission is over, and so is everything that it held.
    pub(crate) fn settle_all_doubt(&mut self) {
        self.doubtful.clear();
        self.left.clear();
        self.flown_last = None;
        self.refused.clear();
    }

    /// The vehicle has accepted an insert that it had refused: it may fly it. The request keeps its outcome, and still
    /// counts as failed. Returns the insert's entry.
    pub(crate) fn doubt_refused(&mut self, now: Timestamp, request: u64) -> Option<&Entry> {
        let mut entry = self.refused.remove(&request)?;
        entry.state = RequestState::TimedOut;
        // A plan that was asked for before now may lack it.
        entry.sent_at = now;
        Some(self.doubtful.entry(request).or_insert(entry))
    }

    /// Notes whether the runtime is cancelling an insert.
    pub(crate) fn set_recalled(&mut self, request: u64, recalled: bool) {
        if recalled {
            self.recalled.insert(request);
        } else {
            self.recalled.remove(&request);
        }
    }

    /// Whether the runtime is cancelling an insert.
    pub(crate) fn is_recalled(&self, request: u64) -> bool {
        self.recalled.contains(&request)
    }

    /// Whether an insert is in doubt: no other insert is sent until the vehicle or its plan settles that.
    pub(crate) fn in_doubt(&self) -> bool {
        self.iter()
            .any(|(_, entry)| entry.is_open_insert() && entry.state == RequestState::Unknown)
    }

    /// Takes a request to another state. `None` if the request has ended or cannot go there: an answer that comes too
    /// late or twice changes nothing.
    pub(crate) fn transition(&mut self, request: u64, to: RequestState) -> Option<Transition> {
        let entry = self.open.get_mut(&request)?;
        if !may_follow(&entry.state, &to, entry.is_open_insert()) {
            return None;
        }
        entry.standing = self.counts.count(entry.standing, &to);
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
            && entry.is_open_insert()
        {
            if transition.state == RequestState::TimedOut {
                self.doubtful.insert(request, entry);
            } else if matches!(transition.state, RequestState::Failed(_)) {
                if self.refused.len() >= REFUSED_MAX {
                    self.refused.pop_first();
                }
                self.refused.insert(request, entry);
            }
        }
        Some(transition)
    }
}

/// A proposed request counts as rejected, for no real reason, until something is decided. So nothing can take an
/// undecided request for an admitted one.
const PROPOSED: RequestState = RequestState::Rejected(Refusal::State(Reason::Undecided));

/// Whether a state is final.
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

/// The transitions: from which state a request may go to which. An insert that has begun can only end: a refusal that
/// comes after its BFMBS does not take it out of the caps. An adjustment that has begun can also fail or time out.
fn may_follow(from: &RequestState, to: &RequestState, insert: bool) -> bool {
    use RequestState as S;
    match from {
        // Proposed. A real rejection is final, and its entry is no longer open.
        S::Rejected(_) => matches!(to, S::Rejected(_) | S::Sent | S::Ended(_)),
        S::Sent => !matches!(to, S::Rejected(_) | S::Sent),
        S::Pending => !matches!(to, S::Rejected(_) | S::Sent | S::Pending),
        S::Unknown => matches!(to, S::Accepted | S::Started | S::Failed(_) | S::TimedOut | S::Ended(_)),
        // When the vehicle flies another dive, an insert that waited is in doubt.
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
                sent: 1,
                failed: 1,
                ..RequestCounts::default()
            }
        );
        assert_eq!(ledger.iter().count(), 0);
    }

    #[test]
    fn a_request_that_has_begun_can_fail_unless_it_is_an_insert() {
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
    fn an_unknown_insert_is_in_doubt_until_the_vehicle_names_it() {
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
