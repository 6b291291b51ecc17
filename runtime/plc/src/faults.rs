//! What goes wrong in a run and when.

mod draw;
mod timeline;

use core::time::Duration;

use backseat_s7k::plc::FailureCause;
use backseat_units::Timestamp;

use crate::config::FaultName;
use crate::sonar::SensorKind;

pub(crate) use timeline::Timeline;

/// What goes wrong in a run, and when. A plan is data: it can be printed, stored and shrunk.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FaultPlan {
    /// The faults, in any order. A fault's number is its place here, from 1.
    pub faults: Vec<Fault>,
}

/// One fault, with its time.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    /// When it begins.
    pub at: Timestamp,
    /// How long it lasts; zero for an instantaneous fault.
    pub lasts: Duration,
    /// What goes wrong.
    pub kind: FaultKind,
}

/// What goes wrong.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FaultKind {
    /// The sensor neither pings nor answers (alarm 2, and 9, 11, 12, 13 for what is asked of it). It goes on where it
    /// was when the fault ends.
    SensorDies(SensorKind),
    /// The sensor reports a failure (alarm 4) and fails its health check (alarm 5). It works all the same.
    SensorUnhealthy {
        /// The sensor.
        sensor: SensorKind,
        /// The cause that it reports.
        cause: FailureCause,
        /// Its own code; -1 if there is none.
        code: i32,
    },
    /// The sensor drops pings (alarm 3): their numbers are missing.
    PingsDropped {
        /// The sensor.
        sensor: SensorKind,
        /// The chance for each ping.
        chance: f64,
    },
    /// The sensor does not start (alarm 6).
    StartFails(SensorKind),
    /// The sensor does not shut down (alarm 7).
    ShutdownFails(SensorKind),
    /// The sensor pings, but the controller gets no data from it (alarm 8).
    DataMissing(SensorKind),
    /// The sensor does not set its clock (alarm 9).
    TimeRefused(SensorKind),
    /// The sensor does no generic command (alarm 11).
    CommandsRefused(SensorKind),
    /// The sensor does not reset (alarm 13).
    ResetRefused(SensorKind),
    /// The disk has no room (alarm 1).
    DiskFull,
    /// The controller neither reads, writes nor does anything. What clients send waits.
    Stall,
    /// The controller sends each client this many records that nobody asked for.
    Flood {
        /// Records a second.
        records_per_s: f64,
    },
    /// The controller sends each client random bytes between the records.
    Garbage {
        /// Bytes a second.
        bytes_per_s: f64,
    },
    /// Records have wrong checksums. Those in log files have right ones.
    ChecksumsWrong {
        /// The chance for each record.
        chance: f64,
    },
    /// The controller closes all connections at the begin, and accepts none until the end.
    LinkClosed,
    /// The key is missing (alarm 15). The controller shuts down after [`crate::PlcConfig::key_grace_s`] if the fault
    /// lasts longer.
    KeyMissing,
}

/// The begin or the end of a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaultEdge {
    /// It begins.
    Begin,
    /// It ends.
    End,
}

impl FaultKind {
    /// The sensor that it concerns.
    #[must_use]
    pub const fn sensor(&self) -> Option<SensorKind> {
        match *self {
            Self::SensorDies(sensor)
            | Self::SensorUnhealthy { sensor, .. }
            | Self::PingsDropped { sensor, .. }
            | Self::StartFails(sensor)
            | Self::ShutdownFails(sensor)
            | Self::DataMissing(sensor)
            | Self::TimeRefused(sensor)
            | Self::CommandsRefused(sensor)
            | Self::ResetRefused(sensor) => Some(sensor),
            Self::DiskFull
            | Self::Stall
            | Self::Flood { .. }
            | Self::Garbage { .. }
            | Self::ChecksumsWrong { .. }
            | Self::LinkClosed
            | Self::KeyMissing => None,
        }
    }

    /// Its name in a file.
    #[must_use]
    pub const fn name(&self) -> FaultName {
        match self {
            Self::SensorDies(_) => FaultName::SensorDies,
            Self::SensorUnhealthy { .. } => FaultName::SensorUnhealthy,
            Self::PingsDropped { .. } => FaultName::PingsDropped,
            Self::StartFails(_) => FaultName::StartFails,
            Self::ShutdownFails(_) => FaultName::ShutdownFails,
            Self::DataMissing(_) => FaultName::DataMissing,
            Self::TimeRefused(_) => FaultName::TimeRefused,
            Self::CommandsRefused(_) => FaultName::CommandsRefused,
            Self::ResetRefused(_) => FaultName::ResetRefused,
            Self::DiskFull => FaultName::DiskFull,
            Self::Stall => FaultName::Stall,
            Self::Flood { .. } => FaultName::Flood,
            Self::Garbage { .. } => FaultName::Garbage,
            Self::ChecksumsWrong { .. } => FaultName::ChecksumsWrong,
            Self::LinkClosed => FaultName::LinkClosed,
            Self::KeyMissing => FaultName::KeyMissing,
        }
    }
}

impl core::fmt::Display for FaultKind {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{}", self.name())?;
        if let Some(sensor) = self.sensor() {
            write!(f, " ({sensor})")?;
        }
        Ok(())
    }
}
