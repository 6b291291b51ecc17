mod another_dive;
mod clipping;
pub(crate) mod dives;
mod ending;
mod ending_commands;
mod flow;
mod insert_commands;
mod inserts;
mod loading;
pub(crate) mod mission;
mod modify;
mod plan_report;
mod reports;
mod schedule;
mod steering;
mod suspend;

use core::time::Duration;
use std::collections::{BTreeSet, VecDeque};

use backseat_spi::{BehaviorId, Text};
use backseat_units::{EastNorth, Timestamp};

use crate::estimate::Estimate;
use crate::event::{Behavior, CancelCause, ClientId, EndReason, ModifyEnd, MvcEventKind, Source, Status};
use crate::file::{ControlWindow, MissionConfig, ModifyLimit, VehicleConfig, WrapUp};
use crate::interpretation::Interpretation;
use crate::plan::course::{Course, SURFACED_M};
use crate::plan::insert::Insert;
use crate::plan::{PayloadText, PlanItem};
use crate::script::ControlOrder;
use crate::truth::Activity;
use crate::vehicle::Vertical;
use crate::vehicle::performance::Performance;
use crate::vehicle::{Demand, Drive, Throttle, Turn};

/// The greatest number of identifiers that a mission can use.
const IDENTIFIERS_MAX: usize = 100_000;

/// The mission executive: it decides which behavior is flown, which inserts are in the plan, and who has control.
///
/// It adds what happens to `log`, in order. [`mission::Mission`] reports that to the clients.
#[derive(Clone, Debug)]
pub(crate) struct Executive {
    log: Vec<MvcEventKind>,
    plan: Vec<PlanItem>,
    interpretation: Interpretation,
    performance: Performance,
    altitude_min_m: f64,
    limits: Limits,
    /// When the dive that is ready starts; `None` if only an operator starts it.
    starts_at: Option<Timestamp>,
    /// When the operator calls the dive off, counted from its start, and whether that is an abort.
    called_off: Option<(Duration, bool)>,
    called_off_at: Option<Timestamp>,
    /// Whether the vehicle has been released: before its first mission it is held in place.
    released: bool,
    /// When the mission is aborted if it is still running.
    ends_at: Option<Timestamp>,
    status: Status,
    /// Why the mission ended. Later statuses repeat it.
    details: Text,
    /// Whether the mission is an empty one (SPI 7.20).
    empty: bool,
    /// The current behavior of the plan: the one that is flown, or the one after which the inserts are flown.
    index: usize,
    /// The element that it belongs to; 0 before the first.
    element: u32,
    element_began: Timestamp,
    /// The plan's last vertical setpoint and speed. The way to a GPS hit is flown with them.
    cruise: (Vertical, f64),
    running: Option<Running>,
    queue: VecDeque<Insert>,
    used: BTreeSet<BehaviorId>,
    /// Whether the inserts that are flown have interrupted the plan.
    interrupting: bool,
    /// The behaviors that inserts have interrupted and that will be resumed, and when each was interrupted. The last
    /// one is resumed first.
    paused: Vec<(Running, Timestamp)>,
    suspension: Option<suspend::Suspension>,
    modify: Option<modify::Modify>,
    /// How long the running behavior has been under a modify.
    modified: Duration,
    modify_barred: bool,
    /// The last modify that was refused, unless one has been accepted since.
    modify_refused: Option<(ClientId, &'static str)>,
    control: bool,
    /// Control is denied, whatever the plan allows.
    control_denied: bool,
    /// What a rule or the operator has ordered about control.
    control_order: ControlOrder,
}

#[derive(Clone, Copy, Debug)]
struct Limits {
    tick: Duration,
    inserts_max: u32,
    modify_total: Option<Duration>,
    modify_deviation_m: Option<f64>,
    modify_limit: ModifyLimit,
    time_limit: Option<Duration>,
    wrap_up: WrapUp,
    control: ControlWindow,
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
    /// The text for the payload when a trackline's lead-in or a trackcircle begins, and when its lead-out or it ends.
    message: Option<PayloadText>,
    /// Whether the payload has been told to log.
    logging: bool,
}

impl Executive {
    /// Without a dive, and with this status.
    pub(crate) fn new(
        config: &MissionConfig,
        vehicle: &VehicleConfig,
        interpretation: Interpretation,
        tick: Duration,
        status: Status,
    ) -> Self {
        let performance = vehicle.performance();
        Self {
            log: Vec::new(),
            plan: Vec::new(),
            interpretation,
            performance,
            altitude_min_m: vehicle.altitude_min_m,
            limits: Limits {
                tick,
                inserts_max: config.inserts_max,
                modify_total: config.modify_total_s.map(Duration::from_secs_f64),
                modify_deviation_m: config.modify_deviation_m,
                modify_limit: config.modify_limit,
                time_limit: config.time_limit_s.map(Duration::from_secs_f64),
                wrap_up: config.wrap_up,
                control: config.control,
            },
            starts_at: None,
            called_off: None,
            called_off_at: None,
            released: false,
            ends_at: None,
            status,
            details: Text::default(),
            empty: false,
            index: 0,
            element: 0,
            cruise: (Vertical::Depth(0.0), performance.speed_max_mps / 2.0),
            element_began: Timestamp::ZERO,
            running: None,
            queue: VecDeque::new(),
            used: BTreeSet::new(),
            interrupting: false,
            paused: Vec::new(),
            suspension: None,
            modify: None,
            modified: Duration::ZERO,
            modify_barred: false,
            modify_refused: None,
            control: false,
            control_denied: false,
            control_order: ControlOrder::Plan,
        }
    }

