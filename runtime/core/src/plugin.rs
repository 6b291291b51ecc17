//! What passes between core and plugins: the `core` side of the WIT world in `wit/`.
//!
//! Figures that come from a plugin are plain `f64` here, whatever they are: NaN, infinities, latitude 91. Core's
//! admission turns them into checked quantities or rejects the request; nothing else reads them.

use std::time::Duration;

use backseat_units::{Altitude, Depth, EastNorth, Heading, Position, Timestamp, Utc};
use serde::{Deserialize, Serialize};

/// Which plugin of the mission: its place in priority order, 0 first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct PluginId(pub usize);

/// What a plugin says of itself.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Description {
    /// Its name, for logs.
    pub name: String,
    /// Its version.
    pub version: String,
    /// How often it is stepped, 20 ms to 60 s.
    pub step_period: Duration,
    /// The events that it wants beside those that all plugins get.
    pub topics: Vec<Topic>,
}

/// Events that a plugin gets only if it asks.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum Topic {
    /// [`Event::Ctd`].
    Ctd,
    /// [`Event::MissionCommand`].
    MissionCommand,
    /// [`Event::BehaviorBegan`] and [`Event::BehaviorEnded`].
    Behavior,
}

/// Navigation as plugins and the monitor see it: BFNVG with BFNVR of the same time (SPI 6.1, 6.2), checked, the grid
/// convergence taken out of its heading.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct NavigationSample {
    /// When the solution was computed, on our clock: through the smallest clock offset seen, never later than its
    /// arrival.
    pub solution: Timestamp,
    /// WGS84.
    pub position: Position,
    /// The same in the fence's frame.
    pub local: EastNorth,
    /// Below the surface.
    pub depth: Depth,
    /// Above the seabed; `None` without bottom lock.
    pub altitude: Option<Altitude>,
    /// True heading.
    pub heading: Heading,
    /// Degrees, starboard down positive.
    pub roll_deg: f64,
    /// Degrees, nose up positive.
    pub pitch_deg: f64,
    /// Over the ground, east, m/s.
    pub east_mps: f64,
    /// Over the ground, north, m/s.
    pub north_mps: f64,
    /// Down, m/s.
    pub down_mps: f64,
    /// Degrees per second, clockwise positive.
    pub yaw_rate_dps: f64,
    /// The solution includes GPS: the vehicle is at the surface.
    pub gps: bool,
}

/// A vertical setpoint as a plugin asks for it, metres.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum VerticalRequest {
    /// Below the surface.
    DepthM(f64),
    /// Above the seabed.
    AltitudeM(f64),
}

/// A latitude and longitude as a plugin gives them, degrees.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PositionRequest {
    /// North positive.
    pub latitude_deg: f64,
    /// East positive.
    pub longitude_deg: f64,
}

impl From<Position> for PositionRequest {
    fn from(position: Position) -> Self {
        Self {
            latitude_deg: position.latitude.as_deg(),
            longitude_deg: position.longitude.as_deg(),
        }
    }
}

/// What a plugin asks for. `tag` is the plugin's own name for the request; its outcomes carry it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Request {
    /// A lease: BPRMB, refreshed by core (SPI 7.12).
    Modify(ModifyRequest),
    /// End this plugin's lease now (BPEMB, SPI 7.13).
    EndModify,
    /// An insert: BPRTK (SPI 7.5).
    Trackline(TracklineRequest),
    /// An insert: BPRTC (SPI 7.6).
    Trackcircle(TrackcircleRequest),
    /// Cancel the insert with this tag (BPRCN, SPI 7.8).
    Cancel(u64),
    /// A line in the vehicle's log (BPMSG, SPI 7.18).
    Message(String),
    /// Wake this plugin with [`Event::Timer`].
    Timer {
        /// Comes back in the event.
        id: u64,
        /// From now.
        after: Duration,
    },
}

/// Steer for a while.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct ModifyRequest {
    /// The plugin's name for it.
    pub tag: u64,
    /// True heading, degrees.
    pub heading_deg: f64,
    /// Depth or altitude.
    pub vertical: VerticalRequest,
    /// Through the water, m/s.
    pub speed_mps: f64,
    /// How long it stands unless it is replaced.
    pub duration: Duration,
}

/// A straight line to survey.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TracklineRequest {
    /// The plugin's name for it.
    pub tag: u64,
    /// Where it begins.
    pub start: PositionRequest,
    /// Where it ends.
    pub end: PositionRequest,
    /// Depth or altitude.
    pub vertical: VerticalRequest,
    /// Through the water, m/s.
    pub speed_mps: f64,
    /// Interrupt the current behaviour rather than follow it.
    pub interrupt: bool,
}

/// A circle to fly.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct TrackcircleRequest {
    /// The plugin's name for it.
    pub tag: u64,
    /// Its centre.
    pub centre: PositionRequest,
    /// Metres.
    pub radius_m: f64,
    /// Clockwise positive.
    pub orbits: f64,
    /// Depth or altitude.
    pub vertical: VerticalRequest,
    /// Through the water, m/s.
    pub speed_mps: f64,
    /// Where on the circle to begin, degrees from north.
    pub entry_angle_deg: Option<f64>,
    /// Interrupt the current behaviour rather than follow it.
    pub interrupt: bool,
}

