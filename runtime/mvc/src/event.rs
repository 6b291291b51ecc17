use core::fmt;
use core::time::Duration;

use backseat_spi::{BehaviorId, CommandName, Text};
use backseat_units::Timestamp;

use crate::acoustic::AcousticEvent;
use crate::adjustment::AdjustmentEvent;
use crate::dvl_trigger::DvlTriggerEvent;
use crate::faults::FaultEvent;
use crate::fixed::Fixed;
use crate::hovering::HoveringEvent;
use crate::mission_event::MissionEvent;
use crate::silence::SilenceEvent;
use crate::topside::TopsideEvent;

/// A client of the server, as the driver numbers its connections.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct ClientId(pub u32);

impl fmt::Display for ClientId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "client {}", self.0)
    }
}

/// Something that happened in the vehicle: a line of its log.
#[derive(Clone, Debug, PartialEq)]
pub struct MvcEvent {
    /// When.
    pub at: Timestamp,
    /// What.
    pub kind: MvcEventKind,
}

/// What happened.
#[derive(Clone, Debug, PartialEq)]
pub enum MvcEventKind {
    /// A client connected.
    Connected(ClientId),
    /// A client is gone.
    Disconnected(ClientId),
    /// A client was given a role (SPI 4.1).
    RoleGiven(ClientId, Box<str>),
    /// A role is free again.
    RoleReleased(ClientId, Box<str>),
    /// A command message was for a role that nobody holds.
    NobodyHolds {
        /// The role.
        role: Box<str>,
        /// The message's name.
        message: Box<str>,
    },
    /// The server cut a client off.
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
        /// As BFMIS says it.
        status: Status,
        /// Why, where there is more to say.
        details: Text,
    },
    /// The vehicle gave (true) or took back (false) control.
    Control(bool),
    /// A behavior began.
    BehaviorBegan(Behavior),
    /// A behavior ended.
    BehaviorEnded(Behavior, EndReason),
    /// A payload began to modify the current behavior, or changed what it asks for.
    Modify(ClientId, ModifyValues),
    /// The modify ended.
    ModifyEnded(ModifyEnd),
    /// An insert was added to the plan.
    InsertAccepted(ClientId, BehaviorId),
    /// An insert was not added.
    InsertRefused(ClientId, BehaviorId, Refusal),
    /// An insert was taken out of the plan before it began.
    InsertCancelled(BehaviorId, CancelCause),
    /// What the executive did at the plan's or a payload's wish.
    Executive(MissionEvent),
    /// A command that could not be read, or is none.
    CommandInvalid(ClientId, CommandName, Text),
    /// What a client has sent that is no sentence, counted by cause: it is not answered.
    Ignored(ClientId, Text),
    /// BPSTS.
    PayloadStatus {
        /// Which client.
        client: ClientId,
        /// All OK, or failed.
        ok: bool,
        /// Its text.
        text: Text,
    },
    /// BPMSG.
    PayloadMessage(ClientId, Text),
    /// BPVER.
    PayloadVersion(ClientId, Text),
    /// BFSHT was sent: the payload's power goes off in a minute.
    ShutdownSoon,
    /// The payload's power went off, and every client with it.
    PowerOff,
    /// GPS came into the navigation solution, or went out of it.
    Gps(bool),
    /// The Doppler log gained or lost bottom lock.
    BottomLock(bool),
    /// A payload's fix moved the navigation so far, metres.
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
    /// Of a hovering vehicle.
    Hovering(HoveringEvent),
    /// A fault of the run's plan began or ended.
    Fault(FaultEvent),
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
    /// A sentence could not be written: its name.
    NotEncoded(Box<str>),
    /// Events were not fetched in time, and so many are lost.
    EventsLost(u64),
}

/// Why the server cut a client off.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DropReason {
    /// It does not fetch what is due to it.
    Backlog,
    /// Too many clients are connected.
    TooMany,
    /// Each role that it could have is held by another client.
    RoleHeld,
    /// No role is meant for its address.
    NoRole,
    /// The payload has no power.
    PowerOff,
}

/// The status of the mission (SPI 6.11).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Status {
    /// Loaded, not started.
    Ready,
    /// Running.
    Running,
    /// Climbing to the surface after the last element.
    WrappingUp,
    /// Climbing to the surface after an abort with errors.
    Aborting,
    /// Over, as planned.
    Completed,
    /// Over, before its end.
    Aborted,
    /// Killed: no movement.
    Stopped,
}

impl Status {
    /// Its name in BFMIS.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Ready => "Ready",
            Self::Running => "Running",
            Self::WrappingUp => "WrappingUp",
            Self::Aborting => "Aborting",
            Self::Completed => "Completed",
            Self::Aborted => "Aborted",
            Self::Stopped => "Stopped",
        }
    }
}

/// Which behavior: an element of the plan, or an insert.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Behavior {
    /// Where it comes from.
    pub source: Source,
    /// Its type, as in BFMBS: `trackline`.
    pub kind: &'static str,
}

/// Where a behavior comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Source {
    /// The behavior of the plan with this number in the dive file, from 1.
    Plan(u32),
    /// The insert with this identifier.
    Insert(BehaviorId),
    /// An empty mission's wait for the payload (SPI 7.20).
    Empty,
}

/// Why a behavior ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum EndReason {
    /// It was flown to its end.
    Done,
    /// It took longer than its element allows.
    TimedOut,
    /// An insert interrupted it.
    Interrupted,
    /// A modify went beyond the mission's limits.
    ModifyLimit,
    /// Control was taken back, and with it the inserts.
    ControlLost,
    /// BPRCB ended it.
    Cancelled,
    /// BPRCE ended the element that it belongs to.
    ElementCancelled,
    /// An empty mission has something to fly.
    Relieved,
    /// The mission ended.
    MissionOver,
}

