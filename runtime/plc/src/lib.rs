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
//! ```
//! use backseat_plc::{ClientId, Ping, Plc, PlcConfig, SensorKind, Sonar, Stored};
//! use backseat_units::{Timestamp, Utc};
//!
//! /// A sonar that hears nothing.
//! struct Silence;
//!
//! impl Sonar for Silence {
//!     fn side_scan(&mut self, _: SensorKind, _: &Ping, _: &mut Vec<u16>, _: &mut Vec<u16>) {}
//!     fn sub_bottom(&mut self, _: &Ping, _: &mut Vec<[i16; 2]>) {}
//! }
//!
//! let config = PlcConfig { time_messages: true, ..PlcConfig::default() };
//! let mut plc = Plc::new(&config, 7, Utc::from_unix_nanos(1_795_442_400_000_000_000), &Stored::default())?;
//! plc.connect(Timestamp::ZERO, ClientId(1));
//! let mut now = Timestamp::ZERO;
//! let (mut bytes, mut sent) = (Vec::new(), 0);
//! while let Some(at) = plc.poll_timeout().filter(|at| *at <= Timestamp::from_secs(90)) {
//!     now = now.max(at);
//!     plc.handle_timeout(now, &mut Silence);
//!     while let Some(_client) = plc.poll_transmit(&mut bytes) {
//!         sent += bytes.len();
//!     }
//!     while plc.poll_disconnect().is_some() || plc.poll_file().is_some() || plc.poll_event().is_some() {}
//! }
//! // Two time messages: 84 bytes and a network frame of 36 each.
//! assert_eq!(sent, 2 * (84 + 36));
//! # Ok::<(), backseat_plc::PlcError>(())
//! ```
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
pub use navigation::Reported;
pub use plc::{Plc, Stored};
pub use server::Ignored;
pub use sonar::{Ping, Pose, Pulse, SensorKind, Sonar};
