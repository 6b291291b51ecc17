//! What passes between core and plugins: the `core` side of the WIT world in `wit/`.
//!
//! Figures that come from a plugin are plain `f64` here, and can be anything: NaN, infinities, latitude 91. Core's
//! admission turns them into checked quantities or rejects the request; nothing else reads them.

pub(crate) mod slots;

use std::time::Duration;

use backseat_units::{Altitude, Depth, EastNorth, Heading, Position, Timestamp, Utc};
use serde::{Deserialize, Serialize};

pub use crate::ended::{EndCause, EndKind, Ended, Failure, FrameOutcome};
pub use crate::refusal::{Refusal, Rule};
pub use slots::QUARANTINED;

mod request;
mod sample;
mod sonar;

pub use request::{
    CameraRequest, DvlTriggerRequest, GpsHitRequest, LightRequest, ModifyRequest, PacketRequest, PositionRequest,
    Request, SilentRequest, SonarAngleRequest, StationRequest, StationTarget, TopsideRequest, TrackcircleRequest,
    TracklineRequest, Transport, VerticalRequest,
};
pub use sample::{
    BatterySample, BuoyancySample, CartesianSample, CompassSample, CtdSample, DvlBeamsSample, DvlSample, ImuSample,
    PlannedElement, PressureSample, ReceivedFrame, ReceivedPacket, RelativeSample, Sample, ServoSample,
    SoundVelocitySample, SurfacesSample, TelemetrySample, TrimSample, VehicleSpeedSample, Window,
};
pub use sonar::{
    AltitudeSource, Decimation, PINGS_MAX, PingNavigation, PingTime, SonarAlarm, SonarChannel, SonarEvent,
    SonarLogRequest, SonarLogging, SonarPing, SonarSetRequest, SonarSetting, SonarSide, Swath,
};

/// Which plugin of the mission: its place in priority order, 0 first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
pub struct PluginId(pub usize);

/// What a plugin says about itself.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Description {
    /// Its name, for logs.
    pub name: String,
    /// Its version.
    pub version: String,
    /// How often it is stepped, 20 ms to 60 s.
    pub step_period: Duration,
    /// The events that it wants in addition to those that all plugins get.
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
    /// [`Event::LoggingBegan`] and [`Event::LoggingEnded`].
    Logging,
    /// [`Event::TopsideMessage`].
    Topside,
    /// [`Event::Window`] and [`Event::Packet`].
    Acoustic,
    /// [`Event::Plan`].
    Plan,
    /// [`Sample::Telemetry`] (BFTEL, SPI 6.3).
    Telemetry,
    /// [`Sample::SoundVelocity`] (BFSVS, SPI 6.4).
    SoundVelocity,
    /// [`Sample::Compass`] (BFRCM, SPI 6.5).
    Compass,
    /// [`Sample::Pressure`] (BFRDP, SPI 6.6).
    Pressure,
    /// [`Sample::VehicleSpeed`] (BFRVL, SPI 6.7).
    VehicleSpeed,
    /// [`Sample::Battery`] (BFRBS, SPI 6.8).
    Battery,
    /// [`Sample::Surfaces`] (BFERC, SPI 6.12).
    Surfaces,
    /// [`Sample::Dvl`] (BFDVL, SPI 6.13).
    Dvl,
    /// [`Sample::DvlBeams`] (BFDV2, SPI 6.14).
    DvlBeams,
    /// [`Sample::Imu`] (BFIMU, SPI 6.15).
    Imu,
    /// [`Sample::Servo`] (BFPIT, SPI 6.18).
    Servo,
    /// [`Sample::Trim`] (BFTRM, SPI 6.22).
    Trim,
    /// [`Sample::Buoyancy`] (BFBOY, SPI 6.23).
    Buoyancy,
    /// [`StepInput::relative`] and [`StepInput::cartesian`] (BFRNV, BFCNV, SPI 6.17, 6.19).
    RelativeNavigation,
    /// [`Event::Sidescan`].
    Sidescan,
    /// [`Event::SubBottom`].
    SubBottom,
    /// [`Event::Sonar`].
    Sonar,
}

/// Navigation as plugins and the monitor see it: BFNVG with BFNVR of the same time (SPI 6.1, 6.2), checked, and with
/// the grid convergence removed from the heading.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct NavigationSample {
    /// When the solution was computed, on our clock: the earliest time that the round trips allow, and never later than
    /// its arrival.
    pub solution: Timestamp,
    /// WGS84.
    pub position: Position,
    /// The position in the fence's frame.
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

/// The state of a request in the ledger, as its plugin sees it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum RequestState {
    /// Core has refused it before it was sent, for this reason. Final.
    Rejected(Refusal),
    /// Written to the link.
    Sent,
    /// The vehicle is working on it.
    Pending,
    /// The vehicle has accepted it.
    Accepted,
    /// It has failed after it was sent, for this reason. Final.
    Failed(Failure),
    /// The vehicle has not answered. Final.
    TimedOut,
    /// It is not known whether the vehicle will fly it: the link was lost before the answer, or the vehicle flies
    /// another dive than the one for which it accepted this. Resolved when the vehicle names the behavior, or when its
    /// plan does not name it.
    Unknown,
    /// The vehicle has begun to fly it.
    Started,
    /// It is over, for this reason. Final.
    Ended(Ended),
    /// Cancelled before it began. Final.
    Cancelled,
}