/// What a modify asks for; none inherits from the behavior (SPI 7.12).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ModifyValues {
    /// What is turned to.
    pub horizontal: Option<ModifyHorizontal>,
    /// What is held vertically.
    pub vertical: Option<ModifyVertical>,
    /// How it is driven.
    pub speed: Option<ModifySpeed>,
}

impl ModifyValues {
    /// Nothing is asked for.
    pub(crate) const NONE: Self = Self {
        horizontal: None,
        vertical: None,
        speed: None,
    };
}

/// How a modify drives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ModifySpeed {
    /// Speed through the water, metres a second.
    MetresPerSecond(f64),
    /// Turns of the thruster a minute.
    Rpm(f64),
}

/// What a modify turns to.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ModifyHorizontal {
    /// Heading, degrees from true north.
    Heading(f64),
    /// Rudder, degrees, positive to starboard.
    Rudder(f64),
}

/// What a modify holds vertically.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ModifyVertical {
    /// Depth, metres.
    Depth(f64),
    /// Height above the seabed, metres.
    Altitude(f64),
    /// Pitch, degrees, positive up.
    Pitch(f64),
    /// Elevator, degrees, positive up.
    Elevator(f64),
}

/// Why a modify ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ModifyEnd {
    /// BPEMB.
    Ended,
    /// No BPRMB came for 5 s.
    Lapsed,
    /// Dynamic requests are no longer allowed.
    ControlLost,
    /// It went beyond the mission's limits.
    Limit,
    /// The behavior that it modified ended.
    BehaviorEnded,
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
    /// So many are waiting already.
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
    /// Taken back by BPRCA before it was decided.
    Cancelled,
}

/// Why a waiting insert was taken out of the plan.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CancelCause {
    /// BPRCN or BPRCA.
    Asked(ClientId),
    /// Control was taken back.
    ControlLost,
    /// BPRCE ended the element that it had its place in.
    ElementCancelled,
    /// The mission ended.
    MissionOver,
}

/// A modify lapses this long after the last BPRMB (SPI 7.12).
pub(crate) const MODIFY_LASTS: Duration = Duration::from_secs(5);

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
            Self::NobodyHolds { role, message } => write!(f, "{message} is for {role} and nobody holds that role"),
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
            Self::Modify(client, values) => write!(f, "{client} modifies the behavior: {values}"),
            Self::ModifyEnded(why) => write!(f, "modify ended: {why}"),
            Self::InsertAccepted(client, id) => write!(f, "insert {id} of {client} accepted"),
            Self::InsertRefused(client, id, why) => write!(f, "insert {id} of {client} refused: {why}"),
            Self::InsertCancelled(id, cause) => write!(f, "insert {id} cancelled: {cause}"),
            Self::Executive(event) => write!(f, "{event}"),
            Self::Ignored(client, what) => write!(f, "{client} sent what is no sentence: {what}"),
            Self::CommandInvalid(client, name, text) => write!(f, "{client} sent an invalid command ({name}): {text}"),
            Self::PayloadStatus { client, ok, text } => {
                write!(
                    f,
                    "{client} says that it is {}: {text}",
                    if *ok { "ok" } else { "failed" }
                )
            }
            Self::PayloadMessage(client, text) => write!(f, "{client} says: {text}"),
            Self::PayloadVersion(client, text) => write!(f, "{client} speaks version {text}"),
            Self::ShutdownSoon => f.write_str("payload power goes off in 60 s"),
            Self::PowerOff => f.write_str("payload power is off"),
            Self::Gps(true) => f.write_str("GPS is in the navigation"),
            Self::Gps(false) => f.write_str("navigation without GPS"),
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

impl fmt::Display for DropReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Backlog => "it does not fetch what is due to it",
            Self::TooMany => "too many clients",
            Self::RoleHeld => "another client holds its role",
            Self::NoRole => "no role is meant for its address",
            Self::PowerOff => "the payload has no power",
        })
    }
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

impl fmt::Display for ModifyValues {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.horizontal {
            Some(ModifyHorizontal::Heading(heading)) => write!(f, "heading {} deg", Fixed::<1>(heading))?,
            Some(ModifyHorizontal::Rudder(rudder)) => write!(f, "rudder {} deg", Fixed::<1>(rudder))?,
            None => f.write_str("heading its own")?,
        }
        match self.vertical {
            Some(ModifyVertical::Depth(depth)) => write!(f, ", depth {} m", Fixed::<2>(depth))?,
            Some(ModifyVertical::Altitude(altitude)) => write!(f, ", altitude {} m", Fixed::<2>(altitude))?,
            Some(ModifyVertical::Pitch(pitch)) => write!(f, ", pitch {} deg", Fixed::<1>(pitch))?,
            Some(ModifyVertical::Elevator(elevator)) => write!(f, ", elevator {} deg", Fixed::<1>(elevator))?,
            None => f.write_str(", depth its own")?,
        }
        match self.speed {
            Some(ModifySpeed::MetresPerSecond(speed)) => write!(f, ", speed {} m/s", Fixed::<2>(speed)),
            Some(ModifySpeed::Rpm(rpm)) => write!(f, ", {} rpm", Fixed::<0>(rpm)),
            None => f.write_str(", speed its own"),
        }
    }
}

impl fmt::Display for ModifyEnd {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Ended => "by the payload",
            Self::Lapsed => "5 s without a refresh",
            Self::ControlLost => "control was taken back",
            Self::Limit => "too long or too far",
            Self::BehaviorEnded => "its behavior ended",
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
