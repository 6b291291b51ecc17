mod sonar;

use std::fmt;
use std::time::Duration;

use backseat_spi::FrameCounts;
use backseat_units::{TimeOfDay, Utc};
use serde::{Deserialize, Serialize};

use crate::ended::Ended;
use crate::ledger::Transition;
use crate::order::Order;
use crate::owner::{ExternalId, Owner};
use crate::plugin::{LogLine, Measure, PluginFault, PluginId, RequestState, Returned, StepInput, Version};
use crate::refusal::Uncontrolled;

pub use sonar::{FromSonar, SonarOrder, SonarOutcome, SonarRates, ToSonar};

/// What a driver passes to core.
#[derive(Clone, Debug, PartialEq)]
pub enum Input<'a> {
    /// The connection to the vehicle is up.
    LinkUp,
    /// The connection is lost, or could not be made.
    LinkDown,
    /// Bytes from the vehicle, cut anywhere.
    Received(&'a [u8]),
    /// A plugin's step has returned.
    Returned(PluginId, Returned),
    /// A plugin was restarted, or could not be.
    Restarted(PluginId, Restarted),
    /// The operator puts another version in a plugin's place. The driver has it ready: the next restart takes it.
    Swap(PluginId, Version),
    /// An act of the operator.
    Operator(Operator),
    /// Bytes from an external source, cut anywhere.
    External(ExternalId, &'a [u8]),
    /// What the client of the sonars reports.
    Sonar(FromSonar),
    /// This reservation of identifiers and inserts is on disk.
    Reserved(Reservation),
    /// Our computer's clock was set: by how many nanoseconds in all since the start.
    UtcSet(i64),
    /// The time that `poll_timeout` returned has come.
    Timeout,
}

/// The result of a plugin's restart.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Restarted {
    /// Fuel used. In simulation it counts as time.
    pub fuel: u64,
    /// Steps since the last snapshot.
    pub lost_steps: u64,
    /// Why the restart failed, if it did.
    pub result: Result<(), PluginFault>,
}

/// What the operator does.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Operator {
    /// Take the helm from every plugin, end leases, cancel inserts. The driver keeps the hold over restarts.
    Hold,
    /// End the hold: plugins may steer again.
    Release,
    /// End the run and its leases.
    Stop,
    /// An order, which no plugin may give.
    Order(Order),
}

/// What core asks the driver to do.
#[derive(Clone, Debug, PartialEq)]
pub enum Output {
    /// Write this to the vehicle, at once and completely.
    Send(Vec<u8>),
    /// Connect to the vehicle after a while.
    Connect {
        /// The delay: back-off with jitter.
        after: Duration,
    },
    /// Reset the connection and report `LinkDown`. Do not close it: nothing that waits in its buffers may be delivered.
    ResetLink,
    /// Run a step of a plugin, and return its result.
    Invoke(PluginId, StepInput),
    /// Write this to an external source.
    External(ExternalId, Vec<u8>),
    /// What the client of the sonars is asked to do.
    Sonar(ToSonar),
    /// Make a new instance of a plugin from its last snapshot; of the version that the operator has put in its place, if
    /// there is one.
    Restart(PluginId),
    /// Write on disk which identifiers and inserts may be used, so that the next process knows it.
    Reserve(Reservation),
    /// Close the logs: the power will be cut, or the operator stopped the run.
    Finish,
    /// For the log and for whoever watches.
    Note(Note),
}

