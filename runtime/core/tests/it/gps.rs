//! GPS hits: inserts that bring the vehicle to the surface (SPI 7.7).

use std::time::Duration;

use backseat_core::plugin::Rule;
use backseat_core::plugin::{GpsHitRequest, Judge, PositionRequest, Request, RequestState, StepInput};
use backseat_core::{Envelope, FailAction, Grant, Limits, Note, Operator, PluginSetup};
use backseat_spi::{AckStatus, ToVehicle};
use backseat_units::Utc;

use crate::course::{self, at, good_line, limits, line};
use crate::trial::{Setup, Trial, shorts};
use crate::vehicle::Reply;

fn plugin(name: &str) -> PluginSetup {
    PluginSetup {
        grants: vec![Grant::Modify, Grant::Insert, Grant::Interrupt, Grant::Surface],
        ..course::plugin(name)
    }
}

fn setup() -> Setup {
    Setup {
        fence: course::harbour(),
        plugins: vec![plugin("first"), plugin("second")],
        ..Setup::default()
    }
}

fn under_way() -> Trial {
    Trial::with_under_way(setup())
}

/// A trial that has run long enough for core to know the depth of the plan.
fn settled() -> Trial {
    let mut trial = under_way();
    trial.run_for(5.0);
    trial
}

/// A GPS hit in the harbour, with a clear way to it and a clear way on.
fn hit(tag: u64) -> Request {
    hit_at(tag, (0.0, 500.0))
}

fn hit_at(tag: u64, (east_m, north_m): (f64, f64)) -> Request {
    Request::GpsHit(GpsHitRequest {
        tag,
        position: at(east_m, north_m),
    })
}

/// An accepted GPS hit under tag 1 with identifier 1.
fn accepted() -> Trial {
    let mut trial = under_way();
    trial.ask(0, [hit(1)]);
    trial.run_for(0.5);
    assert_eq!(shorts(&trial.states(1)), ["sent", "accepted"], "{:?}", trial.states(1));
    trial
}

fn rejected(trial: &mut Trial, request: Request) -> String {
    let tag = match &request {
        Request::GpsHit(hit) => hit.tag,
        Request::Trackline(line) => line.tag,
        other => panic!("{other:?}"),
    };
    trial.ask(0, [request]);
    trial.run_for(0.5);
    trial.rejection(tag)
}

#[test]
fn a_gps_hit_goes_through_each_state_and_is_encoded_as_requested() {
    let mut trial = under_way();
    let reply = Reply::Pending(Duration::from_millis(1500), AckStatus::Succeeded);
    trial.vehicle.replies.insert("RGP", reply);
    trial.ask(0, [hit(1)]);
    trial.run_for(2.5);
    let now = trial.now;
    trial.vehicle.begin(now, None, Some(1));
    trial.run_for(0.5);
    let now = trial.now;
    trial.vehicle.end(now, None, Some(1));
    trial.run_for(0.5);
    assert_eq!(
        shorts(&trial.states(1)),
        ["sent", "pending", "accepted", "started", "ended"]
    );
    let Some((_, ToVehicle::GpsHit(sent))) = trial.commands("RGP").pop() else {
        panic!("no BPRGP")
    };
    let mut bytes = Vec::new();
    ToVehicle::from(sent).encode(&mut bytes).unwrap();
    let text = String::from_utf8(bytes).unwrap();
    let (body, sum) = text.trim_end().split_once('*').unwrap();
    let fields: Vec<&str> = body.split(',').collect();
    assert_eq!((fields[0], fields.len()), ("$BPRGP", 10), "{text}");
    assert_eq!(fields[1].len(), "hhmmss.sss".len(), "{text}");
    assert_eq!(fields[2], "1");
    assert_eq!((fields[4], fields[6]), ("N", "W"));
    assert_eq!(
        &fields[7..],
        ["", "", "0"],
        "the vehicle's own defaults, and straight to the surface"
    );
    let xor = body[1..].bytes().fold(0, |sum, byte| sum ^ byte);
    assert_eq!(sum, format!("{xor:02X}"));
    assert_eq!(trial.core.open_requests(), 0);
}

