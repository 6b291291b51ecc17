use std::time::Duration;

use backseat_core::plugin::{DvlTriggerRequest, Event, FaultKind, Request, RequestState};
use backseat_core::plugin::{EndCause, Failure};
use backseat_core::{Grant, Operator};
use backseat_spi::{AckStatus, DvlTriggering, FromVehicle, Shutdown, ToVehicle};
use backseat_units::Timestamp;

use crate::trial::{Setup, Trial, granted, last_written, shorts};
use crate::vehicle::Reply;

fn say(tag: u64, external: bool, triggering: bool) -> Request {
    Request::DvlTrigger(DvlTriggerRequest {
        tag,
        external,
        triggering,
    })
}

fn want(tag: u64) -> Request {
    say(tag, true, false)
}

fn trigger(tag: u64) -> Request {
    say(tag, true, true)
}

fn end(tag: u64) -> Request {
    say(tag, false, false)
}

fn setup() -> Setup {
    granted(&[Grant::Dvl], &[])
}

fn under_way() -> Trial {
    Trial::with_under_way(setup())
}

fn ask(trial: &mut Trial, request: Request) {
    trial.ask(0, [request]);
    trial.run_for(0.2);
}

fn vehicle_says(trial: &mut Trial, begin: bool) {
    let message = DvlTriggering {
        created: trial.vehicle.clock(trial.now),
        begin,
    };
    trial.vehicle.say(trial.now, message);
    trial.run_for(0.2);
}

/// The first plugin has asked under tag 1.
fn requested() -> Trial {
    let mut trial = under_way();
    ask(&mut trial, want(1));
    trial
}

fn allowed() -> Trial {
    let mut trial = requested();
    vehicle_says(&mut trial, true);
    trial
}

fn triggering() -> Trial {
    let mut trial = allowed();
    ask(&mut trial, trigger(1));
    assert_eq!(shorts(&trial.states(1)), ["sent", "accepted", "started"]);
    trial
}

fn ending() -> Trial {
    let mut trial = triggering();
    ask(&mut trial, say(1, false, true));
    trial
}

fn ceasing() -> Trial {
    let mut trial = triggering();
    vehicle_says(&mut trial, false);
    trial
}

type Reach = fn() -> Trial;

const PHASES: [(&str, Reach); 5] = [
    ("requested", requested),
    ("allowed", allowed),
    ("triggering", triggering),
    ("ending", ending),
    ("ceasing", ceasing),
];

/// All BPDVR that were sent, each as its two fields.
fn said(trial: &Trial) -> Vec<(u8, u8)> {
    let fields = |(_, command)| match command {
        ToVehicle::DvlTriggerRequest(said) => (u8::from(said.external), u8::from(said.triggering)),
        other => panic!("{other:?}"),
    };
    trial.commands("DVR").into_iter().map(fields).collect()
}

fn told(trial: &Trial, plugin: usize) -> Vec<bool> {
    let of = |event| match event {
        Event::DvlTrigger(begin) => Some(begin),
        _ => None,
    };
    trial.events(plugin).into_iter().filter_map(of).collect()
}

fn ended(trial: &Trial, why: &str) {
    match trial.states(1).last() {
        Some(RequestState::Ended(ended)) => assert_eq!(ended.to_string(), why),
        other => panic!("{why}: {other:?}"),
    }
    assert_eq!(trial.core.open_requests(), 0, "{why}");
}

#[test]
fn sr_017_the_whole_handshake_sends_each_change_of_a_field_once() {
    let mut trial = under_way();
    ask(&mut trial, want(1));
    assert_eq!(last_written(&trial, "BPDVR"), ["1", "0"]);
    ask(&mut trial, want(1));
    vehicle_says(&mut trial, true);
    vehicle_says(&mut trial, true);
    for _ in 0..3 {
        ask(&mut trial, trigger(1));
    }
    assert_eq!(last_written(&trial, "BPDVR"), ["1", "1"]);
    for _ in 0..2 {
        ask(&mut trial, say(1, false, true));
    }
    assert_eq!(last_written(&trial, "BPDVR"), ["0", "1"]);
    vehicle_says(&mut trial, false);
    ask(&mut trial, end(1));
    assert_eq!(last_written(&trial, "BPDVR"), ["0", "0"]);
    assert_eq!(said(&trial), [(1, 0), (1, 1), (0, 1), (0, 0)]);
    assert_eq!(told(&trial, 0), [true, false]);
    assert!(told(&trial, 1).is_empty(), "only its owner learns it");
    assert_eq!(shorts(&trial.states(1)), ["sent", "accepted", "started", "ended"]);
    ended(&trial, "the vehicle stopped it");
}

