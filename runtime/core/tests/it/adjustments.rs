//! Trim and buoyancy adjustments, to their final status.

use std::time::Duration;

use backseat_core::plugin::{EndCause, Ended, Failure};
use backseat_core::plugin::{Event, FaultKind, Request, RequestState, Sample, Topic};
use backseat_core::{Grant, Limits, Operator, PluginSetup};
use backseat_spi::{
    AckStatus, AdjustmentError, AdjustmentStatus, BehaviorBegin, BehaviorEnd, BuoyancyStatus, Text, ToVehicle,
    TrimStatus,
};

use crate::course::{self, interrupting, limits};
use crate::trial::{Setup, Trial, shorts};
use crate::vehicle::Reply;

use AdjustmentStatus::{Completed, Failed, Idle, InProgress};

fn plugin(name: &str) -> PluginSetup {
    let mut setup = course::plugin(name);
    setup.grants = vec![Grant::Modify, Grant::Trim, Grant::Buoyancy];
    setup.description.topics.extend([Topic::Trim, Topic::Buoyancy]);
    setup
}

fn setup() -> Setup {
    Setup {
        plugins: vec![plugin("first"), plugin("second")],
        ..Setup::default()
    }
}

fn under_way() -> Trial {
    Trial::with_under_way(setup())
}

fn trim_error(trial: &mut Trial, status: AdjustmentStatus, error: AdjustmentError) {
    let now = trial.now;
    let message = TrimStatus {
        created: trial.vehicle.clock(now),
        status,
        error,
        text: Text::cleaned("as told"),
        pitch_deg: 0.5,
        roll_deg: -0.25,
    };
    trial.vehicle.say(now, message);
    trial.run_for(0.2);
}

fn trim(trial: &mut Trial, status: AdjustmentStatus) {
    trim_error(trial, status, AdjustmentError::None);
}

fn behavior(trial: &mut Trial, began: bool, kind: &str) {
    let now = trial.now;
    let (created, dive_file, kind) = (trial.vehicle.clock(now), Text::cleaned(""), Text::cleaned(kind));
    let (number, identifier) = (None, None);
    if began {
        trial.vehicle.say(
            now,
            BehaviorBegin {
                created,
                dive_file,
                number,
                identifier,
                kind,
            },
        );
    } else {
        trial.vehicle.say(
            now,
            BehaviorEnd {
                created,
                dive_file,
                number,
                identifier,
                kind,
            },
        );
    }
    trial.run_for(0.2);
}

/// A trim under tag 1, sent and not answered yet.
fn sent() -> Trial {
    let mut trial = under_way();
    trial
        .vehicle
        .replies
        .insert("TRM", Reply::Late(Duration::from_millis(1500), AckStatus::Succeeded));
    trial.ask(0, [Request::Trim(1)]);
    trial.run_for(0.3);
    assert_eq!(shorts(&trial.states(1)), ["sent"], "{:?}", trial.states(1));
    trial
}

/// A trim under tag 1, acknowledged.
fn accepted() -> Trial {
    let mut trial = sent();
    trial.run_for(1.5);
    assert_eq!(shorts(&trial.states(1)), ["sent", "accepted"]);
    trial
}

fn started() -> Trial {
    let mut trial = accepted();
    trim(&mut trial, InProgress);
    assert_eq!(shorts(&trial.states(1)), ["sent", "accepted", "started"]);
    trial
}

#[test]
fn a_trim_is_accepted_by_its_acknowledgement_and_started_and_ended_by_its_status() {
    let mut trial = started();
    trim(&mut trial, InProgress);
    trim(&mut trial, Completed);
    assert_eq!(shorts(&trial.states(1)), ["sent", "accepted", "started", "ended"]);
    assert_eq!(
        trial.states(1).last(),
        Some(&RequestState::Ended(Ended::Said(
            EndCause::Completed,
            "as told, pitch 0.5 deg, roll -0.25 deg".to_owned()
        )))
    );
    let mut bytes = Vec::new();
    trial.commands("TRM")[0].1.encode(&mut bytes).unwrap();
    let text = String::from_utf8(bytes).unwrap();
    let (body, sum) = text.trim_end().split_once('*').unwrap();
    assert_eq!(
        (&body[..7], body.len()),
        ("$BPTRM,", "$BPTRM,hhmmss.sss".len()),
        "{text}"
    );
    assert_eq!(
        sum,
        format!("{:02X}", body[1..].bytes().fold(0, |sum, byte| sum ^ byte))
    );
    // The plugin that asked learns everything; the other one learns only the estimates.
    let samples = |plugin: usize| {
        let events = trial.events(plugin).into_iter();
        let mut trims = events.filter_map(|event| match event {
            Event::Sample(Sample::Trim(sample)) => Some(sample),
            _ => None,
        });
        (trims.next().unwrap(), trims.count())
    };
    let (first, others) = samples(1);
    assert_eq!(
        (first.pitch_deg, first.roll_deg, first.adjusting, others),
        (0.5, -0.25, true, 2)
    );
    assert!(
        !trial
            .events(1)
            .iter()
            .any(|event| matches!(event, Event::Outcome { .. }))
    );
    assert_eq!(trial.core.open_requests(), 0);
}

