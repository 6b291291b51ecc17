//! A plugin for tests of the interface between core and plugins: it logs every input, and makes every kind of request.

use backseat_sdk::{
    BottomPosition, Briefing, Camera, Description, DvlTrigger, FRAME_BYTES, FRAMES, GpsHit, HullPosition, Light,
    Modify, Packet, Plugin, Position, Request, Silent, SonarAngle, SonarLog, SonarSet, SonarSetting, Station,
    StationTarget, StepInput, Timer, Topic, Topside, Trackcircle, Trackline, Transport, Vertical, fence, log,
};
use serde::Deserialize;

/// The plugin's settings, from the mission file.
#[derive(Clone, Copy, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Config {
    /// How it answers each step.
    pub answer: Answer,
}

/// How it answers each step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Answer {
    /// With the step's whole input, as Rust's `Debug` formats it, in the frames of packets.
    Input,
    /// With what it was told about its mission, in the same form.
    Briefing,
    /// With [`every_request`].
    EveryRequest,
    /// With no requests. It asks the fence about each request of [`every_request`] and logs the answers.
    AskFence,
}

/// Echoes its input.
#[derive(Clone, Debug)]
pub struct Echo {
    config: Config,
    briefing: Option<Briefing>,
}

impl Plugin for Echo {
    type Config = Config;

    fn describe() -> Description {
        Description {
            name: "echo".into(),
            version: env!("CARGO_PKG_VERSION").into(),
            step_period_ns: 1_000_000_000,
            topics: vec![
                Topic::Sonar,
                Topic::SubBottom,
                Topic::Sidescan,
                Topic::RelativeNavigation,
                Topic::Buoyancy,
                Topic::Trim,
                Topic::Servo,
                Topic::Imu,
                Topic::DvlBeams,
                Topic::Dvl,
                Topic::Surfaces,
                Topic::Battery,
                Topic::VehicleSpeed,
                Topic::Pressure,
                Topic::Compass,
                Topic::SoundVelocity,
                Topic::Telemetry,
                Topic::Plan,
                Topic::Acoustic,
                Topic::Topside,
                Topic::Logging,
                Topic::Behavior,
                Topic::MissionCommand,
                Topic::Ctd,
            ],
            grants: vec![],
        }
    }

    fn new(config: Config) -> Result<Self, String> {
        Ok(Self { config, briefing: None })
    }

    fn brief(&mut self, briefing: &Briefing) -> Result<(), String> {
        self.briefing = Some(briefing.clone());
        Ok(())
    }

    fn step(&mut self, input: &StepInput) -> Result<Vec<Request>, String> {
        Ok(match self.config.answer {
            Answer::Input => said_back(&format!("{input:?}")),
            Answer::Briefing => said_back(&format!("{:?}", self.briefing)),
            Answer::EveryRequest => every_request(),
            Answer::AskFence => {
                for request in every_request() {
                    match fence::check(&request) {
                        Ok(metres) => log::info!("inside, with {metres} m to spare"),
                        Err(refusal) => log::info!("{:?}: {:?} m, {}", refusal.rule, refusal.missing_m, refusal.text),
                    }
                }
                vec![]
            }
        })
    }
}

backseat_sdk::export!(Echo);

fn said_back(text: &str) -> Vec<Request> {
    text.as_bytes()
        .chunks(FRAMES * FRAME_BYTES)
        .filter_map(|part| Packet::of(0, 0, 0, part, FRAME_BYTES))
        .map(Request::Packet)
        .collect()
}

