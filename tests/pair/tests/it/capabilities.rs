use std::time::Duration;

use backseat_core::plugin::{
    CameraRequest, DvlTriggerRequest, GpsHitRequest, LightRequest, PacketRequest, Request, SilentRequest,
    SonarAngleRequest, StationRequest, StationTarget, Topic, TopsideRequest, Transport, VerticalRequest,
};
use backseat_core::{BottomBox, Grant, HullBox, Limits, Note, Operator, Order, StationLimits};
use backseat_pair::{Dive, Setup, circle, course_plugin, limits, line, modify, place};

/// A capability, tried in four ways.
struct Capability {
    name: &'static str,
    /// The three letters of its command.
    command: &'static str,
    vehicle: Vehicle,
    grants: &'static [Grant],
    topics: &'static [Topic],
    /// The request, with tag 1.
    ask: fn() -> Request,
    /// The states that it goes through, and the most seconds for that.
    good: (&'static [&'static str], f64),
    /// The states if the vehicle refuses it.
    refused: &'static [&'static str],
    /// The states if the vehicle never answers; it may still have carried it out.
    unanswered: &'static [&'static str],
    /// The states if the link is cut before the answer, and restored some seconds later.
    cut: &'static [&'static str],
}

/// The vehicle, and its situation at the time of the request.
#[derive(Clone, Copy, PartialEq)]
enum Vehicle {
    /// On its line, where the backseat may steer.
    UnderWay,
    /// Ten metres deep in an empty mission, with the thruster off.
    Drifting,
    /// Beside a ship.
    Hovering,
}

const ACOUSTIC: &str = "
[acoustic]
address = 7
first_s = 3
period_s = 600
length_s = 500
";

const SHIP: &str = "
[hovering]
drift_m_per_sqrt_h = 0
bearing_drift_deg_per_sqrt_h = 0
[hovering.hull]
east_m = -620
north_m = 12
heading_deg = 90
length_m = 60
beam_m = 10
draft_m = 6
";

fn station_limits() -> StationLimits {
    StationLimits {
        speed_max_mps: 0.5,
        speed_default_mps: 1.5,
        position_error_m: 0.5,
        relative_age_max_s: 1.0,
        jump_allowance_m: 2.0,
        term_max_s: 60.0,
        altitude_min_m: 2.0,
        sonar_angle_min_deg: Some(-45.0),
        sonar_angle_max_deg: Some(45.0),
        hull_box: Some(HullBox {
            name: String::new(),
            horizontal_min_m: -50.0,
            horizontal_max_m: 50.0,
            vertical_min_m: -5.0,
            vertical_max_m: 30.0,
            distance_min_m: 1.0,
            distance_max_m: 25.0,
        }),
        bottom_box: Some(BottomBox {
            name: String::new(),
            x_min_m: -50.0,
            x_max_m: 50.0,
            y_min_m: -50.0,
            y_max_m: 50.0,
            depth_min_m: 1.0,
            depth_max_m: 30.0,
        }),
        keep_out_hull: Vec::new(),
        keep_out_bottom: Vec::new(),
    }
}

fn setup(capability: &Capability, faults: &str) -> Setup {
    let plugin = course_plugin(capability.grants, capability.topics);
    match capability.vehicle {
        Vehicle::UnderWay => Setup {
            world: format!("{ACOUSTIC}\n{faults}"),
            plugin,
            ..Setup::default()
        },
        Vehicle::Drifting => Setup {
            world: format!("[interpretation]\ncontrol_replay = true\n[silence]\nsettle_s = 1\n{faults}"),
            replaced: vec![("starts_after_s = 1", "starts_after_s = 5000\nempty_allowed = true")],
            plugin,
            limits: Limits {
                modify_needs_plan: false,
                ..limits()
            },
            ..Setup::default()
        },
        Vehicle::Hovering => Setup {
            world: format!("[vehicle]\nclass = \"hovering\"\n{SHIP}\n{faults}"),
            replaced: vec![
                ("speed_mps = 1.5\ndynamic = true", "speed_mps = 0.5\ndynamic = true"),
                ("speed_mps = 1.5", "speed_mps = 0.5"),
                ("depth_m = 20\nheading_deg = 90", "depth_m = 3\nheading_deg = 0"),
                (
                    "kind = \"trackline\"\nstart = { east_m = -600, north_m = 0 }\nend = { east_m = 600, north_m = 0 }",
                    "kind = \"setpoint\"\nheading_deg = 0\nduration_s = 600",
                ),
            ],
            plugin,
            limits: Limits {
                speed_min_mps: 0.4,
                speed_max_mps: 0.6,
                station: Some(station_limits()),
                ..limits()
            },
            ..Setup::default()
        },
    }
}

