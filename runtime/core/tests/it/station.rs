use std::time::Duration;

use backseat_core::plugin::EndCause;
use backseat_core::plugin::{Event, FaultKind, Request, RequestState, StationRequest, StationTarget, VerticalRequest};
use backseat_core::{BottomBox, Grant, HullBox, Limits, Operator, StationLimits};
use backseat_spi::AckStatus;
use backseat_units::{EastNorth, Timestamp};

use crate::course::limits;
use crate::trial::{Setup, Trial, shorts};
use crate::vehicle::Reply;

/// A position error of half a metre, and 0.2 m/s for the 2 s of the vehicle's time-out and the 1 s of the link's delay:
/// a move at that speed may stray by 1.1 m, and in addition by what it covers within navigation's age.
pub(crate) fn station_limits() -> StationLimits {
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
            vertical_max_m: 20.0,
            distance_min_m: 1.0,
            distance_max_m: 15.0,
        }),
        bottom_box: Some(BottomBox {
            name: String::new(),
            x_min_m: -50.0,
            x_max_m: 50.0,
            y_min_m: -50.0,
            y_max_m: 50.0,
            depth_min_m: 2.0,
            depth_max_m: 30.0,
        }),
        keep_out_hull: vec![HullBox {
            name: "screw".to_owned(),
            horizontal_min_m: 20.0,
            horizontal_max_m: 30.0,
            vertical_min_m: 5.0,
            vertical_max_m: 15.0,
            distance_min_m: -5.0,
            distance_max_m: 5.0,
        }],
        keep_out_bottom: vec![BottomBox {
            name: "mooring".to_owned(),
            x_min_m: 20.0,
            x_max_m: 25.0,
            y_min_m: -5.0,
            y_max_m: 5.0,
            depth_min_m: 0.0,
            depth_max_m: 100.0,
        }],
    }
}

/// The setup of a hovering vehicle some metres from a hull. Its plugins have the grants for station keeping and
/// devices.
pub(crate) fn setup(station: Option<StationLimits>) -> Setup {
    let limits = Limits { station, ..limits() };
    let mut setup = Setup {
        limits,
        ..Setup::default()
    };
    for plugin in &mut setup.plugins {
        plugin.grants.extend([Grant::Station, Grant::Devices]);
    }
    setup
}

pub(crate) fn hovering_with(hull: StationLimits) -> Trial {
    let mut trial = Trial::with(setup(Some(hull)));
    trial.vehicle.speed_mps = 0.0;
    trial.vehicle.hull_m = Some([0.0, 5.0, 5.0]);
    trial.vehicle.bottom_m = Some([0.0, 0.0]);
    trial.run_for(3.0);
    assert!(trial.core.has_control(), "{:#?}", trial.notes());
    trial
}

pub(crate) fn hovering() -> Trial {
    hovering_with(station_limits())
}

pub(crate) fn station(tag: u64) -> StationRequest {
    StationRequest {
        tag,
        target: StationTarget::Here,
        speed_mps: None,
        duration: Duration::from_secs(30),
    }
}

/// A move at 0.2 m/s to a place on the hull.
pub(crate) fn to_hull(tag: u64, horizontal_m: f64, vertical_m: f64, distance_m: f64) -> StationRequest {
    StationRequest {
        target: StationTarget::Hull {
            horizontal_m,
            vertical_m,
            distance_m,
        },
        speed_mps: Some(0.2),
        ..station(tag)
    }
}

/// A move at 0.2 m/s to a place over the bottom.
pub(crate) fn to_bottom(tag: u64, x_m: f64, y_m: f64, vertical: VerticalRequest) -> StationRequest {
    StationRequest {
        target: StationTarget::Bottom { x_m, y_m, vertical },
        speed_mps: Some(0.2),
        ..station(tag)
    }
}

