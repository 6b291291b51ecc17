//! A mock of the RESON 6046 payload controller (PLC): run list, sensors, logging, and the server side of the 7k protocol.
//!
//! Sans-IO: [`Plc`] reads no clock, no socket and no file. A driver calls, in this order:
//!
//! 1. An input, with the current time, which never goes back: [`Plc::connect`], [`Plc::disconnect`], [`Plc::receive`],
//!    [`Plc::set_blocked`], [`Plc::truth`], [`Plc::file_failed`] or [`Plc::handle_timeout`]. If [`Plc::poll_timeout`] is
//!    due, `handle_timeout` comes first.
//! 2. [`Plc::poll_transmit`], [`Plc::poll_disconnect`], [`Plc::poll_file`] and [`Plc::poll_event`], each until it
//!    returns `None`.
//! 3. [`Plc::poll_timeout`], which says when to call `handle_timeout`.
//!
//! The acoustics come from outside: `handle_timeout` takes a [`Sonar`], which fills in what each ping hears. The mock
//! knows the vehicle's true [`Pose`] only to hand it to the sonar. What it writes into records about the vehicle is what
//! its clients send it in records 3100.
//!
//! A driver sends without Nagle's delay, as the successor of the 6046 does. It carries out each [`FileEffect`], and
//! reports those that fail. It keeps the contents of the files `6046.sav` and `6046.cfg` for the next start: see
//! [`Stored`].
//!
//! The same [`PlcConfig`], seed and inputs give the same bytes. `runtime/docs/plc.md` says how the mock reads each
//! command, status and alarm of the specification.

mod clock;
mod config;
mod error;
mod event;
mod faults;
mod interpretation;
mod logging;
mod navigation;
mod plc;
mod server;
mod sonar;
mod suite;

pub use config::{
    BluefinChecksumName, DiskConfig, FaultEntry, FaultName, LayoutName, LoggingConfig, PlcConfig, PulseConfig,
    SensorEntry, SonarConfig,
};
pub use error::PlcError;
pub use event::{ClientId, DropReason, LogStop, PlcEvent, PlcEventKind};
pub use faults::{Fault, FaultEdge, FaultKind, FaultPlan};
pub use interpretation::{
    AcknowledgeOrder, AlarmsAtConnect, ClientAlarms, EventAlarmMode, InterpretationConfig, LoadedIndex, ResetReading,
    SensorStatus, VerboseAtConnect,
};
pub use logging::{FileEffect, FileFailure, FileId, FilePlace};
pub use plc::{Plc, Stored};
pub use sonar::{Ping, Pose, Pulse, SensorKind, Sonar};
