use std::time::Duration;

use crate::fixture::breach;
use backseat_core::plugin::{
    Behavior, CtdSample, Event, PlannedElement, ReceivedFrame, ReceivedPacket, RequestState, Transport, Window,
};
use backseat_core::plugin::{EndCause, Ended, Failure, FrameOutcome, Refusal};
use backseat_core::refusal::ZoneRule;
use backseat_core::refusal::{Figure, FigureBreach};
use backseat_sdk as sdk;
use backseat_units::{EastNorth, Position, Timestamp};

/// Every event with its form in the guest, in a step at `now`.
pub(super) fn events(now: Timestamp) -> Vec<(Event, sdk::Event)> {
    let outcome = |state, guest| {
        (
            Event::Outcome { tag: 1, state },
            sdk::Event::Outcome(sdk::Outcome { tag: 1, state: guest }),
        )
    };
    let topside = |transport, guest| {
        let text = "come up".to_owned();
        (
            Event::TopsideMessage {
                transport,
                text: text.clone(),
            },
            sdk::Event::TopsideMessage(sdk::TopsideMessage { transport: guest, text }),
        )
    };
    let place = |latitude, longitude| Position::from_deg(latitude, longitude).unwrap();
    vec![
        (Event::Control(true), sdk::Event::Control(true)),
        (Event::Control(false), sdk::Event::Control(false)),
        outcome(
            RequestState::Rejected(breach(ZoneRule::KeepOut, 12.5)),
            sdk::State::Rejected(sdk::Refusal {
                zone: Some("box".into()),
                edge: Some(sdk::Edge {
                    polygon: 3,
                    hole: Some(2),
                    number: 1,
                    at: sdk::Position {
                        latitude: 42.5,
                        longitude: -70.25,
                    },
                }),
                missing_m: Some(12.5),
                cause: "keep-out".into(),
                ..sdk::Refusal::new(
                    sdk::Rule::KeepOut,
                    "keep-out: inside keep-out zone 'box' with its margin of 5 m by 12.5 m at polygon 3 hole 2 edge 1 \
                     (latitude 42.500000 longitude -70.250000)",
                )
            }),
        ),
        outcome(
            RequestState::Rejected(Refusal::Figure(FigureBreach {
                figure: Figure::Speed,
                value: Some(3.0),
                not_finite: None,
                least: Some(1.0),
                most: Some(2.0),
            })),
            sdk::State::Rejected(sdk::Refusal {
                cause: "speed".into(),
                value: Some(3.0),
                least: Some(1.0),
                most: Some(2.0),
                ..sdk::Refusal::new(
                    sdk::Rule::Limit,
                    "limit: speed is 3; expected 1 to 2 m/s (limits.speed_min_mps, limits.speed_max_mps)",
                )
            }),
        ),
        outcome(RequestState::Sent, sdk::State::Sent),
        outcome(RequestState::Pending, sdk::State::Pending),
        outcome(RequestState::Accepted, sdk::State::Accepted),
        outcome(
            RequestState::Failed(Failure::Vehicle("busy".into())),
            sdk::State::Failed(sdk::Failure::Vehicle("busy".into())),
        ),
        outcome(
            RequestState::Failed(Failure::NotInPlan),
            sdk::State::Failed(sdk::Failure::NotInPlan),
        ),
        outcome(RequestState::TimedOut, sdk::State::TimedOut),
        outcome(RequestState::Unknown, sdk::State::Unknown),
        outcome(RequestState::Started, sdk::State::Started),
        outcome(
            RequestState::Ended(EndCause::TermOver.into()),
            sdk::State::Ended(sdk::Ended {
                cause: "term-over".into(),
                ..sdk::Ended::new(sdk::EndKind::Term, "its term is over")
            }),
        ),
        outcome(
            RequestState::Ended(Ended::Frames(vec![FrameOutcome::Acked, FrameOutcome::Other(7)])),
            sdk::State::Ended(sdk::Ended {
                cause: "reported".into(),
                frames: vec![sdk::FrameOutcome::Acked, sdk::FrameOutcome::Other(7)],
                ..sdk::Ended::new(sdk::EndKind::Done, "2 frames: acked, status 7")
            }),
        ),
        outcome(RequestState::Cancelled, sdk::State::Cancelled),
        (
            Event::Ctd(CtdSample {
                measured: now - Duration::from_millis(40),
                conductivity_us_per_cm: 42_000.125,
                temperature_c: -1.5,
                pressure_kpa: 201.25,
            }),
            sdk::Event::Ctd(sdk::Ctd {
                age_ns: 40_000_000,
                conductivity: 42_000.125,
                temperature: -1.5,
                pressure: 201.25,
            }),
        ),
        (
            Event::MissionCommand("go on".into()),
            sdk::Event::MissionCommand("go on".into()),
        ),
        (
            Event::BehaviorBegan(Behavior {
                kind: "trackline".into(),
                tag: Some(3),
            }),
            sdk::Event::BehaviorBegan(sdk::Behavior {
                kind: "trackline".into(),
                tag: Some(3),
            }),
        ),
        (
            Event::BehaviorEnded(Behavior {
                kind: "waypoint".into(),
                tag: None,
            }),
            sdk::Event::BehaviorEnded(sdk::Behavior {
                kind: "waypoint".into(),
                tag: None,
            }),
        ),
        (Event::Timer(7), sdk::Event::Timer(7)),
        (
            Event::Restored {
                lost_steps: 4,
                open: vec![1, u64::MAX],
            },
            sdk::Event::Restored(sdk::Restored {
                lost_steps: 4,
                open: vec![1, u64::MAX],
            }),
        ),
        (Event::Shutdown, sdk::Event::Shutdown),
        (
            Event::LoggingBegan("line 4".into()),
            sdk::Event::LoggingBegan("line 4".into()),
        ),
        (
            Event::LoggingEnded(String::new()),
            sdk::Event::LoggingEnded(String::new()),
        ),
        topside(None, None),
        topside(Some(Transport::Ethernet), Some(sdk::Transport::Ethernet)),
        topside(Some(Transport::Wifi), Some(sdk::Transport::Wifi)),
        topside(Some(Transport::RadioModem), Some(sdk::Transport::RadioModem)),
        topside(Some(Transport::AcousticModem), Some(sdk::Transport::AcousticModem)),
        (Event::DvlTrigger(true), sdk::Event::DvlTrigger(true)),
        (Event::DvlTrigger(false), sdk::Event::DvlTrigger(false)),
        (
            Event::Window(Window {
                until: now + Duration::from_millis(30_500),
                address: 17,
                device: "WHOIPSK".into(),
            }),
            sdk::Event::Window(sdk::Window {
                until_ns: now.as_nanos() + 30_500_000_000,
                address: 17,
                device: "WHOIPSK".into(),
            }),
        ),
        (
            Event::Packet(ReceivedPacket {
                arrived: now - Duration::from_millis(250),
                source: 18,
                destination: u32::MAX,
                mode: Some(-2),
                frames: vec![
                    ReceivedFrame {
                        good: true,
                        data: vec![0, 255, 44],
                    },
                    ReceivedFrame {
                        good: false,
                        data: vec![],
                    },
                ],
            }),
            sdk::Event::Packet(sdk::ReceivedPacket {
                age_ns: 250_000_000,
                source: 18,
                destination: u32::MAX,
                mode: Some(-2),
                frames: vec![
                    sdk::ReceivedFrame {
                        good: true,
                        data: vec![0, 255, 44],
                    },
                    sdk::ReceivedFrame {
                        good: false,
                        data: vec![],
                    },
                ],
            }),
        ),
        (
            Event::Packet(ReceivedPacket {
                arrived: now,
                source: 19,
                destination: 20,
                mode: None,
                frames: vec![],
            }),
            sdk::Event::Packet(sdk::ReceivedPacket {
                age_ns: 0,
                source: 19,
                destination: 20,
                mode: None,
                frames: vec![],
            }),
        ),
        (
            Event::Plan(vec![
                PlannedElement {
                    number: Some(1),
                    identifier: None,
                    points: vec![
                        (place(42.25, -70.5), EastNorth::new(1.5, -2.5)),
                        (place(42.375, -70.625), EastNorth::new(3.5, 4.5)),
                    ],
                },
                PlannedElement {
                    number: None,
                    identifier: Some(1001),
                    points: vec![],
                },
            ]),
            sdk::Event::Plan(vec![
                sdk::PlannedElement {
                    number: Some(1),
                    identifier: None,
                    points: vec![
                        sdk::PlannedPoint {
                            position: sdk::Position {
                                latitude: 42.25,
                                longitude: -70.5,
                            },
                            east: 1.5,
                            north: -2.5,
                        },
                        sdk::PlannedPoint {
                            position: sdk::Position {
                                latitude: 42.375,
                                longitude: -70.625,
                            },
                            east: 3.5,
                            north: 4.5,
                        },
                    ],
                },
                sdk::PlannedElement {
                    number: None,
                    identifier: Some(1001),
                    points: vec![],
                },
            ]),
        ),
    ]
}