/// Moves the vehicle evenly to a place on the hull within this many seconds.
pub(crate) fn glide(trial: &mut Trial, to_m: [f64; 3], seconds: f64) {
    let from_m = trial.vehicle.hull_m.unwrap();
    for step in 1..=20 {
        let part = f64::from(step) / 20.0;
        trial.vehicle.hull_m = Some([0, 1, 2].map(|axis| from_m[axis] + (to_m[axis] - from_m[axis]) * part));
        trial.run_for(seconds / 20.0);
    }
}

/// The first plugin moves the vehicle along the hull under tag 1.
pub(crate) fn moving() -> Trial {
    let mut trial = hovering();
    trial.ask(0, [Request::Station(to_hull(1, 10.0, 5.0, 5.0))]);
    trial.run_for(1.2);
    assert_eq!(shorts(&trial.states(1)), ["sent", "accepted"], "{:?}", trial.states(1));
    trial
}

/// The names of the sentences for station keeping and modifies that were sent since then, in order.
pub(crate) fn sentences(trial: &Trial, since: Timestamp) -> Vec<&'static str> {
    let of_a_hold = ["SUS", "SPD", "GHP", "GBP", "CON", "RES", "RMB", "EMB"];
    let names = trial.names_since(since).into_iter();
    names.filter(|name| of_a_hold.contains(name)).collect()
}

/// The lines of this name as they were written, without time of day and checksum, which are checked here.
pub(crate) fn lines(trial: &Trial, name: &str) -> Vec<String> {
    let start = format!("$BP{name},");
    let mut lines = Vec::new();
    for line in &trial.written {
        let Some(line) = line.strip_prefix(&start) else {
            continue;
        };
        let (body, sum) = line.strip_suffix("\r\n").unwrap().split_once('*').unwrap();
        let xor = format!("BP{name},{body}").bytes().fold(0, |sum, byte| sum ^ byte);
        assert_eq!(sum, format!("{xor:02X}"));
        let (time, fields) = body.split_once(',').unwrap_or((body, ""));
        let (seconds, decimals) = time.split_once('.').unwrap();
        assert!(seconds.len() == 6 && decimals.len() == 3, "{time}");
        lines.push(fields.to_owned());
    }
    lines
}

#[test]
fn sr_005_a_move_suspends_limits_the_speed_moves_and_is_refreshed_each_half_second_until_its_term_ends() {
    let mut trial = hovering();
    let asked = trial.now;
    let duration = Duration::from_secs(5);
    trial.ask(
        0,
        [Request::Station(StationRequest {
            duration,
            ..to_hull(1, 10.0, 5.5, 4.25)
        })],
    );
    trial.run_for(8.0);
    let said = sentences(&trial, asked);
    assert_eq!(said[..3], ["SUS", "SPD", "GHP"]);
    assert!(said[3..said.len() - 2].iter().all(|name| *name == "CON"), "{said:?}");
    assert_eq!(said[said.len() - 2..], ["SPD", "RES"]);
    assert_eq!(lines(&trial, "SUS"), [""]);
    assert_eq!(lines(&trial, "SPD"), ["0.2", "1.5"]);
    assert_eq!(lines(&trial, "GHP"), ["10,5.5,4.25"]);
    assert_eq!(lines(&trial, "CON"), [""; 9]);
    assert_eq!(lines(&trial, "RES"), [""]);
    let refreshed = [trial.sent("GHP"), trial.sent("CON")].concat();
    for pair in refreshed.windows(2) {
        assert_eq!(pair[1].since(pair[0]), Duration::from_millis(500));
    }
    assert_eq!(trial.sent("RES")[0].since(trial.sent("SUS")[0]), duration);
    assert_eq!(
        trial.states(1).last(),
        Some(&RequestState::Ended(EndCause::TermOver.into()))
    );
    assert_eq!(shorts(&trial.states(1)), ["sent", "accepted", "ended"]);
    let told = |event: &Event| {
        matches!(
            event,
            Event::Outcome {
                tag: 1,
                state: RequestState::Accepted
            }
        )
    };
    assert!(trial.events(0).iter().any(told), "the plugin learns of it");
    assert_eq!(trial.core.open_requests(), 0);
}