/// Where a request stands; the ledger's states as a plugin sees them.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum RequestState {
    /// Refused before it was sent: the rule, a colon, then place and figures in one line. An end.
    Rejected(String),
    /// Written to the link.
    Sent,
    /// The vehicle is working on it.
    Pending,
    /// The vehicle has accepted it.
    Accepted,
    /// The vehicle has refused it; its text. An end.
    Failed(String),
    /// The vehicle has not answered. An end.
    TimedOut,
    /// The link was lost before the answer; resolved later where the vehicle names the behaviour.
    Unknown,
    /// The vehicle has begun to fly it.
    Started,
    /// It is over, and why. An end.
    Ended(String),
    /// Cancelled before it began. An end.
    Cancelled,
}

/// What has happened since the plugin's last step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Event {
    /// Control was gained or lost.
    Control(bool),
    /// A request has come to another state.
    Outcome {
        /// The plugin's name for the request.
        tag: u64,
        /// Its state now.
        state: RequestState,
    },
    /// A CTD sample (BFCTD, SPI 6.16).
    Ctd(CtdSample),
    /// A mission command (BFMSC, SPI 5.1).
    MissionCommand(String),
    /// A behaviour began (BFMBS, SPI 6.9).
    BehaviorBegan(Behavior),
    /// A behaviour ended (BFMBE, SPI 6.10).
    BehaviorEnded(Behavior),
    /// A timer that the plugin had set.
    Timer(u64),
    /// This is a new instance of a plugin that had failed.
    Restored {
        /// Steps since the last snapshot, which this instance has not seen.
        lost_steps: u64,
        /// Tags of its requests that are not at their end.
        open: Vec<u64>,
    },
    /// Power goes in a minute (BFSHT, SPI 5.2).
    Shutdown,
}

/// A CTD sample.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct CtdSample {
    /// When it was measured, on our clock.
    pub measured: Timestamp,
    /// Microsiemens per centimetre.
    pub conductivity_us_per_cm: f64,
    /// Degrees Celsius.
    pub temperature_c: f64,
    /// Kilopascals.
    pub pressure_kpa: f64,
}

/// A behaviour of the vehicle's mission.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Behavior {
    /// "trackline", "waypoint", "setpoint" and others.
    pub kind: String,
    /// The tag of this plugin's request that it flies, if it is one.
    pub tag: Option<u64>,
}

/// One step's input: all that a plugin may know.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StepInput {
    /// Since the start of the run.
    pub now: Timestamp,
    /// Our UTC.
    pub utc: Utc,
    /// The newest navigation, while it is fresh.
    pub navigation: Option<NavigationSample>,
    /// Whether requests can be sent.
    pub control: bool,
    /// What has happened since the last step, oldest first.
    pub events: Vec<Event>,
}

/// What came of a step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Returned {
    /// Fuel used, which in simulation is time.
    pub fuel: u64,
    /// Lines that the plugin logged.
    pub log: Vec<LogLine>,
    /// What it asks for, or how it failed.
    pub result: Result<Vec<Request>, PluginFault>,
}

/// A plugin's line in the log.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct LogLine {
    /// How much it matters.
    pub level: LogLevel,
    /// At most 256 bytes.
    pub text: String,
}

/// How much a log line matters.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum LogLevel {
    /// For the plugin's author.
    Debug,
    /// For whoever reads the log.
    Info,
    /// Something is not as it should be.
    Warn,
    /// Something has failed.
    Error,
}

/// How a plugin failed.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PluginFault {
    /// Which bound it broke.
    pub kind: FaultKind,
    /// In a line.
    pub text: String,
}

/// Which bound a plugin broke.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub enum FaultKind {
    /// A WebAssembly trap: the instance is lost.
    Trap,
    /// It used all its fuel: the instance is lost.
    OutOfFuel,
    /// It asked for more memory than it may have and trapped: the instance is lost.
    Memory,
    /// The wall-clock backstop of a deployed run: the instance is lost.
    Deadline,
    /// It returned more than the host takes: the instance is lost.
    TooMuch,
    /// It returned an error of its own; the instance lives.
    Error,
    /// Its events overflowed the queue while it ran; the instance lives.
    Overflow,
    /// It could not be started again.
    Start,
}

/// Answers a plugin's question to the `fence` import: a pure function of the immutable envelope and the step's input.
pub trait Judge: Send + Sync {
    /// By how many metres the request's geometry holds, or why it does not.
    ///
    /// # Errors
    /// [`Refusal`] where the request would be rejected for its geometry or its figures.
    fn judge(&self, request: &Request, input: &StepInput) -> Result<f64, Refusal>;
}

/// Why a request does not hold.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Refusal {
    /// The rule: `inclusion`, `exclusion`, `depth`, `altitude`, `limit` where it is the geometry or its figures; else
    /// `control`, `navigation`, `plan`, `priority`, `rate`, `cap`, `tag`, `interrupt`, `identifier`, `doubt`.
    pub rule: &'static str,
    /// What is missing, metres; 0 where metres are not its measure.
    pub metres: f64,
    /// Rule, place and figures in one line.
    pub text: String,
}
