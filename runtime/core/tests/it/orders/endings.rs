//! Abort and kill.

use std::time::Duration;

use backseat_core::plugin::{EndCause, Ended};
use backseat_core::plugin::{Request, RequestState};
use backseat_core::{Operator, Order, RequestKind};
use backseat_spi::AckStatus;

use super::{abort, kill, order, rejection, states, unarmed, wire};
use crate::course::{good_line, modify};
use crate::trial::{Trial, shorts};
use crate::vehicle::Reply;

#[test]
fn an_abort_ends_the_lease_first_and_takes_the_helm_from_the_plugins() {
    let mut trial = Trial::steering();
    let at = trial.now;
    trial.script(1, |_| {
        (
            Duration::from_millis(1),
            Ok(vec![Request::Modify(modify(9)), good_line(8)]),
        )
    });
    order(&mut trial, abort());
    assert_eq!(trial.names_since(at), ["EMB", "ABT"]);
    trial.run_for(5.0);
    assert_eq!(
        shorts(&states(&trial, RequestKind::Abort)),
        ["sent", "accepted", "ended"]
    );
    assert_eq!(wire(&trial.commands("ABT")[0].1), "$BPABT,leak  in bay 2 rmb,1");
    assert!(trial.sent_since("RMB", at).is_empty() && trial.sent_since("RTK", at).is_empty());
    // The mission is over, and the abort does not affect the next one.
    let now = trial.now;
    trial.vehicle.set_status(now, "Aborted");
    trial.run_for(1.0);
    let now = trial.now;
    trial.vehicle.set_status(now, "Running");
    trial.run_for(2.0);
    assert!(trial.core.has_control());
    assert_eq!(trial.commands("ABT").len(), 1);
}

#[test]
fn a_kill_and_a_successful_end_are_encoded_as_ordered() {
    let mut trial = Trial::under_way();
    order(&mut trial, kill());
    order(
        &mut trial,
        Order::Abort {
            text: "done".to_owned(),
            errors: false,
        },
    );
    trial.run_for(1.0);
    assert_eq!(wire(&trial.commands("KIL")[0].1), "$BPKIL,nets");
    assert_eq!(wire(&trial.commands("ABT")[0].1), "$BPABT,done,0");
    assert_eq!(trial.core.open_requests(), 0);
}

#[test]
fn sr_014_an_abort_needs_no_control_but_an_armed_runtime() {
    let mut trial = Trial::under_way();
    trial.operator(Operator::Hold);
    let now = trial.now;
    trial.vehicle.set_control(now, false);
    trial.vehicle.navigates = false;
    trial.run_for(3.0);
    order(&mut trial, abort());
    trial.run_for(1.0);
    assert_eq!(trial.commands("ABT").len(), 1);

    let mut trial = Trial::with(unarmed());
    trial.run_for(2.0);
    for (made, kind) in [
        (abort(), RequestKind::Abort),
        (kill(), RequestKind::Kill),
        (Order::CancelAll, RequestKind::CancelAll),
        (Order::CancelCurrent, RequestKind::CancelCurrent),
        (Order::CancelElement, RequestKind::CancelElement),
        (
            Order::StartEmptyMission { duration_s: 60 },
            RequestKind::StartEmptyMission,
        ),
    ] {
        order(&mut trial, made);
        assert_eq!(rejection(&trial, kind), "control: the runtime is not armed");
    }
    trial.run_for(2.0);
    for name in ["ABT", "KIL", "RCA", "RCB", "RCE", "SEM"] {
        assert!(trial.commands(name).is_empty(), "{name}");
    }
}

#[test]
fn an_unanswered_abort_is_sent_five_times_with_a_new_time_each_and_a_refused_one_once() {
    let mut trial = Trial::under_way();
    trial.vehicle.replies.insert("ABT", Reply::Silent);
    let at = trial.now;
    order(&mut trial, abort());
    order(&mut trial, abort());
    assert!(rejection(&trial, RequestKind::Abort).contains("already under way"));
    trial.run_for(20.0);
    let sent: Vec<Duration> = trial.sent("ABT").iter().map(|sent| sent.since(at)).collect();
    assert_eq!(sent, (0..5).map(Duration::from_secs).collect::<Vec<_>>());
    let mut stamps: Vec<_> = trial
        .commands("ABT")
        .iter()
        .map(|(_, command)| command.created())
        .collect();
    stamps.dedup();
    assert_eq!(stamps.len(), 5);
    assert_eq!(states(&trial, RequestKind::Abort).last(), Some(&RequestState::TimedOut));
    // The plugins still stay without control until the operator releases them.
    assert!(!trial.core.has_control());
    trial.operator(Operator::Release);
    assert!(trial.core.has_control());

    let mut trial = Trial::under_way();
    trial.vehicle.replies.insert("ABT", Reply::Refuse);
    order(&mut trial, abort());
    trial.run_for(10.0);
    assert_eq!(trial.commands("ABT").len(), 1);
    assert_eq!(shorts(&states(&trial, RequestKind::Abort)), ["sent", "failed"]);
    assert!(!trial.core.has_control());
}

