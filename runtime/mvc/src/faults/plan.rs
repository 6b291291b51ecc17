use core::time::Duration;

use backseat_spi::{CommandName, Text};
use backseat_units::{EastNorth, Timestamp};
use serde::{Serialize, Serializer};

use crate::error::MvcError;
use crate::event::ClientId;
use crate::faults::Sensor;
use crate::file::FaultFile;

/// What goes wrong in a run, and when: data, so that it can be printed in full, kept and shrunk.
///
/// ```
/// let plan = backseat_mvc::FaultPlan::from_toml(r#"
/// [[fault]]
/// at_s = 60
/// kind = "stall"
/// for_s = 2.5
/// direction = "from_vehicle"
///
/// [[fault]]
/// at_s = 90
/// kind = "acks_negative"
/// for_s = 10
/// command = "RMB"
/// status = 1
/// "#)?;
/// assert_eq!(plan.faults.len(), 2);
/// assert_eq!(backseat_mvc::FaultPlan::from_toml(&plan.to_toml())?, plan);
/// # Ok::<(), backseat_mvc::MvcError>(())
/// ```
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FaultPlan {
    /// In any order; a fault's number is its place here, from 1.
    pub faults: Vec<Fault>,
}

/// Something that goes wrong for a time.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    /// When it begins.
    pub at: Timestamp,
    /// How long it lasts; zero is an instant.
    pub lasts: Duration,
    /// What it is.
    pub kind: FaultKind,
}

/// What goes wrong.
#[derive(Clone, Debug, PartialEq)]
pub enum FaultKind {
    /// The link, as [`crate::FaultyLink`] plays it.
    Link(LinkFault),
    /// Acknowledgements never come.
    AcksLost(AckFilter),
    /// Acknowledgements come later than they would by `delay`.
    AcksLate {
        /// Which.
        acks: AckFilter,
        /// How much later, up to 60 s. The specification's time for an outcome is 2 s (6.21).
        delay: Duration,
    },
    /// Commands are refused though nothing is wrong with them.
    AcksNegative {
        /// Whose; none is every command.
        command: Option<CommandName>,
        /// What is answered.
        status: NegativeStatus,
        /// The vehicle does what it says that it refuses: only a success is told as its contrary. Else it is not done.
        done: bool,
    },
    /// BFCTL is 0 though the plan allows dynamic requests (SPI 6.24).
    ControlTaken,
    /// BFNVG and BFNVR repeat their values, and BFNVG its solution time.
    NavigationFrozen,
    /// The navigation's position is moved at once, and back at the end where the fault lasts.
    NavigationJump(EastNorth),
    /// Neither BFNVG nor BFNVR comes.
    NavigationMissing,
    /// BFNVG and BFNVR say what is not so. The vehicle itself is well, and steers by what is so.
    Untrue(Untrue),
    /// The vehicle flies another dive from now on, and its status stays `Running` (SPI 6.9, 6.11).
    AnotherDive {
        /// What BFMIS and BFMBS call it.
        file: Text,
        /// Its plan is the present one from its end to its begin, and is begun; else it is the same plan under another name,
        /// and flown on.
        reversed: bool,
    },
    /// The vehicle ends its mission.
    MissionAbort,
    /// A sensor gives nothing.
    SensorDropout(Sensor),
    /// BFSHT; the payload's power goes off at the fault's end, a minute later (SPI 5.2).
    Shutdown,
    /// The vehicle's UTC is set by so many nanoseconds, and back at the end where the fault lasts.
    ClockStep(i64),
}

/// What is wrong with the words of navigation. It ends with the fault, and what is told is true again at once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Untrue {
    /// The position moves by so much more than the velocity says.
    PositionCreeps {
        /// Metres a second, 0 to 100.
        speed_mps: f64,
        /// Where to, degrees from the frame's north.
        towards_deg: f64,
    },
    /// The position is the same to its last digit, while all else and the time of the solution go on.
    PositionFrozen,
    /// The position goes back where the velocity goes on: from where it was at the fault's begin, as far as the vehicle
    /// has gone ahead.
    PositionBackwards,
    /// BFNVR does not come, while BFNVG does.
    VelocityMissing,
    /// The heading is turned by so many degrees at every other step.
    HeadingFlips {
        /// Clockwise, -180 to 180.
        by_deg: f64,
    },
    /// The depth is another by so many metres at every other step.
    DepthFlips {
        /// Downwards, -1000 to 1000.
        by_m: f64,
    },
}

