use core::time::Duration;
use std::collections::{BTreeSet, VecDeque};

use backseat_spi::{AckStatus, Acknowledgement, BehaviorId, CommandName, ToVehicle};
use backseat_units::{EastNorth, Timestamp};

use super::{AckFilter, AckStage, Fault, FaultEdge, FaultEvent, FaultKind, FaultPlan, NegativeStatus};
use crate::error::MvcError;
use crate::event::{ClientId, MvcEventKind};
use crate::file::FaultFile;
use crate::mvc::Mvc;
use crate::power::SHUTDOWN_NOTICE;
use crate::sensors::Sensor;

/// How many acknowledgements may be late at once; beyond it they are lost.
const LATE_MAX: usize = 4096;

/// What goes wrong, and when.
#[derive(Debug, Default)]
pub(crate) struct Faults {
    plan: Vec<Fault>,
    /// Begins and ends in the order in which they happen, and how many have.
    edges: Vec<Edge>,
    happened: usize,
    /// When the next thing happens.
    next: Timestamp,
    /// What has begun and not ended, by its place in the plan.
    acting: BTreeSet<usize>,
    /// The faults of acknowledgements that act, by their place in the plan.
    acks: Vec<usize>,
    late: VecDeque<Late>,
    /// How many of a kind act at once.
    control_taken: u32,
    frozen: u32,
    missing: u32,
    dropouts: [u32; Sensor::ALL.len()],
}

#[derive(Clone, Copy, Debug)]
struct Edge {
    at: Timestamp,
    index: usize,
    edge: FaultEdge,
}

impl Edge {
    /// At one instant what lasts ends before anything begins; an instant's own end comes after its begin.
    fn order(&self, plan: &[Fault]) -> (Timestamp, bool, usize) {
        let lasts = !plan[self.index].lasts.is_zero();
        (self.at, !(lasts && self.edge == FaultEdge::End), self.index)
    }
}

#[derive(Clone, Debug)]
struct Late {
    due: Timestamp,
    client: ClientId,
    message: Acknowledgement,
}

/// What a fault makes of an acknowledgement.
pub(crate) enum Verdict {
    /// It comes, and says this.
    Says(AckStatus),
    Late(AckStatus, Duration),
    Lost,
}

impl Faults {
    pub(crate) fn new(file: &FaultFile) -> Result<Self, MvcError> {
        Ok(Self::of(file.plan()?, Timestamp::ZERO))
    }

    fn of(plan: FaultPlan, now: Timestamp) -> Self {
        let plan = plan.faults;
        let mut edges = Vec::with_capacity(2 * plan.len());
        for (index, fault) in plan.iter().enumerate() {
            // What is over before the run has the plan is no part of it.
            if fault.at < now && fault.until() <= now {
                continue;
            }
            for (at, edge) in [(fault.at, FaultEdge::Begin), (fault.until(), FaultEdge::End)] {
                let at = at.max(now);
                edges.push(Edge { at, index, edge });
            }
        }
        edges.sort_by_key(|edge| edge.order(&plan));
        let next = edges.first().map_or(Timestamp::MAX, |edge| edge.at);
        Self {
            plan,
            edges,
            next,
            ..Self::default()
        }
    }

    /// When [`Mvc::step_faults`] is due; [`Timestamp::MAX`] is never.
    pub(crate) const fn next(&self) -> Timestamp {
        self.next
    }

    /// Nobody is told any more.
    pub(crate) fn forget(&mut self, client: ClientId) {
        self.late.retain(|late| late.client != client);
        self.set_next();
    }

    /// What a command is answered instead of being done.
    pub(crate) fn refusal(&self, name: CommandName) -> Option<AckStatus> {
        self.acks.iter().find_map(|index| {
            if let FaultKind::AcksNegative {
                command,
                status,
                done: false,
            } = &self.plan[*index].kind
                && command.is_none_or(|command| command == name)
            {
                Some(status.as_status())
            } else {
                None
            }
        })
    }