/// An entry of a run's log.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "note", rename_all = "kebab-case")]
pub enum Note {
    /// The connection came up.
    LinkUp,
    /// The connection was lost.
    LinkDown {
        /// How many sentences and dropped lines it had, by cause.
        #[serde(skip)]
        counts: FrameCounts,
        /// The next attempt comes after this, seconds.
        retry_s: f64,
    },
    /// The vehicle's interface version (BFVER).
    VehicleVersion {
        /// As the vehicle says it.
        version: String,
    },
    /// The vehicle's clock, as round trips measure it.
    Clock {
        /// Our clock less the vehicle's, seconds.
        offset_s: f64,
        /// The vehicle's time.
        vehicle: TimeOfDay,
    },
    /// The vehicle's mission status (BFMIS).
    Mission {
        /// As the vehicle says it.
        status: String,
    },
    /// Control was gained or lost.
    Control {
        /// Whether requests can be sent.
        granted: bool,
        /// Why it was lost.
        reason: Option<Uncontrolled>,
    },
    /// A request has changed its state.
    Request(Transition),
    /// A lease ended.
    LeaseEnded {
        /// Whose it was.
        plugin: PluginId,
        /// Why.
        reason: Ended,
    },
    /// The vehicle's plan is known.
    Plan {
        /// How many elements it has.
        elements: usize,
    },
    /// The vehicle's behavior (BFMBS, BFMBE).
    Behavior {
        /// True if it began, false if it ended.
        began: bool,
        /// Its number in the dive file.
        number: Option<u32>,
        /// Our identifier, if it is ours.
        identifier: Option<u32>,
        /// Its type.
        kind: String,
    },
    /// Navigation became stale, jumped, or is good again.
    Navigation {
        /// What happened.
        text: String,
    },
    /// A sentence that cannot be read.
    Malformed {
        /// Message, field and fault.
        text: String,
        /// How many there were on this connection.
        count: u64,
    },
    /// A plugin failed.
    PluginFailed {
        /// Which.
        plugin: PluginId,
        /// How.
        fault: PluginFault,
        /// What core does about it.
        then: &'static str,
    },
    /// A plugin works again after it had failed.
    PluginRestarted {
        /// Which.
        plugin: PluginId,
    },
    /// The operator puts another version in a plugin's place.
    PluginSwap {
        /// Which.
        plugin: PluginId,
        /// The version.
        to: Version,
    },
    /// The version that the operator has put in a plugin's place steps from now on.
    PluginSwapped {
        /// Which.
        plugin: PluginId,
    },
    /// The version that the operator wanted was not taken, and the one before it goes on.
    PluginNotSwapped {
        /// Which.
        plugin: PluginId,
        /// Why.
        text: String,
    },
    /// A line that a plugin logged.
    PluginLog {
        /// Whose.
        plugin: PluginId,
        /// The line.
        line: LogLine,
    },
    /// A value that a plugin published.
    PluginMeasure {
        /// Whose.
        plugin: PluginId,
        /// The value.
        measure: Measure,
    },
    /// An act of the operator.
    Operator {
        /// The act.
        act: Operator,
    },
    /// The vehicle is outside the fence or inside again, and what core does about it.
    Recovery {
        /// What has happened, or the step that core takes.
        text: String,
    },
    /// What the sonars' payload controller has said, or what its client does.
    Sonar {
        /// In a line.
        text: String,
    },
    /// Core was called later than it had asked for.
    Late {
        /// By how much, seconds.
        seconds: f64,
    },
    /// Anything else that somebody should read.
    Text {
        /// In a line.
        text: String,
    },
}

impl Note {
    /// Describes the note with the plugins' names, which come in priority order. [`Display`](fmt::Display) has the
    /// plugins' numbers instead.
    #[must_use]
    pub fn describe<'a>(&'a self, names: &'a [String]) -> impl fmt::Display + 'a {
        Told { note: self, names }
    }
}

impl fmt::Display for Note {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        Told { note: self, names: &[] }.fmt(f)
    }
}

struct Told<'a> {
    note: &'a Note,
    names: &'a [String],
}

/// A plugin's name, or its number if it has no name here.
struct Who<'a>(PluginId, &'a [String]);

impl fmt::Display for Who<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.1.get(self.0.0) {
            Some(name) => f.write_str(name),
            None => write!(f, "plugin {}", self.0.0),
        }
    }
}