#[test]
fn a_buoyancy_adjustment_is_independent_of_a_trim() {
    let mut trial = under_way();
    trial.ask(0, [Request::Buoyancy(1), Request::Trim(2)]);
    trial.run_for(0.5);
    assert!(matches!(trial.commands("BOY")[0].1, ToVehicle::BuoyancyAdjustment(_)));
    let now = trial.now;
    let status = BuoyancyStatus {
        created: trial.vehicle.clock(now),
        status: Failed,
        error: AdjustmentError::AtLimit,
        text: Text::cleaned("as told"),
        buoyancy_n: -12.5,
    };
    trial.vehicle.say(now, status);
    trial.run_for(0.5);
    assert_eq!(
        trial.states(1).last(),
        Some(&RequestState::Failed(Failure::Vehicle(
            "at the limit, or no flow: as told, buoyancy -12.5 N".to_owned()
        )))
    );
    assert_eq!(shorts(&trial.states(2)), ["sent", "accepted"]);
    let estimated =
        |event: Event| matches!(event, Event::Sample(Sample::Buoyancy(sample)) if sample.buoyancy_n == -12.5);
    assert!(trial.events(1).into_iter().any(estimated));
}

#[test]
fn an_adjustment_that_fails_after_its_start_reports_the_error_and_the_text() {
    for (error, name) in [
        (AdjustmentError::Failed, "the operation failed"),
        (AdjustmentError::Canceled, "the operation was cancelled"),
        (AdjustmentError::Other(9), "an error that SPI 1.12a does not define"),
    ] {
        let mut trial = started();
        trim_error(&mut trial, Failed, error);
        let Some(RequestState::Failed(text)) = trial.states(1).pop() else {
            panic!("{:?}", trial.states(1))
        };
        assert!(text.to_string().starts_with(name), "{text}");
        trial.ask(0, [Request::Trim(2)]);
        trial.run_for(0.5);
        assert_eq!(
            shorts(&trial.states(2))[0],
            "sent",
            "the next adjustment can be requested"
        );
    }
}

#[test]
fn sr_009_a_refused_adjustment_fails_and_an_unanswered_one_times_out() {
    for (reply, end) in [
        (Reply::Refuse, "failed"),
        (Reply::Nak, "failed"),
        (Reply::Silent, "timed out"),
        (Reply::PendingForEver, "timed out"),
    ] {
        let mut trial = under_way();
        trial.vehicle.replies.insert("TRM", reply);
        trial.ask(0, [Request::Trim(1)]);
        trial.run_for(8.0);
        assert_eq!(shorts(&trial.states(1)).last(), Some(&end), "{reply:?}");
        trim(&mut trial, Completed);
        assert_eq!(trial.core.open_requests(), 0);
        trial.vehicle.replies.clear();
        trial.ask(0, [Request::Trim(2)]);
        trial.run_for(0.5);
        assert_eq!(shorts(&trial.states(2)), ["sent", "accepted"]);
    }
}

#[test]
fn status_before_the_acknowledgement_may_belong_to_another_adjustment() {
    // This is the end of an adjustment that the vehicle had begun by itself.
    let mut trial = sent();
    trim(&mut trial, InProgress);
    trim(&mut trial, Completed);
    trial.run_for(1.5);
    assert_eq!(shorts(&trial.states(1)), ["sent", "accepted"]);
    trim(&mut trial, InProgress);
    trim_error(&mut trial, Failed, AdjustmentError::Failed);
    assert_eq!(shorts(&trial.states(1)), ["sent", "accepted", "started", "failed"]);
    // An adjustment that is in progress before the acknowledgement and goes on counts as ours after it.
    let mut trial = sent();
    trim(&mut trial, InProgress);
    assert_eq!(shorts(&trial.states(1)), ["sent"]);
    trial.run_for(1.5);
    assert_eq!(shorts(&trial.states(1)), ["sent", "accepted", "started"]);
}

