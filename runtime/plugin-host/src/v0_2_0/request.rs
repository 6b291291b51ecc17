use std::time::Duration;

use backseat_core::plugin as core;

use super::wit;
use crate::instance::TEXT_BYTES;

/// The most requests in one step.
const REQUESTS: usize = 256;
/// The most frames in an acoustic packet (SPI 9.4).
const FRAMES: usize = 8;
/// The longest frame, bytes: more than any mode of a modem can carry.
const FRAME_BYTES: usize = 1024;

/// Converts the requests of a step, if they are within their bounds.
pub(crate) fn requests(requests: Vec<wit::Request>) -> Result<Vec<core::Request>, core::PluginFault> {
    let too_much = |text| {
        Err(core::PluginFault {
            kind: core::FaultKind::TooMuch,
            text,
        })
    };
    if requests.len() > REQUESTS {
        return too_much(format!(
            "{} requests in a step, expected at most {REQUESTS}",
            requests.len()
        ));
    }
    for request in &requests {
        if let Some(what) = excess(request) {
            return too_much(what);
        }
    }
    Ok(requests.into_iter().map(core::Request::from).collect())
}

/// What is too long in a request, and how long it may be.
fn excess(request: &wit::Request) -> Option<String> {
    match request {
        wit::Request::Message(text) | wit::Request::Topside(wit::Topside { text, .. }) => (text.len() > TEXT_BYTES)
            .then(|| format!("a message of {} bytes, expected at most {TEXT_BYTES}", text.len())),
        wit::Request::Packet(wit::Packet { frames, .. }) => {
            if frames.len() > FRAMES {
                return Some(format!(
                    "a packet of {} frames, expected at most {FRAMES}",
                    frames.len()
                ));
            }
            let longest = frames.iter().map(Vec::len).max()?;
            (longest > FRAME_BYTES).then(|| format!("a frame of {longest} bytes, expected at most {FRAME_BYTES}"))
        }
        wit::Request::Modify(_)
        | wit::Request::EndModify
        | wit::Request::Trackline(_)
        | wit::Request::Trackcircle(_)
        | wit::Request::Cancel(_)
        | wit::Request::GpsHit(_)
        | wit::Request::DvlTrigger(_)
        | wit::Request::Silent(_)
        | wit::Request::Trim(_)
        | wit::Request::Buoyancy(_)
        | wit::Request::Station(_)
        | wit::Request::EndStation
        | wit::Request::SonarAngle(_)
        | wit::Request::Camera(_)
        | wit::Request::Light(_)
        | wit::Request::Timer(_) => None,
        wit::Request::SonarSet(wit::SonarSet {
            setting: wit::SonarSetting::Pulse(text),
            ..
        })
        | wit::Request::SonarLog(wit::SonarLog { file: Some(text), .. }) => {
            (text.len() > TEXT_BYTES).then(|| format!("a name of {} bytes, expected at most {TEXT_BYTES}", text.len()))
        }
        wit::Request::SonarSet(_) | wit::Request::SonarLog(_) => None,
    }
}