#[test]
fn sr_017_a_plugin_ends_the_handshake_at_once_in_any_phase() {
    for (phase, reach) in PHASES {
        let mut trial = reach();
        ask(&mut trial, end(1));
        assert_eq!(said(&trial).last(), Some(&(0, 0)), "{phase}");
        let why = if phase == "ceasing" {
            "the vehicle stopped it"
        } else {
            "its plugin ended it"
        };
        ended(&trial, why);
        let count = said(&trial).len();
        trial.run_for(400.0);
        assert_eq!(said(&trial).len(), count, "{phase}: nothing follows");
    }
}

#[test]
fn sr_017_triggering_is_never_announced_without_the_vehicles_permission() {
    for (phase, reach) in PHASES {
        if matches!(phase, "allowed" | "triggering") {
            continue;
        }
        let mut trial = reach();
        let (before, states) = (said(&trial), trial.states(1));
        ask(&mut trial, trigger(1));
        assert!(trial.rejection(1).contains("does not allow triggering"), "{phase}");
        assert_eq!(said(&trial), before, "{phase}");
        assert_eq!(
            trial.states(1).len(),
            states.len() + 1,
            "{phase}: the open request stays open"
        );
        assert_eq!(trial.core.open_requests(), 1);
    }
    // Without a request, and after a request has ended.
    let mut trial = under_way();
    for (tag, request) in [(2, trigger(2)), (3, say(3, false, true)), (4, end(4))] {
        ask(&mut trial, request);
        assert!(trial.rejection(tag).starts_with("state: "));
    }
    assert!(said(&trial).is_empty());
    let mut trial = allowed();
    ask(&mut trial, say(1, false, true));
    assert!(trial.rejection(1).contains("does not allow"), "it does not trigger yet");
    ask(&mut trial, end(1));
    ask(&mut trial, trigger(1));
    assert_eq!(said(&trial), [(1, 0), (0, 0)]);
}

#[test]
fn sr_017_a_plugin_that_does_not_trigger_within_5_s_loses_the_permission() {
    let mut trial = allowed();
    ask(&mut trial, want(1));
    trial.run_for(4.5);
    assert_eq!(trial.core.open_requests(), 1);
    trial.run_for(0.3);
    ended(&trial, "not triggered within 5 s");
    assert_eq!(said(&trial), [(1, 0), (0, 0)]);
    ask(&mut trial, trigger(1));
    assert_eq!(said(&trial).len(), 2);
}

#[test]
fn sr_017_a_triggering_plugin_must_confirm_within_every_5_s() {
    let mut trial = triggering();
    for _ in 0..10 {
        trial.run_for(4.5);
        ask(&mut trial, trigger(1));
    }
    assert_eq!(said(&trial), [(1, 0), (1, 1)], "a repetition is not sent");
    let last = trial.now;
    trial.run_for(5.0);
    ended(&trial, "its plugin did not confirm within 5 s that it still triggers");
    let over = *trial.sent("DVR").last().unwrap();
    assert!(over <= last + Duration::from_secs(5) && said(&trial).last() == Some(&(0, 0)));
}