#[test]
fn sr_009_a_refused_gps_hit_fails_and_an_unanswered_one_may_still_be_flown() {
    let mut trial = under_way();
    trial.vehicle.replies.insert("RGP", Reply::Refuse);
    trial.ask(0, [hit(1)]);
    trial.run_for(1.0);
    assert_eq!(shorts(&trial.states(1)), ["sent", "failed"]);

    let limits = Limits {
        inserts_open_max: 1,
        ..limits()
    };
    let mut trial = Trial::with_under_way(Setup { limits, ..setup() });
    trial.vehicle.replies.insert("RGP", Reply::Silent);
    trial.ask(0, [hit(1)]);
    trial.run_for(4.0);
    assert_eq!(shorts(&trial.states(1)), ["sent", "timed out"]);
    assert!(trial.commands("RCN").is_empty(), "BPRCN does not cover it");
    assert!(rejected(&mut trial, good_line(2)).contains("cap: open inserts is 2"));
    let now = trial.now;
    trial.vehicle.end(now, None, Some(1));
    trial.run_for(0.2);
    trial.ask(0, [good_line(3)]);
    trial.run_for(0.5);
    assert_eq!(shorts(&trial.states(3)), ["sent", "accepted"]);
}

#[test]
fn sr_009_the_vehicles_plan_can_confirm_a_gps_hit_in_doubt_but_cannot_rule_it_out() {
    for named in [true, false] {
        let mut trial = under_way();
        trial.vehicle.replies.insert("RGP", Reply::Silent);
        trial.ask(0, [hit(1)]);
        trial.run_for(0.5);
        if named {
            trial.vehicle.inserted.insert(1);
        }
        trial.cut();
        trial.run_for(8.0);
        let end = if named { "accepted" } else { "timed out" };
        assert_eq!(shorts(&trial.states(1)), ["sent", "unknown", end]);
        assert_eq!(trial.commands("RGP").len(), 1, "never sent twice");
    }
}

#[test]
fn a_gps_hit_needs_its_own_grant() {
    let plugins = vec![course::plugin("first"), course::plugin("second")];
    let mut trial = Trial::with_under_way(Setup { plugins, ..setup() });
    assert!(rejected(&mut trial, hit(1)).contains("does not grant `surface`"));
}

#[test]
fn sr_002_a_gps_hit_and_its_drift_stay_where_the_fence_allows_surfacing() {
    let mut trial = under_way();
    let text = rejected(&mut trial, hit_at(1, (0.0, 1500.0)));
    assert!(
        text.starts_with("surfacing: outside keep-in zone 'harbour', the nearest that allows surfacing,"),
        "{text}"
    );
    // At 0.3 m/s the vehicle drifts 270 m in 900 s, and the errors add to that: 200 m from the harbour's edge are too
    // few.
    assert!(rejected(&mut trial, hit_at(2, (0.0, 700.0))).starts_with("surfacing: "));
    let limits = Limits {
        gps_hit_duration_max_s: 300.0,
        ..limits()
    };
    let mut quicker = Trial::with_under_way(Setup { limits, ..setup() });
    quicker.ask(0, [hit_at(2, (0.0, 700.0))]);
    quicker.run_for(0.5);
    assert_eq!(shorts(&quicker.states(2)), ["sent", "accepted"]);
    // This fence allows surfacing nowhere.
    let mut trial = Trial::with_under_way(Setup {
        fence: course::fence(),
        ..setup()
    });
    assert!(rejected(&mut trial, hit(1)).contains("no keep-in zone allows surfacing"));
}

