//! What goes wrong in a run and when: from a fault plan, or injected by the driver. This module only logs the faults of
//! the link; [`crate::FaultyLink`] plays them.

mod draw;
mod plan;
mod sensor;
mod text;
pub(crate) mod timeline;

pub use plan::{
    AckFilter, AckStage, Directions, Fault, FaultKind, FaultPlan, LinkFault, LinkFaultKind, NegativeStatus, Untrue,
    Whom,
};
pub use sensor::{Sensor, SensorFailure};

/// A fault begins or ends: a line of the vehicle's log.
#[derive(Clone, Debug, PartialEq)]
pub struct FaultEvent {
    /// Its number, from 1: its place in the plan. Injected faults have the numbers after those of the plan.
    pub number: u32,
    /// Whether it begins or ends.
    pub edge: FaultEdge,
    /// What goes wrong.
    pub kind: FaultKind,
}

/// The begin or the end of a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaultEdge {
    /// It begins.
    Begin,
    /// It ends.
    End,
}
