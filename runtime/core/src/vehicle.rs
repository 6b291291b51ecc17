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

use backseat_units::LocalFrame;

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

/// What is believed of the vehicle. Each part follows what the vehicle says of one thing.
#[derive(Debug)]
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub(crate) struct Vehicle {
    pub(crate) navigation: Tracker,
    pub(crate) relative: Track<RelativeSample>,
    pub(crate) cartesian: Track<CartesianSample>,
    pub(crate) dive: Dive,
    pub(crate) plan: Plan,
    pub(crate) compared: Compared,
    /// How far its mission is.
    pub(crate) phase: Phase,
    pub(crate) courses: Courses,
    pub(crate) named_insert: NamedInsert,
    pub(crate) previous_run: PreviousRun,
    /// Where its mission was suspended by station keeping that is over: it may not have gone on yet, for the vehicle may
    /// return there first, and one that is suspended meanwhile stands where it stood (8.3).
    pub(crate) suspended: Vec<Suspended>,
    /// A plugin counts on its silence.
    pub(crate) silent: bool,
}

impl Vehicle {
    pub(crate) fn new(frame: LocalFrame, limits: &Limits, identifiers: Option<Identifiers>) -> Self {
        let station = limits.station.as_ref();
        Self {
            navigation: Tracker::new(frame, limits),
            relative: Track::new(limits, station.is_some_and(|station| station.hull_box.is_some())),
            cartesian: Track::new(limits, station.is_some_and(|station| station.bottom_box.is_some())),
            dive: Dive::default(),
            plan: Plan::default(),
            compared: Compared::default(),
            phase: Phase::default(),
            courses: Courses::default(),
            named_insert: NamedInsert::default(),
            previous_run: PreviousRun::new(identifiers),
            suspended: Vec::new(),
            silent: false,
        }
    }

    /// The connection is new or gone: its samples and its plan are.
    pub(crate) fn reset(&mut self) {
        self.navigation.reset();
        self.relative.reset();
        self.cartesian.reset();
        self.forget_plan();
    }

    /// The plan is not known, nor whether it is the expected one.
    pub(crate) fn forget_plan(&mut self) {
        self.plan.forget();
        self.compared = Compared::default();
    }

    /// Its mission goes on, for a behavior has begun or it is over.
    pub(crate) fn mission_goes_on(&mut self) {
        self.suspended.clear();
    }

    /// Something was not heard, which may have been a begin or an end of what is flown.
    pub(crate) fn invalidate_after_loss(&mut self) {
        self.plan.invalidate_after_loss();
        self.courses.invalidate_after_loss();
        self.previous_run.invalidate_after_loss();
        self.named_insert.invalidate_after_loss();
    }
}
