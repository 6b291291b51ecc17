use std::time::Duration;

use backseat_units::Position;
use serde::{Deserialize, Serialize};

use super::{SonarLogRequest, SonarSetRequest};

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
    /// Surface and take a GPS position: an insert that cannot be cancelled (BPRGP, SPI 7.7).
    GpsHit(GpsHitRequest),
    /// A message to the topside (BPTOP, SPI 7.3).
    Topside(TopsideRequest),
    /// The payload's side of the DVL triggering handshake (BPDVR, SPI 7.4).
    DvlTrigger(DvlTriggerRequest),
    /// Begin or end silent mode (BPSIL, SPI 7.22).
    Silent(SilentRequest),
    /// Trim the vehicle; the tag (BPTRM, SPI 7.23).
    Trim(u64),
    /// Adjust its buoyancy; the tag (BPBOY, SPI 7.24).
    Buoyancy(u64),
    /// A packet through the acoustic modem (BPCPD, SPI 9.4).
    Packet(PacketRequest),
    /// A lease of a hovering vehicle: suspend its mission and keep the station, or go to a place (BPSUS, BPCON, BPGHP,
    /// BPGBP, SPI 8).
    Station(StationRequest),
    /// End this plugin's station keeping now (BPRES, SPI 8.3).
    EndStation,
    /// Turn the sonar (BPSAN, SPI 8.5).
    SonarAngle(SonarAngleRequest),
    /// Move the camera (BPPTZ, SPI 8.10).
    Camera(CameraRequest),
    /// Switch the light (BPLIT, SPI 8.11).
    Light(LightRequest),
    /// Change a setting of a sonar.
    SonarSet(SonarSetRequest),
    /// Switch the payload controller's logging.
    SonarLog(SonarLogRequest),
    /// Wake this plugin with [`Event::Timer`](super::Event::Timer).
    Timer {
        /// Comes back in the event.
        id: u64,
        /// From now.
        after: Duration,
    },
}

impl Request {
    /// The plugin's name for it; `None` for what has no outcome.
    #[must_use]
    pub const fn tag(&self) -> Option<u64> {
        Some(match self {
            Self::Modify(asked) => asked.tag,
            Self::Trackline(asked) => asked.tag,
            Self::Trackcircle(asked) => asked.tag,
            Self::GpsHit(asked) => asked.tag,
            Self::Cancel(tag) => *tag,
            Self::Topside(asked) => asked.tag,
            Self::DvlTrigger(asked) => asked.tag,
            Self::Silent(asked) => asked.tag,
            Self::Trim(tag) => *tag,
            Self::Buoyancy(tag) => *tag,
            Self::Packet(asked) => asked.tag,
            Self::Station(asked) => asked.tag,
            Self::SonarAngle(asked) => asked.tag,
            Self::Camera(asked) => asked.tag,
            Self::Light(asked) => asked.tag,
            Self::SonarSet(asked) => asked.tag,
            Self::SonarLog(asked) => asked.tag,
            Self::EndModify | Self::EndStation | Self::Message(_) | Self::Timer { .. } => return None,
        })
    }
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
    /// How long it lasts unless it is replaced.
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
    /// Interrupt the current behavior rather than follow it.
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
    /// Interrupt the current behavior rather than follow it.
    pub interrupt: bool,
}

/// Surface at a place and take a GPS position (SPI 7.7). The vehicle goes straight up; the other modes of SPI are not
/// offered.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct GpsHitRequest {
    /// The plugin's name for it.
    pub tag: u64,
    /// Where to surface.
    pub position: PositionRequest,
}

/// How a message travels between vehicle and topside (SPI 5.5, 7.3).
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Transport {
    /// A cable.
    Ethernet,
    /// 802.11.
    Wifi,
    /// A radio modem.
    RadioModem,
    /// The acoustic modem: a few 26-byte packets a minute.
    AcousticModem,
}