#[test]
fn an_adjustment_without_a_seen_start_ends_once_the_vehicle_has_been_idle_for_a_while() {
    let mut trial = sent();
    trim(&mut trial, Completed);
    trial.run_for(1.5);
    trim(&mut trial, Idle);
    assert_eq!(
        shorts(&trial.states(1)),
        ["sent", "accepted"],
        "the adjustment may be about to begin"
    );
    trial.run_for(10.0);
    trim(&mut trial, Idle);
    assert_eq!(shorts(&trial.states(1)), ["sent", "accepted", "ended"]);
    // An adjustment that was seen in progress is over as soon as the vehicle is idle.
    let mut trial = started();
    trim(&mut trial, Idle);
    assert_eq!(shorts(&trial.states(1)).last(), Some(&"ended"));
    // A final status ends it, even if it was never seen in progress.
    let mut trial = accepted();
    trim(&mut trial, Completed);
    assert_eq!(shorts(&trial.states(1)), ["sent", "accepted", "ended"]);
}

#[test]
fn only_a_behavior_of_the_adjustments_type_shows_that_it_has_begun() {
    let mut trial = accepted();
    behavior(&mut trial, true, "buoyancy adjustment");
    behavior(&mut trial, true, "setpoint");
    assert_eq!(shorts(&trial.states(1)), ["sent", "accepted"]);
    behavior(&mut trial, true, "TrimAdjustment");
    assert_eq!(shorts(&trial.states(1)), ["sent", "accepted", "started"]);
    // The behavior ends, but no final status comes.
    behavior(&mut trial, false, "TrimAdjustment");
    trial.run_for(20.0);
    assert_eq!(shorts(&trial.states(1)).last(), Some(&"started"));
    trial.run_for(15.0);
    assert_eq!(shorts(&trial.states(1)).last(), Some(&"timed out"));
}

#[test]
fn status_without_a_request_only_informs() {
    let mut trial = under_way();
    for status in [InProgress, Completed, Failed, Idle, AdjustmentStatus::Other(7)] {
        trim(&mut trial, status);
    }
    assert_eq!(trial.core.open_requests(), 0);
    let told = trial.events(0);
    assert_eq!(
        told.iter()
            .filter(|event| matches!(event, Event::Sample(Sample::Trim(_))))
            .count(),
        5
    );
    let mut trial = started();
    trim(&mut trial, AdjustmentStatus::Other(7));
    assert_eq!(shorts(&trial.states(1)).last(), Some(&"started"));
}

#[test]
fn an_adjustment_without_further_status_times_out_after_25_minutes() {
    for trial in [&mut accepted(), &mut started()] {
        trial.run_for(24.9 * 60.0);
        assert_eq!(trial.core.open_requests(), 1);
        trial.run_for(10.0);
        assert_eq!(shorts(&trial.states(1)).last(), Some(&"timed out"));
    }
}

#[test]
fn sr_009_an_adjustment_in_doubt_after_a_link_loss_is_resolved_by_its_status() {
    let resolved = |status: AdjustmentStatus| {
        let mut trial = sent();
        trial.cut();
        trial.run_for(3.0);
        assert_eq!(shorts(&trial.states(1)), ["sent", "unknown"]);
        trial.ask(1, [Request::Trim(2)]);
        trial.run_for(0.3);
        assert!(trial.rejection(2).contains("is under way"), "{}", trial.rejection(2));
        trim(&mut trial, status);
        assert_eq!(trial.commands("TRM").len(), 1, "never sent twice");
        shorts(&trial.states(1)).split_off(2)
    };
    assert_eq!(resolved(InProgress), ["accepted", "started"]);
    assert_eq!(resolved(Completed), ["ended"]);
    assert_eq!(resolved(Failed), ["failed"]);
    assert_eq!(resolved(Idle), ["ended"]);
    let mut trial = sent();
    trial.cut();
    trial.run_for(25.5 * 60.0);
    assert_eq!(shorts(&trial.states(1)), ["sent", "unknown", "timed out"]);
    // An adjustment that has begun goes on over a link loss.
    let mut trial = started();
    trial.cut();
    trial.run_for(3.0);
    trim(&mut trial, Completed);
    assert_eq!(shorts(&trial.states(1)), ["sent", "accepted", "started", "ended"]);
}

#[test]
fn an_adjustment_outlives_its_plugin_control_and_the_operators_hold() {
    let mut trial = started();
    trial.fail(0, FaultKind::Trap);
    trial.run_for(0.5);
    trial.operator(Operator::Hold);
    let now = trial.now;
    trial.vehicle.set_control(now, false);
    trial.run_for(1.0);
    assert_eq!(trial.core.open_requests(), 1);
    trim(&mut trial, Completed);
    assert_eq!(shorts(&trial.states(1)).last(), Some(&"ended"));
}