impl From<wit::Request> for core::Request {
    fn from(request: wit::Request) -> Self {
        match request {
            wit::Request::Modify(modify) => Self::Modify(core::ModifyRequest {
                tag: modify.tag,
                heading_deg: modify.heading,
                vertical: modify.vertical.into(),
                speed_mps: modify.speed,
                duration: Duration::from_nanos(modify.duration_ns),
            }),
            wit::Request::EndModify => Self::EndModify,
            wit::Request::Trackline(line) => Self::Trackline(core::TracklineRequest {
                tag: line.tag,
                start: line.start.into(),
                end: line.end.into(),
                vertical: line.vertical.into(),
                speed_mps: line.speed,
                interrupt: line.interrupt,
            }),
            wit::Request::Trackcircle(circle) => Self::Trackcircle(core::TrackcircleRequest {
                tag: circle.tag,
                centre: circle.centre.into(),
                radius_m: circle.radius,
                orbits: circle.orbits,
                vertical: circle.vertical.into(),
                speed_mps: circle.speed,
                entry_angle_deg: circle.entry_angle,
                interrupt: circle.interrupt,
            }),
            wit::Request::Cancel(tag) => Self::Cancel(tag),
            wit::Request::Message(text) => Self::Message(text),
            wit::Request::GpsHit(hit) => Self::GpsHit(core::GpsHitRequest {
                tag: hit.tag,
                position: hit.position.into(),
            }),
            wit::Request::Topside(message) => Self::Topside(core::TopsideRequest {
                tag: message.tag,
                slowest: message.slowest.into(),
                text: message.text,
            }),
            wit::Request::DvlTrigger(trigger) => Self::DvlTrigger(core::DvlTriggerRequest {
                tag: trigger.tag,
                external: trigger.external,
                triggering: trigger.triggering,
            }),
            wit::Request::Silent(silent) => Self::Silent(core::SilentRequest {
                tag: silent.tag,
                silent: silent.silent,
            }),
            wit::Request::Trim(tag) => Self::Trim(tag),
            wit::Request::Buoyancy(tag) => Self::Buoyancy(tag),
            wit::Request::Packet(packet) => Self::Packet(core::PacketRequest {
                tag: packet.tag,
                destination: packet.destination,
                mode: packet.mode,
                acknowledge: packet.acknowledge,
                frames: packet.frames,
            }),
            wit::Request::Station(station) => Self::Station(core::StationRequest {
                tag: station.tag,
                target: station.target.into(),
                speed_mps: station.speed,
                duration: Duration::from_nanos(station.duration_ns),
            }),
            wit::Request::EndStation => Self::EndStation,
            wit::Request::SonarAngle(sonar) => Self::SonarAngle(core::SonarAngleRequest {
                tag: sonar.tag,
                angle_deg: sonar.angle,
            }),
            wit::Request::Camera(camera) => Self::Camera(core::CameraRequest {
                tag: camera.tag,
                pan: camera.pan,
                tilt: camera.tilt,
                zoom: camera.zoom,
            }),
            wit::Request::Light(light) => Self::Light(core::LightRequest {
                tag: light.tag,
                light: light.light,
                on: light.on,
            }),
            wit::Request::SonarSet(set) => Self::SonarSet(core::SonarSetRequest {
                tag: set.tag,
                sensor: set.sensor,
                setting: set.setting.into(),
            }),
            wit::Request::SonarLog(log) => Self::SonarLog(core::SonarLogRequest {
                tag: log.tag,
                on: log.on,
                file: log.file,
            }),
            wit::Request::Timer(timer) => Self::Timer {
                id: timer.id,
                after: Duration::from_nanos(timer.after_ns),
            },
        }
    }
}

impl From<wit::Vertical> for core::VerticalRequest {
    fn from(vertical: wit::Vertical) -> Self {
        match vertical {
            wit::Vertical::Depth(metres) => Self::DepthM(metres),
            wit::Vertical::Altitude(metres) => Self::AltitudeM(metres),
        }
    }
}

impl From<wit::Position> for core::PositionRequest {
    fn from(position: wit::Position) -> Self {
        Self {
            latitude_deg: position.latitude,
            longitude_deg: position.longitude,
        }
    }
}

impl From<wit::Transport> for core::Transport {
    fn from(transport: wit::Transport) -> Self {
        match transport {
            wit::Transport::Ethernet => Self::Ethernet,
            wit::Transport::Wifi => Self::Wifi,
            wit::Transport::RadioModem => Self::RadioModem,
            wit::Transport::AcousticModem => Self::AcousticModem,
        }
    }
}

impl From<wit::StationTarget> for core::StationTarget {
    fn from(target: wit::StationTarget) -> Self {
        match target {
            wit::StationTarget::Here => Self::Here,
            wit::StationTarget::Hull(place) => Self::Hull {
                horizontal_m: place.horizontal,
                vertical_m: place.vertical,
                distance_m: place.distance,
            },
            wit::StationTarget::Bottom(place) => Self::Bottom {
                x_m: place.x,
                y_m: place.y,
                vertical: place.vertical.into(),
            },
        }
    }
}
