//! What the controller reports to its driver: a log of what happens inside it.

use core::fmt;
use std::collections::VecDeque;

use backseat_s7k::plc::{Alarm, Status};
use backseat_s7k::record::CommandStatus;
use backseat_s7k::{SensorIndex, plc::CommandId};
use backseat_units::Timestamp;

use crate::faults::{FaultEdge, FaultKind};
use crate::logging::{FileFailure, FilePlace};
use crate::server::Ignored;
use crate::sonar::SensorKind;

/// A client of the controller. The driver numbers the connections. The number is the client index of alarms 10, 11 and
/// 14.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct ClientId(pub u32);

impl fmt::Display for ClientId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "client {}", self.0)
    }
}

/// Why the controller closed a client's connection.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DropReason {
    /// Too many clients are connected.
    TooMany,
    /// The controller is shut down.
    ShutDown,
    /// A fault closes links.
    Fault,
    /// It sent a record that says that it has more bytes than are dropped for one: where its next record begins is not
    /// known.
    Astray,
}

impl fmt::Display for DropReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::TooMany => "too many clients",
            Self::ShutDown => "the controller is shut down",
            Self::Fault => "a fault closes links",
            Self::Astray => "one of its records claims a length that no record has",
        })
    }
}

/// Why logging ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LogStop {
    /// A client switched it off.
    Command,
    /// The disk is full.
    DiskFull,
    /// A file could not be written.
    Failed,
    /// The controller shuts down.
    ShutDown,
}

impl fmt::Display for LogStop {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Command => "a client switched it off",
            Self::DiskFull => "the disk is full",
            Self::Failed => "a file could not be written",
            Self::ShutDown => "the controller shuts down",
        })
    }
}

/// Something that happened, with its time.
#[derive(Clone, Debug, PartialEq)]
pub struct PlcEvent {
    /// When.
    pub at: Timestamp,
    /// What.
    pub kind: PlcEventKind,
}

/// What happened. `Display` makes one line for a log.
#[derive(Clone, Debug, PartialEq)]
pub enum PlcEventKind {
    /// A client connected.
    Connected(ClientId),
    /// A client's connection is gone.
    Disconnected(ClientId),
    /// The controller closed a client's connection.
    Dropped(ClientId, DropReason),
    /// A client sent a command, and what became of it. Whether the client was told is its verbose mode.
    Command {
        /// The client.
        client: ClientId,
        /// The command.
        command: CommandId,
        /// Whom it was for.
        sensor: SensorIndex,
        /// Its text, cut to 200 characters.
        text: Box<str>,
        /// What became of it.
        status: CommandStatus,
    },
    /// A status was sent, to one client or to all.
    Status(Option<ClientId>, Box<Status>),
    /// An alarm became active.
    Raised(Box<Alarm>),
    /// An alarm is over.
    Cleared(Box<Alarm>),
    /// An alarm without duration.
    Warned(Box<Alarm>),
    /// Bytes or records of a client could not be used since the last event about them.
    Ignored {
        /// The client.
        client: ClientId,
        /// What, by cause.
        what: Box<Ignored>,
    },
    /// Records for a client were lost since the last event about them, because it does not read.
    Lost {
        /// The client.
        client: ClientId,
        /// How many.
        records: u64,
    },
    /// A sensor starts.
    SensorStarting(SensorIndex, SensorKind),
    /// A sensor works.
    SensorStarted(SensorIndex, SensorKind),
    /// A sensor did not start.
    SensorStartFailed(SensorIndex, SensorKind),
    /// A sensor is down; `true` if its shutdown procedure succeeded.
    SensorDown(SensorIndex, SensorKind, bool),
    /// A log file was opened.
    LogOpened(FilePlace),
    /// Logging ended.
    LogStopped(LogStop),
    /// The driver reported that an effect on a file failed.
    FileFailed(FileFailure),
    /// The controller's clock was set, by so many nanoseconds.
    ClockSet(i64),
    /// A fault begins or ends: its number in the plan, from 1.
    Fault(u32, FaultEdge, FaultKind),
    /// The controller begins to shut down; `true` if the sensors and the operating system do too.
    ShuttingDown(bool),
    /// The controller is shut down: nothing happens any more.
    ShutDown,
}

impl fmt::Display for PlcEventKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Connected(client) => write!(f, "{client} connected"),
            Self::Disconnected(client) => write!(f, "{client} disconnected"),
            Self::Dropped(client, reason) => write!(f, "{client} cut off: {reason}"),
            Self::Command {
                client,
                command,
                sensor,
                text,
                status,
            } => {
                write!(f, "{client}: {command:?} to sensor {sensor} \"{text}\": {status:?}")
            }
            Self::Status(Some(client), status) => write!(f, "status {} to {client}", status.name()),
            Self::Status(None, status) => write!(f, "status {} to all clients", status.name()),
            Self::Raised(alarm) => write!(f, "alarm {} active: {}", alarm.name(), AlarmText(alarm)),
            Self::Cleared(alarm) => write!(f, "alarm {} over", alarm.name()),
            Self::Warned(alarm) => write!(f, "alarm {}: {}", alarm.name(), AlarmText(alarm)),
            Self::Ignored { client, what } => write!(f, "{client}: ignored {what}"),
            Self::Lost { client, records } => write!(f, "{client} does not read: {records} records lost"),
            Self::SensorStarting(index, kind) => write!(f, "sensor {index} ({kind}) starts"),
            Self::SensorStarted(index, kind) => write!(f, "sensor {index} ({kind}) works"),
            Self::SensorStartFailed(index, kind) => write!(f, "sensor {index} ({kind}) did not start"),
            Self::SensorDown(index, kind, true) => write!(f, "sensor {index} ({kind}) is down"),
            Self::SensorDown(index, kind, false) => write!(f, "sensor {index} ({kind}) did not shut down"),
            Self::LogOpened(place) => write!(f, "logging to {place}"),
            Self::LogStopped(why) => write!(f, "logging ended: {why}"),
            Self::FileFailed(failure) => write!(f, "a file failed: {failure}"),
            Self::ClockSet(nanos) => write!(f, "clock set by {:.3} s", *nanos as f64 / 1e9),
            Self::Fault(number, FaultEdge::Begin, kind) => write!(f, "fault {number} begins: {kind}"),
            Self::Fault(number, FaultEdge::End, kind) => write!(f, "fault {number} ends: {kind}"),
            Self::ShuttingDown(true) => f.write_str("shutting down with sensors and operating system"),
            Self::ShuttingDown(false) => f.write_str("shutting down"),
            Self::ShutDown => f.write_str("shut down"),
        }
    }
}

/// An alarm's text as it goes into its record.
struct AlarmText<'a>(&'a Alarm);

impl fmt::Display for AlarmText<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut text = String::new();
        match self.0.write(&mut text) {
            Ok(()) => f.write_str(&text),
            Err(error) => write!(f, "{error}"),
        }
    }
}

/// Events that the driver has not fetched.
#[derive(Debug, Default)]
pub(crate) struct Log(VecDeque<PlcEvent>);

impl Log {
    pub(crate) fn note(&mut self, at: Timestamp, kind: PlcEventKind) {
        self.0.push_back(PlcEvent { at, kind });
    }

    pub(crate) fn poll(&mut self) -> Option<PlcEvent> {
        self.0.pop_front()
    }
}