#[test]
fn a_move_over_the_bottom_is_sent_with_a_depth_or_an_altitude() {
    let mut trial = hovering();
    trial.ask(
        0,
        [Request::Station(to_bottom(
            1,
            5.0,
            -3.25,
            VerticalRequest::DepthM(18.0),
        ))],
    );
    trial.run_for(1.0);
    trial.vehicle.altitude_m = Some(20.0);
    // A bottom lock that gives 40 m of water changes nothing, because the mission says at least 80 m; one that gives 85
    // m counts.
    trial.vehicle.altitude_m = Some(65.0);
    trial.run_for(1.0);
    trial.ask(
        0,
        [Request::Station(to_bottom(
            2,
            5.0,
            -3.0,
            VerticalRequest::AltitudeM(62.0),
        ))],
    );
    trial.run_for(1.0);
    assert_eq!(
        lines(&trial, "GBP"),
        ["5,-3.25,D,18", "5,-3,A,62"],
        "{:?}",
        trial.states(2)
    );
    assert_eq!(lines(&trial, "SPD"), ["0.2"], "the vehicle already has this limit");
    assert_eq!(shorts(&trial.states(1)), ["sent", "accepted", "ended"]);
    assert_eq!(shorts(&trial.states(2)), ["sent", "accepted"]);
}

#[test]
fn station_keeping_at_the_current_place_needs_no_move_and_no_speed() {
    let mut trial = hovering();
    let asked = trial.now;
    trial.ask(0, [Request::Station(station(1))]);
    trial.run_for(1.3);
    trial.ask(0, [Request::EndStation]);
    trial.run_for(1.0);
    assert_eq!(sentences(&trial, asked), ["SUS", "CON", "CON", "RES"]);
    assert_eq!(shorts(&trial.states(1)), ["sent", "accepted", "ended"]);
}

#[test]
fn a_station_request_repeated_in_each_step_is_refreshed_no_more_often_and_stays_one_request() {
    for target in [station(1), to_hull(1, 3.0, 5.0, 5.0)] {
        let mut trial = hovering();
        trial.script(0, move |_| {
            (Duration::from_millis(1), Ok(vec![Request::Station(target)]))
        });
        let start = trial.now;
        trial.run_for(5.0);
        let said = sentences(&trial, start);
        let refreshes = said.iter().filter(|name| **name == "CON").count();
        assert!((8..=10).contains(&refreshes), "{said:?}");
        assert_eq!(
            said.iter().filter(|name| ["SUS", "GHP"].contains(name)).count(),
            lines(&trial, "GHP").len() + 1
        );
        assert!(lines(&trial, "GHP").len() <= 1, "{said:?}");
        assert!(trial.lease_ends().is_empty());
        assert_eq!(trial.core.open_requests(), 1);
    }
}

#[test]
fn a_changed_target_is_sent_at_once_and_at_most_five_times_a_second() {
    let mut trial = moving();
    let start = trial.now;
    let mut horizontal_m = 0.0;
    trial.script(0, move |_| {
        horizontal_m += 0.125;
        let request = Request::Station(to_hull(1, horizontal_m, 5.0, 5.0));
        (Duration::from_millis(1), Ok(vec![request]))
    });
    trial.run_for(4.0);
    // The judge of the trial refuses pauses below 200 ms and over a second.
    let sent = trial.sent_since("GHP", start).len();
    assert!((15..=21).contains(&sent), "{sent}");
    assert_eq!(trial.core.open_requests(), 1);
}

#[test]
fn station_requests_that_end_and_begin_are_sent_at_most_five_times_a_second() {
    let mut trial = hovering();
    trial.script(0, |_| {
        let requests = [
            Request::Station(station(1)),
            Request::EndStation,
            Request::Station(station(2)),
            Request::EndStation,
        ];
        (Duration::from_millis(1), Ok(requests.to_vec()))
    });
    trial.run_for(3.0);
    assert!(trial.sent("SUS").len() <= 16, "{}", trial.sent("SUS").len());
    assert!(trial.sent("RES").len() <= 16);
}

