use backseat_sdk::{
    BottomPosition, Camera, DvlTrigger, GpsHit, HullPosition, Light, Modify, Packet, Position, Request, Silent,
    SonarAngle, Station, StationTarget, Topside, Trackline, Transport, Vertical,
};

/// Latitude 0, longitude 0.
pub(crate) const ORIGIN: Position = Position {
    latitude: 0.0,
    longitude: 0.0,
};

/// Texts that would break a sentence.
pub(crate) const RESERVED: [&str; 5] = [
    "a,b",
    "a*4E",
    "$BPABT,000000.000*5A",
    "first\r\n$BPKIL,000000.000*5A\r\n",
    "caf\u{e9}\0",
];

pub(crate) fn topside(tag: u64, text: &str) -> Request {
    Request::Topside(Topside {
        tag,
        slowest: Transport::AcousticModem,
        text: text.into(),
    })
}

pub(crate) fn packet(tag: u64, frames: usize, bytes: usize) -> Request {
    Request::Packet(Packet {
        tag,
        destination: 1,
        mode: 0,
        acknowledge: false,
        frames: vec![vec![0x55; bytes]; frames],
    })
}

pub(crate) fn gps_hit(tag: u64, position: Position) -> Request {
    Request::GpsHit(GpsHit { tag, position })
}

pub(crate) fn light(tag: u64, on: bool) -> Request {
    Request::Light(Light { tag, light: 0, on })
}

pub(crate) fn camera(tag: u64, movement: i32) -> Request {
    Request::Camera(Camera {
        tag,
        pan: movement,
        tilt: -movement,
        zoom: movement,
    })
}

/// Requests that need the vehicle's permission first.
pub(crate) fn uninvited(mut tag: impl FnMut() -> u64) -> Vec<Request> {
    vec![
        packet(tag(), 1, 8),
        Request::DvlTrigger(DvlTrigger {
            tag: tag(),
            external: false,
            triggering: true,
        }),
        Request::Silent(Silent {
            tag: tag(),
            silent: true,
        }),
        station(tag(), StationTarget::Here, None),
        Request::EndStation,
    ]
}

/// Every kind of request with `value` for all of its values.
pub(crate) fn with_figure(value: f64, mut tag: impl FnMut() -> u64) -> Vec<Request> {
    let (vertical, speed) = (Vertical::Depth(value), value);
    let position = Position {
        latitude: value,
        longitude: value,
    };
    let hull = StationTarget::Hull(HullPosition {
        horizontal: value,
        vertical: value,
        distance: value,
    });
    let bottom = StationTarget::Bottom(BottomPosition {
        x: value,
        y: value,
        vertical: Vertical::Altitude(value),
    });
    vec![
        Request::Modify(Modify {
            tag: tag(),
            heading: value,
            vertical,
            speed,
            duration_ns: u64::MAX,
        }),
        Request::Trackline(Trackline {
            tag: tag(),
            start: position,
            end: position,
            vertical,
            speed,
            interrupt: true,
        }),
        gps_hit(tag(), position),
        station(tag(), hull, Some(value)),
        station(tag(), bottom, Some(value)),
        Request::SonarAngle(SonarAngle {
            tag: tag(),
            angle: value,
        }),
    ]
}

pub(crate) fn station(tag: u64, target: StationTarget, speed: Option<f64>) -> Request {
    Request::Station(Station {
        tag,
        target,
        speed,
        duration_ns: 5_000_000_000,
    })
}
