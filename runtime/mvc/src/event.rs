//! The vehicle's log: what happened, one event a line.

pub(crate) mod acoustic;
pub(crate) mod adjustment;
pub(crate) mod behavior;
pub(crate) mod client;
pub(crate) mod dvl_trigger;
pub(crate) mod fixed;
pub(crate) mod hovering;
pub(crate) mod mission;
pub(crate) mod modify;
pub(crate) mod silence;
pub(crate) mod topside;

use core::fmt;

use backseat_spi::{BehaviorId, CommandName, Text};
use backseat_units::Timestamp;

use self::fixed::Fixed;
use crate::faults::FaultEvent;
use crate::script::Orderer;

pub use self::acoustic::AcousticEvent;
pub use self::adjustment::{AdjustmentEvent, AdjustmentKind};
pub use self::behavior::{Behavior, CancelCause, EndReason, Refusal, Source, Status};
pub use self::client::{ClientId, DropReason};
pub use self::dvl_trigger::DvlTriggerEvent;
pub use self::hovering::{HoveringEvent, SuspensionEnd};
pub use self::mission::{MissionEvent, Told};
pub use self::modify::{ModifyEnd, ModifyHorizontal, ModifySpeed, ModifyValues, ModifyVertical};
pub use self::silence::SilenceEvent;
pub use self::topside::TopsideEvent;

/// Something that happened in the vehicle: a line of its log.
#[derive(Clone, Debug, PartialEq)]
pub struct MvcEvent {
    /// When it happened.
    pub at: Timestamp,
    /// What happened.
    pub kind: MvcEventKind,
}

/// What happened.
#[derive(Clone, Debug, PartialEq)]
pub enum MvcEventKind {
    /// A client connected.
    Connected(ClientId),
    /// A client disconnected.
    Disconnected(ClientId),
    /// A client got a role (SPI 4.1).
    RoleGiven(ClientId, Box<str>),
    /// A role is free again.
    RoleReleased(ClientId, Box<str>),
    /// A command message was for a role that no client holds.
    NobodyHolds {
        /// The role.
        role: Box<str>,
        /// The message's name.
        message: Box<str>,
    },
    /// The server closed a client's connection.
    Dropped(ClientId, DropReason),
    /// A client switched a status message on or off.
    Subscribed {
        /// Which client.
        client: ClientId,
        /// The message's three letters, or `ALL`.
        message: Text,
        /// On or off.
        on: bool,
    },
    /// The mission's status changed.
    Mission {
        /// The status, as BFMIS reports it.
        status: Status,
        /// Details such as the reason; may be empty.
        details: Text,
    },
    /// The vehicle gave control to the payload (true) or took it back (false).
    Control(bool),
    /// A behavior began.
    BehaviorBegan(Behavior),
    /// A behavior ended.
    BehaviorEnded(Behavior, EndReason),
    /// A payload began to modify the current behavior, or changed the values of its modify.
    Modify {
        /// The payload.
        client: ClientId,
        /// What it asks for.
        values: ModifyValues,
        /// What the vehicle does not fly of it, in words; empty if it flies all of it.
        clipped: Text,
    },
    /// A payload's modify was refused, and why. There is one event for all repetitions.
    ModifyRefused(ClientId, &'static str),
    /// The modify ended.
    ModifyEnded(ModifyEnd),
    /// An insert was added to the plan.
    InsertAccepted(ClientId, BehaviorId),
    /// An insert was not added to the plan.
    InsertRefused(ClientId, BehaviorId, Refusal),
    /// An insert was removed from the plan before it began.
    InsertCancelled(BehaviorId, CancelCause),
    /// What the executive did because the plan or a payload asked for it.
    Executive(MissionEvent),
    /// A command that could not be read or is unknown.
    CommandInvalid(ClientId, CommandName, Text),
    /// Input of a client that is no valid sentence, counted by cause. The vehicle does not answer it.
    Ignored(ClientId, Text),
    /// BPSTS.
    PayloadStatus {
        /// Which client.
        client: ClientId,
        /// All OK (true), or failed (false).
        ok: bool,
        /// Its text.
        text: Text,
    },
    /// BPMSG.
    PayloadMessage(ClientId, Text),
    /// BPVER.
    PayloadVersion(ClientId, Text),
    /// BFSHT was sent: the payload's power goes off one minute later.
    ShutdownSoon,
    /// The payload's power went off, and every client was cut off.
    PowerOff,
    /// The navigation solution began (true) or ceased (false) to use GPS.
    Gps(bool),
    /// The Doppler log gained (true) or lost (false) bottom lock.
    BottomLock(bool),
    /// A payload's fix moved the navigation solution by this much, metres.
    PositionFix(ClientId, f64),
    /// A payload's fix was not used, and why.
    PositionFixRefused(ClientId, Box<str>),
    /// BPCTD.
    PayloadCtd {
        /// Which client.
        client: ClientId,
        /// Conductivity, microsiemens a centimetre.
        conductivity_us_per_cm: f64,
        /// Temperature, degrees Celsius.
        temperature_c: f64,
        /// Pressure, kilopascals.
        pressure_kpa: f64,
    },
    /// The vehicle touched the seabed.
    Grounded,
    /// An event that only a hovering vehicle has.
    Hovering(HoveringEvent),
    /// A fault began or ended.
    Fault(FaultEvent),
    /// A rule of the script or the operator ordered something.
    Ordered {
        /// Who.
        by: Orderer,
        /// What, in words.
        order: Box<str>,
    },
    /// The vehicle did not do what was ordered last.
    NotDone {
        /// Who had ordered it.
        by: Orderer,
        /// Why.
        why: Box<str>,
    },
    /// Silent mode.
    Silence(SilenceEvent),
    /// Trim or buoyancy.
    Adjustment(AdjustmentEvent),
    /// External triggering of the DVL.
    DvlTrigger(DvlTriggerEvent),
    /// Text to or from the topside.
    Topside(TopsideEvent),
    /// The acoustic modem.
    Acoustic(AcousticEvent),
    /// A sentence with this name could not be encoded.
    NotEncoded(Box<str>),
    /// This many events are lost, because the driver did not fetch them in time.
    EventsLost(u64),
}

impl fmt::Display for MvcEvent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} s: {}", Fixed::<3>(self.at.as_secs_f64()), self.kind)
    }
}

