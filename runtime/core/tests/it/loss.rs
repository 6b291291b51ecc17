//! What holds although a message came late, damaged or not at all.

use std::time::Duration;

use backseat_core::plugin::FaultKind;
use backseat_core::{FailAction, Note, Operator, Order, PluginSetup};
use backseat_spi::AckStatus;
use backseat_units::EastNorth;

use crate::course::{good_line, interrupting, modify_for, plugin};
use crate::trial::{Seen, Setup, Trial, shorts};
use crate::vehicle::{Reply, name_of};

const SECOND: i64 = 1_000_000_000;

/// GPS hits discipline the vehicle's clock (SPI 2), and also move its position.
#[test]
fn sr_021_a_jump_is_noticed_even_if_the_vehicles_clock_is_set_with_it() {
    for seconds in [30, 120, 4000] {
        let mut trial = Trial::under_way();
        trial.ask(0, [modify_for(1, Duration::from_secs(60))]);
        trial.run_for(5.0);
        assert!(trial.core.is_steering());
        trial.vehicle.clock_nanos += seconds * SECOND;
        trial.vehicle.jump = EastNorth::new(0.0, 120.0);
        trial.run_for(1.0);
        let jumped = |(_, note)| matches!(note, Note::Navigation { .. });
        assert!(
            trial.notes().into_iter().any(jumped),
            "{seconds} s: a jump of 120 m was not seen"
        );
        assert!(!trial.core.is_steering(), "{seconds} s");
    }
}

/// When the operator's hold is set, the vehicle has not decided on the insert and knows none that it could cancel.
#[test]
fn sr_015_a_hold_takes_back_an_insert_that_the_vehicle_accepts_after_it_has_refused_the_cancel() {
    let mut trial = Trial::under_way();
    let pending = Reply::Pending(Duration::from_millis(1500), AckStatus::Succeeded);
    trial.vehicle.replies.insert("RTK", pending);
    trial.vehicle.replies.insert("RCN", Reply::Refuse);
    trial.ask(0, [good_line(1)]);
    trial.run_for(0.5);
    trial.operator(Operator::Hold);
    trial.run_for(0.5);
    assert_eq!(trial.commands("RCN").len(), 1);
    trial.vehicle.replies.clear();
    trial.run_for(20.0);
    assert_eq!(
        shorts(&trial.states(1)).last(),
        Some(&"cancelled"),
        "{:?}",
        shorts(&trial.states(1))
    );
}

/// Neither an insert nor its cancels are answered; then the vehicle hears again.
fn never_answered(setup: Setup) -> Trial {
    let mut trial = Trial::with_under_way(setup);
    trial.vehicle.replies.insert("RTK", Reply::Silent);
    trial.vehicle.replies.insert("RCN", Reply::Silent);
    trial.ask(0, [good_line(1)]);
    trial.run_for(60.0);
    assert_eq!(shorts(&trial.states(1)), ["sent", "timed out"]);
    trial.vehicle.replies.clear();
    // The vehicle has the insert in spite of that.
    trial.vehicle.inserted.insert(1);
    trial
}

#[test]
fn sr_015_a_hold_takes_back_an_insert_that_was_never_answered() {
    let mut trial = never_answered(Setup::default());
    let held = trial.now;
    trial.operator(Operator::Hold);
    trial.run_for(20.0);
    assert!(!trial.sent_since("RCN", held).is_empty(), "no cancel under the hold");
}

#[test]
fn sr_015_an_unanswered_insert_of_a_failed_plugin_is_taken_back() {
    let failing = PluginSetup {
        on_failure: FailAction::Cancel,
        ..plugin("first")
    };
    let mut trial = never_answered(Setup {
        plugins: vec![failing],
        ..Setup::default()
    });
    let failed = trial.now;
    trial.fail(0, FaultKind::Trap);
    trial.run_for(20.0);
    assert!(!trial.sent_since("RCN", failed).is_empty(), "no cancel");
}

/// Like the test before the last one, but the link was lost before the answer.
#[test]
fn sr_015_a_hold_takes_back_an_insert_whose_answer_was_lost_with_the_link() {
    let mut trial = Trial::under_way();
    trial.vehicle.replies.insert("RTK", Reply::Silent);
    trial.ask(0, [good_line(1)]);
    trial.run_for(0.3);
    trial.vehicle.replays = false;
    trial.cut();
    trial.run_for(15.0);
    assert_eq!(
        shorts(&trial.states(1)).last(),
        Some(&"timed out"),
        "{:?}",
        trial.states(1)
    );
    trial.vehicle.inserted.insert(1);
    let held = trial.now;
    trial.operator(Operator::Hold);
    trial.run_for(20.0);
    assert!(!trial.sent_since("RCN", held).is_empty(), "no cancel under the hold");
}

