use core::time::Duration;

use backseat_spi::{CommandName, Text};
use backseat_units::{EastNorth, Timestamp};
use serde::{Serialize, Serializer};

use crate::error::MvcError;
use crate::event::ClientId;
use crate::faults::Sensor;
use crate::file::FaultFile;

/// What goes wrong in a run, and when. A plan is data, so it can be printed in full, stored and shrunk.
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
#[derive(Clone, Debug, PartialEq)]
pub enum FaultKind {
    /// A fault of the link, which [`crate::FaultyLink`] plays.
    Link(LinkFault),
    /// The vehicle does not send acknowledgements.
    AcksLost(AckFilter),
    /// The vehicle sends acknowledgements later by `delay`.
    AcksLate {
        /// Which acknowledgements.
        acks: AckFilter,
        /// How much later, up to 60 s. The specification allows 2 s for an outcome (6.21).
        delay: Duration,
    },
    /// The vehicle refuses commands although nothing is wrong with them.
    AcksNegative {
        /// Which command; `None` for every command.
        command: Option<CommandName>,
        /// What the vehicle answers.
        status: NegativeStatus,
        /// Whether the vehicle carries out the command although it says that it refuses it. Then only an answer of
        /// success is replaced by `status`.
        done: bool,
    },
    /// The vehicle reports BFCTL 0 although the plan allows dynamic requests (SPI 6.24), and refuses them.
    ControlTaken,
    /// BFNVG and BFNVR repeat their values, and BFNVG also repeats the time of the solution.
    NavigationFrozen,
    /// The navigation solution jumps by this much. If the fault has a duration, the solution jumps back at its end.
    NavigationJump(EastNorth),
    /// The vehicle sends neither BFNVG nor BFNVR.
    NavigationMissing,
    /// Navigation messages are wrong. The vehicle itself steers by the right solution.
    Untrue(Untrue),
    /// The vehicle names another dive from then on, while its status stays `Running` (SPI 6.9, 6.11).
    AnotherDive {
        /// The name of the other dive file in BFMIS and BFMBS.
        file: Text,
        /// If true, the other dive is the current plan from its last element to its first, and the vehicle begins it.
        /// If false, the other dive is the same plan under another name, and the vehicle flies on.
        reversed: bool,
    },
    /// The vehicle aborts its mission.
    MissionAbort,
    /// A sensor gives no data.
    SensorDropout(Sensor),
    /// The vehicle sends BFSHT, and the payload's power goes off at the fault's end, one minute later (SPI 5.2).
    Shutdown,
    /// The vehicle's UTC clock is set forward by this many nanoseconds, or back if negative. If the fault has a
    /// duration, the clock is set back at its end.
    ClockStep(i64),
}

/// How the navigation messages are wrong. At the end of the fault they are right again at once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Untrue {
    /// The reported position moves away from the solution, and BFNVR does not say so.
    PositionCreeps {
        /// How fast, metres a second, 0 to 100.
        speed_mps: f64,
        /// In which direction, degrees from the frame's north.
        towards_deg: f64,
    },
    /// The position stays the same to its last digit, while everything else and the time of the solution go on.
    PositionFrozen,
    /// The position moves back from where it was when the fault began, as far as the vehicle has moved ahead since. The
    /// velocity goes on.
    PositionBackwards,
    /// The vehicle sends BFNVG without BFNVR.
    VelocityMissing,
    /// The heading is wrong by this many degrees at every other step.
    HeadingFlips {
        /// Clockwise, -180 to 180.
        by_deg: f64,
    },
    /// The depth is wrong by this many metres at every other step.
    DepthFlips {
        /// Downwards, -1000 to 1000.
        by_m: f64,
    },
}

/// A fault of the link between payloads and vehicle.
#[derive(Clone, Debug, PartialEq)]
pub struct LinkFault {
    /// The link of which client.
    pub whom: Whom,
    /// In which direction. [`LinkFaultKind::Cut`] and [`LinkFaultKind::Refuse`] always act in both directions.
    pub direction: Directions,
    /// What goes wrong.
    pub kind: LinkFaultKind,
}

/// What goes wrong with a link. Most kinds act on bytes when they are written. `Cut`, `Stall` and `Deaf` also act on
/// bytes that are under way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum LinkFaultKind {
    /// The connection is reset, and the bytes under way are lost. New connections are refused until the fault ends.
    Cut,
    /// New connections are refused. Existing ones stay.
    Refuse,
    /// Nothing arrives until the fault ends; then everything arrives at once.
    Stall,
    /// The vehicle's program does not read what clients send. Its computer accepts and acknowledges the bytes, and the
    /// program reads all of them in order when the fault ends. The other direction works.
    Deaf,
    /// Bytes are lost silently, and the connection stays open.
    HalfOpen,
    /// Everything arrives later by `delay`, by up to `jitter` more, and by `growth` for each second since the fault
    /// began, whichever connection it is. The order stays the same.
    Delay {
        /// At most 60 s.
        delay: Duration,
        /// At most 60 s. The seed draws a value from 0 to this for each write.
        jitter: Duration,
        /// Seconds per second, 0 to 1. It adds at most 60 s.
        growth: f64,
    },
    /// One write arrives in pieces of 1 to `bytes` bytes, `gap` apart.
    Split {
        /// 1 to 4096.
        bytes: u32,
        /// At most 1 s.
        gap: Duration,
    },
    /// Writes are collected for `hold`, and arrive as one.
    Join {
        /// Up to 10 s.
        hold: Duration,
    },
    /// A sentence arrives twice, with this chance.
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

/// The link of which client.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Whom {
    /// Every client.
    #[default]
    All,
    /// The connection with this number. A client that connects again gets another number.
    Client(ClientId),
    /// The client that holds this role (SPI 4.1).
    Role(String),
}

impl Whom {
    /// Whether the fault applies to a connection.
    #[must_use]
    pub fn includes(&self, client: ClientId, role: Option<&str>) -> bool {
        match self {
            Self::All => true,
            Self::Client(meant) => *meant == client,
            Self::Role(meant) => role == Some(meant),
        }
    }
}

/// In which directions of a link a fault acts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Directions {
    /// Both directions.
    #[default]
    Both,
    /// From payloads to the vehicle.
    ToVehicle,
    /// From the vehicle to payloads.
    FromVehicle,
}

/// To which acknowledgements a fault applies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct AckFilter {
    /// Those of this command; `None` for every command.
    pub command: Option<CommandName>,
    /// Those of this stage.
    pub stage: AckStage,
}

/// Which of a command's acknowledgements a fault applies to (SPI 6.21).
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

    /// The whole plan as the text of a file, which [`FaultPlan::from_toml`] reads back as the same plan.
    #[must_use]
    pub fn to_toml(&self) -> String {
        toml::to_string(&FaultFile::of(self))
            .expect("a fault has only numbers, strings and booleans, and no nested table")
    }

    /// When the last fault ends; `None` for an empty plan.
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