#[test]
fn sr_002_the_ways_to_and_from_the_surface_are_checked_at_every_depth_on_the_way() {
    // The plan's leg ends at (600, 0). The way from there leads over the shoals: a line at 20 m passes under them, but
    // the way to the surface does not.
    let mut trial = settled();
    let text = rejected(&mut trial, hit_at(1, (1450.0, 500.0)));
    assert!(text.starts_with("keep-out: inside keep-out zone 'shoals'"), "{text}");
    trial.ask(0, [Request::Trackline(line(2, (1400.0, 470.0), (1500.0, 530.0)))]);
    trial.run_for(0.5);
    assert_eq!(shorts(&trial.states(2)), ["sent", "accepted"], "{:?}", trial.states(2));
}

#[test]
fn sr_002_the_way_on_from_a_gps_hit_is_checked_from_the_surface_and_with_the_drift() {
    let beyond = |tag| Request::Trackline(line(tag, (1300.0, 270.0), (1400.0, 270.0)));
    let mut trial = settled();
    trial.ask(0, [beyond(1)]);
    trial.run_for(0.5);
    assert_eq!(shorts(&trial.states(1)), ["sent", "accepted"], "alone it is good");
    let mut trial = accepted();
    let text = rejected(&mut trial, beyond(2));
    assert!(
        text.starts_with("keep-out: on the way") && text.contains(": inside keep-out zone 'shoals'"),
        "{text}"
    );
    trial.ask(0, [good_line(3)]);
    trial.run_for(0.5);
    assert_eq!(shorts(&trial.states(3)), ["sent", "accepted"], "{:?}", trial.states(3));
}

#[test]
fn sr_002_the_way_from_an_interrupting_insert_to_a_waiting_gps_hit_is_checked_up_to_the_surface() {
    // From the interrupting line beyond the shoals the vehicle may go on to the GPS hit, and come up on the way.
    let beyond = |tag| {
        let mut beyond = line(tag, (1300.0, 270.0), (1400.0, 270.0));
        beyond.interrupt = true;
        Request::Trackline(beyond)
    };
    let mut trial = settled();
    trial.ask(0, [beyond(1)]);
    trial.run_for(0.5);
    assert_eq!(shorts(&trial.states(1)), ["sent", "accepted"], "alone it is good");
    let mut trial = accepted();
    let text = rejected(&mut trial, beyond(2));
    assert!(
        text.starts_with("keep-out: on the way") && text.contains(": inside keep-out zone 'shoals'"),
        "{text}"
    );
}

#[test]
fn sr_002_nothing_is_modified_or_interrupted_while_the_vehicle_is_on_its_way_to_the_surface() {
    let mut trial = accepted();
    let modify = |tag| Request::Modify(course::modify(tag));
    let asks = |trial: &mut Trial, tag| {
        trial.ask(0, [modify(tag), course::interrupting(tag + 1)]);
        trial.run_for(0.5);
        [tag, tag + 1].map(|tag| trial.states(tag))
    };
    let now = trial.now;
    trial.vehicle.begin(now, None, Some(1));
    trial.run_for(0.5);
    for states in asks(&mut trial, 2) {
        assert!(
            matches!(&states[..], [RequestState::Rejected(refusal)] if refusal.rule() == Rule::GpsHit),
            "{states:?}"
        );
    }
    let now = trial.now;
    trial.vehicle.end(now, None, Some(1));
    trial.vehicle.begin(now, Some(2), None);
    trial.run_for(0.5);
    for states in asks(&mut trial, 4) {
        assert_eq!(shorts(&states)[..2], ["sent", "accepted"], "{states:?}");
    }
}