/// The record on disk is older than the vehicle's mission: a backup, another folder, an overlay that a reboot has reset.
#[test]
fn sr_009_an_identifier_that_the_vehicles_plan_names_already_is_not_used_again() {
    let mut trial = Trial::new();
    trial.vehicle.inserted.insert(1);
    trial.run_for(3.0);
    trial.ask(0, [good_line(1)]);
    trial.run_for(0.5);
    let used: Vec<_> = trial
        .commands("RTK")
        .iter()
        .map(|(_, command)| name_of(command).1)
        .collect();
    assert!(!used.contains(&Some(1)), "{used:?}");
}

fn bytes(body: &str) -> Vec<u8> {
    let sum = body.bytes().fold(0u8, |sum, byte| sum ^ byte);
    format!("${body}*{sum:02X}\r\n").into_bytes()
}

#[test]
fn sr_001_an_unreadable_message_about_control_takes_control_away() {
    for body in [
        "BFCTL,221325.000,",
        "BFCTL,221325.000",
        "BFCTL,,0",
        "BFCTL,221325.000,2",
        "BFCTL,221325.000,false",
        "BFMIS,,survey.dive,Aborting,by the operator",
        "BFMIS,221325.000,survey.dive",
    ] {
        let mut trial = Trial::steering();
        trial.hear_bytes(&bytes(body));
        assert!(!trial.core.has_control() && !trial.core.is_steering(), "{body}");
    }
}

/// Persisting the hold syncs the disk, and the vehicle's helm must not wait for that.
#[test]
fn sr_003_the_bpemb_of_a_hold_is_sent_before_the_hold_is_persisted() {
    let mut trial = Trial::steering();
    let before = trial.seen.len();
    trial.operator(Operator::Hold);
    let kept = trial.seen[before..]
        .iter()
        .position(|(_, seen)| matches!(seen, Seen::Note(Note::Operator { .. })));
    let said = trial.seen[before..]
        .iter()
        .position(|(_, seen)| matches!(seen, Seen::Sent(_)));
    assert!(said < kept, "{said:?} {kept:?}");
}

fn begun(trial: &mut Trial, identifier: u32) {
    let now = trial.now;
    trial.vehicle.begin(now, None, Some(identifier));
    trial.run_for(0.3);
}

/// The damaged sentences may have been the end of our insert and the begin of another payload's.
#[test]
fn sr_012_the_current_behavior_is_not_cancelled_if_it_may_be_another_payloads() {
    let mut trial = Trial::under_way();
    trial.ask(0, [good_line(1)]);
    trial.run_for(0.5);
    begun(&mut trial, 1);
    trial.vehicle.inserted.remove(&1);
    trial.hear_bytes(b"$BFMBE,221325.000,,,1,trackline*00\r\n$BFMBS,221325.000,,,77,trackline*00\r\n");
    trial.run_for(10.0);
    trial.operator(Operator::Order(Order::CancelCurrent));
    trial.run_for(0.5);
    assert!(trial.commands("RCB").is_empty());
}

#[test]
fn sr_010_another_payloads_insert_is_not_interrupted_even_if_its_begin_was_damaged() {
    let mut trial = Trial::under_way();
    trial.hear_bytes(b"$BFMBS,221325.000,,,77,trackline*00\r\n");
    trial.run_for(10.0);
    trial.ask(0, [interrupting(1)]);
    trial.run_for(0.5);
    assert_eq!(shorts(&trial.states(1)), ["rejected"]);
}

#[test]
fn sr_010_another_payloads_insert_is_not_interrupted_after_a_link_loss() {
    let mut trial = Trial::under_way();
    begun(&mut trial, 77);
    trial.ask(0, [interrupting(1)]);
    trial.run_for(0.5);
    assert_eq!(shorts(&trial.states(1)), ["rejected"], "heard");
    trial.vehicle.replays = false;
    trial.cut();
    trial.run_for(10.0);
    let now = trial.now;
    trial.vehicle.set_control(now, true);
    trial.vehicle.set_status(now, "Running");
    trial.run_for(3.0);
    assert!(trial.core.has_control());
    trial.ask(0, [interrupting(2)]);
    trial.run_for(0.5);
    assert_eq!(shorts(&trial.states(2)), ["rejected"], "{:?}", trial.states(2));
}
