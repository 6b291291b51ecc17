mod typed;
mod written;

use core::fmt;

use serde::{Deserialize, Serialize};

use crate::error::MvcError;
use crate::faults::Sensor;
use crate::faults::{AckStage, Directions, FaultPlan};

/// No plan has more faults.
const FAULTS_MAX: usize = 100_000;

/// The `[faults]` section of `world.toml`, and the whole of a file of faults: as it is written.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FaultFile {
    /// In any order.
    pub fault: Vec<FaultEntry>,
}

/// One fault as it is written. Which keys it needs and has depends on its kind.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FaultEntry {
    /// When it begins, seconds after the start.
    pub at_s: f64,
    /// What it is.
    pub kind: FaultName,
    /// How long it lasts, seconds. A cut, a jump and a clock step may be instants without it; an abort and
    /// another dive are one, and a shutdown takes its minute.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub for_s: Option<f64>,
    /// Of a link: the connection's number; without it and `role` all.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub client: Option<u32>,
    /// Of a link: the client's role.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub role: Option<String>,
    /// Of a link: which way; both without it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub direction: Option<DirectionName>,
    /// Of `delay` and `acks_late`: how much later, seconds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub delay_s: Option<f64>,
    /// Of `delay`: up to so much more, seconds; none without it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub jitter_s: Option<f64>,
    /// Of `delay`: seconds more for each second since its begin; none without it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub growth: Option<f64>,
    /// Of `split`: the largest piece, bytes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bytes: Option<u32>,
    /// Of `split`: time between pieces, seconds; none without it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gap_s: Option<f64>,
    /// Of `join`: how long writes are gathered, seconds.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hold_s: Option<f64>,
    /// Of `duplicate`, `drop` (a sentence) and `corrupt` (a byte): 0 to 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub chance: Option<f64>,
    /// Of acknowledgements: the command's name, `RMB` or `BPRMB`; every command without it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub command: Option<String>,
    /// Of `acks_lost` and `acks_late`: which; all without it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stage: Option<StageName>,
    /// Of `acks_negative`: 0 or 1; 1 without it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub status: Option<u32>,
    /// Of `acks_negative`: the vehicle does what it says that it refuses; false without it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub done: Option<bool>,
    /// Of `navigation_jump`: metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub east_m: Option<f64>,
    /// Of `navigation_jump`: metres.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub north_m: Option<f64>,
    /// Of `sensor_dropout`: which.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sensor: Option<SensorName>,
    /// Of `clock_step`: seconds, positive where the vehicle's clock is set forward.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub by_s: Option<f64>,
    /// Of `position_creep`: metres a second.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub speed_mps: Option<f64>,
    /// Of `position_creep`: degrees from the frame's north.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub towards_deg: Option<f64>,
    /// Of `heading_flip`: degrees clockwise.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub by_deg: Option<f64>,
    /// Of `depth_flip`: metres downwards.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub by_m: Option<f64>,
    /// Of `another_dive`: what it is called.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dive_file: Option<String>,
    /// Of `another_dive`: its plan is the present one reversed; false without it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub reversed: Option<bool>,
}

