//! What a previous run has left in the vehicle: inserts of that run that the vehicle may still fly (safety requirements
//! 002, 007, 010 and 015).
//!
//! The driver says which identifiers were used in the vehicle's mission before this process began. The vehicle's plan
//! (BFPLN) says which of these inserts wait. No message tells a client that connects later which one is flown now. So
//! until the vehicle reports that a behavior begins, it may be flying any of them.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use backseat_spi::BehaviorId;

use crate::io::Identifiers;
use crate::vehicle::plan::Plan;

/// How the vehicle names the kinds of insert that keep to their depth (SPI 6.9).
const PATHS: [&str; 2] = ["trackline", "trackcircle"];

/// The identifiers of previous runs, and what is known of their inserts.
#[derive(Debug, Default)]
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub(crate) struct PreviousRun {
    identifiers: Range<u32>,
    /// Previous runs may have sent inserts. A run that only modified has used identifiers for nothing, or for packets.
    inserted: bool,
    /// A behavior has begun on this connection, and no message was lost since, so it is known what is flown.
    heard: bool,
    /// An insert of this process that the vehicle flies although its request has ended, for example because the vehicle
    /// refused it.
    still_flown_after_end: Option<BehaviorId>,
    /// The inserts that the vehicle's plan had when it was last complete, or has named since, and that have not begun
    /// or ended since, on whatever connection.
    left: BTreeSet<BehaviorId>,
    /// One of the inserts of previous runs may have been a GPS hit.
    gps_hits: bool,
    /// The insert of a previous run that is flown, if its kind is neither trackline nor trackcircle.
    surfacing: Option<BehaviorId>,
    /// All inserts of previous runs are over: the plan has gone on and had none of them, or the mission is over.
    over: bool,
    /// How often each was cancelled on this connection.
    cancelled: BTreeMap<BehaviorId, u32>,
}

impl PreviousRun {
    pub(crate) fn new(identifiers: Option<Identifiers>) -> Self {
        Self {
            identifiers: identifiers.map_or(0..0, |identifiers| identifiers.first..identifiers.next),
            inserted: identifiers.is_some_and(|identifiers| identifiers.inserts > 0 || identifiers.gps_hits > 0),
            gps_hits: identifiers.is_some_and(|identifiers| identifiers.gps_hits > 0),
            ..Self::default()
        }
    }

    /// Whether there was no previous run: this process is the first of the vehicle's mission.
    pub(crate) fn is_none(&self) -> bool {
        self.identifiers.is_empty()
    }

    /// A behavior begins. It may be one that was believed to be over.
    pub(crate) fn heard_begin(
        &mut self,
        begun: Option<BehaviorId>,
        kind: &str,
        still_flown_after_end: Option<BehaviorId>,
    ) {
        self.heard = true;
        let keeps_down = PATHS.iter().any(|path| path.eq_ignore_ascii_case(kind));
        self.surfacing = begun.filter(|identifier| self.includes(*identifier) && !keeps_down);
        self.still_flown_after_end = still_flown_after_end;
        self.forget(begun);
    }

    /// A behavior has ended.
    pub(crate) fn heard_end(&mut self, identifier: Option<BehaviorId>) {
        if self.still_flown_after_end == identifier {
            self.still_flown_after_end = None;
        }
        if self.surfacing == identifier {
            self.surfacing = None;
        }
        self.forget(identifier);
    }

    fn forget(&mut self, identifier: Option<BehaviorId>) {
        if let Some(identifier) = identifier {
            self.left.remove(&identifier);
        }
    }

    /// Whether the vehicle flies an insert that was believed to be over.
    pub(crate) const fn is_still_flown_after_end(&self) -> bool {
        self.still_flown_after_end.is_some()
    }

    /// The vehicle's mission is over, and so is everything that was in it.
    pub(crate) const fn mission_over(&mut self) {
        self.over = true;
    }

