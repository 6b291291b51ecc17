use std::time::Duration;

use backseat_core::plugin::{CameraRequest, LightRequest, Request, SonarAngleRequest};
use backseat_core::{Grant, Operator, StationLimits};
use backseat_spi::AckStatus;

use crate::station::{hovering, hovering_with, lines, setup, station_limits};
use crate::trial::{Trial, shorts};
use crate::vehicle::Reply;

const fn sonar(tag: u64, angle_deg: f64) -> Request {
    Request::SonarAngle(SonarAngleRequest { tag, angle_deg })
}

const fn camera(tag: u64, pan: i32, tilt: i32, zoom: i32) -> Request {
    Request::Camera(CameraRequest { tag, pan, tilt, zoom })
}

const fn light(tag: u64, light: i32, on: bool) -> Request {
    Request::Light(LightRequest { tag, light, on })
}

fn all() -> [(&'static str, Request); 3] {
    [
        ("SAN", sonar(1, -30.5)),
        ("PTZ", camera(1, 9, -9, 0)),
        ("LIT", light(1, 0, true)),
    ]
}

#[test]
fn requests_for_sonar_camera_and_light_are_sent_and_end() {
    let mut trial = hovering();
    trial.ask(
        0,
        [
            sonar(1, -30.5),
            camera(2, 9, -9, 0),
            light(3, 1, true),
            light(4, 1, false),
        ],
    );
    trial.run_for(0.5);
    assert_eq!(lines(&trial, "SAN"), ["-30.5"]);
    assert_eq!(lines(&trial, "PTZ"), ["9,-9,0"]);
    assert_eq!(lines(&trial, "LIT"), ["1,1", "1,0"]);
    for tag in 1..=4 {
        assert_eq!(shorts(&trial.states(tag)), ["sent", "accepted", "ended"]);
    }
    assert_eq!(trial.core.open_requests(), 0);
}

#[test]
fn a_refused_request_fails_and_an_unanswered_one_times_out() {
    for (name, request) in all() {
        let replies = [
            (Reply::Refuse, vec!["sent", "failed"]),
            (Reply::Nak, vec!["sent", "failed"]),
            (Reply::Silent, vec!["sent", "timed out"]),
            (
                Reply::Late(Duration::from_secs(3), AckStatus::Succeeded),
                vec!["sent", "timed out"],
            ),
            (
                Reply::Pending(Duration::from_secs(1), AckStatus::Succeeded),
                vec!["sent", "pending", "accepted", "ended"],
            ),
            (Reply::PendingForEver, vec!["sent", "pending", "timed out"]),
        ];
        for (reply, states) in replies {
            let mut trial = hovering();
            trial.vehicle.replies.insert(name, reply);
            trial.ask(0, [request.clone()]);
            trial.run_for(8.0);
            assert_eq!(shorts(&trial.states(1)), states, "{name} {reply:?}");
            assert_eq!(trial.core.open_requests(), 0);
        }
    }
}

#[test]
fn a_request_whose_answer_was_lost_with_the_link_times_out_and_is_not_sent_again() {
    for (name, request) in all() {
        let mut trial = hovering();
        trial.vehicle.replies.insert(name, Reply::Silent);
        trial.ask(0, [request]);
        trial.run_for(0.3);
        trial.cut();
        trial.vehicle.replies.clear();
        trial.run_for(6.0);
        assert!(trial.core.has_control());
        assert_eq!(shorts(&trial.states(1)), ["sent", "timed out"], "{name}");
        assert_eq!(trial.commands(name).len(), 1);
    }
}

#[test]
fn figures_beyond_the_limits_are_rejected_and_never_clamped() {
    let mut trial = hovering();
    let bad = [
        (sonar(1, 45.1), "angle of the sonar is 45.1; expected -45 to 45 deg"),
        (sonar(2, f64::NAN), "is NaN"),
        (sonar(3, f64::NEG_INFINITY), "is minus infinite"),
        (
            camera(4, 10, 0, 0),
            "pan of the camera is 10; expected -9 to 9 tenths of a second",
        ),
        (camera(5, 0, -10, 0), "tilt"),
        (camera(6, 0, 0, i32::MAX), "zoom"),
        (light(7, -1, true), "number of a light is -1; expected at least 0"),
    ];
    for (tag, (request, text)) in (1..).zip(bad) {
        trial.ask(0, [request]);
        trial.run_for(0.2);
        let rejection = trial.rejection(tag);
        assert!(
            rejection.starts_with("limit: ") && rejection.contains(text),
            "{rejection}"
        );
    }
    for name in ["SAN", "PTZ", "LIT"] {
        assert!(trial.commands(name).is_empty());
    }
}

#[test]
fn sr_001_devices_need_the_table_of_limits_a_grant_and_control() {
    let mut no_table = Trial::with_under_way(setup(None));
    let mut no_grant = setup(Some(station_limits()));
    no_grant.plugins[0].grants.retain(|grant| *grant != Grant::Devices);
    let mut no_grant = Trial::with_under_way(no_grant);
    let mut no_control = hovering();
    no_control.operator(Operator::Hold);
    for (trial, text) in [
        (&mut no_table, "the mission has no [limits.station]"),
        (&mut no_grant, "does not grant `devices`"),
        (&mut no_control, "control: the operator's hold is set"),
    ] {
        for (name, request) in all() {
            trial.ask(0, [request]);
            trial.run_for(0.3);
            assert!(trial.rejection(1).contains(text), "{}", trial.rejection(1));
            assert!(trial.commands(name).is_empty());
        }
    }
    let mut no_angles = hovering_with(StationLimits {
        sonar_angle_min_deg: None,
        sonar_angle_max_deg: None,
        ..station_limits()
    });
    no_angles.ask(0, [sonar(1, 0.0)]);
    no_angles.run_for(0.3);
    assert!(no_angles.rejection(1).contains("no sonar_angle_min_deg"));
}

#[test]
fn sr_019_a_flood_of_device_requests_is_limited_to_the_rate() {
    let mut trial = hovering();
    trial.script(0, |_| {
        let flood = (0..100).map(|tag| camera(tag, 1, 0, 0));
        (Duration::from_millis(1), Ok(flood.collect()))
    });
    trial.run_for(2.0);
    assert!(trial.commands("PTZ").len() <= 65, "{}", trial.commands("PTZ").len());
    assert!(trial.core.has_control());
}
