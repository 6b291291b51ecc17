//! What goes wrong in the vehicle, and when: by a plan, or as the run's driver injects it. Faults of the link are told
//! here and played by [`crate::FaultyLink`].

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

/// A fault of the run begins or ends: a line of the vehicle's log.
#[derive(Clone, Debug, PartialEq)]
pub struct FaultEvent {
    /// Its number, from 1: its place in the plan, after which those count that were injected.
    pub number: u32,
    /// Which of the two.
    pub edge: FaultEdge,
    /// What.
    pub kind: FaultKind,
}

/// Which end of a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaultEdge {
    /// It begins.
    Begin,
    /// It ends.
    End,
}