#[test]
fn sr_002_a_keep_out_zone_at_the_depth_of_another_insert_counts_beside_a_gps_hit() {
    // East of the pit the vehicle flies at 45 m. From there to the line at 20 m beyond the pit it may still be that deep.
    // The line ends far south of the pit.
    let deep = |tag| {
        let mut deep = line(tag, (-300.0, 500.0), (-600.0, 500.0));
        deep.vertical = backseat_core::plugin::VerticalRequest::DepthM(45.0);
        Request::Trackline(deep)
    };
    let beyond = |tag| Request::Trackline(line(tag, (-1000.0, 500.0), (-1000.0, -100.0)));
    let setup = || Setup {
        fence: course::harbour_with_pit(),
        ..setup()
    };
    for hits in [vec![], vec![hit(1)]] {
        let mut trial = Trial::with_under_way(setup());
        trial.run_for(5.0);
        let count = hits.len();
        trial.ask(0, hits);
        trial.run_for(0.5);
        trial.ask(0, [beyond(2)]);
        trial.run_for(0.5);
        assert_eq!(shorts(&trial.states(2)), ["sent", "accepted"], "{:?}", trial.states(2));
        let mut trial = Trial::with_under_way(setup());
        trial.run_for(5.0);
        trial.ask(0, (0..count).map(|_| hit(1)));
        trial.ask(0, [deep(3)]);
        trial.run_for(0.5);
        assert_eq!(shorts(&trial.states(3)), ["sent", "accepted"], "{:?}", trial.states(3));
        let text = rejected(&mut trial, beyond(4));
        assert!(
            text.starts_with("keep-out: on the way to it: inside keep-out zone 'pit'"),
            "{count} GPS hits: {text}"
        );
    }
}

#[test]
fn sr_002_the_depth_of_the_behavior_before_a_gps_hit_counts() {
    let deep = |tag| {
        let mut deep = line(tag, (0.0, 500.0), (300.0, 500.0));
        deep.vertical = backseat_core::plugin::VerticalRequest::DepthM(55.0);
        Request::Trackline(deep)
    };
    // In 58.5 m of water a line at 55 m keeps 2.5 m, with its error of 1 m included. A vehicle that comes from there
    // may be at 56 m, and the same error leaves too little.
    let limits = Limits {
        water_depth_min_m: Some(58.5),
        ..limits()
    };
    let mut trial = Trial::with(Setup { limits, ..setup() });
    trial.vehicle.altitude_m = None;
    trial.run_for(2.0);
    trial.ask(0, [hit(1), deep(2), hit(3)]);
    trial.run_for(0.5);
    assert_eq!(shorts(&trial.states(1)), ["sent", "accepted"], "{:?}", trial.states(1));
    assert_eq!(shorts(&trial.states(2)), ["sent", "accepted"], "{:?}", trial.states(2));
    assert!(trial.rejection(3).starts_with("altitude: "), "{}", trial.rejection(3));
}

#[test]
fn impossible_places_are_rejected() {
    let mut trial = under_way();
    for (tag, (latitude_deg, longitude_deg)) in
        (1..).zip([(f64::NAN, -70.0), (91.0, -70.0), (42.0, f64::INFINITY), (42.0, 1e300)])
    {
        let position = PositionRequest {
            latitude_deg,
            longitude_deg,
        };
        let text = rejected(&mut trial, Request::GpsHit(GpsHitRequest { tag, position }));
        assert!(text.starts_with("limit: "), "{text}");
    }
    // A valid place 3000 km away.
    assert!(rejected(&mut trial, hit_at(9, (3e6, 0.0))).starts_with("surfacing: "));
    assert!(trial.commands("RGP").is_empty());
}

#[test]
fn sr_019_gps_hits_are_capped_in_number_and_count_in_the_duration_of_all_inserts() {
    let limits = Limits {
        gps_hits_total_max: 1,
        inserts_total_max: 1,
        ..limits()
    };
    let mut trial = Trial::with_under_way(Setup { limits, ..setup() });
    trial.ask(0, [hit(1)]);
    trial.run_for(0.5);
    assert!(rejected(&mut trial, hit(2)).contains("GPS hits of the mission is 2"));
    trial.ask(0, [good_line(3)]);
    trial.run_for(0.5);
    assert_eq!(
        shorts(&trial.states(3))[0],
        "sent",
        "a GPS hit does not count as a trackline"
    );

    let limits = Limits {
        inserts_duration_max_s: 3000.0,
        ..course::limits()
    };
    let mut trial = Trial::with_under_way(Setup { limits, ..setup() });
    trial.ask(0, [hit(1)]);
    trial.run_for(0.5);
    let text = rejected(&mut trial, hit(2));
    assert!(text.contains("expected at most 3000 s"), "{text}");
}

