use std::collections::{BTreeSet, VecDeque};

use backseat_spi::BehaviorId;
use backseat_units::{EastNorth, Timestamp};
use core::time::Duration;

use crate::course::{Course, Steer, crabbed_deg};
use crate::event::{
    Behavior, CancelCause, ClientId, EndReason, MODIFY_LASTS, ModifyEnd, ModifyValues, ModifyVertical, MvcEventKind,
    Refusal, Source, Status,
};
use crate::file::{MissionConfig, ModifyLimit, WrapUp};
use crate::insert::Insert;
use crate::interpretation::Interpretation;
use crate::modify::Modify;
use crate::plan::{PlanItem, Vertical};
use crate::truth::Activity;
use crate::vehicle::{Demand, Drive, Vehicle};

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
        interpretation: Interpretation,
        tick: Duration,
    ) -> Self {
        Self {
            log: Vec::new(),
            plan,
            interpretation,
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
        }
    }

    pub(crate) const fn status(&self) -> Status {
        self.status
    }

    pub(crate) const fn control(&self) -> bool {
        self.control
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
    pub(crate) fn tick(&mut self, now: Timestamp, vehicle: &Vehicle, convergence_deg: f64) -> Drive {
        if self.status == Status::Ready && now >= self.starts_at {
            self.set_status(Status::Running, "");
            self.begin_planned(0, now, vehicle.at);
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
        let mut steer = self.steer(now, vehicle);
        if let Some(flown) = steer
            && self.modify_beyond_limits(flown.off_line_m)
        {
            self.end_modify(ModifyEnd::Limit);
            match self.limits.modify_limit {
                ModifyLimit::Modify => self.modify_barred = true,
                ModifyLimit::Behavior => {
                    self.next(now, vehicle.at, EndReason::ModifyLimit);
                    steer = self.steer(now, vehicle);
                }
            }
        }
        if self.update_control(now, vehicle.at) {
            steer = self.steer(now, vehicle);
        }
        match (self.status, &self.running, steer) {
            (Status::Ready, _, _) => Drive::Held,
            (Status::WrappingUp, _, _) => {
                if vehicle.depth_m < SURFACED_M {
                    self.set_status(Status::Completed, "");
                }
                let speed_mps = vehicle.hull().speed_min_mps.max(0.3) * 2.0;
                Drive::Under(Demand {
                    heading_deg: vehicle.heading_deg,
                    vertical: Vertical::Depth(0.0),
                    speed_mps,
                })
            }
            (Status::Running, Some(running), Some(steer)) => {
                Drive::Under(self.demand(running, &steer, vehicle, convergence_deg))
            }
            (Status::Running | Status::Completed | Status::Aborted, _, _) => Drive::Adrift,
        }
    }

    /// Takes a modify (SPI 7.12), or says why not.
    pub(crate) fn modify(
        &mut self,
        now: Timestamp,
        client: ClientId,
        values: ModifyValues,
    ) -> Result<(), &'static str> {
        if !self.control {
            return Err("dynamic requests are not allowed now");
        }
        if self.modify_barred {
            return Err("this behavior has been modified for too long or too far");
        }
        if self
            .modify
            .is_none_or(|modify| modify.values != values || modify.client != client)
        {
            self.log.push(MvcEventKind::Modify(client, values));
        }
        self.modify = Some(Modify {
            client,
            values,
            until: now + MODIFY_LASTS,
        });
        Ok(())
    }

    /// BPEMB: whether there was a modify to end.
    pub(crate) fn end_modify_asked(&mut self) -> bool {
        let active = self.modify.is_some();
        self.end_modify(ModifyEnd::Ended);
        active
    }

    /// Adds an insert to the plan, or says why not.
    pub(crate) fn insert(&mut self, now: Timestamp, insert: Insert, vehicle: &Vehicle) -> Result<(), Refusal> {
        if !self.control {
            return Err(Refusal::NotAllowed);
        }
        if self.used.contains(&insert.id) {
            return Err(Refusal::Duplicate);
        }
        insert.within(vehicle.hull(), vehicle.altitude_min_m())?;
        if insert.interrupt && self.interrupting {
            return Err(Refusal::InterruptsInterrupt);
        }
        if self.queue.len() >= self.limits.inserts_max as usize || self.used.len() >= IDENTIFIERS_MAX {
            return Err(Refusal::Full(self.queue.len() as u32));
        }
        self.used.insert(insert.id);
        self.log.push(MvcEventKind::InsertAccepted(insert.client, insert.id));
        if insert.interrupt {
            self.interrupt(now, insert, vehicle.at);
        } else {
            self.queue.push_back(insert);
        }
        Ok(())
    }

    /// BPRCN: takes a waiting insert out of the plan, or says why not.
    pub(crate) fn cancel(&mut self, client: ClientId, id: BehaviorId) -> Result<(), &'static str> {
        if let Some(at) = self.queue.iter().position(|insert| insert.id == id) {
            self.queue.remove(at);
            self.log
                .push(MvcEventKind::InsertCancelled(id, CancelCause::Asked(client)));
            return Ok(());
        }
        if self.inserts().any(|insert| insert.id == id) {
            return Err("the behavior has begun");
        }
        Err("no such behavior is waiting")
    }

    /// BPRCA: takes the waiting inserts out of the plan, and says how many.
    pub(crate) fn cancel_all(&mut self, client: ClientId) -> usize {
        let all = self.interpretation.cancel_all;
        self.drop_queue(CancelCause::Asked(client), |insert| all || insert.client == client)
    }

    fn is_running(&self) -> bool {
        self.status == Status::Running
    }

    /// Goes through behaviors that are at their end, and steers the first that is not.
    fn steer(&mut self, now: Timestamp, vehicle: &Vehicle) -> Option<Steer> {
        while self.is_running() {
            let running = self.running.as_mut()?;
            let steer = running.course.steer(vehicle.at, running.speed_mps, vehicle.hull(), now);
            let reason = if steer.done {
                EndReason::Done
            } else if running.timeout.is_some_and(|timeout| now >= running.began + timeout) {
                EndReason::TimedOut
            } else {
                return Some(steer);
            };
            self.next(now, vehicle.at, reason);
        }
        None
    }

    fn demand(&self, running: &Running, steer: &Steer, vehicle: &Vehicle, convergence_deg: f64) -> Demand {
        let asked = self.modify.map(|modify| modify.values);
        let speed_mps = asked.and_then(|values| values.speed_mps).unwrap_or(running.speed_mps);
        let heading_deg = match asked.and_then(|values| values.heading_deg) {
            Some(true_deg) => true_deg - convergence_deg,
            None if steer.is_heading => steer.bearing_deg - convergence_deg,
            None => crabbed_deg(steer.bearing_deg, vehicle.surge_mps, vehicle.current),
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

    fn modify_beyond_limits(&mut self, off_line_m: f64) -> bool {
        if self.modify.is_none() {
            return false;
        }
        self.modified += self.limits.tick;
        self.limits.modify_total.is_some_and(|limit| self.modified > limit)
            || self.limits.modify_deviation_m.is_some_and(|limit| off_line_m > limit)
    }

    /// Gives or takes back control where `allowDynamicRequests` has changed (SPI 6.24). Whether the running behavior
    /// has changed by it.
    fn update_control(&mut self, now: Timestamp, at: EastNorth) -> bool {
        let mut changed = false;
        // Dropped inserts pass on to the next element, which may allow requests again: at most a fall and a rise.
        for _ in 0..3 {
            let allowed = self.is_running()
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

    fn interrupt(&mut self, now: Timestamp, insert: Insert, at: EastNorth) {
        if let Some(running) = self.end_running(EndReason::Interrupted)
            && self.interpretation.resume
        {
            match running.insert {
                None => self.paused = Some((running, now)),
                Some(interrupted) => self.queue.push_back(interrupted),
            }
        }
        self.interrupting = true;
        self.begin_insert(insert, now, at);
    }

    /// Ends the running behavior and begins what comes after it: an insert, what was interrupted, the next element.
    fn next(&mut self, now: Timestamp, at: EastNorth, reason: EndReason) {
        self.end_running(reason);
        if let Some(insert) = self.queue.pop_front() {
            self.begin_insert(insert, now, at);
            return;
        }
        self.interrupting = false;
        if let Some((mut running, since)) = self.paused.take() {
            let pause = now.since(since);
            running.course.resume(pause);
            running.began = running.began + pause;
            self.begin(running);
        } else if self.index + 1 < self.plan.len() {
            self.begin_planned(self.index + 1, now, at);
        } else {
            match self.limits.wrap_up {
                WrapUp::None => self.finish(Status::Completed, "", EndReason::Done),
                WrapUp::Surface => self.finish(Status::WrappingUp, "", EndReason::Done),
            }
        }
    }

    fn end_running(&mut self, reason: EndReason) -> Option<Running> {
        let running = self.running.take()?;
        (self.modified, self.modify_barred) = (Duration::ZERO, false);
        self.log.push(MvcEventKind::BehaviorEnded(running.behavior, reason));
        Some(running)
    }

    fn begin_planned(&mut self, index: usize, now: Timestamp, at: EastNorth) {
        let item = self.plan[index];
        (self.index, self.element_began) = (index, now);
        self.begin(Running {
            behavior: Behavior {
                source: Source::Plan(item.number),
                kind: item.shape.kind(),
            },
            course: Course::begin(item.shape, at, now),
            vertical: item.vertical,
            speed_mps: item.speed_mps,
            began: now,
            timeout: item.timeout,
            insert: None,
        });
    }

    fn begin_insert(&mut self, insert: Insert, now: Timestamp, at: EastNorth) {
        let shape = insert.flown(self.interpretation.lead_in_m);
        self.begin(Running {
            behavior: Behavior {
                source: Source::Insert(insert.id),
                kind: shape.kind(),
            },
            course: Course::begin(shape, at, now),
            vertical: insert.vertical,
            speed_mps: insert.speed_mps,
            began: now,
            timeout: None,
            insert: Some(insert),
        });
    }

    fn begin(&mut self, running: Running) {
        self.log.push(MvcEventKind::BehaviorBegan(running.behavior));
        self.running = Some(running);
    }

    /// The mission leaves `Running`.
    fn finish(&mut self, status: Status, details: &'static str, reason: EndReason) {
        self.end_running(reason);
        self.paused = None;
        self.drop_queue(CancelCause::MissionOver, |_| true);
        self.status = status;
        self.set_control(false);
        self.log.push(MvcEventKind::Mission { status, details });
    }

    fn set_status(&mut self, status: Status, details: &'static str) {
        self.status = status;
        self.log.push(MvcEventKind::Mission { status, details });
    }

    /// When the modify lapses unless it is refreshed.
    pub(crate) fn modify_until(&self) -> Option<Timestamp> {
        self.modify.map(|modify| modify.until)
    }

    /// Ends a modify whose time is over.
    pub(crate) fn lapse(&mut self, now: Timestamp) {
        if self.modify_until().is_some_and(|until| now >= until) {
            self.end_modify(ModifyEnd::Lapsed);
        }
    }

    fn end_modify(&mut self, why: ModifyEnd) {
        if self.modify.take().is_some() {
            self.log.push(MvcEventKind::ModifyEnded(why));
        }
    }

    fn drop_queue(&mut self, cause: CancelCause, of: impl Fn(&Insert) -> bool) -> usize {
        let before = self.queue.len();
        let log = &mut self.log;
        self.queue.retain(|insert| {
            let dropped = of(insert);
            if dropped {
                log.push(MvcEventKind::InsertCancelled(insert.id, cause));
            }
            !dropped
        });
        before - self.queue.len()
    }
}