fn fault(kind: &str, command: &str) -> String {
    format!("[[faults.fault]]\nat_s = 4\nfor_s = 600\nkind = \"{kind}\"\ncommand = \"{command}\"\n")
}

const CAPABILITIES: &[Capability] = &[
    Capability {
        name: "modify",
        command: "RMB",
        vehicle: Vehicle::UnderWay,
        grants: &[Grant::Modify],
        topics: &[],
        ask: || Request::Modify(modify(1, 45.0, 10)),
        good: (&["sent", "accepted", "ended"], 15.0),
        refused: &["sent", "failed"],
        unanswered: &["sent", "timed out"],
        cut: &["sent", "ended"],
    },
    Capability {
        name: "trackline",
        command: "RTK",
        vehicle: Vehicle::UnderWay,
        grants: &[Grant::Insert, Grant::Interrupt],
        topics: &[],
        ask: || Request::Trackline(line(1, (-500.0, 60.0), (-450.0, 60.0), true)),
        good: (&["sent", "pending", "accepted", "started", "ended"], 300.0),
        refused: &["sent", "failed"],
        unanswered: &["sent", "started"],
        cut: &["sent", "unknown"],
    },
    Capability {
        name: "trackcircle",
        command: "RTC",
        vehicle: Vehicle::UnderWay,
        grants: &[Grant::Insert, Grant::Interrupt],
        topics: &[],
        ask: || Request::Trackcircle(circle(1, (-500.0, 80.0), 40.0)),
        good: (&["sent", "pending", "accepted", "started", "ended"], 500.0),
        refused: &["sent", "failed"],
        unanswered: &["sent", "started"],
        cut: &["sent", "unknown"],
    },
    Capability {
        name: "gps hit",
        command: "RGP",
        vehicle: Vehicle::UnderWay,
        grants: &[Grant::Insert, Grant::Interrupt, Grant::Surface],
        topics: &[],
        ask: || {
            Request::GpsHit(GpsHitRequest {
                tag: 1,
                position: place(600.0, 150.0),
            })
        },
        good: (&["sent", "accepted", "started", "ended"], 1600.0),
        refused: &["sent", "failed"],
        unanswered: &["sent", "timed out"],
        cut: &["sent", "unknown"],
    },
    Capability {
        name: "message",
        command: "TOP",
        vehicle: Vehicle::UnderWay,
        grants: &[Grant::Topside],
        topics: &[],
        ask: || {
            Request::Topside(TopsideRequest {
                tag: 1,
                slowest: Transport::AcousticModem,
                text: "a plume".to_owned(),
            })
        },
        good: (&["sent", "pending", "accepted"], 10.0),
        refused: &["sent", "failed"],
        unanswered: &["sent", "timed out"],
        cut: &["sent", "timed out"],
    },
    Capability {
        name: "dvl triggering",
        command: "DVR",
        vehicle: Vehicle::UnderWay,
        grants: &[Grant::Dvl],
        topics: &[],
        ask: || {
            Request::DvlTrigger(DvlTriggerRequest {
                tag: 1,
                external: true,
                triggering: false,
            })
        },
        good: (&["sent", "accepted"], 5.0),
        refused: &["sent", "failed"],
        unanswered: &["sent", "ended"],
        cut: &["sent", "timed out"],
    },
    Capability {
        name: "acoustic packet",
        command: "CPD",
        vehicle: Vehicle::UnderWay,
        grants: &[Grant::Acoustic],
        topics: &[Topic::Acoustic],
        ask: || {
            Request::Packet(PacketRequest {
                tag: 1,
                destination: 3,
                mode: 1,
                acknowledge: false,
                frames: vec![vec![1, 2, 3]],
            })
        },
        good: (&["sent", "accepted", "ended"], 60.0),
        refused: &["sent", "failed"],
        unanswered: &["sent", "ended"],
        cut: &["sent", "unknown"],
    },
    Capability {
        name: "silent mode refused while the tailcone spins",
        command: "SIL",
        vehicle: Vehicle::UnderWay,
        grants: &[Grant::Silent],
        topics: &[],
        ask: || Request::Silent(SilentRequest { tag: 1, silent: true }),
        good: (&["sent", "failed"], 10.0),
        refused: &["sent", "failed"],
        unanswered: &["sent", "timed out"],
        cut: &["sent", "timed out"],
    },
    Capability {
        name: "trim refused while the tailcone spins",
        command: "TRM",
        vehicle: Vehicle::UnderWay,
        grants: &[Grant::Trim],
        topics: &[Topic::Trim],
        ask: || Request::Trim(1),
        good: (&["sent", "failed"], 10.0),
        refused: &["sent", "failed"],
        unanswered: &["sent", "timed out"],
        cut: &["sent", "unknown"],
    },
    Capability {
        name: "silent mode",
        command: "SIL",
        vehicle: Vehicle::Drifting,
        grants: &[Grant::Silent],
        topics: &[],
        ask: || Request::Silent(SilentRequest { tag: 1, silent: true }),
        good: (&["sent", "pending", "accepted", "started", "ended"], 320.0),
        refused: &["sent", "failed"],
        unanswered: &["sent", "timed out"],
        cut: &["sent", "timed out"],
    },
    Capability {
        name: "trim",
        command: "TRM",
        vehicle: Vehicle::Drifting,
        grants: &[Grant::Trim],
        topics: &[Topic::Trim],
        ask: || Request::Trim(1),
        good: (&["sent", "accepted", "started", "ended"], 100.0),
        refused: &["sent", "failed"],
        unanswered: &["sent", "timed out"],
        cut: &["sent", "unknown"],
    },
    Capability {
        name: "buoyancy",
        command: "BOY",
        vehicle: Vehicle::Drifting,
        grants: &[Grant::Buoyancy],
        topics: &[Topic::Buoyancy],
        ask: || Request::Buoyancy(1),
        good: (&["sent", "accepted", "started", "ended"], 200.0),
        refused: &["sent", "failed"],
        unanswered: &["sent", "timed out"],
        cut: &["sent", "unknown"],
    },
    Capability {
        name: "station here",
        command: "SUS",
        vehicle: Vehicle::Hovering,
        grants: &[Grant::Station],
        topics: &[],
        ask: || {
            Request::Station(StationRequest {
                tag: 1,
                target: StationTarget::Here,
                speed_mps: None,
                duration: Duration::from_secs(10),
            })
        },
        good: (&["sent", "accepted", "ended"], 15.0),
        refused: &["sent", "failed"],
        unanswered: &["sent", "timed out"],
        cut: &["sent", "ended"],
    },
    Capability {
        name: "bottom position",
        command: "GBP",
        vehicle: Vehicle::Hovering,
        grants: &[Grant::Station],
        topics: &[],
        ask: || {
            Request::Station(StationRequest {
                tag: 1,
                target: StationTarget::Bottom {
                    x_m: -12.0,
                    y_m: 2.0,
                    vertical: VerticalRequest::DepthM(4.0),
                },
                speed_mps: Some(0.3),
                duration: Duration::from_secs(10),
            })
        },
        good: (&["sent", "accepted", "ended"], 15.0),
        refused: &["sent", "failed"],
        unanswered: &["sent", "timed out"],
        cut: &["sent", "ended"],
    },
    Capability {
        name: "hull position",
        command: "GHP",
        vehicle: Vehicle::Hovering,
        grants: &[Grant::Station],
        topics: &[],
        ask: || {
            Request::Station(StationRequest {
                tag: 1,
                target: StationTarget::Hull {
                    horizontal_m: 2.0,
                    vertical_m: 3.0,
                    distance_m: 6.0,
                },
                speed_mps: Some(0.3),
                duration: Duration::from_secs(20),
            })
        },
        good: (&["sent", "accepted", "ended"], 25.0),
        refused: &["sent", "failed"],
        unanswered: &["sent", "timed out"],
        cut: &["sent", "ended"],
    },
    Capability {
        name: "sonar angle",
        command: "SAN",
        vehicle: Vehicle::Hovering,
        grants: &[Grant::Devices],
        topics: &[],
        ask: || {
            Request::SonarAngle(SonarAngleRequest {
                tag: 1,
                angle_deg: 10.0,
            })
        },
        good: (&["sent", "accepted"], 5.0),
        refused: &["sent", "failed"],
        unanswered: &["sent", "timed out"],
        cut: &["sent", "timed out"],
    },
    Capability {
        name: "camera",
        command: "PTZ",
        vehicle: Vehicle::Hovering,
        grants: &[Grant::Devices],
        topics: &[],
        ask: || {
            Request::Camera(CameraRequest {
                tag: 1,
                pan: 3,
                tilt: -3,
                zoom: 0,
            })
        },
        good: (&["sent", "accepted"], 5.0),
        refused: &["sent", "failed"],
        unanswered: &["sent", "timed out"],
        cut: &["sent", "timed out"],
    },
    Capability {
        name: "light",
        command: "LIT",
        vehicle: Vehicle::Hovering,
        grants: &[Grant::Devices],
        topics: &[],
        ask: || {
            Request::Light(LightRequest {
                tag: 1,
                light: 0,
                on: true,
            })
        },
        good: (&["sent", "accepted"], 5.0),
        refused: &["sent", "failed"],
        unanswered: &["sent", "timed out"],
        cut: &["sent", "timed out"],
    },
];