/// A fault of the link between payloads and vehicle.
#[derive(Clone, Debug, PartialEq)]
pub struct LinkFault {
    /// Whose link.
    pub whom: Whom,
    /// Which way. [`LinkFaultKind::Cut`] and [`LinkFaultKind::Refuse`] are of both.
    pub direction: Directions,
    /// What.
    pub kind: LinkFaultKind,
}

/// What goes wrong with a link. All act on bytes when they are written; those under way are not touched.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LinkFaultKind {
    /// The connection is reset, with all that is under way. New ones are refused for as long as it lasts.
    Cut,
    /// New connections are refused; those that are stay.
    Refuse,
    /// Nothing arrives before the end, then all at once.
    Stall,
    /// The vehicle does not read what it is sent: its computer takes and acknowledges it, and at the end it is read in
    /// order, all at once. The other way goes on.
    Deaf,
    /// All is silently lost, and the connection stays.
    HalfOpen,
    /// All takes longer by `delay`, by up to `jitter` more, and by `growth` for each second since the fault's begin,
    /// whichever connection it is. The order stays.
    Delay {
        /// At most 60 s.
        delay: Duration,
        /// At most 60 s, uniform.
        jitter: Duration,
        /// Seconds a second, 0 to 1. More than 60 s do not come of it.
        growth: f64,
    },
    /// Bytes come in pieces of 1 to `bytes` bytes, one each `gap`.
    Split {
        /// 1 to 4096.
        bytes: u32,
        /// At most 1 s.
        gap: Duration,
    },
    /// Writes are gathered for so long, and arrive as one.
    Join {
        /// Up to 10 s.
        hold: Duration,
    },
    /// A sentence comes twice, with this chance.
    Duplicate {
        /// 0 to 1.
        chance: f64,
    },
    /// One bit of a byte is wrong, with this chance for each byte.
    Corrupt {
        /// 0 to 1.
        chance: f64,
    },
    /// A sentence is lost, with this chance.
    Drop {
        /// 0 to 1.
        chance: f64,
    },
}

/// Whose link.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Whom {
    /// Everyone's.
    #[default]
    All,
    /// The connection with this number: a client that connects again is another.
    Client(ClientId),
    /// Whoever holds this role (SPI 4.1).
    Role(String),
}

impl Whom {
    /// Whether a connection is meant.
    #[must_use]
    pub fn includes(&self, client: ClientId, role: Option<&str>) -> bool {
        match self {
            Self::All => true,
            Self::Client(meant) => *meant == client,
            Self::Role(meant) => role == Some(meant),
        }
    }
}

/// Which ways of a link a fault is of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Directions {
    /// Both.
    #[default]
    Both,
    /// What payloads send.
    ToVehicle,
    /// What payloads are sent.
    FromVehicle,
}

/// Which acknowledgements a fault is of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AckFilter {
    /// Those of this command; none is every command.
    pub command: Option<CommandName>,
    /// Those of this stage.
    pub stage: AckStage,
}

/// Which of a command's acknowledgements (SPI 6.21).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum AckStage {
    /// All.
    #[default]
    All,
    /// Those that say that the outcome is pending.
    Pending,
    /// Those that tell the outcome.
    Outcome,
}

/// How a command is refused (SPI 6.21).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NegativeStatus {
    /// 0: an invalid request.
    Invalid,
    /// 1: processed without success.
    Failed,
}

impl Fault {
    /// When it ends.
    #[must_use]
    pub fn until(&self) -> Timestamp {
        self.at + self.lasts
    }
}

impl FaultPlan {
    /// Reads a file of faults: `[[fault]]` tables with `at_s`, `kind` and the keys of the kind.
    ///
    /// # Errors
    /// [`MvcError::Toml`] with line and column, or [`MvcError::Fault`] with number, key and what was expected.
    pub fn from_toml(text: &str) -> Result<Self, MvcError> {
        FaultFile::from_toml(text)?.plan()
    }

    /// The whole plan as a file that [`FaultPlan::from_toml`] reads back as the same plan.
    #[must_use]
    pub fn to_toml(&self) -> String {
        toml::to_string(&FaultFile::of(self)).expect("a fault has only numbers and strings, and no nested table")
    }

    /// When the last fault has ended; none where there is none.
    #[must_use]
    pub fn ends(&self) -> Option<Timestamp> {
        self.faults.iter().map(Fault::until).max()
    }
}

impl Serialize for FaultPlan {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        FaultFile::of(self).serialize(serializer)
    }
}