#[test]
fn sr_017_a_confirmation_that_is_handled_after_its_time_is_too_late() {
    let mut trial = triggering();
    let last = *trial.sent("DVR").last().unwrap();
    trial.run_for((last + Duration::from_millis(4750)).since(trial.now).as_secs_f64());
    // The step returns in time, but core wakes a little late and handles the return of the step first.
    trial.script(0, |_| (Duration::from_millis(300), Ok(vec![trigger(1)])));
    trial.run_for(0.1);
    trial.asleep_until = last + Duration::from_millis(5250);
    trial.stalled_until = last + Duration::from_millis(5300);
    trial.run_for(0.6);
    assert!(trial.core.has_control() && trial.core.late_count() == 0);
    let over = RequestState::Ended(EndCause::NotGoingOn.into());
    assert!(trial.states(1).contains(&over), "{:?}", trial.states(1));
    assert_eq!(said(&trial), [(1, 0), (1, 1), (0, 0)]);
}

#[test]
fn sr_017_a_pause_is_announced_and_may_last_5_s() {
    let mut trial = triggering();
    ask(&mut trial, want(1));
    assert_eq!(said(&trial).last(), Some(&(1, 0)));
    trial.run_for(3.0);
    ask(&mut trial, trigger(1));
    assert_eq!(said(&trial).last(), Some(&(1, 1)));
    ask(&mut trial, want(1));
    trial.run_for(5.0);
    ended(&trial, "not triggered within 5 s");
}

#[test]
fn sr_017_a_plugin_can_ask_again_after_the_vehicle_has_stopped_the_triggering() {
    for (phase, reach) in PHASES {
        if phase == "ceasing" {
            continue;
        }
        let mut trial = reach();
        vehicle_says(&mut trial, false);
        vehicle_says(&mut trial, false);
        assert_eq!(told(&trial, 0).last(), Some(&false), "{phase}");
        ask(&mut trial, want(1));
        assert_eq!(said(&trial).last(), Some(&(1, 0)), "{phase}");
        trial.run_for(100.0);
        vehicle_says(&mut trial, true);
        ask(&mut trial, trigger(1));
        assert_eq!(said(&trial).last(), Some(&(1, 1)), "{phase}");
        assert_eq!(trial.core.open_requests(), 1);
    }
}

#[test]
fn sr_017_core_answers_a_stop_that_the_plugin_does_not_answer_within_a_second() {
    let mut trial = triggering();
    let stop = trial.now;
    vehicle_says(&mut trial, false);
    trial.run_for(0.7);
    assert_eq!(said(&trial).last(), Some(&(1, 1)));
    trial.run_for(0.3);
    ended(
        &trial,
        "the vehicle stopped it, and its plugin did not answer within 1 s",
    );
    let over = *trial.sent("DVR").last().unwrap();
    assert_eq!(said(&trial).last(), Some(&(0, 0)));
    assert!(over <= stop + trial.delay + Duration::from_secs(1));
}

#[test]
fn sr_017_the_handshake_is_over_5_s_after_an_unanswered_end() {
    let mut trial = ending();
    trial.run_for(5.0);
    ended(&trial, "the vehicle did not stop it within 5 s");
    assert_eq!(said(&trial), [(1, 0), (1, 1), (0, 1), (0, 0)]);
}

#[test]
fn sr_009_a_request_that_the_vehicle_never_allows_ends_after_300_s() {
    let mut trial = requested();
    trial.run_for(299.0);
    assert_eq!(trial.core.open_requests(), 1);
    trial.run_for(1.0);
    ended(&trial, "the vehicle did not allow it within 300 s");
    assert_eq!(said(&trial), [(1, 0), (0, 0)]);
}

#[test]
fn sr_009_a_refused_dvl_request_fails_and_an_unanswered_one_times_out() {
    for (reply, end) in [
        (
            Reply::Refuse,
            RequestState::Failed(Failure::Vehicle("as told".to_owned())),
        ),
        (Reply::Nak, RequestState::Failed(Failure::Vehicle("as told".to_owned()))),
        (
            Reply::Pending(Duration::from_secs(1), AckStatus::Failed),
            RequestState::Failed(Failure::Vehicle("as told".to_owned())),
        ),
        (Reply::Silent, RequestState::TimedOut),
        (Reply::PendingForEver, RequestState::TimedOut),
        (
            Reply::Late(Duration::from_secs(3), AckStatus::Succeeded),
            RequestState::TimedOut,
        ),
    ] {
        let mut trial = under_way();
        trial.vehicle.replies.insert("DVR", reply);
        ask(&mut trial, want(1));
        trial.run_for(6.0);
        assert_eq!(trial.states(1).last(), Some(&end), "{reply:?}");
        assert_eq!(said(&trial), [(1, 0), (0, 0)], "{reply:?}");
        assert_eq!(trial.core.open_requests(), 0);
    }
}

