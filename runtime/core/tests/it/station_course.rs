//! What happens to station keeping when the link, the navigation, control or another plugin interferes, and which
//! requests are rejected.

use std::time::Duration;

use backseat_core::plugin::{Request, RequestState, StationRequest, VerticalRequest};
use backseat_core::refusal::Uncontrolled;
use backseat_core::{Grant, Operator};
use backseat_units::Timestamp;

use crate::course::{modify, turn};
use crate::station::{hovering, lines, moving, sentences, setup, station, station_limits, to_bottom, to_hull};
use crate::trial::{Trial, shorts};
use crate::vehicle::Reply;

#[test]
fn sr_007_a_cut_link_ends_station_keeping_and_the_speed_limit_is_restored_once_when_control_is_back() {
    let mut trial = moving();
    trial.vehicle.replays = false;
    let cut = trial.now;
    trial.cut();
    assert_eq!(
        trial.states(1).last(),
        Some(&RequestState::Ended(Uncontrolled::LinkDown.into()))
    );
    trial.run_for(5.0);
    assert!(sentences(&trial, cut).is_empty(), "without control nothing is sent");
    let now = trial.now;
    trial.vehicle.set_control(now, true);
    trial.vehicle.set_status(now, "Running");
    trial.run_for(5.0);
    assert_eq!(
        sentences(&trial, cut),
        ["SPD"],
        "no old BPCON, and no BPRES for station keeping that has lapsed"
    );
    assert_eq!(lines(&trial, "SPD"), ["0.2", "1.5"]);
    let now = trial.now;
    trial.vehicle.set_control(now, false);
    trial.run_for(0.5);
    let now = trial.now;
    trial.vehicle.set_control(now, true);
    trial.run_for(1.0);
    assert_eq!(lines(&trial, "SPD").len(), 2, "it has been acknowledged");
    assert_eq!(trial.core.open_requests(), 0);
}

#[test]
fn a_speed_limit_that_could_not_be_restored_is_restored_with_the_next_control() {
    for reply in [Reply::Refuse, Reply::Silent] {
        let mut trial = moving();
        trial.vehicle.replies.insert("SPD", reply);
        trial.ask(0, [Request::EndStation]);
        trial.run_for(4.0);
        assert_eq!(lines(&trial, "SPD"), ["0.2", "1.5"]);
        trial.vehicle.replies.clear();
        for _ in 0..2 {
            let now = trial.now;
            trial.vehicle.set_control(now, false);
            trial.run_for(0.5);
            let now = trial.now;
            trial.vehicle.set_control(now, true);
            trial.run_for(1.0);
        }
        assert_eq!(lines(&trial, "SPD"), ["0.2", "1.5", "1.5"], "{reply:?}");
    }
}

#[test]
fn station_keeping_that_is_cut_off_before_its_first_answer_ends_and_is_not_sent_again() {
    let mut trial = hovering();
    trial.vehicle.replies.insert("SUS", Reply::Silent);
    trial.ask(0, [Request::Station(to_hull(1, 10.0, 5.0, 5.0))]);
    trial.run_for(0.4);
    trial.cut();
    trial.vehicle.replies.clear();
    let cut = trial.now;
    trial.run_for(10.0);
    assert!(trial.core.has_control());
    assert!(sentences(&trial, cut).is_empty());
    assert_eq!(shorts(&trial.states(1)), ["sent", "ended"]);
    assert_eq!(trial.core.open_requests(), 0);
}

#[test]
fn sr_021_after_a_jump_station_keeping_is_rejected_until_navigation_has_been_steady_for_ten_seconds() {
    let mut trial = hovering();
    trial.vehicle.hull_m = Some([6.0, 5.0, 5.0]);
    trial.run_for(1.0);
    trial.ask(0, [Request::Station(to_hull(1, 10.0, 5.0, 5.0))]);
    trial.run_for(8.0);
    assert!(
        trial.rejection(1).contains("needs fresh BFRNV"),
        "{}",
        trial.rejection(1)
    );
    trial.run_for(2.0);
    trial.ask(0, [Request::Station(to_hull(2, 10.0, 5.0, 5.0))]);
    trial.run_for(0.5);
    assert_eq!(shorts(&trial.states(2)), ["sent", "accepted"]);
}