/// Every kind of request in all its variants. All values differ, so that none can be mistaken for another.
#[must_use]
pub fn every_request() -> Vec<Request> {
    let position = |latitude, longitude| Position { latitude, longitude };
    let topside = |tag, slowest, text: &str| {
        Request::Topside(Topside {
            tag,
            slowest,
            text: text.into(),
        })
    };
    let station = |tag, target, speed, duration_ns| {
        Request::Station(Station {
            tag,
            target,
            speed,
            duration_ns,
        })
    };
    vec![
        Request::Modify(Modify {
            tag: 1,
            heading: 101.5,
            vertical: Vertical::Altitude(102.5),
            speed: 103.5,
            duration_ns: 104,
        }),
        Request::EndModify,
        Request::Trackline(Trackline {
            tag: 2,
            start: position(1.25, 2.25),
            end: position(3.25, 4.25),
            vertical: Vertical::Depth(105.5),
            speed: 106.5,
            interrupt: true,
        }),
        Request::Trackcircle(Trackcircle {
            tag: 3,
            centre: position(5.25, 6.25),
            radius: 107.5,
            orbits: -108.5,
            vertical: Vertical::Altitude(109.5),
            speed: 110.5,
            entry_angle: Some(111.5),
            interrupt: false,
        }),
        Request::Trackcircle(Trackcircle {
            tag: 4,
            centre: position(-7.25, -8.25),
            radius: 112.5,
            orbits: 113.5,
            vertical: Vertical::Depth(114.5),
            speed: 115.5,
            entry_angle: None,
            interrupt: true,
        }),
        Request::Cancel(5),
        Request::Message("a line".into()),
        Request::GpsHit(GpsHit {
            tag: 6,
            position: position(9.25, -10.25),
        }),
        topside(7, Transport::Ethernet, "by cable"),
        topside(8, Transport::Wifi, "by air"),
        topside(9, Transport::RadioModem, "by radio"),
        topside(10, Transport::AcousticModem, ""),
        Request::DvlTrigger(DvlTrigger {
            tag: 11,
            external: true,
            triggering: false,
        }),
        Request::DvlTrigger(DvlTrigger {
            tag: 12,
            external: false,
            triggering: true,
        }),
        Request::Silent(Silent { tag: 13, silent: true }),
        Request::Silent(Silent { tag: 14, silent: false }),
        Request::Trim(15),
        Request::Buoyancy(16),
        Request::Packet(Packet {
            tag: 17,
            destination: 4_000_000_001,
            mode: -118,
            acknowledge: true,
            frames: vec![vec![0, 255, b'$'], vec![], vec![7; FRAME_BYTES]],
        }),
        Request::Packet(Packet {
            tag: 18,
            destination: 119,
            mode: 120,
            acknowledge: false,
            frames: (0..8).map(|frame| vec![frame]).collect(),
        }),
        station(19, StationTarget::Here, None, 121),
        station(
            20,
            StationTarget::Hull(HullPosition {
                horizontal: 122.5,
                vertical: -123.5,
                distance: 124.5,
            }),
            Some(125.5),
            126,
        ),
        station(
            21,
            StationTarget::Bottom(BottomPosition {
                x: 127.5,
                y: -128.5,
                vertical: Vertical::Altitude(129.5),
            }),
            Some(130.5),
            131,
        ),
        station(
            22,
            StationTarget::Bottom(BottomPosition {
                x: -0.0,
                y: f64::INFINITY,
                vertical: Vertical::Depth(132.5),
            }),
            None,
            u64::MAX,
        ),
        Request::EndStation,
        Request::SonarAngle(SonarAngle { tag: 23, angle: -133.5 }),
        Request::Camera(Camera {
            tag: 24,
            pan: -9,
            tilt: 134,
            zoom: i32::MIN,
        }),
        Request::Light(Light {
            tag: 25,
            light: -135,
            on: true,
        }),
        Request::Light(Light {
            tag: u64::MAX,
            light: 136,
            on: false,
        }),
        sonar(26, SonarSetting::Range(139.5)),
        sonar(27, SonarSetting::Pulse("a pulse".into())),
        sonar(28, SonarSetting::Ping(true)),
        sonar(29, SonarSetting::Power(140.5)),
        sonar(30, SonarSetting::Gain(-141)),
        sonar(31, SonarSetting::Period(142.5)),
        sonar(32, SonarSetting::DefaultState),
        Request::SonarLog(SonarLog {
            tag: 33,
            on: true,
            file: Some("a file".into()),
        }),
        Request::SonarLog(SonarLog {
            tag: 34,
            on: false,
            file: None,
        }),
        Request::Timer(Timer { id: 137, after_ns: 138 }),
    ]
}

const fn sonar(tag: u64, setting: SonarSetting) -> Request {
    Request::SonarSet(SonarSet {
        tag,
        sensor: -143,
        setting,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_input_of_any_length_is_echoed_whole() {
        let input = StepInput {
            events: vec![backseat_sdk::Event::MissionCommand("x".repeat(20_000))],
            ..StepInput::default()
        };
        let requests = Echo(Config { answer: Answer::Input }).step(&input).unwrap();
        let mut bytes = Vec::new();
        for request in &requests {
            let Request::Packet(packet) = request else {
                panic!("{request:?}")
            };
            bytes.extend(packet.frames.concat());
        }
        assert_eq!(String::from_utf8(bytes).unwrap(), format!("{input:?}"));
    }
}