#[test]
fn an_abort_is_not_sent_again_once_the_vehicle_reports_that_its_mission_is_ending() {
    let mut trial = Trial::under_way();
    trial.vehicle.replies.insert("ABT", Reply::Silent);
    trial.vehicle.replies.insert("KIL", Reply::Silent);
    order(&mut trial, abort());
    trial.run_for(0.5);
    let now = trial.now;
    trial.vehicle.set_status(now, "Aborting");
    trial.run_for(0.2);
    assert_eq!(
        states(&trial, RequestKind::Abort).last(),
        Some(&RequestState::Ended(Ended::Said(
            EndCause::MissionIs,
            "Aborting".to_owned()
        )))
    );
    // A vehicle that wraps up still moves, so core repeats a kill until the vehicle has stopped.
    order(&mut trial, kill());
    trial.run_for(2.5);
    assert_eq!((trial.commands("ABT").len(), trial.commands("KIL").len()), (1, 3));
    let now = trial.now;
    trial.vehicle.set_status(now, "Stopped");
    trial.run_for(5.0);
    assert_eq!(trial.commands("KIL").len(), 3);
    assert_eq!(trial.core.open_requests(), 0);
}

#[test]
fn a_kill_replaces_an_unanswered_abort() {
    let mut trial = Trial::under_way();
    trial.vehicle.replies.insert("ABT", Reply::Silent);
    order(&mut trial, abort());
    trial.run_for(0.5);
    order(&mut trial, kill());
    trial.run_for(10.0);
    assert_eq!((trial.commands("ABT").len(), trial.commands("KIL").len()), (1, 1));
    assert_eq!(shorts(&states(&trial, RequestKind::Abort)), ["sent", "timed out"]);

    // The same holds while nothing can be sent.
    let mut trial = Trial::under_way();
    trial.unreachable = true;
    trial.cut();
    order(&mut trial, abort());
    order(&mut trial, kill());
    trial.unreachable = false;
    trial.run_for(15.0);
    assert_eq!((trial.commands("ABT").len(), trial.commands("KIL").len()), (0, 1));
    assert_eq!(trial.core.open_requests(), 0);
}

#[test]
fn an_abort_without_a_link_is_kept_for_two_minutes_and_no_longer() {
    for (seconds, sent) in [(100.0, 1), (130.0, 0)] {
        let mut trial = Trial::under_way();
        trial.unreachable = true;
        trial.cut();
        order(&mut trial, abort());
        trial.run_for(seconds);
        trial.unreachable = false;
        trial.run_for(30.0);
        assert_eq!(trial.commands("ABT").len(), sent, "{seconds} s");
        assert_eq!(trial.core.open_requests(), 0);
        if sent == 0 {
            assert!(rejection(&trial, RequestKind::Abort).contains("give the order again"));
        } else {
            let up = trial.names_since(trial.sent("VER").last().copied().unwrap());
            let acks = up.iter().position(|name| *name == "LOG").unwrap();
            let abort = up.iter().position(|name| *name == "ABT").unwrap();
            assert!(acks < abort && !up[..abort].contains(&"RMB"));
        }
    }
}

#[test]
fn sr_009_an_abort_whose_answer_was_lost_with_the_link_is_sent_again_when_it_is_back() {
    let mut trial = Trial::under_way();
    trial.vehicle.replies.insert("ABT", Reply::Silent);
    order(&mut trial, abort());
    trial.run_for(0.5);
    trial.vehicle.replies.clear();
    trial.cut();
    trial.run_for(5.0);
    assert_eq!(trial.commands("ABT").len(), 2);
    assert_eq!(
        shorts(&states(&trial, RequestKind::Abort)),
        ["sent", "unknown", "accepted", "ended"]
    );

    let mut trial = Trial::under_way();
    trial.vehicle.replies.insert("ABT", Reply::Silent);
    order(&mut trial, abort());
    trial.run_for(0.5);
    trial.unreachable = true;
    trial.cut();
    trial.run_for(200.0);
    assert_eq!(
        shorts(&states(&trial, RequestKind::Abort)),
        ["sent", "unknown", "timed out"]
    );
    trial.unreachable = false;
    trial.run_for(30.0);
    assert_eq!(trial.commands("ABT").len(), 1);
}

#[test]
fn late_answers_to_an_abort_change_nothing() {
    let mut trial = Trial::under_way();
    trial
        .vehicle
        .replies
        .insert("ABT", Reply::Late(Duration::from_millis(2500), AckStatus::Failed));
    order(&mut trial, abort());
    trial.run_for(1.2);
    trial.vehicle.replies.clear();
    trial.run_for(10.0);
    // The first two were answered too late, the third in time.
    assert_eq!(trial.commands("ABT").len(), 3);
    assert_eq!(
        shorts(&states(&trial, RequestKind::Abort)),
        ["sent", "accepted", "ended"]
    );
}