impl fmt::Display for MvcEventKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Connected(client) => write!(f, "{client} connected"),
            Self::Disconnected(client) => write!(f, "{client} disconnected"),
            Self::RoleGiven(client, role) => write!(f, "{client} has the role {role}"),
            Self::RoleReleased(client, role) => write!(f, "the role {role} of {client} is free"),
            Self::NobodyHolds { role, message } => write!(f, "{message} is for the role {role}, which no client holds"),
            Self::Dropped(client, reason) => write!(f, "{client} cut off: {reason}"),
            Self::Subscribed { client, message, on } => {
                write!(f, "{client} switched {message} {}", if *on { "on" } else { "off" })
            }
            Self::Mission { status, details } if details.as_str().is_empty() => write!(f, "mission {}", status.name()),
            Self::Mission { status, details } => write!(f, "mission {}: {details}", status.name()),
            Self::Control(true) => f.write_str("control given to the payload"),
            Self::Control(false) => f.write_str("control taken back"),
            Self::BehaviorBegan(behavior) => write!(f, "{behavior} began"),
            Self::BehaviorEnded(behavior, reason) => write!(f, "{behavior} ended: {reason}"),
            Self::Modify {
                client,
                values,
                clipped,
            } => {
                write!(f, "{client} modifies the behavior: {values}")?;
                if clipped.as_str().is_empty() {
                    return Ok(());
                }
                write!(f, " ({clipped})")
            }
            Self::ModifyRefused(client, why) => write!(f, "modify of {client} refused: {why}"),
            Self::ModifyEnded(why) => write!(f, "modify ended: {why}"),
            Self::InsertAccepted(client, id) => write!(f, "insert {id} of {client} accepted"),
            Self::InsertRefused(client, id, why) => write!(f, "insert {id} of {client} refused: {why}"),
            Self::InsertCancelled(id, cause) => write!(f, "insert {id} cancelled: {cause}"),
            Self::Executive(event) => write!(f, "{event}"),
            Self::Ignored(client, what) => write!(f, "{client} sent invalid input: {what}"),
            Self::CommandInvalid(client, name, text) => write!(f, "{client} sent an invalid command ({name}): {text}"),
            Self::PayloadStatus { client, ok, text } => {
                write!(
                    f,
                    "{client} reports status {}: {text}",
                    if *ok { "ok" } else { "failed" }
                )
            }
            Self::PayloadMessage(client, text) => write!(f, "{client} says: {text}"),
            Self::PayloadVersion(client, text) => write!(f, "{client} uses interface version {text}"),
            Self::ShutdownSoon => f.write_str("payload power goes off in 60 s"),
            Self::PowerOff => f.write_str("payload power is off"),
            Self::Gps(true) => f.write_str("navigation uses GPS"),
            Self::Gps(false) => f.write_str("navigation no longer uses GPS"),
            Self::BottomLock(true) => f.write_str("bottom lock"),
            Self::BottomLock(false) => f.write_str("bottom lock lost"),
            Self::PositionFix(client, metres) => write!(f, "a fix of {client} moved the navigation by {metres:.2} m"),
            Self::PositionFixRefused(client, why) => write!(f, "a fix of {client} was not used: {why}"),
            Self::PayloadCtd {
                client,
                conductivity_us_per_cm,
                temperature_c,
                pressure_kpa,
            } => write!(
                f,
                "{client} measures {conductivity_us_per_cm:.1} uS/cm, {temperature_c:.3} degC, {pressure_kpa:.1} kPa"
            ),
            Self::Grounded => f.write_str("the vehicle touched the seabed"),
            Self::Hovering(event) => event.fmt(f),
            Self::Fault(fault) => fault.fmt(f),
            Self::Ordered { by, order } => write!(f, "{by}: {order}"),
            Self::NotDone { by, why } => write!(f, "{by}: not done: {why}"),
            Self::Silence(event) => event.fmt(f),
            Self::Adjustment(event) => event.fmt(f),
            Self::DvlTrigger(event) => event.fmt(f),
            Self::Topside(event) => event.fmt(f),
            Self::Acoustic(event) => event.fmt(f),
            Self::NotEncoded(name) => write!(f, "a {name} could not be encoded"),
            Self::EventsLost(count) => write!(f, "{count} events were not fetched and are lost"),
        }
    }
}
