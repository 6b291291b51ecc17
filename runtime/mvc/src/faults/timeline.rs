use std::collections::BTreeSet;

use backseat_spi::Text;
use backseat_units::{EastNorth, Timestamp};

use super::{Fault, FaultEdge, FaultEvent, FaultKind, FaultPlan, Sensor, SensorFailure, Untrue};
use crate::error::MvcError;
use crate::file::FaultFile;

/// What goes wrong, and when.
#[derive(Debug, Default)]
pub(crate) struct Timeline {
    plan: Vec<Fault>,
    /// Begins and ends in the order in which they happen, and how many have.
    edges: Vec<Edge>,
    happened: usize,
    /// What has begun and not ended, by its place in the plan.
    acting: BTreeSet<usize>,
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

/// What the begin or the end of a fault does, and to which part of the vehicle.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Effect {
    /// Nothing: the link's driver plays it, or its end changes nothing.
    None,
    /// Acknowledgements: a fault with this place in the plan begins or ends.
    Acknowledgements(usize, FaultKind, FaultEdge),
    /// Control is withheld, or not.
    Control(bool),
    Sensors(SensorFailure),
    /// Navigation says what is not so, as the fault with this place in the plan has it, or no longer.
    Untrue(usize, Option<Untrue>),
    /// The vehicle flies another dive; its plan is reversed, or the same.
    AnotherDive(Text, bool),
    /// The clock is set forward or back, nanoseconds.
    Clock(i64),
    /// The mission is aborted.
    Abort,
    /// The payload's power is to go off, or is going off.
    Shutdown(FaultEdge),
}

impl Timeline {
    pub(crate) fn new(file: &FaultFile) -> Result<Self, MvcError> {
        Ok(Self::of(file.plan()?, Timestamp::ZERO))
    }

    /// What is left of a plan from `now` on.
    pub(crate) fn of(plan: FaultPlan, now: Timestamp) -> Self {
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
        Self {
            plan,
            edges,
            ..Self::default()
        }
    }

    /// When [`Timeline::next_due`] has more; [`Timestamp::MAX`] is never.
    pub(crate) fn next(&self) -> Timestamp {
        self.edges.get(self.happened).map_or(Timestamp::MAX, |edge| edge.at)
    }

    /// The next that begins or ends by now, by its place in the plan.
    pub(crate) fn next_due(&mut self, now: Timestamp) -> Option<(usize, FaultEdge)> {
        let edge = self.edges.get(self.happened).filter(|edge| edge.at <= now)?;
        self.happened += 1;
        Some((edge.index, edge.edge))
    }

    /// What acts, by its place in the plan.
    pub(crate) fn acting(&self) -> impl Iterator<Item = usize> + use<> {
        self.acting.clone().into_iter()
    }

    /// One more fault that begins now; its place in the plan. Where it lasts, its end is planned.
    pub(crate) fn inject(&mut self, now: Timestamp, fault: Fault) -> usize {
        let index = self.plan.len();
        let fault = Fault { at: now, ..fault };
        let end = Edge {
            at: fault.until(),
            index,
            edge: FaultEdge::End,
        };
        let instant = fault.lasts.is_zero();
        self.plan.push(fault);
        if !instant {
            let to_come = &self.edges[self.happened..];
            let place = to_come.partition_point(|edge| edge.order(&self.plan) <= end.order(&self.plan));
            self.edges.insert(self.happened + place, end);
        }
        index
    }

    /// A fault begins or ends: what the log says of it, and what it does.
    pub(crate) fn act(&mut self, index: usize, edge: FaultEdge) -> (FaultEvent, Effect) {
        let begins = edge == FaultEdge::Begin;
        if begins {
            self.acting.insert(index);
        } else {
            self.acting.remove(&index);
        }
        let Fault { lasts, kind, .. } = self.plan[index].clone();
        let event = FaultEvent {
            number: u32::try_from(index + 1).unwrap_or(u32::MAX),
            edge,
            kind: kind.clone(),
        };
        let effect = match kind {
            FaultKind::Link(_) => Effect::None,
            FaultKind::AcksLost(_) | FaultKind::AcksLate { .. } | FaultKind::AcksNegative { .. } => {
                Effect::Acknowledgements(index, kind, edge)
            }
            FaultKind::ControlTaken => Effect::Control(Self::count(&mut self.control_taken, edge)),
            FaultKind::NavigationFrozen => Effect::Sensors(SensorFailure::Frozen(Self::count(&mut self.frozen, edge))),
            FaultKind::NavigationMissing => {
                Effect::Sensors(SensorFailure::Silent(Self::count(&mut self.missing, edge)))
            }
            FaultKind::Untrue(untrue) => Effect::Untrue(index, begins.then_some(untrue)),
            FaultKind::AnotherDive { file, reversed } if begins => Effect::AnotherDive(file, reversed),
            FaultKind::SensorDropout(sensor) => {
                let out = Self::count(&mut self.dropouts[sensor as usize], edge);
                Effect::Sensors(SensorFailure::Dropout(sensor, out))
            }
            FaultKind::NavigationJump(by) if begins => Effect::Sensors(SensorFailure::Jump(by)),
            FaultKind::NavigationJump(by) if !lasts.is_zero() => {
                Effect::Sensors(SensorFailure::Jump(EastNorth::default() - by))
            }
            FaultKind::ClockStep(nanos) if begins => Effect::Clock(nanos),
            FaultKind::ClockStep(nanos) if !lasts.is_zero() => Effect::Clock(-nanos),
            FaultKind::MissionAbort if begins => Effect::Abort,
            FaultKind::Shutdown => Effect::Shutdown(edge),
            FaultKind::NavigationJump(_)
            | FaultKind::ClockStep(_)
            | FaultKind::MissionAbort
            | FaultKind::AnotherDive { .. } => Effect::None,
        };
        (event, effect)
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