    /// A message was lost, which may have been a begin.
    pub(crate) const fn invalidate_after_loss(&mut self) {
        self.heard = false;
    }

    /// The link is lost: what begins now is not heard.
    pub(crate) fn link_lost(&mut self) {
        self.heard = false;
        self.surfacing = None;
        self.cancelled.clear();
    }

    /// Whether inserts of previous runs may wait.
    pub(crate) fn has_left(&self) -> bool {
        !self.left.is_empty()
    }

    /// Whether the vehicle may still fly an insert of a previous run, or flies one that was believed to be over.
    /// `current` is the insert that the newest BFMBS named.
    pub(crate) fn may_fly(&self, current: Option<BehaviorId>, plan: &Plan) -> bool {
        self.is_still_flown_after_end()
            || self.inserted
                && (!self.heard
                    || !self.left.is_empty()
                    || current.is_some_and(|current| self.includes(current))
                    || plan.others(|identifier| !self.includes(identifier)).next().is_some())
    }

    /// Whether the vehicle may be on its way to the surface, by a GPS hit of a previous run or by one of this process
    /// that was believed to be over. `doubtful` says whether there is such a GPS hit of this process.
    pub(crate) fn may_surface(&self, doubtful: bool) -> bool {
        if self.is_still_flown_after_end() && doubtful {
            return true;
        }
        let any = !self.is_none() && self.gps_hits;
        any && (self.surfacing.is_some() || (!self.over && !self.heard))
    }

    /// The plan goes on. If it is known and has no insert of a previous run, all of those are over.
    pub(crate) fn plan_goes_on(&mut self, plan: &Plan) {
        let waits = !self.left.is_empty() || plan.others(|identifier| !self.includes(identifier)).next().is_some();
        if plan.is_complete() && !waits {
            self.over = true;
        }
    }

    /// The vehicle's plan is complete: it says what is left.
    pub(crate) fn heard_plan(&mut self, plan: &Plan) {
        let left = plan.others(|identifier| !self.includes(identifier));
        self.left = left.map(|(identifier, _)| identifier).collect();
    }

    /// The inserts that wait and were cancelled fewer than `most` times on this connection.
    pub(crate) fn waiting(&self, most: u32) -> Vec<BehaviorId> {
        let taken_back = |identifier: &&BehaviorId| self.cancelled.get(identifier).is_none_or(|sent| *sent < most);
        self.left.iter().filter(taken_back).copied().collect()
    }

    /// The vehicle's plan names an insert of a previous run. Returns whether that is new and the insert was not
    /// cancelled yet.
    pub(crate) fn named(&mut self, identifier: BehaviorId) -> bool {
        self.left.insert(identifier) && !self.cancelled.contains_key(&identifier)
    }

    /// The operator holds: all that waits may be cancelled again.
    pub(crate) fn held(&mut self) {
        self.cancelled.clear();
    }

    /// An insert of a previous run was cancelled once more.
    pub(crate) fn taken_back(&mut self, identifier: BehaviorId) {
        *self.cancelled.entry(identifier).or_default() += 1;
    }

    /// Whether an identifier is a previous run's.
    pub(crate) fn includes(&self, identifier: BehaviorId) -> bool {
        self.identifiers.contains(&identifier.get())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sr_002_an_insert_of_a_previous_run_that_an_incomplete_plan_names_may_be_flown() {
        let mut run = PreviousRun::new(Some(Identifiers {
            first: 1,
            next: 5,
            reserved: 5,
            inserts: 2,
            ..Identifiers::default()
        }));
        let plan = Plan::default();
        assert!(run.may_fly(None, &plan));
        run.heard_begin(None, "trackline", None);
        assert!(!run.may_fly(None, &plan));
        assert!(run.named(BehaviorId::new(3)));
        assert!(run.may_fly(None, &plan));
        run.heard_end(Some(BehaviorId::new(3)));
        assert!(!run.may_fly(None, &plan));
    }
}
