pub(crate) mod clock;
pub(crate) mod course;
pub(crate) mod dive;
pub(crate) mod expected;
pub(crate) mod integrity;
pub(crate) mod named_insert;
pub(crate) mod navigation;
pub(crate) mod phase;
pub(crate) mod plan;
pub(crate) mod previous_run;
pub(crate) mod relative;

use backseat_spi::BehaviorId;
use backseat_units::{LocalFrame, TimeOfDay, Timestamp};

use crate::control::{ClockSet, Newest};
use crate::io::Identifiers;
use crate::monitor::envelope::Suspended;
use crate::monitor::limits::Limits;
use crate::plugin::{CartesianSample, RelativeSample};
use crate::vehicle::course::Courses;
use crate::vehicle::dive::Dive;
use crate::vehicle::expected::Compared;
use crate::vehicle::named_insert::NamedInsert;
use crate::vehicle::navigation::Tracker;
use crate::vehicle::phase::Phase;
use crate::vehicle::plan::Plan;
use crate::vehicle::previous_run::PreviousRun;
use crate::vehicle::relative::Track;

/// What a BFMBS (`began`) or BFMBE said.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct HeardBehavior {
    pub(crate) created: TimeOfDay,
    pub(crate) began: bool,
    pub(crate) number: Option<u32>,
    pub(crate) identifier: Option<BehaviorId>,
}

/// What core believes of the vehicle. Each part follows what the vehicle reports about one thing.
#[derive(Debug)]
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub(crate) struct Vehicle {
    pub(crate) navigation: Tracker,
    pub(crate) relative: Track<RelativeSample>,
    pub(crate) cartesian: Track<CartesianSample>,
    pub(crate) dive: Dive,
    /// The newest BFMBS or BFMBE of this connection.
    pub(crate) behaviors: Newest,
    /// The newest message of any kind.
    pub(crate) latest: Newest,
    /// What the newest of them said.
    #[cfg_attr(feature = "explore", serde(skip))]
    pub(crate) heard_last: Option<HeardBehavior>,
    pub(crate) plan: Plan,
    pub(crate) compared: Compared,
    /// The phase of its mission.
    pub(crate) phase: Phase,
    pub(crate) courses: Courses,
    pub(crate) named_insert: NamedInsert,
    pub(crate) previous_run: PreviousRun,
    /// Where station keeping that has ended suspended the mission. The mission may not have gone on yet, because the
    /// vehicle may return to that place first. If it is suspended again before that, it is still suspended at that
    /// place (8.3).
    pub(crate) suspended: Vec<Suspended>,
    /// A plugin relies on silent mode.
    pub(crate) silent: bool,
}

impl Vehicle {
    pub(crate) fn new(frame: LocalFrame, limits: &Limits, identifiers: Option<Identifiers>) -> Self {
        let station = limits.station.as_ref();
        let previous_run = PreviousRun::new(identifiers);
        Self {
            navigation: Tracker::new(frame, limits),
            relative: Track::new(limits, station.is_some_and(|station| station.hull_box.is_some())),
            cartesian: Track::new(limits, station.is_some_and(|station| station.bottom_box.is_some())),
            dive: Dive::default(),
            behaviors: Newest::default(),
            latest: Newest::default(),
            heard_last: None,
            plan: Plan::default(),
            compared: Compared::default(),
            phase: Phase::default(),
            courses: Courses::new(!previous_run.is_none()),
            named_insert: NamedInsert::default(),
            previous_run,
            suspended: Vec::new(),
            silent: false,
        }
    }

    /// The connection is new or gone: forgets its samples and its plan.
    pub(crate) fn reset(&mut self) {
        self.navigation.reset();
        self.relative.reset();
        self.cartesian.reset();
        (self.behaviors, self.latest) = Default::default();
        self.heard_last = None;
        self.dive.connected();
        self.forget_plan();
    }

    /// The vehicle's clock was set.
    pub(crate) fn clock_set(&mut self, set: ClockSet) {
        self.behaviors.clock_set(set);
        self.latest.clock_set(set);
        self.dive.clock_set(set);
    }

    /// Forgets the plan, and whether it is the expected one.
    pub(crate) fn forget_plan(&mut self) {
        self.plan.forget();
        self.compared = Compared::default();
    }

    /// The mission has gone on: a behavior has begun, or the mission is over. So it is not suspended anywhere.
    pub(crate) fn mission_goes_on(&mut self) {
        self.suspended.clear();
    }

    /// A message was lost. It may have been the begin or the end of what is flown. What the vehicle made before the newest
    /// message until now came before that, and says nothing about what is flown now.
    pub(crate) fn invalidate_after_loss(&mut self, now: Timestamp) {
        if let Some(created) = self.latest.created() {
            self.behaviors.hear(now, created);
        }
        self.plan.invalidate_after_loss();
        self.previous_run.invalidate_after_loss();
        self.named_insert.invalidate_after_loss();
    }
}
