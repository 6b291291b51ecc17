use core::fmt;

use backseat_spi::BehaviorId;

use super::client::ClientId;

/// The status of the mission (SPI 6.11). The section names the statuses without a word about what each means; this is
/// how the mock uses them.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// The vehicle's computer does not take missions yet.
    Offline,
    /// No dive is loaded.
    Waiting,
    /// The dive file that was loaded cannot be used.
    InvalidDiveFile,
    /// The wrapup file of the dive that was loaded cannot be used.
    InvalidWrapupFile,
    /// Loaded, not started.
    Ready,
    /// Running.
    Running,
    /// Climbing to the surface after the last element.
    WrappingUp,
    /// Climbing to the surface after an abort with errors.
    Aborting,
    /// Over as planned.
    Completed,
    /// Over, before its end.
    Aborted,
    /// Killed: the vehicle does not move.
    Stopped,
}

impl Status {
    /// Its name in BFMIS.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Offline => "Offline",
            Self::Waiting => "Waiting",
            Self::InvalidDiveFile => "Invalid Dive File",
            Self::InvalidWrapupFile => "Invalid Wrapup File",
            Self::Ready => "Ready",
            Self::Running => "Running",
            Self::WrappingUp => "WrappingUp",
            Self::Aborting => "Aborting",
            Self::Completed => "Completed",
            Self::Aborted => "Aborted",
            Self::Stopped => "Stopped",
        }
    }

    /// Whether a dive can be loaded: none is, or the last one is over.
    pub(crate) const fn is_free(self) -> bool {
        match self {
            Self::Waiting
            | Self::InvalidDiveFile
            | Self::InvalidWrapupFile
            | Self::Completed
            | Self::Aborted
            | Self::Stopped => true,
            Self::Offline | Self::Ready | Self::Running | Self::WrappingUp | Self::Aborting => false,
        }
    }
}

/// A behavior: an element of the plan, or an insert.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Behavior {
    /// Where it comes from.
    pub source: Source,
    /// Its type as in BFMBS, such as `trackline`.
    pub kind: &'static str,
}

/// Where a behavior comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// The behavior of the plan with this number in the dive file, from 1.
    Plan(u32),
    /// The insert with this identifier.
    Insert(BehaviorId),
    /// An empty mission that waits for the payload (SPI 7.20).
    Empty,
}

/// Why a behavior ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EndReason {
    /// It was flown to its end.
    Done,
    /// It took longer than its element allows, or a GPS hit got no fix in time.
    TimedOut,
    /// An insert interrupted it.
    Interrupted,
    /// A modify exceeded a limit of the mission.
    ModifyLimit,
    /// The vehicle took control back and dropped the inserts.
    ControlLost,
    /// BPRCB ended it.
    Cancelled,
    /// BPRCE ended the element that it belongs to.
    ElementCancelled,
    /// The empty mission has something to fly now.
    Relieved,
    /// The mission ended.
    MissionOver,
}

/// Why an insert was not added.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Refusal {
    /// `allowDynamicRequests` is false.
    NotAllowed,
    /// The identifier has been used in this mission.
    Duplicate,
    /// An interrupting insert is running.
    InterruptsInterrupt,
    /// This many inserts wait already.
    Full(u32),
    /// The depth or altitude is beyond the vehicle's limits.
    Vertical(f64),
    /// The speed is beyond the vehicle's limits.
    Speed(f64),
    /// The place is over 50 km from the origin.
    FarAway,
    /// The line is too short, or the circle too small or too long.
    Geometry,
    /// A GPS hit asks for a spiral to the surface (SPI 7.7: "future implementation").
    Spiral,
    /// BPRCA cancelled it before the vehicle had decided.
    Cancelled,
}

/// Why a waiting insert was removed from the plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CancelCause {
    /// A client cancelled it (BPRCN or BPRCA).
    Asked(ClientId),
    /// Control was taken back.
    ControlLost,
    /// BPRCE ended the element in which it was to be flown.
    ElementCancelled,
    /// The mission ended.
    MissionOver,
}

impl fmt::Display for Behavior {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.source {
            Source::Plan(number) => write!(f, "{} {number} of the plan", self.kind),
            Source::Insert(id) => write!(f, "inserted {} {id}", self.kind),
            Source::Empty => f.write_str("the empty mission's wait"),
        }
    }
}

impl fmt::Display for EndReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Done => "done",
            Self::TimedOut => "it took too long",
            Self::Interrupted => "interrupted by an insert",
            Self::ModifyLimit => "modified for too long or too far",
            Self::ControlLost => "control was taken back",
            Self::Cancelled => "cancelled by a payload",
            Self::ElementCancelled => "its element was cancelled by a payload",
            Self::Relieved => "there is something to fly",
            Self::MissionOver => "the mission ended",
        })
    }
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotAllowed => f.write_str("dynamic requests are not allowed now"),
            Self::Duplicate => f.write_str("the identifier has been used in this mission"),
            Self::InterruptsInterrupt => f.write_str("an interrupting insert is running"),
            Self::Full(count) => write!(f, "{count} inserts are waiting already"),
            Self::Vertical(metres) => write!(f, "depth or altitude {metres} m is beyond the limits of the vehicle"),
            Self::Speed(speed) => write!(f, "speed {speed} m/s is beyond the limits of the vehicle"),
            Self::FarAway => f.write_str("the place is over 50 km from the origin"),
            Self::Geometry => f.write_str("the line is too short or the circle too small or too long"),
            Self::Spiral => f.write_str("surfacing in a spiral is not implemented"),
            Self::Cancelled => f.write_str("cancelled before it was decided"),
        }
    }
}

impl fmt::Display for CancelCause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Asked(client) => write!(f, "{client} asked"),
            Self::ControlLost => f.write_str("control was taken back"),
            Self::ElementCancelled => f.write_str("its element was cancelled by a payload"),
            Self::MissionOver => f.write_str("the mission ended"),
        }
    }
}