/// Makes a request, and waits until it has begun.
fn asked(capability: &Capability, faults: &str) -> Dive {
    let mut dive = Dive::new(setup(capability, faults));
    dive.run_for(3.0);
    if capability.vehicle == Vehicle::Drifting {
        dive.operator(Operator::Order(Order::StartEmptyMission { duration_s: 900 }));
    }
    dive.run_for(3.0);
    let told = || -> Vec<String> { dive.notes.iter().map(|(at, note)| format!("{at} {note:?}")).collect() };
    assert!(dive.core.has_control(), "{}: {:#?}", capability.name, told());
    dive.ask((capability.ask)());
    dive.run_until(3.0, |dive| !dive.states(1).is_empty());
    dive
}

fn compare(failures: &mut Vec<String>, capability: &Capability, way: &str, dive: &Dive, expected: &[&str]) {
    let states = dive.states(1);
    if !states.starts_with(expected) {
        let told: Vec<String> = dive
            .notes
            .iter()
            .filter(|(_, note)| matches!(note, Note::Request(_)))
            .map(|(at, note)| format!("{at} {note:?}"))
            .collect();
        let name = capability.name;
        failures.push(format!("{name}, {way}: {states:?}, expected {expected:?}: {told:#?}"));
    }
}

#[test]
fn each_capability_comes_to_its_good_end() {
    let mut failures = Vec::new();
    for capability in CAPABILITIES {
        let mut dive = asked(capability, "");
        let (expected, seconds) = capability.good;
        dive.run_until(seconds, |dive| dive.states(1).len() >= expected.len());
        compare(&mut failures, capability, "good", &dive, expected);
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

#[test]
fn a_refusal_is_its_end() {
    let mut failures = Vec::new();
    for capability in CAPABILITIES {
        let mut dive = asked(capability, &fault("acks_negative", capability.command));
        dive.run_for(10.0);
        compare(&mut failures, capability, "refused", &dive, capability.refused);
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

#[test]
fn without_an_answer_it_ends_too() {
    let mut failures = Vec::new();
    for capability in CAPABILITIES {
        let mut dive = asked(capability, &fault("acks_lost", capability.command));
        dive.run_for(90.0);
        compare(&mut failures, capability, "unanswered", &dive, capability.unanswered);
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

#[test]
fn a_link_lost_midway_leaves_nothing_behind() {
    let mut failures = Vec::new();
    for capability in CAPABILITIES {
        let mut dive = asked(capability, "");
        dive.run_for(0.001);
        dive.cut();
        dive.run_for(5.0);
        compare(&mut failures, capability, "cut", &dive, capability.cut);
        let sent = dive.count(&format!("$BP{}", capability.command));
        dive.run_for(30.0);
        if dive.count(&format!("$BP{}", capability.command)) != sent {
            failures.push(format!("{} was sent again", capability.name));
        }
    }
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}