#[test]
fn an_adjustment_ends_with_the_mission() {
    let mut trial = started();
    let now = trial.now;
    trial.vehicle.set_status(now, "Completed");
    trial.run_for(0.5);
    assert_eq!(
        trial.states(1).last(),
        Some(&RequestState::Ended(EndCause::MissionOver.into()))
    );
    let mut trial = sent();
    let now = trial.now;
    trial.vehicle.set_status(now, "Completed");
    trial.vehicle.replies.clear();
    trial.run_for(30.0 * 60.0);
    assert_eq!(trial.core.open_requests(), 0);
}

#[test]
fn sr_019_adjustments_are_capped_and_need_a_grant_a_subscription_and_no_other_under_way() {
    let mut trial = Trial::under_way();
    trial.ask(0, [Request::Trim(1), Request::Buoyancy(2)]);
    trial.run_for(0.5);
    assert!(trial.rejection(1).contains("does not grant `trim`"));
    assert!(trial.rejection(2).contains("does not grant `buoyancy`"));

    let mut trial = Trial::with(setup());
    trial.vehicle.replies.insert("LOG", Reply::Refuse);
    trial.run_for(2.0);
    trial.ask(0, [Request::Trim(1)]);
    trial.run_for(0.5);
    assert!(
        trial.rejection(1).contains("not confirmed the subscription to BFTRM"),
        "{}",
        trial.rejection(1)
    );

    let limits = Limits {
        adjustments_total_max: 2,
        ..limits()
    };
    let mut trial = Trial::with_under_way(Setup { limits, ..setup() });
    trial.ask(0, [Request::Trim(1), Request::Trim(2), Request::Buoyancy(3)]);
    trial.run_for(0.5);
    assert!(trial.rejection(2).contains("is under way"));
    trim(&mut trial, Completed);
    trial.ask(0, [Request::Trim(4)]);
    trial.run_for(0.5);
    assert!(trial.rejection(4).contains("adjustments of the mission is 3"));
    let now = trial.now;
    trial.vehicle.set_control(now, false);
    trial.run_for(0.2);
    trial.ask(0, [Request::Trim(5)]);
    trial.run_for(0.5);
    assert!(trial.rejection(5).starts_with("control: "));
    assert_eq!((trial.commands("TRM").len(), trial.commands("BOY").len()), (1, 1));
}

#[test]
fn repeated_late_and_unrelated_answers_change_nothing() {
    let mut trial = started();
    let sent = trial.commands("TRM")[0].1.created().unwrap();
    let now = trial.now;
    trial.vehicle.acknowledge(now, ("TRM", sent, None, AckStatus::Failed));
    trial.vehicle.acknowledge(now, ("BOY", sent, None, AckStatus::Failed));
    trial.run_for(0.5);
    assert_eq!(shorts(&trial.states(1)), ["sent", "accepted", "started"]);
    trim(&mut trial, Completed);
    trim_error(&mut trial, Failed, AdjustmentError::Failed);
    trial.run_for(0.5);
    assert_eq!(shorts(&trial.states(1)), ["sent", "accepted", "started", "ended"]);
}

#[test]
fn a_flood_of_requests_sends_one_adjustment() {
    let mut trial = under_way();
    for _ in 0..20 {
        trial.ask(0, (0..50).map(|tag| Request::Trim(100 + tag)));
        trial.run_for(0.1);
    }
    assert_eq!(trial.commands("TRM").len(), 1);
    assert_eq!(trial.core.open_requests(), 1);
}

#[test]
fn sr_010_an_adjustment_during_an_interrupting_insert_does_not_end_the_insert() {
    let mut plugins = setup();
    plugins.plugins[0].grants.extend([Grant::Insert, Grant::Interrupt]);
    let mut trial = Trial::with_under_way(plugins);
    trial.ask(0, [interrupting(1)]);
    trial.run_for(0.5);
    let now = trial.now;
    trial.vehicle.begin(now, None, Some(1));
    trial.run_for(0.3);
    assert_eq!(shorts(&trial.states(1)), ["sent", "accepted", "started"]);
    behavior(&mut trial, true, "trim");
    behavior(&mut trial, false, "trim");
    trial.run_for(0.3);
    trial.ask(0, [interrupting(2)]);
    trial.run_for(0.5);
    assert!(trial.rejection(2).starts_with("interrupt: "), "{}", trial.rejection(2));
    assert_eq!(shorts(&trial.states(1)), ["sent", "accepted", "started"]);
}