    pub(crate) fn verdict(&self, name: CommandName, mut status: AckStatus) -> Verdict {
        let mut delay = Duration::ZERO;
        for index in &self.acks {
            let kind = &self.plan[*index].kind;
            if let FaultKind::AcksNegative {
                command,
                status: says,
                done: true,
            } = kind
                && command.is_none_or(|command| command == name)
                && status == AckStatus::Succeeded
            {
                status = says.as_status();
            }
            if let FaultKind::AcksLost(acks) = kind
                && acks.includes(name, status)
            {
                return Verdict::Lost;
            }
            if let FaultKind::AcksLate { acks, delay: by } = kind
                && acks.includes(name, status)
            {
                delay += *by;
            }
        }
        if delay.is_zero() {
            Verdict::Says(status)
        } else {
            Verdict::Late(status, delay)
        }
    }

    pub(crate) fn delay(&mut self, due: Timestamp, client: ClientId, message: Acknowledgement) {
        if self.late.len() < LATE_MAX {
            let place = self.late.partition_point(|late| late.due <= due);
            self.late.insert(place, Late { due, client, message });
            self.set_next();
        }
    }

    fn set_next(&mut self) {
        let edge = self.edges.get(self.happened).map_or(Timestamp::MAX, |edge| edge.at);
        let late = self.late.front().map_or(Timestamp::MAX, |late| late.due);
        self.next = edge.min(late);
    }

    /// Counts one more or one less that acts. Whether any does.
    fn count(of: &mut u32, edge: FaultEdge) -> bool {
        match edge {
            FaultEdge::Begin => *of += 1,
            FaultEdge::End => *of -= 1,
        }
        *of > 0
    }
}

impl AckFilter {
    fn includes(&self, name: CommandName, status: AckStatus) -> bool {
        self.command.is_none_or(|command| command == name)
            && match self.stage {
                AckStage::All => true,
                AckStage::Pending => status == AckStatus::Pending,
                AckStage::Outcome => status != AckStatus::Pending,
            }
    }
}

impl NegativeStatus {
    const fn as_status(self) -> AckStatus {
        match self {
            Self::Invalid => AckStatus::Invalid,
            Self::Failed => AckStatus::Failed,
        }
    }
}

/// The behavior that a command is about, as its acknowledgement names it.
pub(crate) fn ack_identifier(command: &ToVehicle) -> Option<BehaviorId> {
    if let ToVehicle::Trackline(request) = command {
        Some(request.identifier)
    } else if let ToVehicle::Trackcircle(request) = command {
        Some(request.identifier)
    } else if let ToVehicle::GpsHit(request) = command {
        Some(request.identifier)
    } else if let ToVehicle::CancelBehavior(request) = command {
        Some(request.identifier)
    } else {
        None
    }
}

impl Mvc {
    /// Replaces what goes wrong in this run: what acts ends, and what ought to act by the new plan begins at once. A
    /// fault that is over by then is left out.
    ///
    /// The driver of the link plays its faults by [`crate::LinkFaults`], made from the same plan.
    pub fn set_faults(&mut self, plan: FaultPlan) {
        let now = self.last_tick();
        for index in core::mem::take(&mut self.faults.acting) {
            self.edge(now, index, FaultEdge::End);
        }
        let late = core::mem::take(&mut self.faults.late);
        self.faults = Faults {
            late,
            ..Faults::of(plan, now)
        };
        self.faults.set_next();
    }

    /// Something goes wrong from now on, whatever `fault.at` says, for as long as the fault lasts. It is counted after
    /// those that the run has had, and does what it would have done as a part of the plan, but that all that was due by
    /// now has happened before it.
    ///
    /// Of a fault of the link only begin and end are told here: its driver plays it by [`crate::LinkFaults::inject`] and
    /// [`crate::FaultyLink::inject`].
    pub fn inject(&mut self, now: Timestamp, fault: Fault) {
        self.handle_timeout(now);
        let index = self.faults.plan.len();
        let instant = fault.lasts.is_zero();
        let fault = Fault { at: now, ..fault };
        let end = Edge {
            at: fault.until(),
            index,
            edge: FaultEdge::End,
        };
        self.faults.plan.push(fault);
        self.edge(now, index, FaultEdge::Begin);
        if instant {
            self.edge(now, index, FaultEdge::End);
        } else {
            let faults = &mut self.faults;
            let to_come = &faults.edges[faults.happened..];
            let place = to_come.partition_point(|edge| edge.order(&faults.plan) <= end.order(&faults.plan));
            faults.edges.insert(faults.happened + place, end);
        }
        self.faults.set_next();
        self.settle(now);
    }