/// Something that has happened since the plugin's last step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Event {
    /// Control was gained or lost.
    Control(bool),
    /// A request has changed its state.
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
    /// A behavior began (BFMBS, SPI 6.9).
    BehaviorBegan(Behavior),
    /// A behavior ended (BFMBE, SPI 6.10).
    BehaviorEnded(Behavior),
    /// A timer that the plugin had set has expired.
    Timer(u64),
    /// This is a new instance of a plugin that had failed.
    Restored {
        /// Steps since the last snapshot, which this instance has not seen.
        lost_steps: u64,
        /// Tags of its requests that have not ended.
        open: Vec<u64>,
    },
    /// The vehicle shuts our power off in a minute (BFSHT, SPI 5.2).
    Shutdown,
    /// The vehicle begins the lead-in of a survey line: log data (BFBDL, SPI 5.3). The mission planner's text.
    LoggingBegan(String),
    /// The lead-out is over: stop logging (BFSDL, SPI 5.4). The mission planner's text.
    LoggingEnded(String),
    /// A message from the topside (BFTOP, SPI 5.5).
    TopsideMessage {
        /// How it came; `None` for a way that the specification does not number.
        transport: Option<Transport>,
        /// Its text.
        text: String,
    },
    /// The vehicle lets the payload trigger the DVL, or wants it to stop (BFDVT, SPI 5.6). Only the plugin whose DVL
    /// request is open gets this.
    DvlTrigger(bool),
    /// The payload may use the acoustic modem for a while (BFCMA, SPI 9.1).
    Window(Window),
    /// A packet came through the acoustic modem (BFCPR, SPI 9.3).
    Packet(ReceivedPacket),
    /// The vehicle's plan has been read again (BFPLN, SPI 6.20). The elements are in the order in which they are flown.
    Plan(Vec<PlannedElement>),
    /// A sensor's sample, for plugins that asked for its topic.
    Sample(Sample),
    /// A ping of the sidescan (record 3000 of the 7k format).
    Sidescan(SonarPing),
    /// A ping of the sub-bottom profiler (record 3001).
    SubBottom(SonarPing),
    /// What the sonars' payload controller reports.
    Sonar(SonarEvent),
}

/// A behavior of the vehicle's mission.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Behavior {
    /// "trackline", "waypoint", "setpoint" and others.
    pub kind: String,
    /// The tag of the plugin's own request, if the behavior flies one.
    pub tag: Option<u64>,
}

/// One step's input: all that a plugin may know.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct StepInput {
    /// Since the start of the run.
    pub now: Timestamp,
    /// Our UTC.
    pub utc: Utc,
    /// By how much the vehicle's UTC differs from ours, to judge zones that are valid for a limited time; `None` if it
    /// is not known or over 60 s. Plugins do not see it.
    #[serde(default)]
    pub clocks_apart: Option<Duration>,
    /// The newest navigation, while it is fresh.
    pub navigation: Option<NavigationSample>,
    /// Where a hovering vehicle is relative to its target, while that is fresh (BFRNV, SPI 6.17).
    pub relative: Option<RelativeSample>,
    /// Where it is in its own inertial frame, while that is fresh (BFCNV, SPI 6.19).
    pub cartesian: Option<CartesianSample>,
    /// Whether requests can be sent.
    pub control: bool,
    /// What has happened since the last step, oldest first.
    pub events: Vec<Event>,
}

/// The result of a step.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Returned {
    /// Fuel used, which in simulation is time.
    pub fuel: u64,
    /// Lines that the plugin logged.
    pub log: Vec<LogLine>,
    /// Values that it published, oldest first.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub measures: Vec<Measure>,
    /// What it asks for, or how it failed.
    pub result: Result<Vec<Request>, PluginFault>,
}

/// A value that a plugin published. Core passes it on to the log and does nothing else with it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Measure {
    /// 1 to 48 of a-z, 0-9 and _.
    pub name: String,
    /// Finite.
    pub value: f64,
    /// At most 16 bytes; may be empty.
    pub unit: String,
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
    /// In one line.
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
    /// It exceeded the wall-clock limit of a run at sea: the instance is lost.
    Deadline,
    /// It returned more than the host accepts: the instance is lost.
    TooMuch,
    /// It returned an error of its own; the instance lives.
    Error,
    /// Its events overflowed the queue while it ran; the instance lives.
    Overflow,
    /// It could not be started again.
    Start,
    /// It is a new version on trial and has failed, or was refused something: the version before it comes back.
    Trial,
}

/// A version that the operator puts in the place of a plugin's present one.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Version {
    /// As the component says it.
    pub version: String,
    /// The component's SHA-256, hexadecimal.
    pub sha256: String,
    /// If it fails or is refused something in this many steps, the version before it comes back.
    pub trial_steps: u32,
}

impl std::fmt::Display for Version {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "{} ({}), {} steps on trial",
            self.version,
            self.sha256.get(..12).unwrap_or(&self.sha256),
            self.trial_steps
        )
    }
}

/// Answers a plugin's call of the `fence` import: a pure function of the immutable envelope and the step's input.
pub trait Judge: Send + Sync {
    /// The clearance of the request's geometry, in metres.
    ///
    /// # Errors
    /// [`Refusal`] if core would reject the request for its geometry or its figures.
    fn judge(&self, request: &Request, input: &StepInput) -> Result<f64, Refusal>;
}
