//! Every value from core arrives in a plugin, and every request of a plugin in core, to the last bit.

use std::sync::{Arc, Mutex};
use std::time::Duration;

use backseat_core::plugin::{
    CartesianSample, Event, Judge, Refusal, RelativeSample, Request, Returned, StepInput, Topic,
};
use backseat_core::refusal::ZoneRule;
use backseat_plugin_host::{Budget, Component, Started};
use backseat_sdk as sdk;

use crate::fixture::{Latitude, breach, brief, components, input};

mod briefing;
mod events;
mod requests;
mod samples;
mod sonar;

use events::events;
use requests::every_request;
use samples::samples;

/// The plugin in both versions of the interface.
fn echoes() -> [&'static Component; 2] {
    [&components().echo, &components().old_echo]
}

fn echo(component: &Component, answer: &str, judge: Arc<dyn Judge>) -> Started {
    let config = format!(r#"{{"answer": "{answer}"}}"#);
    // The plugin formats all of its input, which takes some fuel.
    let budget = Budget {
        fuel_per_step: 100_000_000,
        ..Budget::default()
    };
    component.start(budget, &brief(&config), judge).unwrap()
}

/// The text that a step returned in the frames of packets.
#[track_caller]
fn said_back(returned: Returned) -> String {
    let mut bytes = Vec::new();
    for request in returned.result.unwrap() {
        let Request::Packet(packet) = request else {
            panic!("{request:?}")
        };
        bytes.extend(packet.frames.concat());
    }
    String::from_utf8(bytes).unwrap()
}

/// What the guest received, in the form in which it logs it.
#[track_caller]
fn heard(input: &StepInput) -> String {
    let [new, old] = echoes().map(|component| {
        let returned = echo(component, "input", Arc::new(Latitude)).plugin.step(input);
        said_back(returned)
    });
    assert_eq!(
        new, old,
        "a plugin that was made for the older interface receives the same"
    );
    new
}

/// What a guest receives for [`input`], without the events.
fn guest_input(second: u64) -> sdk::StepInput {
    sdk::StepInput {
        now_ns: second * 1_000_000_000,
        utc_ns: 1_790_000_000_000_000_000 + second * 1_000_000_000,
        navigation: Some(sdk::Navigation {
            age_ns: 0,
            position: sdk::Position {
                latitude: 42.0,
                longitude: -70.0,
            },
            east: 100.0,
            north: 200.0,
            depth: 10.0,
            altitude: Some(15.0),
            heading: 45.0,
            roll: 0.5,
            pitch: -1.0,
            velocity_east: 1.0,
            velocity_north: 1.0,
            velocity_down: 0.0,
            yaw_rate: 0.1,
            gps: false,
        }),
        relative: None,
        cartesian: None,
        control: true,
        events: vec![],
    }
}

#[test]
fn every_event_arrives_in_the_plugin() {
    let step = input(100);
    let (given, expected) = events(step.now).into_iter().unzip();
    let step = StepInput { events: given, ..step };
    let expected = sdk::StepInput {
        events: expected,
        ..guest_input(100)
    };
    assert_eq!(heard(&step), format!("{expected:?}"));
}

#[test]
fn every_sample_arrives_in_the_plugin() {
    let step = input(100);
    let (given, expected): (Vec<_>, Vec<_>) = samples(step.now).into_iter().unzip();
    let step = StepInput {
        events: given.into_iter().map(Event::Sample).collect(),
        ..step
    };
    let expected = sdk::StepInput {
        events: expected.into_iter().map(sdk::Event::Sample).collect(),
        ..guest_input(100)
    };
    assert_eq!(heard(&step), format!("{expected:?}"));
}

#[test]
fn every_ping_and_report_of_the_sonars_arrives_in_the_plugin() {
    let step = input(100);
    let (given, expected) = sonar::events(step.now).into_iter().unzip();
    let step = StepInput { events: given, ..step };
    let expected = sdk::StepInput {
        events: expected,
        ..guest_input(100)
    };
    assert_eq!(heard(&step), format!("{expected:?}"));
}

#[test]
fn navigation_of_every_kind_arrives_in_the_plugin() {
    let step = input(7);
    let step = StepInput {
        relative: Some(RelativeSample {
            measured: step.now - Duration::from_millis(20),
            horizontal_m: 1.5,
            vertical_m: -2.5,
            distance_m: 3.5,
            heading_deg: 4.5,
            depth_m: 5.5,
            absolute_heading_deg: 6.5,
            roll_deg: -7.5,
            pitch_deg: 8.5,
        }),
        cartesian: Some(CartesianSample {
            measured: step.now - Duration::from_millis(30),
            x_m: 9.5,
            y_m: -10.5,
            z_m: 11.5,
            heading_deg: 12.5,
        }),
        ..step
    };
    let expected = sdk::StepInput {
        relative: Some(sdk::Relative {
            age_ns: 20_000_000,
            horizontal: 1.5,
            vertical: -2.5,
            distance: 3.5,
            heading: 4.5,
            depth: 5.5,
            absolute_heading: 6.5,
            roll: -7.5,
            pitch: 8.5,
        }),
        cartesian: Some(sdk::Cartesian {
            age_ns: 30_000_000,
            x: 9.5,
            y: -10.5,
            z: 11.5,
            heading: 12.5,
        }),
        ..guest_input(7)
    };
    assert_eq!(heard(&step), format!("{expected:?}"));
    let without = StepInput {
        navigation: None,
        control: false,
        ..input(7)
    };
    let expected = sdk::StepInput {
        navigation: None,
        control: false,
        ..guest_input(7)
    };
    assert_eq!(heard(&without), format!("{expected:?}"));
}

#[test]
fn a_plugin_receives_nothing_of_the_step_before() {
    let mut plugin = echo(&components().echo, "input", Arc::new(Latitude)).plugin;
    let step = input(1);
    let full = StepInput {
        relative: Some(RelativeSample {
            measured: step.now,
            horizontal_m: 1.0,
            vertical_m: 1.0,
            distance_m: 1.0,
            heading_deg: 1.0,
            depth_m: 1.0,
            absolute_heading_deg: 1.0,
            roll_deg: 1.0,
            pitch_deg: 1.0,
        }),
        cartesian: Some(CartesianSample {
            measured: step.now,
            x_m: 1.0,
            y_m: 1.0,
            z_m: 1.0,
            heading_deg: 1.0,
        }),
        events: vec![Event::Shutdown],
        ..step
    };
    plugin.step(&full);
    let returned = plugin.step(&input(2));
    let Ok([Request::Packet(packet)]) = returned.result.as_deref() else {
        panic!("{returned:?}")
    };
    assert_eq!(
        String::from_utf8(packet.frames.concat()).unwrap(),
        format!("{:?}", guest_input(2))
    );
}

#[test]
fn every_request_arrives_in_core() {
    for component in echoes() {
        let returned = echo(component, "every_request", Arc::new(Latitude))
            .plugin
            .step(&input(0));
        let requests = returned.result.unwrap();
        // Compared as text, which distinguishes -0 from 0.
        assert_eq!(format!("{requests:#?}"), format!("{:#?}", every_request()));
    }
}

/// Answers each request with a clearance of as many metres as there were requests, and keeps the requests.
#[derive(Default)]
struct Listening(Mutex<Vec<Request>>);

impl Judge for Listening {
    fn judge(&self, request: &Request, _: &StepInput) -> Result<f64, Refusal> {
        let mut asked = self.0.lock().unwrap();
        asked.push(request.clone());
        if let Request::GpsHit(_) = request {
            return Err(breach(ZoneRule::Surfacing, 0.5));
        }
        Ok(asked.len() as f64)
    }
}

#[test]
fn the_fence_receives_every_request_unchanged() {
    for component in echoes() {
        let judge = Arc::new(Listening::default());
        let returned = echo(component, "ask_fence", judge.clone()).plugin.step(&input(0));
        assert_eq!(returned.result, Ok(vec![]));
        let asked = judge.0.lock().unwrap();
        assert_eq!(format!("{asked:#?}"), format!("{:#?}", every_request()));
        let lines: Vec<&str> = returned.log.iter().map(|line| line.text.as_str()).collect();
        // 32 lines are kept, and one says how many were not.
        assert!(asked.len() > 32 && lines.len() == 33, "{} {}", asked.len(), lines.len());
        assert_eq!(lines[0], "inside, with 1 m to spare");
        assert_eq!(
            lines[7],
            "Rule::Surfacing: Some(0.5) m, surfacing: outside keep-in zone 'box', the nearest that allows surfacing, with its margin of \
             5 m by 0.5 m at polygon 3 hole 2 edge 1 (latitude 42.500000 longitude -70.250000)"
        );
    }
}

#[test]
fn a_plugin_may_list_topics_in_any_order() {
    for component in echoes() {
        let description = echo(component, "input", Arc::new(Latitude)).description;
        assert_eq!(description.topics, TOPICS);
    }
}

/// In the order of core.
const TOPICS: [Topic; 24] = [
    Topic::Ctd,
    Topic::MissionCommand,
    Topic::Behavior,
    Topic::Logging,
    Topic::Topside,
    Topic::Acoustic,
    Topic::Plan,
    Topic::Telemetry,
    Topic::SoundVelocity,
    Topic::Compass,
    Topic::Pressure,
    Topic::VehicleSpeed,
    Topic::Battery,
    Topic::Surfaces,
    Topic::Dvl,
    Topic::DvlBeams,
    Topic::Imu,
    Topic::Servo,
    Topic::Trim,
    Topic::Buoyancy,
    Topic::RelativeNavigation,
    Topic::Sidescan,
    Topic::SubBottom,
    Topic::Sonar,
];
