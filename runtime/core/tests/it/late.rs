//! Messages and answers that come late, come again, or do not come.

use backseat_core::Settings;
use backseat_core::plugin::Request;
use backseat_spi::{AckStatus, BackseatControl, MissionCommand, Text};

use crate::course::modify;
use crate::trial::{Setup, Trial, settings};

fn mission_command(trial: &Trial, text: &str) -> MissionCommand {
    MissionCommand {
        created: trial.vehicle.clock(trial.now),
        text: Text::cleaned(text),
    }
}

const DAMAGED: &[u8] = b"$BFCTL,081025.987,0*00\r\n";

/// The release from before the operator's hold comes again.
#[test]
fn sr_015_an_older_release_does_not_overrule_a_newer_hold() {
    let mut trial = Trial::with_under_way(Setup {
        settings: Settings {
            hold_text: Some("hold".to_owned()),
            release_text: Some("release".to_owned()),
            ..settings()
        },
        ..Setup::default()
    });
    let release = mission_command(&trial, "release");
    trial.hear_now([release.clone().into()]);
    trial.run_for(1.0);
    let hold = mission_command(&trial, "hold");
    trial.hear_now([hold.into()]);
    assert!(!trial.core.has_control());
    trial.run_for(0.5);
    trial.hear_now([release.into()]);
    trial.run_for(0.5);
    assert!(!trial.core.has_control(), "the older release came again");
}

/// The revocation is damaged; the grant before it comes again, late. The vehicle does not tell its state.
#[test]
fn sr_001_an_older_grant_does_not_overrule_a_damaged_revocation() {
    let mut trial = Trial::under_way();
    trial.vehicle.replays = false;
    let granted = BackseatControl {
        created: trial.vehicle.clock(trial.now),
        granted: true,
    };
    trial.hear_now([granted.clone().into()]);
    trial.run_for(2.0);
    trial.vehicle.control = false;
    trial.hear_bytes(DAMAGED);
    assert!(!trial.core.has_control());
    trial.run_for(1.0);
    trial.hear_now([granted.into()]);
    trial.run_for(0.5);
    assert!(!trial.core.has_control(), "the older grant came again");
}

/// An older BFMIS comes again after a newer one that says that the mission is over.
#[test]
fn sr_001_an_older_status_does_not_overrule_a_newer_one_that_ends_the_mission() {
    let mut trial = Trial::steering();
    let status = |trial: &Trial, status: &str| backseat_spi::MissionStatus {
        created: trial.vehicle.clock(trial.now),
        dive_file: Text::cleaned("survey.dive"),
        status: Text::cleaned(status),
        details: Text::cleaned(""),
    };
    let running = status(&trial, "Running");
    trial.hear_now([running.clone().into()]);
    trial.run_for(2.0);
    let over = status(&trial, "Completed");
    trial.hear_now([over.into()]);
    assert!(!trial.core.has_control());
    trial.run_for(0.5);
    trial.hear_now([running.into()]);
    trial.run_for(2.0);
    assert!(!trial.core.has_control(), "the older status came again");
}

/// The answer to the first cancel is lost, and the second is refused because the insert is gone.
#[test]
fn sr_009_a_cancelled_insert_whose_answer_was_lost_is_over_once_the_plan_lacks_it() {
    let mut trial = Trial::under_way();
    trial.ask(0, [crate::course::good_line(2)]);
    trial.run_for(1.0);
    assert_eq!(trial.core.open_requests(), 1);
    trial.vehicle.replies.insert("RCN", crate::vehicle::Reply::Silent);
    trial.ask(0, [Request::Cancel(2)]);
    trial.run_for(2.5);
    trial.vehicle.inserted.clear();
    trial.vehicle.replies.insert("RCN", crate::vehicle::Reply::Refuse);
    trial.ask(0, [Request::Cancel(2)]);
    trial.run_for(200.0);
    let now = trial.now;
    trial.vehicle.begin(now, Some(2), None);
    trial.run_for(200.0);
    assert_eq!(trial.core.open_requests(), 0, "{:?}", trial.core.open_request_states());
}

/// The vehicle refuses an insert, and accepts it after all; that answer is lost. Its plan names the insert.
#[test]
fn sr_009_a_refused_insert_that_the_plan_names_is_cancelled() {
    let mut trial = Trial::under_way();
    trial.vehicle.replies.insert("RTK", crate::vehicle::Reply::Refuse);
    trial.ask(0, [crate::course::good_line(2)]);
    trial.run_for(1.0);
    assert_eq!(trial.core.open_requests(), 0);
    let at = trial.now;
    trial.vehicle.inserted.insert(1);
    let now = trial.now;
    trial.vehicle.set_status(now, "Paused");
    trial.run_for(1.0);
    let now = trial.now;
    trial.vehicle.set_status(now, "Running");
    trial.run_for(5.0);
    assert!(trial.core.has_control());
    assert!(!trial.sent_since("RCN", at).is_empty(), "it is not called back");
}

