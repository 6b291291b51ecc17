use std::collections::BTreeSet;

use backseat_spi::Text;
use backseat_units::{EastNorth, Timestamp};

use super::{Fault, FaultEdge, FaultEvent, FaultKind, FaultPlan, Sensor, SensorFailure, Untrue};
use crate::error::MvcError;
use crate::file::{FAULTS_MAX, FaultFile};

/// The faults of a run, and when they begin and end.
#[derive(Debug, Default)]
pub(crate) struct Timeline {
    plan: Vec<Fault>,
    /// The begins and ends, in the order in which they happen.
    edges: Vec<Edge>,
    happened: usize,
    /// The faults that act now, by their place in the plan.
    acting: BTreeSet<usize>,
    /// How many faults of this kind act now; the same for the next three.
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
    /// If several edges are at the same time, faults with a duration end before others begin. An instantaneous fault
    /// ends after it begins.
    fn order(&self, plan: &[Fault]) -> (Timestamp, bool, usize) {
        let lasts = !plan[self.index].lasts.is_zero();
        (self.at, !(lasts && self.edge == FaultEdge::End), self.index)
    }
}

/// What the begin or the end of a fault does, and to which part of the vehicle.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Effect {
    /// Nothing: the link's driver plays the fault, or its end changes nothing.
    None,
    /// A fault of acknowledgements, with this place in the plan, begins or ends.
    Acknowledgements(usize, FaultKind, FaultEdge),
    /// Control is withheld (true) or given back (false).
    Control(bool),
    Sensors(SensorFailure),
    /// The fault with this place in the plan falsifies navigation messages in this way, or no longer.
    Untrue(usize, Option<Untrue>),
    /// The vehicle flies another dive, with the plan reversed (true) or the same plan (false).
    AnotherDive(Text, bool),
    /// The vehicle's clock is set forward by this much, nanoseconds; back if negative.
    Clock(i64),
    /// The mission is aborted.
    Abort,
    /// The payload's power will go off in a minute (begin), or goes off (end).
    Shutdown(FaultEdge),
}

impl Timeline {
    pub(crate) fn new(file: &FaultFile) -> Result<Self, MvcError> {
        Ok(Self::of(file.plan()?, Timestamp::ZERO))
    }

    /// A plan without the faults that were over before `now`. What should have begun before `now` begins now.
    pub(crate) fn of(plan: FaultPlan, now: Timestamp) -> Self {
        let plan = plan.faults;
        let mut edges = Vec::with_capacity(2 * plan.len());
        for (index, fault) in plan.iter().enumerate() {
            // Skip a fault that was over before the run got this plan.
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

    /// When [`Timeline::next_due`] returns the next edge; [`Timestamp::MAX`] means never.
    pub(crate) fn next(&self) -> Timestamp {
        self.edges.get(self.happened).map_or(Timestamp::MAX, |edge| edge.at)
    }

    /// The next fault that begins or ends by `now`, by its place in the plan.
    pub(crate) fn next_due(&mut self, now: Timestamp) -> Option<(usize, FaultEdge)> {
        let edge = self.edges.get(self.happened).filter(|edge| edge.at <= now)?;
        self.happened += 1;
        Some((edge.index, edge.edge))
    }

    /// The faults that act now, by their place in the plan.
    pub(crate) fn acting(&self) -> impl Iterator<Item = usize> + use<> {
        self.acting.clone().into_iter()
    }

    /// Whether no fault may be added by an order.
    pub(crate) const fn is_full(&self) -> bool {
        self.plan.len() >= FAULTS_MAX
    }

    /// Adds a fault that begins now, and returns its place in the plan. If the fault has a duration, its end is added
    /// to the edges.
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

    /// Begins or ends a fault: returns the line for the log, and what the fault does.
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

    /// Counts one more or one fewer, and returns whether any fault of the kind acts.
    fn count(of: &mut u32, edge: FaultEdge) -> bool {
        match edge {
            FaultEdge::Begin => *of += 1,
            FaultEdge::End => *of -= 1,
        }
        *of > 0
    }
}