#[test]
fn a_plugin_of_higher_priority_takes_over_station_keeping_and_one_of_lower_priority_is_rejected() {
    let mut trial = hovering();
    trial.ask(1, [Request::Station(station(1))]);
    trial.run_for(0.5);
    let taken = trial.now;
    trial.ask(0, [Request::Station(to_hull(2, 3.0, 5.0, 5.0))]);
    trial.run_for(0.4);
    assert_eq!(shorts(&trial.states(1)).last(), Some(&"ended"));
    assert_eq!(shorts(&trial.states(2)), ["sent", "accepted"]);
    assert_eq!(
        sentences(&trial, taken)
            .into_iter()
            .filter(|name| *name != "CON")
            .collect::<Vec<_>>(),
        ["SPD", "GHP"],
        "the vehicle stays suspended"
    );
    trial.ask(
        1,
        [
            Request::Station(station(3)),
            Request::EndStation,
            Request::Modify(modify(4)),
        ],
    );
    trial.run_for(0.5);
    assert!(trial.rejection(3).contains("higher priority"));
    assert!(trial.rejection(4).contains("higher priority keeps"));
    assert!(
        trial.core.is_steering(),
        "the plugin of lower priority cannot end it either"
    );
}

#[test]
fn a_rejected_station_request_of_higher_priority_leaves_that_of_lower_priority() {
    let mut trial = hovering();
    trial.ask(1, [Request::Station(station(1))]);
    trial.run_for(0.5);
    trial.ask(0, [Request::Station(to_hull(2, f64::NAN, 5.0, 5.0))]);
    trial.run_for(0.5);
    assert!(trial.core.is_steering() && trial.lease_ends().is_empty());
    assert_eq!(shorts(&trial.states(2)), ["rejected"]);
}

#[test]
fn a_modify_and_station_keeping_are_never_active_together() {
    let mut trial = hovering();
    trial.ask(1, [Request::Modify(modify(1))]);
    trial.run_for(0.5);
    let start = trial.now;
    trial.ask(0, [Request::Station(station(2))]);
    trial.run_for(0.3);
    assert_eq!(
        sentences(&trial, start),
        ["EMB", "SUS"],
        "the judge of the trial checks the order too"
    );
    assert_eq!(shorts(&trial.states(1)).last(), Some(&"ended"));
    let start = trial.now;
    trial.ask(1, [turn(3, 45.0)]);
    trial.run_for(0.1);
    trial.ask(0, [Request::Modify(modify(4))]);
    trial.run_for(0.2);
    assert!(
        trial
            .rejection(3)
            .contains("a plugin of higher priority keeps the vehicle at its station")
    );
    let said: Vec<_> = sentences(&trial, start)
        .into_iter()
        .filter(|name| *name != "CON")
        .collect();
    assert_eq!(said, ["RES", "RMB"]);
    assert_eq!(shorts(&trial.states(2)), ["sent", "accepted", "ended"]);
    assert_eq!(shorts(&trial.states(4)), ["sent", "accepted"]);
    trial.ask(1, [Request::Station(station(5))]);
    trial.run_for(0.3);
    assert!(trial.rejection(5).contains("higher priority steers"));
    // Of the requests of the same plugin the newest counts.
    trial.ask(0, [Request::Station(station(6))]);
    trial.run_for(0.3);
    assert_eq!(shorts(&trial.states(6)), ["sent", "accepted"]);
    assert_eq!(trial.core.open_requests(), 1);
}

#[test]
fn sr_014_without_control_no_request_for_station_keeping_leaves() {
    let mut trial = hovering();
    let start = trial.now;
    trial.ask(0, [Request::EndStation]);
    trial.operator(Operator::Hold);
    trial.ask(0, [Request::Station(to_hull(1, 10.0, 5.0, 5.0)), Request::EndStation]);
    trial.run_for(2.0);
    assert!(sentences(&trial, start).is_empty());
    assert!(trial.rejection(1).contains("the operator's hold is set"));
}