#[test]
fn a_moving_vehicle_that_is_to_stay_is_sent_to_its_current_place() {
    let mut trial = moving();
    glide(&mut trial, [4.0, 5.0, 5.5], 4.0);
    trial.ask(0, [Request::Station(station(2))]);
    trial.run_for(0.5);
    assert_eq!(
        lines(&trial, "GHP"),
        ["10,5,5", "4,5,5.5"],
        "there is no command to stop"
    );
    assert_eq!(shorts(&trial.states(2)), ["sent", "accepted"]);
    // The vehicle drifts. When the plugin asks again, the target stays and does not follow the drift.
    trial.vehicle.hull_m = Some([4.5, 5.0, 5.5]);
    trial.run_for(0.3);
    trial.ask(0, [Request::Station(station(2))]);
    trial.run_for(1.0);
    assert_eq!(lines(&trial, "GHP").len(), 2);
    assert_eq!(lines(&trial, "SUS").len(), 1);
}

#[test]
fn a_move_without_a_speed_never_inherits_one() {
    let hull = StationLimits {
        speed_max_mps: 2.0,
        ..station_limits()
    };
    let mut trial = hovering_with(hull);
    glide(&mut trial, [0.0, 5.0, 8.0], 4.0);
    let plain = |tag| StationRequest {
        speed_mps: None,
        ..to_hull(tag, 5.0, 5.0, 9.0)
    };
    let slow = |tag| StationRequest {
        speed_mps: Some(0.5),
        ..plain(tag)
    };
    for request in [plain(1), slow(2), plain(3)] {
        trial.ask(0, [Request::Station(request)]);
        trial.run_for(0.6);
    }
    assert_eq!(lines(&trial, "SPD"), ["1.5", "0.5", "1.5"], "{:?}", trial.states(1));
    trial.ask(0, [Request::EndStation]);
    trial.run_for(0.5);
    assert_eq!(lines(&trial, "SPD").len(), 3, "the vehicle already has its own limit");
    // If the vehicle's own limit is above that of a move, a move must state its speed.
    let mut trial = hovering();
    trial.ask(0, [Request::Station(plain(1))]);
    trial.run_for(0.5);
    assert!(
        trial.rejection(1).contains("is 1.5; expected at most 0.5 m/s"),
        "{}",
        trial.rejection(1)
    );
}

