mod flow;
mod inserts;
mod modify;

use core::time::Duration;
use std::collections::{BTreeSet, VecDeque};

use backseat_spi::BehaviorId;
use backseat_units::{EastNorth, Timestamp};

use crate::course::{Course, Steer, crabbed_deg};
use crate::estimate::Estimate;
use crate::event::{Behavior, CancelCause, EndReason, ModifyEnd, ModifyVertical, MvcEventKind, Source, Status};
use crate::file::{MissionConfig, ModifyLimit, VehicleConfig, WrapUp};
use crate::hull::Hull;
use crate::insert::Insert;
use crate::interpretation::Interpretation;
use crate::modify::Modify;
use crate::plan::{PlanItem, Vertical};
use crate::truth::Activity;
use crate::vehicle::{Demand, Drive};

/// How many identifiers a mission may use up.
const IDENTIFIERS_MAX: usize = 100_000;
/// Above this depth the wrap-up is done, metres.
const SURFACED_M: f64 = 0.3;

/// The mission executive: which behavior is flown, what is inserted, who has control.
///
/// What happens is left in `log`, in order; the server tells it to the clients.
#[derive(Clone, Debug)]
pub(crate) struct Executive {
    pub(crate) log: Vec<MvcEventKind>,
    plan: Vec<PlanItem>,
    interpretation: Interpretation,
    hull: Hull,
    altitude_min_m: f64,
    limits: Limits,
    starts_at: Timestamp,
    status: Status,
    /// The planned element that is current: the one that is flown, or after which the inserts are flown.
    index: usize,
    element_began: Timestamp,
    running: Option<Running>,
    queue: VecDeque<Insert>,
    used: BTreeSet<BehaviorId>,
    /// The inserts that are flown have interrupted the plan.
    interrupting: bool,
    /// What an insert has interrupted, where it is to be resumed, and when.
    paused: Option<(Running, Timestamp)>,
    modify: Option<Modify>,
    /// How long the running behavior has been modified.
    modified: Duration,
    modify_barred: bool,
    control: bool,
    /// Control is not given, whatever the plan allows.
    control_denied: bool,
}

#[derive(Clone, Copy, Debug)]
struct Limits {
    tick: Duration,
    time_limit: Option<Duration>,
    inserts_max: u32,
    modify_total: Option<Duration>,
    modify_deviation_m: Option<f64>,
    modify_limit: ModifyLimit,
    wrap_up: WrapUp,
}

#[derive(Clone, Debug)]
struct Running {
    behavior: Behavior,
    course: Course,
    vertical: Vertical,
    speed_mps: f64,
    began: Timestamp,
    timeout: Option<Duration>,
    insert: Option<Insert>,
}

impl Executive {
    pub(crate) fn new(
        plan: Vec<PlanItem>,
        config: &MissionConfig,
        vehicle: &VehicleConfig,
        interpretation: Interpretation,
        tick: Duration,
    ) -> Self {
        Self {
            log: Vec::new(),
            plan,
            interpretation,
            hull: vehicle.hull(),
            altitude_min_m: vehicle.altitude_min_m,
            limits: Limits {
                tick,
                time_limit: config.time_limit_s.map(Duration::from_secs_f64),
                inserts_max: config.inserts_max,
                modify_total: config.modify_total_s.map(Duration::from_secs_f64),
                modify_deviation_m: config.modify_deviation_m,
                modify_limit: config.modify_limit,
                wrap_up: config.wrap_up,
            },
            starts_at: Timestamp::ZERO + Duration::from_secs_f64(config.starts_after_s),
            status: Status::Ready,
            index: 0,
            element_began: Timestamp::ZERO,
            running: None,
            queue: VecDeque::new(),
            used: BTreeSet::new(),
            interrupting: false,
            paused: None,
            modify: None,
            modified: Duration::ZERO,
            modify_barred: false,
            control: false,
            control_denied: false,
        }
    }

    pub(crate) const fn status(&self) -> Status {
        self.status
    }

    pub(crate) const fn control(&self) -> bool {
        self.control
    }

    /// Whether control is withheld though the plan allows it; the next step acts on it.
    pub(crate) const fn deny_control(&mut self, denied: bool) {
        self.control_denied = denied;
    }

    /// The vehicle ends the mission that runs, or is to run.
    pub(crate) fn fail_mission(&mut self, details: &'static str) {
        match self.status {
            Status::Ready | Status::Running | Status::WrappingUp => {
                self.finish(Status::Aborted, details, EndReason::MissionOver);
            }
            Status::Completed | Status::Aborted => {}
        }
    }

    pub(crate) fn plan(&self) -> &[PlanItem] {
        &self.plan
    }

    /// How many elements of the plan come before the inserts.
    pub(crate) fn inserts_after(&self) -> usize {
        self.index + 1
    }

    /// The inserts of the plan in the order in which they are flown, the running one first.
    pub(crate) fn inserts(&self) -> impl Iterator<Item = &Insert> {
        self.running
            .iter()
            .filter_map(|running| running.insert.as_ref())
            .chain(&self.queue)
    }

    pub(crate) fn activity(&self) -> Activity {
        match self.status {
            Status::Ready => Activity::Waiting,
            Status::WrappingUp => Activity::WrappingUp,
            Status::Completed | Status::Aborted => Activity::Stopped,
            Status::Running => match (
                self.running.as_ref().map(|running| running.behavior.source),
                self.modify,
            ) {
                (None, _) => Activity::Stopped,
                (Some(Source::Plan(number)), None) => Activity::Plan { number },
                (Some(Source::Insert(id)), None) => Activity::Insert { id },
                (Some(Source::Plan(number)), Some(_)) => Activity::Modified {
                    number: Some(number),
                    id: None,
                },
                (Some(Source::Insert(id)), Some(_)) => Activity::Modified {
                    number: None,
                    id: Some(id),
                },
            },
        }
    }