#[test]
fn sr_009_a_refused_or_unanswered_step_ends_the_handshake() {
    for (reply, why) in [
        (Reply::Refuse, "the vehicle refused it: as told"),
        (Reply::Silent, "the vehicle did not acknowledge it"),
    ] {
        let mut trial = allowed();
        trial.vehicle.replies.insert("DVR", reply);
        ask(&mut trial, trigger(1));
        trial.run_for(2.0);
        ended(&trial, why);
        assert_eq!(said(&trial), [(1, 0), (1, 1), (0, 0)]);
    }
}

#[test]
fn a_repeated_acknowledgement_changes_nothing_and_bfdvt_counts_as_an_answer() {
    let mut trial = under_way();
    trial
        .vehicle
        .replies
        .insert("DVR", Reply::Twice(Duration::from_millis(100), AckStatus::Failed));
    ask(&mut trial, want(1));
    vehicle_says(&mut trial, true);
    ask(&mut trial, trigger(1));
    assert_eq!(shorts(&trial.states(1)), ["sent", "accepted", "started"]);
    let mut trial = under_way();
    trial.vehicle.replies.insert("DVR", Reply::Silent);
    ask(&mut trial, want(1));
    vehicle_says(&mut trial, true);
    trial.run_for(3.0);
    assert_eq!(trial.core.open_requests(), 1, "BFDVT has answered it");
}

#[test]
fn sr_017_a_lost_link_ends_the_handshake_and_nothing_is_sent_for_it_later() {
    for (phase, reach) in PHASES {
        let mut trial = reach();
        let before = said(&trial).len();
        trial.cut();
        ended(&trial, "the link is down");
        trial.run_for(10.0);
        assert!(trial.core.has_control());
        assert_eq!(said(&trial).len(), before, "{phase}");
        // The vehicle has not received the end.
        vehicle_says(&mut trial, true);
        assert_eq!(said(&trial).last(), Some(&(0, 0)), "{phase}");
        ask(&mut trial, want(2));
        assert_eq!(shorts(&trial.states(2)), ["sent", "accepted"], "{phase}");
    }
    let mut trial = under_way();
    trial.vehicle.replies.insert("DVR", Reply::Silent);
    ask(&mut trial, want(1));
    trial.cut();
    assert_eq!(trial.states(1).last(), Some(&RequestState::TimedOut));
}

#[test]
fn sr_014_a_loss_of_control_or_plugin_ends_the_handshake_with_one_bpdvr_within_100_ms() {
    type Act = fn(&mut Trial);
    let acts: [(&str, Act); 8] = [
        ("the operator's hold is set", |trial| trial.operator(Operator::Hold)),
        ("the run is ending", |trial| trial.operator(Operator::Stop)),
        ("its plugin failed", |trial| trial.fail(0, FaultKind::Trap)),
        ("its plugin failed", |trial| trial.fail(0, FaultKind::Error)),
        ("the vehicle has control", |trial| {
            let now = trial.now;
            trial.vehicle.set_control(now, false);
        }),
        ("the mission is not running", |trial| {
            let now = trial.now;
            trial.vehicle.set_status(now, "Aborting");
        }),
        ("the power is being switched off", |trial| {
            let created = trial.vehicle.clock(trial.now);
            trial.hear_now([FromVehicle::from(Shutdown { created })]);
        }),
        ("navigation is stale", |trial| trial.vehicle.navigates = false),
    ];
    for (why, act) in acts {
        for (phase, reach) in PHASES {
            if matches!((why, phase), ("navigation is stale", "ceasing")) {
                // The handshake ends before navigation is stale.
                continue;
            }
            let mut trial = reach();
            let (before, at) = (said(&trial).len(), trial.now);
            act(&mut trial);
            trial.run_for(1.5);
            ended(&trial, why);
            assert_eq!(said(&trial)[before..], [(0, 0)], "{why} {phase}");
            if why != "navigation is stale" {
                let over = trial.sent("DVR").last().unwrap().since(at);
                // A plugin fails in its next step.
                let most = if why == "its plugin failed" { 250 } else { 100 };
                assert!(over <= Duration::from_millis(most), "{why} {phase}: {over:?}");
            }
        }
    }
}