#[test]
fn sr_005_station_keeping_ends_with_one_bpres_whatever_ends_it() {
    type End = fn(&mut Trial);
    let ends: [(&str, End); 19] = [
        ("its plugin ended it", |trial| trial.ask(0, [Request::EndStation])),
        ("its plugin failed", |trial| trial.fail(0, FaultKind::Error)),
        ("its plugin failed", |trial| trial.fail(0, FaultKind::Trap)),
        ("the vehicle refused it", |trial| {
            trial.vehicle.replies.insert("CON", Reply::Refuse);
        }),
        ("the vehicle refused it", |trial| {
            trial.vehicle.replies.insert("CON", Reply::Nak);
        }),
        ("the vehicle did not acknowledge it", |trial| {
            trial.vehicle.replies.insert("CON", Reply::Silent);
        }),
        ("the vehicle did not acknowledge it", |trial| {
            trial.vehicle.replies.insert("CON", Reply::PendingForEver);
        }),
        ("a behavior began", |trial| {
            let now = trial.now;
            trial.vehicle.begin(now, Some(2), None);
        }),
        ("the operator's hold is set", |trial| trial.operator(Operator::Hold)),
        ("the run is ending", |trial| trial.operator(Operator::Stop)),
        ("the vehicle has control", |trial| {
            let now = trial.now;
            trial.vehicle.set_control(now, false);
        }),
        ("the mission is not running", |trial| {
            let now = trial.now;
            trial.vehicle.set_status(now, "Completed");
        }),
        ("navigation is stale", |trial| trial.vehicle.navigates = false),
        ("navigation has not been steady", |trial| {
            trial.vehicle.jump = EastNorth::new(100.0, 0.0);
        }),
        ("navigation jumped: BFRNV by 4.0 m", |trial| {
            trial.vehicle.hull_m = Some([4.0, 5.0, 5.0]);
        }),
        ("navigation jumped: BFCNV by 4.0 m", |trial| {
            trial.vehicle.bottom_m = Some([0.0, 4.0]);
        }),
        ("navigation: a move on the hull needs fresh BFRNV", |trial| {
            trial.vehicle.hull_m = None;
        }),
        ("navigation: a move on the hull needs fresh BFRNV", |trial| {
            trial.vehicle.hull_frozen = Some(trial.now);
        }),
        ("the runtime woke late", |trial| {
            trial.asleep_until = trial.now + Duration::from_millis(1800);
        }),
    ];
    for (reason, end) in ends {
        let mut trial = moving();
        let before = trial.now;
        end(&mut trial);
        trial.run_for(6.0);
        let ended = trial.lease_ends();
        assert_eq!(ended.len(), 1, "{reason}: {ended:?}");
        assert!(ended[0].1.starts_with(reason), "{reason}: {}", ended[0].1);
        let said = sentences(&trial, ended[0].0);
        assert_eq!(said, ["SPD", "RES"], "{reason}: then silence");
        assert_eq!(trial.sent_since("RES", before), [ended[0].0], "{reason}");
        assert_eq!(lines(&trial, "SPD"), ["0.2", "1.5"], "{reason}");
        assert!(!trial.core.is_steering() && trial.core.open_requests() == 0, "{reason}");
        let last = trial.states(1).pop().unwrap();
        let outcome = match reason {
            "the vehicle refused it" => "failed",
            "the vehicle did not acknowledge it" => "timed out",
            _ => "ended",
        };
        assert_eq!(crate::trial::short(&last), outcome, "{reason}: {last:?}");
    }
}

#[test]
fn sr_005_station_keeping_ends_the_moment_that_relative_navigation_is_stale() {
    let mut trial = moving();
    let last = trial.now;
    trial.vehicle.hull_m = None;
    trial.run_for(3.0);
    let after = trial.sent_since("RES", last)[0].since(last);
    assert!((900..=1010).contains(&after.as_millis()), "{after:?}");
    // Staying at the current place needs one of the two relative positions.
    let mut trial = hovering();
    trial.ask(0, [Request::Station(station(1))]);
    trial.run_for(0.5);
    trial.vehicle.hull_m = None;
    trial.run_for(3.0);
    assert!(trial.lease_ends().is_empty());
    trial.vehicle.bottom_m = None;
    trial.run_for(3.0);
    assert_eq!(trial.lease_ends().len(), 1);
}

#[test]
fn sr_005_a_refusal_or_silence_at_any_step_ends_station_keeping_and_its_request_once() {
    for name in ["SUS", "SPD", "GHP"] {
        let replies = [
            (Reply::Refuse, "failed"),
            (Reply::Nak, "failed"),
            (Reply::Silent, "timed out"),
            (Reply::Pending(Duration::from_millis(300), AckStatus::Failed), "failed"),
        ];
        for (reply, outcome) in replies {
            let mut trial = hovering();
            trial.vehicle.replies.insert(name, reply);
            let asked = trial.now;
            trial.ask(0, [Request::Station(to_hull(1, 10.0, 5.0, 5.0))]);
            trial.run_for(6.0);
            let states = shorts(&trial.states(1));
            assert_eq!(
                (states[0], *states.last().unwrap()),
                ("sent", outcome),
                "{name} {reply:?}"
            );
            assert_eq!(trial.commands("RES").len(), 1, "{name} {reply:?}");
            assert_eq!(trial.core.open_requests(), 0);
            if reply == Reply::Silent {
                let waited = trial.lease_ends()[0].0.since(trial.sent_since(name, asked)[0]);
                assert_eq!(waited, Duration::from_secs(1), "{name}");
            }
            let moved = !trial.commands("GHP").is_empty();
            assert_eq!(
                moved,
                name == "GHP",
                "no move leaves before the steps that it needs are acknowledged"
            );
        }
    }
}