/// The same with inserts that interrupt. The refused one cannot be cancelled, because it has begun.
#[test]
fn sr_010_nothing_interrupts_beside_a_refused_insert_that_the_plan_names() {
    let mut trial = Trial::under_way();
    trial.vehicle.replies.insert("RTK", crate::vehicle::Reply::Refuse);
    trial.ask(0, [crate::course::interrupting(2)]);
    trial.run_for(1.5);
    assert_eq!(
        (trial.sent("RTK").len(), trial.core.open_requests()),
        (1, 0),
        "{:?}",
        trial.states(2)
    );
    trial.vehicle.replies.remove("RTK");
    trial.vehicle.replies.insert("RCN", crate::vehicle::Reply::Refuse);
    // The vehicle has it all the same: it is queued, and the plan names it.
    trial.vehicle.inserted.insert(1);
    let now = trial.now;
    trial.vehicle.begin(now, Some(9), None);
    trial.run_for(1.0);
    let now = trial.now;
    trial.vehicle.begin(now, Some(1), None);
    trial.run_for(2.0);
    trial.ask(0, [crate::course::interrupting(3)]);
    trial.run_for(2.0);
    assert_eq!(trial.sent("RTK").len(), 1, "{:?}", trial.states(3));
}

/// A BFMBS of the dive before comes after the BFMIS of the new one.
#[test]
fn sr_025_a_late_begin_of_the_dive_before_is_not_one_of_the_new_dive() {
    let mut trial = Trial::under_way();
    let status = |trial: &Trial, file: &str| backseat_spi::MissionStatus {
        created: trial.vehicle.clock(trial.now),
        dive_file: Text::cleaned(file),
        status: Text::cleaned("Running"),
        details: Text::cleaned(""),
    };
    let begin = |trial: &Trial, file: &str, number| backseat_spi::BehaviorBegin {
        created: trial.vehicle.clock(trial.now),
        dive_file: Text::cleaned(file),
        number: Some(number),
        identifier: None,
        kind: Text::cleaned("trackline"),
    };
    let old = begin(&trial, "survey.dive", 1);
    trial.hear_now([old.clone().into()]);
    trial.run_for(1.0);
    let other = status(&trial, "other.dive");
    trial.hear_now([other.into()]);
    trial.hear_now([old.into()]);
    trial.run_for(3.0);
    trial.ask(0, [Request::Modify(modify(1))]);
    trial.run_for(1.0);
    assert!(
        !trial.core.is_steering(),
        "nobody heard a behavior of the new dive begin"
    );
}

/// For comparison.
#[test]
fn nothing_steers_in_a_new_dive_before_a_behavior_begins() {
    let mut trial = Trial::under_way();
    let other = backseat_spi::MissionStatus {
        created: trial.vehicle.clock(trial.now),
        dive_file: Text::cleaned("other.dive"),
        status: Text::cleaned("Running"),
        details: Text::cleaned(""),
    };
    trial.hear_now([other.into()]);
    trial.run_for(3.0);
    trial.ask(0, [Request::Modify(modify(1))]);
    trial.run_for(1.0);
    assert!(!trial.core.is_steering());
}

/// Refused, then pending: the cancel is refused because the vehicle has not decided. It is not repeated.
#[test]
fn sr_009_the_cancel_of_an_insert_accepted_after_its_refusal_is_repeated() {
    let mut trial = Trial::under_way();
    trial.vehicle.replies.insert("RTK", crate::vehicle::Reply::Refuse);
    trial.vehicle.replies.insert("RCN", crate::vehicle::Reply::Refuse);
    trial.ask(0, [crate::course::good_line(2)]);
    trial.run_for(0.5);
    let backseat_spi::ToVehicle::Trackline(line) = trial.commands("RTK").pop().unwrap().1 else {
        panic!()
    };
    let at = trial.now;
    let ack = |status| ("RTK", line.created, Some(1), status);
    trial.vehicle.acknowledge(at, ack(AckStatus::Pending));
    trial.run_for(0.5);
    let now = trial.now;
    trial.vehicle.replies.remove("RCN");
    trial.vehicle.acknowledge(now, ack(AckStatus::Succeeded));
    trial.vehicle.inserted.insert(1);
    trial.run_for(60.0);
    assert!(
        trial.sent_since("RCN", at).len() > 1,
        "{:?}",
        trial.notes().into_iter().rev().take(4).collect::<Vec<_>>()
    );
    assert!(trial.vehicle.inserted.is_empty());
}

/// The runtime's cancel under the hold: its first answer is lost, the second one is a refusal.
#[test]
fn sr_009_an_insert_cancelled_by_the_hold_is_over_once_the_plan_lacks_it() {
    let mut trial = Trial::under_way();
    trial.ask(0, [crate::course::good_line(2)]);
    trial.run_for(1.0);
    trial.vehicle.replies.insert("RCN", crate::vehicle::Reply::Silent);
    trial.operator(backseat_core::Operator::Hold);
    trial.run_for(1.0);
    trial.vehicle.inserted.clear();
    trial.vehicle.replies.insert("RCN", crate::vehicle::Reply::Refuse);
    trial.run_for(10.0);
    trial.operator(backseat_core::Operator::Release);
    trial.run_for(100.0);
    let now = trial.now;
    trial.vehicle.begin(now, Some(2), None);
    trial.run_for(100.0);
    assert_eq!(trial.core.open_requests(), 0, "{:?}", trial.core.open_request_states());
}
