use std::collections::BTreeSet;

use backseat_units::Timestamp;

use super::{Fault, FaultEdge, FaultKind, FaultPlan};
use crate::sonar::SensorKind;

/// The begins and ends of a plan in the order of their times, and which faults act now.
#[derive(Debug)]
pub(crate) struct Timeline {
    plan: Vec<Fault>,
    /// Each with the place of its fault in the plan.
    edges: Vec<(Timestamp, FaultEdge, usize)>,
    happened: usize,
    acting: BTreeSet<usize>,
}

impl Timeline {
    pub(crate) fn new(plan: FaultPlan) -> Self {
        let plan = plan.faults;
        let mut edges = Vec::with_capacity(2 * plan.len());
        for (index, fault) in plan.iter().enumerate() {
            edges.push((fault.at, FaultEdge::Begin, index));
            edges.push((fault.at + fault.lasts, FaultEdge::End, index));
        }
        // At one time faults that last end before others begin, and an instantaneous one ends after it begins.
        edges.sort_by_key(|(at, edge, index)| {
            let lasts = !plan[*index].lasts.is_zero();
            (
                *at,
                !(lasts && *edge == FaultEdge::End),
                *index,
                *edge == FaultEdge::End,
            )
        });
        Self {
            plan,
            edges,
            happened: 0,
            acting: BTreeSet::new(),
        }
    }

    /// When the next fault begins or ends; [`Timestamp::MAX`] means never.
    pub(crate) fn next(&self) -> Timestamp {
        self.edges.get(self.happened).map_or(Timestamp::MAX, |(at, ..)| *at)
    }

    /// The next begin or end: the fault's number from 1, and what it is.
    pub(crate) fn advance(&mut self) -> Option<(u32, FaultEdge, FaultKind)> {
        let (_, edge, index) = *self.edges.get(self.happened)?;
        self.happened += 1;
        match edge {
            FaultEdge::Begin => self.acting.insert(index),
            FaultEdge::End => self.acting.remove(&index),
        };
        let number = u32::try_from(index + 1).unwrap_or(u32::MAX);
        Some((number, edge, self.plan[index].kind))
    }

    /// Adds a fault that begins now, and returns its number.
    pub(crate) fn inject(&mut self, now: Timestamp, fault: Fault) -> u32 {
        let index = self.plan.len();
        let end = now + fault.lasts;
        // The begin comes before everything that is still to happen, and the end after what ends at the same time.
        self.edges.insert(self.happened, (now, FaultEdge::Begin, index));
        let to_come = &self.edges[self.happened + 1..];
        let place = self.happened + 1 + to_come.partition_point(|(at, ..)| *at <= end);
        self.edges.insert(place, (end, FaultEdge::End, index));
        self.plan.push(Fault { at: now, ..fault });
        u32::try_from(index + 1).unwrap_or(u32::MAX)
    }

    /// The faults that act now, in the order of the plan.
    pub(crate) fn acting(&self) -> impl Iterator<Item = &FaultKind> {
        self.acting.iter().map(|index| &self.plan[*index].kind)
    }

    /// Whether a fault of this kind without parameters acts.
    pub(crate) fn acts(&self, kind: &FaultKind) -> bool {
        self.acting().any(|acting| acting == kind)
    }

    pub(crate) fn is_unhealthy(&self, sensor: SensorKind) -> bool {
        let unhealthy = |kind: &FaultKind| matches!(kind, FaultKind::SensorUnhealthy { .. });
        self.acting()
            .any(|kind| unhealthy(kind) && kind.sensor() == Some(sensor))
    }

    /// The chance that a ping of this sensor is dropped: the greatest of those that act.
    pub(crate) fn drop_chance(&self, sensor: SensorKind) -> f64 {
        self.greatest(|kind| {
            if let FaultKind::PingsDropped { sensor: of, chance } = *kind
                && of == sensor
            {
                Some(chance)
            } else {
                None
            }
        })
    }

    pub(crate) fn wrong_checksum_chance(&self) -> f64 {
        self.greatest(|kind| {
            if let FaultKind::ChecksumsWrong { chance } = *kind {
                Some(chance)
            } else {
                None
            }
        })
    }

    /// Records a second of all floods that act.
    pub(crate) fn flood_per_s(&self) -> f64 {
        let rate = |kind: &FaultKind| {
            if let FaultKind::Flood { records_per_s } = *kind {
                Some(records_per_s)
            } else {
                None
            }
        };
        self.acting().filter_map(rate).sum()
    }

    /// Bytes a second of all garbage that acts.
    pub(crate) fn garbage_per_s(&self) -> f64 {
        let rate = |kind: &FaultKind| {
            if let FaultKind::Garbage { bytes_per_s } = *kind {
                Some(bytes_per_s)
            } else {
                None
            }
        };
        self.acting().filter_map(rate).sum()
    }

    fn greatest(&self, chance: impl Fn(&FaultKind) -> Option<f64>) -> f64 {
        self.acting().filter_map(chance).fold(0.0, f64::max)
    }
}