/// A message to the topside.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct TopsideRequest {
    /// The plugin's name for it.
    pub tag: u64,
    /// The slowest transport that is still acceptable; advisory.
    pub slowest: Transport,
    /// 1 to 200 bytes of printable ASCII without comma, asterisk and dollar, and without the three letters of a command
    /// (`RMB`, `TOP`) in upper case, because some vehicles act on such a name anywhere in a line. Core rejects any
    /// other text; it never changes one to make it fit.
    pub text: String,
}

/// Whether the payload wants to trigger the DVL, and whether it triggers it now.
///
/// A request begins with `external` alone, and stays one entry of the ledger until it ends. Later requests under its
/// tag are steps of it. While the plugin triggers the DVL, it repeats the request at least every 5 s. When the vehicle
/// wants it to stop, the plugin answers within 1 s: with neither flag, which ends the request, or with `external`
/// alone, to trigger again when the vehicle allows it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct DvlTriggerRequest {
    /// The plugin's name for it.
    pub tag: u64,
    /// It wants to trigger the DVL.
    pub external: bool,
    /// It is triggering the DVL now: only after [`Event::DvlTrigger`](super::Event::DvlTrigger) has allowed it.
    pub triggering: bool,
}

/// Silent mode. The request counts as started when the vehicle is silent, and ends at the latest when the vehicle may
/// be heard again. Only the plugin that asked for it can end it before. It continues if the plugin fails, if control is
/// lost and if the link is lost.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct SilentRequest {
    /// The plugin's name for it.
    pub tag: u64,
    /// True for silent mode, false to end it. The vehicle ends it by itself after five minutes.
    pub silent: bool,
}

/// A packet for the acoustic modem. Core sends it only if it arrives before the end of a [`Window`](super::Window). The
/// request ends with the vehicle's report on its frames, or times out a minute after it was sent.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct PacketRequest {
    /// The plugin's name for it.
    pub tag: u64,
    /// The modem that it is for.
    pub destination: u32,
    /// Telemetry mode, the modem's own numbering.
    pub mode: i32,
    /// Whether the other modem shall acknowledge it.
    pub acknowledge: bool,
    /// One to eight frames; the mode limits their length.
    pub frames: Vec<Vec<u8>>,
}

/// Have a hovering vehicle keep its station for a while.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct StationRequest {
    /// The plugin's name for it.
    pub tag: u64,
    /// Where to go.
    pub target: StationTarget,
    /// The speed limit of the moves, m/s; `None` for the vehicle's own.
    pub speed_mps: Option<f64>,
    /// How long it lasts unless it is replaced.
    pub duration: Duration,
}

/// Where a vehicle goes that keeps its station.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum StationTarget {
    /// It stays where it is.
    Here,
    /// To a place on the hull (BPGHP, SPI 8.6).
    Hull {
        /// Along the hull, metres.
        horizontal_m: f64,
        /// Across it, metres.
        vertical_m: f64,
        /// From the hull, metres.
        distance_m: f64,
    },
    /// To a place over the bottom (BPGBP, SPI 8.7).
    Bottom {
        /// In the vehicle's inertial frame, metres.
        x_m: f64,
        /// In the vehicle's inertial frame, metres.
        y_m: f64,
        /// Depth or altitude.
        vertical: VerticalRequest,
    },
}

/// Turn the sonar.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct SonarAngleRequest {
    /// The plugin's name for it.
    pub tag: u64,
    /// Degrees.
    pub angle_deg: f64,
}

/// Move the camera: each figure is from -9 to 9, in tenths of a second of movement.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct CameraRequest {
    /// The plugin's name for it.
    pub tag: u64,
    /// Pan.
    pub pan: i32,
    /// Tilt.
    pub tilt: i32,
    /// Zoom.
    pub zoom: i32,
}

/// Switch the light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct LightRequest {
    /// The plugin's name for it.
    pub tag: u64,
    /// Which light.
    pub light: i32,
    /// On or off.
    pub on: bool,
}