    /// Removes and returns what has happened since the last call, in order.
    pub(crate) fn take_log(&mut self) -> Vec<MvcEventKind> {
        core::mem::take(&mut self.log)
    }

    /// Takes back the vector from [`Executive::take_log`], to use its memory again.
    pub(crate) fn recycle_log(&mut self, log: Vec<MvcEventKind>) {
        // Reporting an event never adds another one, so the executive's log is still empty.
        self.log = log;
    }

    pub(crate) const fn status(&self) -> Status {
        self.status
    }

    pub(crate) const fn control(&self) -> bool {
        self.control
    }

    /// Sets whether control is denied although the plan allows it. It takes effect in the next step.
    pub(crate) const fn deny_control(&mut self, denied: bool) {
        self.control_denied = denied;
    }

    /// Sets what decides about control from now on. It takes effect in the next step.
    pub(crate) const fn order_control(&mut self, order: ControlOrder) {
        self.control_order = order;
    }

    /// The vehicle ends a mission that is running or waiting to start.
    pub(crate) fn fail_mission(&mut self, details: &'static str) {
        match self.status {
            Status::Running => self.end_mission(true, details),
            Status::Ready | Status::WrappingUp => self.finish(Status::Aborted, details),
            Status::Offline
            | Status::Waiting
            | Status::InvalidDiveFile
            | Status::InvalidWrapupFile
            | Status::Aborting
            | Status::Completed
            | Status::Aborted
            | Status::Stopped => {}
        }
    }

    pub(crate) fn plan(&self) -> &[PlanItem] {
        &self.plan
    }

    /// Whether the mission is an empty one, which has no dive file (SPI 7.20).
    pub(crate) const fn is_empty_mission(&self) -> bool {
        self.empty
    }

    pub(crate) const fn cruise(&self) -> (Vertical, f64) {
        self.cruise
    }

    /// How many behaviors of the plan come before the inserts. The place of inserts is "at the end of the current
    /// planned survey leg or trackcircle or before the beginning of the next one" (SPI 7.5).
    pub(crate) fn inserts_after(&self) -> usize {
        let after = self.index + 1;
        let inserted = self.running.as_ref().is_some_and(|running| running.insert.is_some());
        let on_leg = self.plan.get(self.index).is_some_and(|item| item.shape.is_leg());
        if inserted || on_leg || !self.interpretation.inserts_at_legs {
            return after;
        }
        let others = self.plan.iter().skip(after).position(|item| item.shape.is_leg());
        after + others.unwrap_or(0)
    }

    /// The inserts in the order in which they are flown: the running one, the waiting ones, and those that an insert
    /// has interrupted.
    pub(crate) fn inserts(&self) -> impl Iterator<Item = &Insert> {
        let begun = self.running.iter().filter_map(|running| running.insert.as_ref());
        let paused = self
            .paused
            .iter()
            .rev()
            .filter_map(|(running, _)| running.insert.as_ref());
        begun.chain(&self.queue).chain(paused)
    }

