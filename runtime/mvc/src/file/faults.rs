mod typed;
mod written;

use core::fmt;

use serde::{Deserialize, Serialize};

use crate::error::MvcError;
use crate::faults::Sensor;
use crate::faults::{AckStage, Directions, FaultPlan};

pub(super) use typed::{LONGEST_S, is_command};

/// The most faults that a plan may have.
pub(crate) const FAULTS_MAX: usize = 100_000;

/// The `[faults]` section of `world.toml`, or a whole file of faults, as it is written.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct FaultFile {
    /// The faults, in any order.
    pub fault: Vec<FaultEntry>,
}

/// One fault as it is written. Its kind decides which keys it needs and may have.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FaultEntry {
    /// When it begins, seconds after the start. A fault of a plan needs it; that of a rule or of the operator has none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at_s: Option<f64>,
    /// What goes wrong.
    pub kind: FaultName,
    /// How long it lasts, seconds. Without it, a `link_cut`, a `navigation_jump` and a `clock_step` are instantaneous;
    /// every other kind needs it. `mission_abort` and `another_dive` are always instantaneous and `shutdown` always
    /// takes a minute, so these three do not have this key.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub for_s: Option<f64>,
    /// Faults of a link: the number of the connection; without this key and `role` all connections.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub client: Option<u32>,
    /// Faults of a link: the role of the client.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub role: Option<String>,
    /// Faults of a link: the direction; both without this key.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub direction: Option<DirectionName>,
    /// `delay` and `acks_late`: how much later, seconds, 0 to 60.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub delay_s: Option<f64>,
    /// `delay`: how much may be added to `delay_s`, seconds, 0 to 60; 0 without this key.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub jitter_s: Option<f64>,
    /// `delay`: how much the delay grows with each second since its begin, seconds, 0 to 1; 0 without this key.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub growth: Option<f64>,
    /// `split`: the size of the largest piece, bytes, 1 to 4096.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub bytes: Option<u32>,
    /// `split`: the time from one piece to the next, seconds, 0 to 1; 0 without this key.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub gap_s: Option<f64>,
    /// `join`: how long writes are collected, seconds, 0.001 to 10.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hold_s: Option<f64>,
    /// `duplicate`, `drop` and `corrupt`: the chance for each sentence, or for each byte with `corrupt`, 0 to 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub chance: Option<f64>,
    /// Faults of acknowledgements: the command, written `RMB` or `BPRMB`; every command without this key.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub command: Option<String>,
    /// `acks_lost` and `acks_late`: which acknowledgements of a command; all without this key.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub stage: Option<StageName>,
    /// `acks_negative`: what the vehicle answers, 0 or 1; 1 without this key.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub status: Option<u32>,
    /// `acks_negative`: whether the vehicle does what it says that it refuses; false without this key.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub done: Option<bool>,
    /// `navigation_jump`: how far to the east, metres, within 10000.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub east_m: Option<f64>,
    /// `navigation_jump`: how far to the north, metres, within 10000.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub north_m: Option<f64>,
    /// `sensor_dropout`: the sensor.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub sensor: Option<SensorName>,
    /// `clock_step`: how far the vehicle's clock is set forward, seconds, within 86400; back if negative.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub by_s: Option<f64>,
    /// `position_creep`: how fast the position moves away, metres a second, 0 to 100.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub speed_mps: Option<f64>,
    /// `position_creep`: in which direction, degrees from the frame's north, within 360.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub towards_deg: Option<f64>,
    /// `heading_flip`: how far the heading is turned, degrees clockwise, within 180.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub by_deg: Option<f64>,
    /// `depth_flip`: how much is added to the depth, metres, within 1000.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub by_m: Option<f64>,
    /// `another_dive`: the name of the other dive file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub dive_file: Option<String>,
    /// `another_dive`: whether its plan is the current one reversed; false without this key.
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

/// The name of a variant of [`Directions`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum DirectionName {
    /// Both directions.
    Both,
    /// From payloads to the vehicle.
    ToVehicle,
    /// From the vehicle to payloads.
    FromVehicle,
}

/// The name of an [`AckStage`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum StageName {
    /// All acknowledgements.
    All,
    /// Those that say that the outcome is pending.
    Pending,
    /// Those that tell the outcome.
    Outcome,
}

/// The name of a [`Sensor`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[expect(missing_docs, reason = "Sensor documents them")]
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

/// Converts the names of a file into the types of a plan, and back.
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

    /// Checks every value and returns the plan.
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

    /// Returns the file for a plan.
    #[must_use]
    pub fn of(plan: &FaultPlan) -> Self {
        Self {
            fault: plan.faults.iter().map(FaultEntry::of).collect(),
        }
    }
}

impl fmt::Display for FaultName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // The name in a file.
        self.serialize(f)
    }
}
