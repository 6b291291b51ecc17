//! An insert that was cancelled, or that the plan lacks, may no longer come before the next one, whatever became of the
//! answer.

use backseat_core::plugin::Request;
use backseat_core::{Operator, Order};

use crate::course::line;
use crate::trial::Trial;
use crate::vehicle::Reply;

/// How many inserts leave, if this happens before the second one is asked for.
fn asked_after(lose: impl FnOnce(&mut Trial)) -> usize {
    // The wreck bars the way from the leg to the start of the second insert, but not the way from the end of the first.
    let first = Request::Trackline(line(1, (800.0, -300.0), (800.0, -1500.0)));
    let second = Request::Trackline(line(2, (0.0, -1500.0), (500.0, -1500.0)));
    let mut trial = Trial::under_way();
    trial.ask(0, [first]);
    trial.run_for(0.5);
    assert_eq!((trial.sent("RTK").len(), trial.core.open_requests()), (1, 1));
    lose(&mut trial);
    assert!(trial.core.has_control(), "{:?}", trial.core.uncontrolled());
    trial.ask(0, [second]);
    trial.run_for(0.5);
    trial.sent("RTK").len()
}

/// For comparison.
#[test]
fn a_waiting_insert_comes_before_the_next_one() {
    assert_eq!(asked_after(|_| {}), 2);
}

/// The vehicle has cancelled the first insert, and its answer is lost.
#[test]
fn sr_002_after_a_plugins_cancel_that_was_not_answered() {
    let left = asked_after(|trial| {
        trial.vehicle.replies.insert("RCN", Reply::Silent);
        trial.ask(0, [Request::Cancel(1)]);
        trial.run_for(3.0);
        trial.vehicle.inserted.clear();
    });
    assert_eq!(left, 1);
}

/// The link is lost with the answer. The plan of the next connection does not name the insert.
#[test]
fn sr_002_after_a_cancel_whose_answer_was_lost_with_the_link() {
    let left = asked_after(|trial| {
        trial.vehicle.replies.insert("RCN", Reply::Silent);
        trial.ask(0, [Request::Cancel(1)]);
        trial.run_for(0.1);
        trial.vehicle.inserted.clear();
        trial.cut();
        trial.run_for(20.0);
    });
    assert_eq!(left, 1);
}

/// The hold's five cancels are done, and no answer comes.
#[test]
fn sr_002_after_the_unanswered_cancels_of_a_hold() {
    let left = asked_after(|trial| {
        trial.vehicle.replies.insert("RCN", Reply::Silent);
        trial.operator(Operator::Hold);
        trial.run_for(3.0);
        trial.vehicle.inserted.clear();
        trial.run_for(60.0);
        trial.operator(Operator::Release);
        trial.run_for(1.0);
    });
    assert_eq!(left, 1);
}

/// A complete plan without the insert: another payload has cancelled all (BPRCA).
#[test]
fn sr_002_after_a_plan_that_no_longer_names_the_insert() {
    let left = asked_after(|trial| {
        trial.run_for(5.0);
        trial.vehicle.inserted.clear();
        let now = trial.now;
        trial.vehicle.begin(now, Some(9), None);
        trial.run_for(1.0);
        let now = trial.now;
        trial.vehicle.begin(now, Some(1), None);
        trial.run_for(2.0);
        assert_eq!(trial.sent("RMP").len(), 3);
    });
    assert_eq!(left, 1);
}

/// The operator's BPRCA is done, and its answer is lost.
#[test]
fn sr_002_after_a_cancel_of_all_that_was_not_answered() {
    let left = asked_after(|trial| {
        trial.vehicle.replies.insert("RCA", Reply::Silent);
        trial.operator(Operator::Order(Order::CancelAll));
        trial.run_for(3.0);
        assert_eq!(trial.sent("RCA").len(), 1);
        trial.vehicle.inserted.clear();
    });
    assert_eq!(left, 1);
}
