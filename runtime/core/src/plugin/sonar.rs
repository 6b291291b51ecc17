//! What plugins see of the sonars, and what they ask of them (7k format, volume III). Core passes all of this on; it
//! computes nothing from it.

use backseat_units::{Altitude, Depth, EastNorth, Heading, Position, Timestamp};
use serde::{Deserialize, Serialize};

/// How many pings wait for a plugin's next step at most. If more come, the oldest is dropped.
pub const PINGS_MAX: usize = 16;

/// A ping, as fine as the mission's `[[plugin.ping]]` says.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SonarPing {
    /// A sub-bottom profile (record 3001) and no sidescan (record 3000).
    pub sub_bottom: bool,
    /// The sensor's index in the payload controller.
    pub sensor: i32,
    /// The ping's number, by the sonar.
    pub number: u32,
    /// When it was, on our clock; the start of the run if it was before that.
    pub time: Timestamp,
    /// Where the time comes from.
    pub time_source: PingTime,
    /// How several samples became one.
    pub decimation: Decimation,
    /// One to four channels.
    pub channels: Vec<SonarChannel>,
    /// The vehicle's last solution that was not later than the ping; `None` if it sent none in the last seconds.
    pub navigation: Option<PingNavigation>,
}

/// Where the time of a ping comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum PingTime {
    /// The payload controller's time, less the measured offset of its clock.
    Measured,
    /// The payload controller's time as it is.
    Controller,
    /// The arrival of the record.
    Arrival,
}

/// How several samples became one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Decimation {
    /// By their maximum.
    Maximum,
    /// By their mean.
    Mean,
}

/// One channel of a ping.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SonarChannel {
    /// The side that it looks to.
    pub side: SonarSide,
    /// The samples are spaced along the ground and not along the slant range.
    pub ground_range: bool,
    /// Range of the end of the last sample, metres.
    pub range_m: f64,
    /// Time from the ping to the begin of the first sample, nanoseconds.
    pub start_nanos: u64,
    /// Mean time from one sample to the next, nanoseconds.
    pub sample_nanos: f64,
    /// How many samples the record has.
    pub recorded: u32,
    /// One step of the samples in volts; `None` if the record does not have it.
    pub volts_per_step: Option<f32>,
    /// The amplitudes, in steps of the sonar's converter.
    pub samples: Vec<f32>,
}

/// The side that a channel looks to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SonarSide {
    /// To port.
    Port,
    /// To starboard.
    Starboard,
    /// Down, or not told.
    Other,
}

/// The vehicle's navigation at the time of a ping.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct PingNavigation {
    /// When the solution was computed, on our clock.
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
    /// Over the ground to the east and to the north, m/s; `None` without a BFNVR.
    pub velocity_mps: Option<(f64, f64)>,
}

/// What the payload controller reports.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SonarEvent {
    /// Whether pings come and requests are sent.
    Ready(bool),
    /// The state of its logging.
    Logging(SonarLogging),
    /// The sensors, each with whether it is healthy.
    Health(Vec<(i32, bool)>),
    /// An alarm began, ended or happened.
    Alarm(SonarAlarm),
    /// All alarms that are active now.
    ActiveAlarms(Vec<SonarAlarm>),
    /// How wide a strip of the seabed a sidescan sees.
    Swath(Swath),
    /// The controller shuts down by itself.
    ControllerShutdown,
}

/// The state of the payload controller's logging (status 3).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SonarLogging {
    /// On or off.
    pub on: bool,
    /// The name of the log file.
    pub file: String,
    /// Its size, megabytes.
    pub size_mb: f64,
    /// It is off although it was ordered on.
    pub missing: bool,
}

/// An alarm of the payload controller (table 18).
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SonarAlarm {
    /// Its number in that table.
    pub id: i32,
    /// Whether it is active; `None` for one that only happens.
    pub active: Option<bool>,
    /// The sensor that it is about.
    pub sensor: Option<i32>,
    /// The payload controller's words, at most 200 bytes.
    pub text: String,
}

/// How wide a strip of the seabed a sidescan ping shows on a level bottom: an upper bound.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Swath {
    /// The sensor's index in the payload controller.
    pub sensor: i32,
    /// The ping's number, by the sonar.
    pub number: u32,
    /// Over the ground to port, metres; 0 if the range does not reach the seabed.
    pub port_m: f64,
    /// Over the ground to starboard, metres.
    pub starboard_m: f64,
    /// The altitude that it was computed from, metres.
    pub altitude_m: Option<f64>,
    /// Where the altitude comes from.
    pub source: AltitudeSource,
}

/// Where the altitude of a swath comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum AltitudeSource {
    /// The vehicle's bottom lock.
    BottomLock,
    /// The first return in the imagery.
    FirstReturn,
    /// None is needed: the samples are spaced along the ground.
    GroundRange,
}

/// Change a setting of a sonar.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SonarSetRequest {
    /// The plugin's name for it.
    pub tag: u64,
    /// The sensor's index in the payload controller.
    pub sensor: i32,
    /// What to change.
    pub setting: SonarSetting,
}

/// A setting of a sonar (table 19).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum SonarSetting {
    /// Range, metres.
    RangeM(f64),
    /// The pulse, by the sonar's name for it.
    Pulse(String),
    /// Pinging on or off.
    Ping(bool),
    /// Transmission power, percent.
    PowerPercent(f64),
    /// The receiver's gain, in the sonar's own steps.
    Gain(i32),
    /// Time from ping to ping, milliseconds.
    PeriodMs(f64),
    /// Everything as the sonar has it by default.
    DefaultState,
}

/// Switch the payload controller's logging.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SonarLogRequest {
    /// The plugin's name for it.
    pub tag: u64,
    /// On or off.
    pub on: bool,
    /// The name of the log file; only with `on`.
    pub file: Option<String>,
}