    /// One step of the mission: what is to move the vehicle now. `convergence_deg` is the angle from true north to
    /// the frame's.
    pub(crate) fn tick(&mut self, now: Timestamp, estimate: &Estimate, convergence_deg: f64) -> Drive {
        if self.status == Status::Ready && now >= self.starts_at {
            self.set_status(Status::Running, "");
            self.begin_planned(0, now, estimate.at);
        }
        self.lapse(now);
        if self
            .limits
            .time_limit
            .is_some_and(|limit| now >= self.starts_at + limit)
            && self.is_running()
        {
            self.finish(Status::Aborted, "time limit", EndReason::MissionOver);
        }
        let mut steer = self.steer(now, estimate);
        if let Some(flown) = steer
            && self.modify_beyond_limits(flown.off_line_m)
        {
            self.end_modify(ModifyEnd::Limit);
            match self.limits.modify_limit {
                ModifyLimit::Modify => self.modify_barred = true,
                ModifyLimit::Behavior => {
                    self.next(now, estimate.at, EndReason::ModifyLimit);
                    steer = self.steer(now, estimate);
                }
            }
        }
        if self.update_control(now, estimate.at) {
            steer = self.steer(now, estimate);
        }
        match (self.status, &self.running, steer) {
            (Status::Ready, _, _) => Drive::Held,
            (Status::WrappingUp, _, _) => {
                if estimate.depth_m < SURFACED_M {
                    self.set_status(Status::Completed, "");
                }
                let speed_mps = self.hull.speed_min_mps.max(0.3) * 2.0;
                Drive::Under(Demand {
                    heading_deg: estimate.heading_deg,
                    vertical: Vertical::Depth(0.0),
                    speed_mps,
                })
            }
            (Status::Running, Some(running), Some(steer)) => {
                Drive::Under(self.demand(running, &steer, estimate, convergence_deg))
            }
            (Status::Running | Status::Completed | Status::Aborted, _, _) => Drive::Adrift,
        }
    }

    fn is_running(&self) -> bool {
        self.status == Status::Running
    }

    /// Goes through behaviors that are at their end, and steers the first that is not.
    fn steer(&mut self, now: Timestamp, estimate: &Estimate) -> Option<Steer> {
        while self.is_running() {
            let running = self.running.as_mut()?;
            let steer = running.course.steer(estimate.at, running.speed_mps, &self.hull, now);
            let reason = if steer.done {
                EndReason::Done
            } else if running.timeout.is_some_and(|timeout| now >= running.began + timeout) {
                EndReason::TimedOut
            } else {
                return Some(steer);
            };
            self.next(now, estimate.at, reason);
        }
        None
    }

    fn demand(&self, running: &Running, steer: &Steer, estimate: &Estimate, convergence_deg: f64) -> Demand {
        let asked = self.modify.map(|modify| modify.values);
        let speed_mps = asked.and_then(|values| values.speed_mps).unwrap_or(running.speed_mps);
        let heading_deg = match asked.and_then(|values| values.heading_deg) {
            Some(true_deg) => true_deg - convergence_deg,
            None if steer.is_heading => steer.bearing_deg - convergence_deg,
            None => crabbed_deg(steer.bearing_deg, estimate.surge_mps, estimate.current),
        };
        let vertical = match asked.and_then(|values| values.vertical) {
            None => running.vertical,
            Some(ModifyVertical::Depth(depth)) => Vertical::Depth(depth),
            Some(ModifyVertical::Altitude(altitude)) => Vertical::Altitude(altitude),
            Some(ModifyVertical::Pitch(pitch)) => Vertical::Pitch(pitch),
        };
        Demand {
            heading_deg,
            vertical,
            speed_mps,
        }
    }

    /// Gives or takes back control where `allowDynamicRequests` has changed (SPI 6.24). Whether the running behavior
    /// has changed by it.
    fn update_control(&mut self, now: Timestamp, at: EastNorth) -> bool {
        let mut changed = false;
        // Dropped inserts pass on to the next element, which may allow requests again: at most a fall and a rise.
        for _ in 0..3 {
            let allowed = self.is_running()
                && !self.control_denied
                && self
                    .plan
                    .get(self.index)
                    .and_then(|item| item.dynamic)
                    .is_some_and(|(from, until)| {
                        let since = now.since(self.element_began);
                        since >= from && since < until
                    });
            if allowed == self.control {
                break;
            }
            self.set_control(allowed);
            if !allowed && !self.interpretation.inserts_fly_on {
                self.drop_queue(CancelCause::ControlLost, |_| true);
                if self.running.as_ref().is_some_and(|running| running.insert.is_some()) {
                    self.next(now, at, EndReason::ControlLost);
                    changed = true;
                }
            }
        }
        changed
    }

    fn set_control(&mut self, allowed: bool) {
        if !allowed {
            self.end_modify(if self.is_running() {
                ModifyEnd::ControlLost
            } else {
                ModifyEnd::MissionOver
            });
        }
        if self.control != allowed {
            self.control = allowed;
            self.log.push(MvcEventKind::Control(allowed));
        }
    }
}