#[test]
fn sr_017_an_unrequested_bfdvt_is_answered_at_most_once_a_second() {
    let mut trial = Trial::under_way();
    let from = trial.now;
    vehicle_says(&mut trial, true);
    assert_eq!(said(&trial), [(0, 0)]);
    assert!(format!("{:?}", trial.notes()).contains("DVL triggering, and no request for it is open"));
    for _ in 0..50 {
        vehicle_says(&mut trial, false);
    }
    let spans = trial.now.since(from).as_secs_f64();
    assert!((said(&trial).len() as f64) <= spans + 1.0 && said(&trial).len() > 5);
    assert!(said(&trial).iter().all(|fields| *fields == (0, 0)));
    assert!(told(&trial, 0).is_empty());
    assert_eq!(trial.core.request_counts().proposed, 0);
}

#[test]
fn only_one_plugin_has_the_trigger_at_a_time_under_one_tag() {
    let mut trial = triggering();
    trial.ask(0, [want(2)]);
    trial.ask(1, [want(3), end(1), trigger(1)]);
    trial.run_for(0.3);
    assert!(trial.rejection(2).contains("the trigger is still open"));
    assert!(trial.rejection(3).starts_with("priority: "));
    assert!(trial.rejection(1).starts_with("priority: "));
    assert_eq!(said(&trial), [(1, 0), (1, 1)]);
    // The failure of the other plugin does not end it.
    trial.fail(1, FaultKind::Trap);
    trial.run_for(0.5);
    assert_eq!(trial.core.open_requests(), 1);
    ask(&mut trial, end(1));
    trial.run_for(2.0);
    trial.ask(1, [want(4)]);
    trial.run_for(0.3);
    assert_eq!(shorts(&trial.states(4)), ["sent", "accepted"]);
}

#[test]
fn sr_019_a_flood_of_changes_is_limited_but_the_end_is_not() {
    let mut trial = triggering();
    trial.script(0, |_| {
        let mut requests: Vec<Request> = (0..100).map(|n| say(1, true, n % 2 == 0)).collect();
        requests.push(end(1));
        requests.push(want(1));
        (Duration::from_millis(1), Ok(requests))
    });
    trial.run_for(0.05);
    let from = trial.now;
    trial.run_for(10.0);
    let sent = trial.sent_since("DVR", from).len();
    assert!(sent <= 230, "{sent}");
    trial.script(0, |_| (Duration::from_millis(1), Ok(Vec::new())));
    trial.run_for(310.0);
    assert_eq!(trial.core.open_requests(), 0);
    assert_eq!(said(&trial).last(), Some(&(0, 0)));
}

#[test]
fn sr_017_a_delayed_permission_counts_from_when_the_vehicle_gave_it() {
    let mut trial = requested();
    let message = DvlTriggering {
        created: trial.vehicle.clock(trial.now),
        begin: true,
    };
    trial.run_for(4.0);
    trial.hear_now([FromVehicle::from(message)]);
    trial.run_for(1.1);
    ended(&trial, "not triggered within 5 s");
}

#[test]
fn sr_001_the_handshake_needs_the_grant_and_an_armed_runtime() {
    let mut trial = Trial::under_way();
    ask(&mut trial, want(1));
    assert!(trial.rejection(1).contains("does not grant `dvl`"));
    let mut setup = setup();
    setup.start.armed = false;
    let mut trial = Trial::with_under_way(setup);
    ask(&mut trial, want(1));
    assert!(trial.rejection(1).contains("not armed"));
    assert_eq!(trial.sent_since("DVR", Timestamp::ZERO), []);
}