impl fmt::Display for Told<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        use Note as N;
        let who = |plugin: &PluginId| Who(*plugin, self.names);
        match self.note {
            N::LinkUp => write!(f, "connected to the vehicle"),
            N::LinkDown { retry_s, .. } => write!(f, "no connection to the vehicle; next attempt in {retry_s:.1} s"),
            N::VehicleVersion { version } => write!(f, "the vehicle speaks SPI {version}"),
            N::Clock { offset_s, vehicle } => {
                // The offset is ours less the vehicle's.
                write!(f, "the vehicle's clock says {vehicle}, {:+.3} s from ours", -offset_s)
            }
            N::Mission { status } => write!(f, "mission {status}"),
            N::Control { granted: true, .. } => write!(f, "control granted"),
            N::Control { granted: false, reason } => match reason {
                Some(reason) => write!(f, "no control: {}", reason.text()),
                None => write!(f, "no control"),
            },
            N::Request(transition) => match transition.owner {
                Owner::Plugin(plugin) => write_transition(f, transition, &who(&plugin)),
                owner @ (Owner::Operator | Owner::External(_)) => write_transition(f, transition, &owner),
            },
            N::LeaseEnded { plugin, reason } => write!(f, "{} no longer steers: {reason}", who(plugin)),
            N::Plan { elements } => write!(f, "the vehicle's plan has {elements} elements"),
            N::Behavior {
                began,
                number,
                identifier,
                kind,
            } => {
                write!(f, "{kind} ")?;
                match (number, identifier) {
                    (_, Some(identifier)) => write!(f, "of request {identifier}")?,
                    (Some(number), None) => write!(f, "{number} of the plan")?,
                    (None, None) => write!(f, "without a number")?,
                }
                write!(f, " {}", if *began { "began" } else { "ended" })
            }
            N::Navigation { text } | N::Text { text } | N::Recovery { text } => write!(f, "{text}"),
            N::Malformed { text, count } => write!(f, "{text} (number {count} on this connection)"),
            N::PluginFailed { plugin, fault, then } => {
                write!(f, "{} failed ({:?}): {}; {then}", who(plugin), fault.kind, fault.text)
            }
            N::PluginRestarted { plugin } => write!(f, "{} works again", who(plugin)),
            N::PluginSwap { plugin, to } => write!(f, "{}: swap to version {to}", who(plugin)),
            N::PluginSwapped { plugin } => write!(f, "{}: swapped", who(plugin)),
            N::PluginNotSwapped { plugin, text } => {
                write!(f, "{}: not swapped, the version before goes on: {text}", who(plugin))
            }
            N::PluginLog { plugin, line } => write!(f, "{} says: {}", who(plugin), line.text),
            N::PluginMeasure { plugin, measure } => {
                let Measure { name, value, unit } = measure;
                write!(f, "{} publishes {name} = {value} {unit}", who(plugin))
            }
            N::Operator { act } => write!(f, "operator: {act:?}"),
            N::Sonar { text } => write!(f, "sonar: {text}"),
            N::Late { seconds } => write!(f, "woke {seconds:.3} s late"),
        }
    }
}

fn write_transition(f: &mut fmt::Formatter<'_>, transition: &Transition, who: &dyn fmt::Display) -> fmt::Result {
    let Transition {
        request,
        owner: _,
        tag,
        kind,
        identifier,
        state,
    } = transition;
    write!(f, "{kind:?} {request} ({who}, tag {tag}")?;
    if let Some(identifier) = identifier {
        write!(f, ", identifier {identifier}")?;
    }
    write!(f, ") ")?;
    match state {
        RequestState::Rejected(text) => write!(f, "rejected: {text}"),
        RequestState::Failed(text) => write!(f, "failed: {text}"),
        RequestState::Ended(text) => write!(f, "ended: {text}"),
        RequestState::Sent => write!(f, "sent"),
        RequestState::Pending => write!(f, "pending"),
        RequestState::Accepted => write!(f, "accepted"),
        RequestState::TimedOut => write!(f, "not answered"),
        RequestState::Unknown => write!(f, "in doubt"),
        RequestState::Started => write!(f, "started"),
        RequestState::Cancelled => write!(f, "cancelled"),
    }
}

/// The SPI identifiers that this run may use, and what previous runs of the same vehicle mission have sent.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Identifiers {
    /// The first identifier that is not used.
    pub next: u32,
    /// All below this are reserved on disk.
    pub reserved: u32,
    /// The first identifier of the vehicle's mission. Previous runs used those from here up to `next`.
    #[serde(default)]
    pub first: u32,
    /// How many inserts previous runs can have sent at most.
    #[serde(default)]
    pub inserts: u32,
    /// How many GPS hits previous runs can have sent at most.
    #[serde(default)]
    pub gps_hits: u32,
}

/// What may be used until the next reservation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Reservation {
    /// All SPI identifiers below this.
    pub below: u32,
    /// This many inserts of the vehicle's mission, in all.
    pub inserts: u32,
    /// This many GPS hits of the vehicle's mission, in all.
    pub gps_hits: u32,
}

/// What a driver knows when it starts core.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Start {
    /// Our UTC at time zero.
    pub utc: Utc,
    /// `None` if the state on disk is missing; then no insert is sent.
    pub identifiers: Option<Identifiers>,
    /// Whether dynamic requests may be sent at all.
    pub armed: bool,
    /// Whether the operator's hold is still on from an earlier process.
    pub held: bool,
    /// Seed of the back-off's jitter.
    pub jitter: u64,
}