    /// Everything of the plan that is due at `at`.
    pub(crate) fn step_faults(&mut self, at: Timestamp) {
        while let Some(edge) = self.faults.edges.get(self.faults.happened).copied()
            && edge.at <= at
        {
            self.faults.happened += 1;
            self.edge(at, edge.index, edge.edge);
        }
        while self.faults.late.front().is_some_and(|late| late.due <= at) {
            if let Some(late) = self.faults.late.pop_front() {
                let message = Acknowledgement {
                    created: self.stamp(at),
                    ..late.message
                };
                self.send(at, late.client, message.into());
            }
        }
        self.faults.set_next();
        self.settle(at);
    }

    fn edge(&mut self, at: Timestamp, index: usize, edge: FaultEdge) {
        let fault = self.faults.plan[index].clone();
        let number = u32::try_from(index + 1).unwrap_or(u32::MAX);
        self.note(
            at,
            MvcEventKind::Fault(FaultEvent {
                number,
                edge,
                kind: fault.kind.clone(),
            }),
        );
        let begins = edge == FaultEdge::Begin;
        if begins {
            self.faults.acting.insert(index);
        } else {
            self.faults.acting.remove(&index);
        }
        match fault.kind {
            // The link's driver plays it.
            FaultKind::Link(_) => {}
            FaultKind::AcksLost(_) | FaultKind::AcksLate { .. } | FaultKind::AcksNegative { .. } => {
                let acks = &mut self.faults.acks;
                acks.retain(|place| *place != index);
                if begins {
                    acks.push(index);
                    acks.sort_unstable();
                }
            }
            FaultKind::ControlTaken => {
                let denied = Faults::count(&mut self.faults.control_taken, edge);
                self.executive.deny_control(denied);
            }
            FaultKind::NavigationFrozen => {
                let frozen = Faults::count(&mut self.faults.frozen, edge);
                self.sensors.freeze(frozen);
            }
            FaultKind::NavigationMissing => {
                let missing = Faults::count(&mut self.faults.missing, edge);
                self.sensors.silence_navigation(missing);
            }
            FaultKind::Untrue(untrue) if begins => self.sensors.begin_untrue(index, untrue),
            FaultKind::Untrue(_) => self.sensors.end_untrue(index),
            FaultKind::AnotherDive { file, reversed } if begins => self.change_dive(at, file, reversed),
            FaultKind::SensorDropout(sensor) => {
                let out = Faults::count(&mut self.faults.dropouts[sensor as usize], edge);
                self.sensors.sensor_dropout(sensor, out);
            }
            FaultKind::NavigationJump(by) if begins => self.sensors.jump(by),
            FaultKind::NavigationJump(by) if !fault.lasts.is_zero() => self.sensors.jump(EastNorth::default() - by),
            FaultKind::ClockStep(nanos) if begins => self.step_clock(nanos),
            FaultKind::ClockStep(nanos) if !fault.lasts.is_zero() => self.step_clock(-nanos),
            FaultKind::MissionAbort if begins => self.executive.fail_mission("aborted by the vehicle"),
            FaultKind::Shutdown if begins => self.shut_down(at, at + SHUTDOWN_NOTICE),
            FaultKind::Shutdown => self.watch_power(at),
            FaultKind::NavigationJump(_)
            | FaultKind::ClockStep(_)
            | FaultKind::MissionAbort
            | FaultKind::AnotherDive { .. } => {}
        }
    }
}