/// The name of a kind of fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum FaultName {
    /// [`crate::LinkFaultKind::Cut`].
    LinkCut,
    /// [`crate::LinkFaultKind::Refuse`].
    Refuse,
    /// [`crate::LinkFaultKind::Stall`].
    Stall,
    /// [`crate::LinkFaultKind::Deaf`].
    Deaf,
    /// [`crate::LinkFaultKind::HalfOpen`].
    HalfOpen,
    /// [`crate::LinkFaultKind::Delay`].
    Delay,
    /// [`crate::LinkFaultKind::Split`].
    Split,
    /// [`crate::LinkFaultKind::Join`].
    Join,
    /// [`crate::LinkFaultKind::Duplicate`].
    Duplicate,
    /// [`crate::LinkFaultKind::Corrupt`].
    Corrupt,
    /// [`crate::LinkFaultKind::Drop`].
    Drop,
    /// [`crate::FaultKind::AcksLost`].
    AcksLost,
    /// [`crate::FaultKind::AcksLate`].
    AcksLate,
    /// [`crate::FaultKind::AcksNegative`].
    AcksNegative,
    /// [`crate::FaultKind::ControlTaken`].
    ControlTaken,
    /// [`crate::FaultKind::NavigationFrozen`].
    NavigationFrozen,
    /// [`crate::FaultKind::NavigationJump`].
    NavigationJump,
    /// [`crate::FaultKind::NavigationMissing`].
    NavigationMissing,
    /// [`crate::Untrue::PositionCreeps`].
    PositionCreep,
    /// [`crate::Untrue::PositionFrozen`].
    PositionFrozen,
    /// [`crate::Untrue::PositionBackwards`].
    PositionBackwards,
    /// [`crate::Untrue::VelocityMissing`].
    VelocityMissing,
    /// [`crate::Untrue::HeadingFlips`].
    HeadingFlip,
    /// [`crate::Untrue::DepthFlips`].
    DepthFlip,
    /// [`crate::FaultKind::AnotherDive`].
    AnotherDive,
    /// [`crate::FaultKind::MissionAbort`].
    MissionAbort,
    /// [`crate::FaultKind::SensorDropout`].
    SensorDropout,
    /// [`crate::FaultKind::Shutdown`].
    Shutdown,
    /// [`crate::FaultKind::ClockStep`].
    ClockStep,
}

/// The name of [`Directions`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DirectionName {
    /// Both.
    Both,
    /// What payloads send.
    ToVehicle,
    /// What payloads are sent.
    FromVehicle,
}

/// The name of an [`AckStage`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StageName {
    /// All.
    All,
    /// "Pending".
    Pending,
    /// The outcome.
    Outcome,
}

/// The name of a [`Sensor`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[expect(missing_docs, reason = "as Sensor says")]
pub enum SensorName {
    Dvl,
    Altimeter,
    Gps,
    Compass,
    Depth,
    Imu,
    Ctd,
    SoundVelocity,
    Tailcone,
    Telemetry,
}

/// Names on one side, kinds on the other.
macro_rules! names {
    ($name:ident = $kind:ident: $($variant:ident),+) => {
        impl From<$name> for $kind {
            fn from(name: $name) -> Self {
                match name { $($name::$variant => Self::$variant),+ }
            }
        }
        impl From<$kind> for $name {
            fn from(kind: $kind) -> Self {
                match kind { $($kind::$variant => Self::$variant),+ }
            }
        }
    };
}

names!(DirectionName = Directions: Both, ToVehicle, FromVehicle);
names!(StageName = AckStage: All, Pending, Outcome);
names!(SensorName = Sensor: Dvl, Altimeter, Gps, Compass, Depth, Imu, Ctd, SoundVelocity, Tailcone, Telemetry);

impl FaultFile {
    pub(crate) fn from_toml(text: &str) -> Result<Self, MvcError> {
        toml::from_str(text).map_err(|error| super::toml_error(text, &error))
    }

    /// The plan, every value checked.
    ///
    /// # Errors
    /// [`MvcError::Fault`] with the fault's number, the key, and what was expected.
    pub fn plan(&self) -> Result<FaultPlan, MvcError> {
        if self.fault.len() > FAULTS_MAX {
            return Err(MvcError::Value {
                key: "fault",
                value: format!("{} faults", self.fault.len()),
                expected: "at most 100000",
            });
        }
        let numbered = (1..).zip(&self.fault);
        let faults = numbered.map(|(number, entry)| entry.fault().map_err(|fault| MvcError::Fault { number, fault }));
        Ok(FaultPlan {
            faults: faults.collect::<Result<_, _>>()?,
        })
    }

    /// A plan as it is written.
    #[must_use]
    pub fn of(plan: &FaultPlan) -> Self {
        Self {
            fault: plan.faults.iter().map(FaultEntry::of).collect(),
        }
    }
}

impl fmt::Display for FaultName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // As it is written in a file.
        self.serialize(f)
    }
}
