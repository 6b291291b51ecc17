//! A mock of the Bluefin main vehicle computer: mission executive, vehicle, sensors, SPI server side.
//!
//! Sans-IO: [`Mvc`] reads no clock and no socket. A driver calls, in this order:
//!
//! 1. an input: [`Mvc::connect_from`], [`Mvc::disconnect`], [`Mvc::receive`] or [`Mvc::handle_timeout`], each with the time
//!    of now, which never goes back;
//! 2. then [`Mvc::poll_transmit`], [`Mvc::poll_disconnect`] and [`Mvc::poll_event`], each until it has no more;
//! 3. then [`Mvc::poll_timeout`], which says when to call `handle_timeout`.
//!
//! Everything happens in steps of the vehicle, ten a second unless configured: its motion, its navigation messages,
//! the lapse of a modify, the outcome of a pending request. What a client sends is answered at once.
//!
//! The mock is the honest other side: it shares the sentences and the quantities with the runtime, and nothing that
//! judges. What it knows and a payload cannot is in [`Mvc::truth`] and [`Mvc::world`]. The same [`WorldFile`], seed
//! and inputs give the same bytes.
//!
//! What goes wrong is a [`FaultPlan`]: the vehicle's own faults act in here, those of the link are played by a driver
//! with [`LinkFaults`], and each begin and end is an event.
//!
//! Deliberately absent so far: GPS hits, trim and buoyancy, silent mode, the hovering hull's suspension, DVL
//! triggering, acoustic communications, and the payload's abort and kill. Those commands are known and refused.

mod acoustic;
mod adjustment;
mod aiding;
mod answers;
mod commands;
mod course;
mod dvl_trigger;
mod ending;
mod error;
mod estimate;
mod event;
mod executive;
mod faults;
mod file;
mod hovering;
mod hull;
mod insert;
mod interpretation;
mod link;
mod mission_commands;
mod modify;
mod mvc;
mod plan;
mod plan_report;
mod power;
mod requests;
mod sensors;
mod server;
mod silence;
mod surfacing;
mod topside;
mod truth;
mod vehicle;

pub use error::MvcError;
pub use event::{
    Behavior, CancelCause, ClientId, DropReason, EndReason, ModifyEnd, ModifyValues, ModifyVertical, MvcEvent,
    MvcEventKind, Refusal, Source, Status,
};
pub use faults::{
    AckFilter, AckStage, Directions, Fault, FaultEdge, FaultEvent, FaultKind, FaultPlan, LinkFault, LinkFaultKind,
    NegativeStatus, SensorKind, Whom,
};
pub use file::{
    AcknowledgeConfig, AfterInterrupt, CancelAllScope, Choice, ContourExpectation, DirectionName, Expectations,
    FaultEntry, FaultFile, FaultName, HeadingFrame, InsertsAfterControl, InterpretationConfig, MaximumExpectation,
    MissionCommandConfig, MissionConfig, ModifyLimit, PlaceConfig, PlanEntry, PlanKind, Profile, RoleConfig, RoleError,
    SensorConfig, SensorName, SpiConfig, StageName, StartConfig, VehicleConfig, WithoutRole, WorldFile, WrapUp,
};
pub use hull::{Hull, HullClass};
pub use interpretation::Interpretation;
pub use link::{Chunk, Direction, FaultyLink, LinkFaults};
pub use mvc::Mvc;
pub use truth::{Activity, Truth};
