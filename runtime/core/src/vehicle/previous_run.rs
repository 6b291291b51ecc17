//! What a previous run has left in the vehicle: inserts of its that may yet be flown (safety requirements 002,
//! 007, 010 and 015).
//!
//! The driver tells which identifiers the vehicle's mission has seen before this process began. The vehicle's plan
//! (BFPLN) tells which of them wait. Which one is flown now nobody tells whoever connects later, so that until the
//! vehicle says that a behavior begins, any of them may be.

use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use backseat_spi::BehaviorId;

use crate::io::Identifiers;
use crate::vehicle::plan::Plan;

/// What the vehicle calls an insert that keeps to its depth (SPI 6.9).
const PATHS: [&str; 2] = ["trackline", "trackcircle"];

/// The identifiers of previous runs, and what is known of their inserts.
#[derive(Debug, Default)]
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub(crate) struct PreviousRun {
    identifiers: Range<u32>,
    /// A behavior has begun on this connection: what is flown is known.
    heard: bool,
    /// An insert of this process that the vehicle flies though its request has come to its end: refused, yet done.
    still_flown_after_end: Option<BehaviorId>,
    /// What was in the vehicle's plan when it last came whole, and has not begun or ended since, on whatever connection.
    left: BTreeSet<BehaviorId>,
    /// One of them may have been a GPS hit.
    gps_hits: bool,
    /// Of theirs, what is flown and is no line and no circle by its name.
    surfacing: Option<BehaviorId>,
    /// All of theirs are over: the plan went on, and had none of them.
    over: bool,
    /// How often each was taken back on this connection.
    cancelled: BTreeMap<BehaviorId, u32>,
}

impl PreviousRun {
    pub(crate) fn new(identifiers: Option<Identifiers>) -> Self {
        Self {
            identifiers: identifiers.map_or(0..0, |identifiers| identifiers.first..identifiers.next),
            gps_hits: identifiers.is_some_and(|identifiers| identifiers.gps_hits > 0),
            ..Self::default()
        }
    }

    /// Whether this process is the first of the vehicle's mission.
    pub(crate) fn is_none(&self) -> bool {
        self.identifiers.is_empty()
    }

    /// A behavior begins, which may be one that was held to be over.
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

    /// Whether an insert is flown that was held to be over.
    pub(crate) const fn is_still_flown_after_end(&self) -> bool {
        self.still_flown_after_end.is_some()
    }

    /// The vehicle's mission is over, and what was in it.
    pub(crate) const fn mission_over(&mut self) {
        self.over = true;
    }

    /// Something was not heard, which may have been a begin.
    pub(crate) const fn invalidate_after_loss(&mut self) {
        self.heard = false;
    }

    /// The link is gone: what begins now is not heard.
    pub(crate) fn link_lost(&mut self) {
        self.heard = false;
        self.surfacing = None;
        self.cancelled.clear();
    }

    /// Whether the vehicle may yet fly an insert of theirs, where it is `current` that the newest BFMBS named, or flies one
    /// that was held to be over.
    pub(crate) fn may_fly(&self, current: Option<BehaviorId>, plan: &Plan) -> bool {
        self.is_still_flown_after_end()
            || !self.is_none()
                && (!self.heard
                    || current.is_some_and(|current| self.includes(current))
                    || plan.others(|identifier| !self.includes(identifier)).next().is_some())
    }

    /// Whether the vehicle may be on its way to the surface by one of theirs, or by a GPS hit of this process that was held
    /// to be over, where one is `doubtful`.
    pub(crate) fn may_surface(&self, doubtful: bool) -> bool {
        if self.is_still_flown_after_end() && doubtful {
            return true;
        }
        let any = !self.is_none() && self.gps_hits;
        any && (self.surfacing.is_some() || (!self.over && !self.heard))
    }

    /// The plan goes on: where it is known and has nothing of a previous run, all that was is over.
    pub(crate) fn plan_goes_on(&mut self, plan: &Plan) {
        let waits = !self.left.is_empty() || plan.others(|identifier| !self.includes(identifier)).next().is_some();
        if plan.is_complete() && !waits {
            self.over = true;
        }
    }

    /// The vehicle's plan has come whole: it says what is left.
    pub(crate) fn heard_plan(&mut self, plan: &Plan) {
        let left = plan.others(|identifier| !self.includes(identifier));
        self.left = left.map(|(identifier, _)| identifier).collect();
    }

    /// What waits and has been taken back less often than `most` on this connection.
    pub(crate) fn waiting(&self, most: u32) -> Vec<BehaviorId> {
        let taken_back = |identifier: &&BehaviorId| self.cancelled.get(identifier).is_none_or(|sent| *sent < most);
        self.left.iter().filter(taken_back).copied().collect()
    }

    /// The vehicle's plan names an insert of theirs; whether that is new, and has not been taken back.
    pub(crate) fn named(&mut self, identifier: BehaviorId) -> bool {
        self.left.insert(identifier) && !self.cancelled.contains_key(&identifier)
    }

    /// An insert of theirs has been taken back once more.
    pub(crate) fn taken_back(&mut self, identifier: BehaviorId) {
        *self.cancelled.entry(identifier).or_default() += 1;
    }

    /// Whether an identifier is a previous run's.
    pub(crate) fn includes(&self, identifier: BehaviorId) -> bool {
        self.identifiers.contains(&identifier.get())
    }
}
