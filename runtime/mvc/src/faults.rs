//! What goes wrong in the vehicle, and when. Faults of the link are told here and played by [`crate::FaultyLink`].

mod active;
mod draw;
mod plan;
mod text;

pub(crate) use active::{Faults, Verdict, ack_identifier};
pub use plan::{
    AckFilter, AckStage, Directions, Fault, FaultKind, FaultPlan, LinkFault, LinkFaultKind, NegativeStatus, SensorKind,
    Whom,
};

/// A fault of the run's plan begins or ends: a line of the vehicle's log.
#[derive(Clone, Debug, PartialEq)]
pub struct FaultEvent {
    /// Its number in the plan, from 1.
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