#[test]
fn an_acknowledgement_may_take_its_time_while_the_mission_stays_suspended() {
    let mut trial = hovering();
    for name in ["SUS", "SPD", "GHP"] {
        let reply = Reply::Pending(Duration::from_millis(1500), AckStatus::Succeeded);
        trial.vehicle.replies.insert(name, reply);
    }
    trial.ask(0, [Request::Station(to_hull(1, 10.0, 5.0, 5.0))]);
    trial.run_for(6.0);
    assert_eq!(shorts(&trial.states(1)), ["sent", "pending", "accepted"]);
    assert!(
        trial.commands("CON").len() > 6,
        "the judge of the trial checks the pauses"
    );
}

#[test]
fn repeated_late_and_unrelated_answers_change_nothing() {
    let mut trial = moving();
    let echo = trial.sent("GHP")[0];
    let now = trial.now;
    let echoed = trial.vehicle.clock(echo);
    for (name, status) in [
        ("GHP", AckStatus::Failed),
        ("RMB", AckStatus::Failed),
        ("SAN", AckStatus::Succeeded),
    ] {
        trial.vehicle.acknowledge(now, (name, echoed, None, status));
    }
    trial.run_for(1.0);
    assert!(trial.lease_ends().is_empty());
    // The answer to the first suspension does not count for the second.
    let mut trial = hovering();
    trial
        .vehicle
        .replies
        .insert("SUS", Reply::Late(Duration::from_millis(400), AckStatus::Succeeded));
    trial.ask(0, [Request::Station(to_hull(1, 10.0, 5.0, 5.0))]);
    trial.run_for(0.25);
    trial.vehicle.replies.insert("SUS", Reply::Silent);
    trial.ask(0, [Request::EndStation, Request::Station(to_hull(2, 10.0, 5.0, 5.0))]);
    trial.run_for(3.0);
    assert!(trial.commands("GHP").is_empty() && trial.commands("SPD").is_empty());
    assert_eq!(shorts(&trial.states(2)), ["sent", "timed out"]);
}

#[test]
fn a_request_during_another_is_sent_after_the_acknowledgement_of_the_first() {
    let mut trial = hovering();
    let slow = Reply::Late(Duration::from_millis(450), AckStatus::Succeeded);
    for name in ["SUS", "SPD", "GHP"] {
        trial.vehicle.replies.insert(name, slow);
    }
    trial.ask(0, [Request::Station(to_hull(1, 10.0, 5.0, 5.0))]);
    trial.run_for(0.3);
    trial.ask(0, [Request::Station(to_hull(2, 5.0, 5.0, 5.0))]);
    trial.run_for(3.0);
    assert_eq!(lines(&trial, "GHP"), ["5,5,5"], "only the newest");
    assert_eq!(shorts(&trial.states(1)), ["sent", "ended"]);
    assert_eq!(shorts(&trial.states(2)), ["sent", "accepted"]);
    // The acknowledgement of a replaced move does not count for the new one.
    trial.ask(0, [Request::Station(to_hull(3, 6.0, 5.0, 5.0))]);
    trial.run_for(0.3);
    trial.ask(0, [Request::Station(to_hull(4, 7.0, 5.0, 5.0))]);
    trial.run_for(0.35);
    assert_eq!(shorts(&trial.states(4)), ["sent"]);
    trial.run_for(1.0);
    assert_eq!(shorts(&trial.states(3)), ["sent", "ended"]);
    assert_eq!(shorts(&trial.states(4)), ["sent", "accepted"]);
}