    pub(crate) fn activity(&self) -> Activity {
        match self.status {
            Status::Offline | Status::Waiting | Status::InvalidDiveFile | Status::InvalidWrapupFile | Status::Ready => {
                Activity::Waiting
            }
            Status::WrappingUp | Status::Aborting => Activity::WrappingUp,
            Status::Completed | Status::Aborted | Status::Stopped => Activity::Stopped,
            Status::Running if self.is_suspended() => Activity::Suspended,
            Status::Running => match (
                self.running.as_ref().map(|running| running.behavior.source),
                self.modify,
            ) {
                (None, _) => Activity::Stopped,
                (Some(Source::Plan(number)), None) => Activity::Plan { number },
                (Some(Source::Insert(id)), None) => Activity::Insert { id },
                (Some(Source::Empty), None) => Activity::Plan { number: 0 },
                (Some(Source::Empty), Some(_)) => Activity::Modified { number: None, id: None },
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

    /// One step of the mission. Returns what moves the vehicle now. `convergence_deg` is the angle from true north to
    /// the frame's north.
    pub(crate) fn tick(&mut self, now: Timestamp, estimate: &Estimate, convergence_deg: f64) -> Drive {
        if let Some(at) = self.starts_at.filter(|at| now >= *at && self.status == Status::Ready) {
            self.start(at, now, estimate.at);
        }
        self.lapse(now);
        if self.is_running() && self.ends_at.is_some_and(|at| now >= at) {
            self.end_mission(true, "time limit");
        }
        self.call_off(now);
        if let Some(drive) = self.fly_suspended(now, estimate) {
            return drive;
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
        match self.status {
            Status::Offline | Status::Waiting | Status::InvalidDiveFile | Status::InvalidWrapupFile | Status::Ready => {
                if self.released {
                    Drive::Adrift
                } else {
                    Drive::Held
                }
            }
            Status::WrappingUp | Status::Aborting => self.climb(estimate),
            Status::Running => self.drive(steer, estimate, convergence_deg),
            Status::Completed | Status::Aborted | Status::Stopped => Drive::Adrift,
        }
    }

    /// The wrap-up: a powered ascent (SPI 7.16).
    fn climb(&mut self, estimate: &Estimate) -> Drive {
        if estimate.depth_m < SURFACED_M {
            let over = if self.status == Status::Aborting {
                Status::Aborted
            } else {
                Status::Completed
            };
            let details = self.details.clone();
            self.set_status(over, details.as_str());
        }
        Drive::Under(Demand {
            turn: Turn::Heading(estimate.heading_deg),
            vertical: Vertical::Depth(0.0),
            throttle: Throttle::Speed(self.performance.speed_min_mps.max(0.3) * 2.0),
        })
    }

    fn is_running(&self) -> bool {
        self.status == Status::Running
    }

    /// Gives or takes back control if `allowDynamicRequests` has changed (SPI 6.24). Returns whether this has changed
    /// the running behavior.
    fn update_control(&mut self, now: Timestamp, at: EastNorth) -> bool {
        let mut changed = false;
        // When inserts are dropped, the next element may begin, and it may allow requests again. So control changes at
        // most twice.
        for _ in 0..3 {
            let allowed = !self.control_denied && self.allows_dynamic_requests(now);
            if allowed == self.control {
                break;
            }
            self.set_control(allowed);
            if !allowed && !self.interpretation.inserts_fly_on {
                self.drop_queue(CancelCause::ControlLost, |_| true);
                self.paused.retain(|(paused, _)| paused.insert.is_none());
                if self.running.as_ref().is_some_and(|running| running.insert.is_some()) {
                    self.next(now, at, EndReason::ControlLost);
                    changed = true;
                }
            }
        }
        changed
    }

    /// The value of "allowDynamicRequests" (SPI 6.24, 7.5).
    fn allows_dynamic_requests(&self, now: Timestamp) -> bool {
        let whole = match self.control_order {
            ControlOrder::Take => return false,
            ControlOrder::Give => true,
            ControlOrder::Plan => self.empty || self.limits.control == ControlWindow::Mission,
        };
        self.is_running()
            && (whole
                || self
                    .plan
                    .get(self.index)
                    .and_then(|item| item.dynamic)
                    .is_some_and(|(from, until)| {
                        let since = now.since(self.element_began);
                        since >= from && since < until
                    }))
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