#[test]
fn neither_its_plugin_nor_a_failure_nor_a_hold_cancels_a_gps_hit() {
    let failing = PluginSetup {
        on_failure: FailAction::Cancel,
        ..plugin("first")
    };
    let mut trial = Trial::with_under_way(Setup {
        plugins: vec![failing, plugin("second")],
        ..setup()
    });
    trial.ask(0, [hit(1), good_line(2)]);
    trial.run_for(0.5);
    trial.ask(0, [Request::Cancel(1)]);
    trial.run_for(0.5);
    let Some(RequestState::Rejected(refusal)) = trial.cancel_states(1).pop() else {
        panic!("{:?}", trial.cancel_states(1))
    };
    assert_eq!(refusal.cause(), "tag-is-gps-hit");
    trial.fail(0, backseat_core::plugin::FaultKind::Trap);
    trial.run_for(0.5);
    trial.operator(Operator::Hold);
    trial.run_for(0.5);
    assert_eq!(trial.commands("RCN").len(), 1, "only the trackline is cancelled");
    assert_eq!(shorts(&trial.states(1)), ["sent", "accepted"]);
    assert_eq!(shorts(&trial.states(2)).last(), Some(&"cancelled"));
    let said = trial.notes().into_iter().filter(
        |(_, note)| matches!(note, Note::Text { text } if text.contains("may still be flown: it cannot be cancelled")),
    );
    assert_eq!(said.count(), 2);
}

#[test]
fn a_gps_hit_needs_a_complete_plan_and_control() {
    let mut trial = under_way();
    trial.vehicle.replies.insert("RMP", Reply::Silent);
    let now = trial.now;
    trial.vehicle.begin(now, Some(77), None);
    trial.run_for(0.5);
    assert!(rejected(&mut trial, hit(1)).starts_with("plan: "));
    let now = trial.now;
    trial.vehicle.set_control(now, false);
    trial.run_for(0.5);
    assert!(rejected(&mut trial, hit(2)).starts_with("control: "));
    assert!(trial.commands("RGP").is_empty());
}

#[test]
fn repeated_and_unrelated_answers_change_nothing() {
    let mut trial = accepted();
    let sent = trial.commands("RGP").pop().unwrap().1.created().unwrap();
    let now = trial.now;
    trial
        .vehicle
        .acknowledge(now, ("RGP", sent, Some(1), AckStatus::Failed));
    trial
        .vehicle
        .acknowledge(now, ("RTK", sent, Some(1), AckStatus::Failed));
    trial.vehicle.end(now, None, Some(2));
    trial.run_for(0.5);
    assert_eq!(shorts(&trial.states(1)), ["sent", "accepted"]);
}

#[test]
fn a_plugins_query_about_a_gps_hit_gets_cores_verdict() {
    let envelope = Envelope::new(course::harbour(), limits());
    let mut trial = under_way();
    trial.run_for(0.5);
    let (_, step) = trial.steps(0).pop().unwrap();
    assert!(envelope.judge(&hit(1), &step).unwrap() > 0.0);
    assert_eq!(
        envelope.judge(&hit_at(1, (0.0, 1500.0)), &step).unwrap_err().rule(),
        Rule::Surfacing
    );
    let blind = StepInput {
        navigation: None,
        utc: Utc::from_unix_nanos(0),
        ..step
    };
    assert!(envelope.judge(&hit(1), &blind).is_err());
}