#[test]
fn sr_005_station_keeping_needs_a_grant_an_armed_runtime_a_table_and_figures_within_the_limits() {
    let mut trial = hovering();
    let bad = [
        (
            StationRequest {
                duration: Duration::ZERO,
                ..station(1)
            },
            "is 0; expected more than 0, at most 60 s",
        ),
        (
            StationRequest {
                duration: Duration::from_secs(61),
                ..station(2)
            },
            "is 61; expected more than 0, at most 60 s",
        ),
        (
            StationRequest {
                speed_mps: Some(0.6),
                ..station(3)
            },
            "speed of station keeping is 0.6; expected 0.01 to 0.5 m/s",
        ),
        (
            StationRequest {
                speed_mps: Some(f64::NAN),
                ..station(4)
            },
            "speed of station keeping is NaN",
        ),
        (
            StationRequest {
                speed_mps: Some(0.0),
                ..station(5)
            },
            "0.01 to 0.5 m/s",
        ),
        (
            to_bottom(6, 0.0, 0.0, VerticalRequest::DepthM(f64::NAN)),
            "depth is NaN",
        ),
        (
            to_bottom(7, 0.0, 0.0, VerticalRequest::DepthM(-1.0)),
            "depth is -1; expected at least 0 m",
        ),
        (
            to_bottom(8, f64::NAN, 0.0, VerticalRequest::DepthM(20.0)),
            "x is not a finite number",
        ),
        (
            to_hull(9, 0.0, f64::INFINITY, 5.0),
            "vertical position is not a finite number",
        ),
        (to_hull(10, 1e300, 5.0, 5.0), "beyond hull_box's horizontal_max_m 50"),
    ];
    for (request, text) in bad {
        trial.ask(0, [Request::Station(request)]);
        trial.run_for(0.3);
        let rejection = trial.rejection(request.tag);
        assert!(rejection.contains(text), "{rejection}");
    }
    assert!(sentences(&trial, Timestamp::ZERO).is_empty());

    let mut without_table = Trial::with_under_way(setup(None));
    without_table.ask(0, [Request::Station(station(1))]);
    without_table.run_for(0.5);
    assert_eq!(without_table.rejection(1), "limit: the mission has no [limits.station]");

    let mut ungranted = setup(Some(station_limits()));
    ungranted.plugins[0].grants.retain(|grant| *grant != Grant::Station);
    let mut trial = Trial::with_under_way(ungranted);
    trial.ask(0, [Request::Station(station(1))]);
    trial.run_for(0.5);
    assert!(trial.rejection(1).contains("does not grant `station`"));

    let mut unarmed = setup(Some(station_limits()));
    unarmed.start.armed = false;
    let mut trial = Trial::with_under_way(unarmed);
    trial.ask(0, [Request::Station(station(1))]);
    trial.run_for(0.5);
    assert!(trial.rejection(1).contains("not armed"));
}

#[test]
fn sr_006_a_flood_of_station_requests_is_bounded_and_the_vehicle_keeps_its_station() {
    let mut trial = hovering();
    trial.script(0, |_| {
        let flood = (0..200).map(|tag| Request::Station(to_hull(tag, tag as f64 / 100.0, 5.0, 5.0)));
        (Duration::from_millis(1), Ok(flood.collect()))
    });
    let start = trial.now;
    trial.run_for(5.0);
    assert!(trial.sent_since("GHP", start).len() <= 26);
    assert!(trial.core.open_requests() <= 1);
}

#[test]
fn plugins_see_relative_navigation_while_it_is_fresh() {
    let mut trial = hovering();
    trial.run_for(0.5);
    let seen = trial.steps(0).pop().unwrap().1;
    assert_eq!(seen.relative.map(|sample| sample.distance_m), Some(5.0));
    assert_eq!(seen.cartesian.map(|sample| sample.x_m), Some(0.0));
    trial.vehicle.hull_frozen = Some(trial.now);
    trial.vehicle.bottom_m = None;
    trial.run_for(2.0);
    let seen = trial.steps(0).pop().unwrap().1;
    assert_eq!((seen.relative, seen.cartesian), (None, None));
}

#[test]
fn a_burst_of_relative_navigation_after_a_stall_is_old() {
    let mut trial = moving();
    let stalled = trial.now;
    trial.stalled_until = stalled + Duration::from_millis(1500);
    trial.run_for(1.45);
    assert_eq!(trial.lease_ends().len(), 1, "nothing came for over a second");
    trial.run_for(0.06);
    trial.ask(0, [Request::Station(station(2))]);
    trial.run_for(0.2);
    assert_eq!(shorts(&trial.states(2)), ["rejected"]);
}
