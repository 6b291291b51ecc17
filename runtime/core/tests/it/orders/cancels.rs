//! Cancels that only the operator may order.

use backseat_core::plugin::Request;
use backseat_core::{Operator, Order, RequestKind};
use backseat_spi::AckStatus;

use super::{order, rejection, states, wire};
use crate::course::{good_line, interrupting, line};
use crate::scene::{begins, refused_for};
use crate::trial::{Trial, shorts};
use crate::vehicle::Reply;

#[test]
fn a_cancel_of_all_cancels_our_inserts_that_have_not_begun_and_asks_for_the_plan() {
    let mut trial = Trial::under_way();
    trial.ask(0, [good_line(11), good_line(12)]);
    trial.run_for(0.5);
    let now = trial.now;
    trial.vehicle.begin(now, None, Some(1));
    trial.run_for(0.3);
    let plans = trial.commands("RMP").len();
    order(&mut trial, Order::CancelAll);
    trial.run_for(0.5);
    assert_eq!(wire(&trial.commands("RCA")[0].1), "$BPRCA");
    assert_eq!(
        shorts(&states(&trial, RequestKind::CancelAll)),
        ["sent", "accepted", "ended"]
    );
    assert_eq!(shorts(&trial.states(11)).last(), Some(&"started"));
    assert_eq!(shorts(&trial.states(12)).last(), Some(&"cancelled"));
    assert_eq!(trial.commands("RMP").len(), plans + 1);
}

#[test]
fn a_refused_unanswered_or_lost_cancel_of_all_leaves_the_inserts() {
    for (reply, end) in [(Reply::Refuse, "failed"), (Reply::Silent, "timed out")] {
        for lost in [false, true] {
            let mut trial = Trial::under_way();
            trial.ask(0, [good_line(11)]);
            trial.run_for(0.5);
            trial
                .vehicle
                .replies
                .insert("RCA", if lost { Reply::Silent } else { reply });
            order(&mut trial, Order::CancelAll);
            trial.run_for(0.5);
            if lost {
                trial.cut();
            }
            trial.run_for(4.0);
            let end = if lost { "timed out" } else { end };
            assert_eq!(shorts(&states(&trial, RequestKind::CancelAll)), ["sent", end]);
            assert_eq!(shorts(&trial.states(11)), ["sent", "accepted"]);
            assert_eq!(trial.commands("RCA").len(), 1);
        }
    }
}

#[test]
fn sr_010_a_cancel_of_all_does_not_end_an_unanswered_insert_that_may_be_flown() {
    let mut trial = Trial::under_way();
    trial.vehicle.replies.insert("RTK", Reply::Silent);
    // The insert has begun, and can no longer be cancelled by its identifier (SPI 7.8).
    trial.vehicle.replies.insert("RCN", Reply::Refuse);
    trial.ask(0, [interrupting(11)]);
    trial.run_for(5.0);
    trial.vehicle.replies.remove("RTK");
    order(&mut trial, Order::CancelAll);
    trial.run_for(1.0);
    assert_eq!(
        shorts(&states(&trial, RequestKind::CancelAll)),
        ["sent", "accepted", "ended"]
    );
    refused_for(&mut trial, interrupting(12), 12, "interrupt");
    // The insert now neither waits nor is flown.
    begins(&mut trial, Some(2), None);
    trial.ask(0, [interrupting(13)]);
    trial.run_for(0.5);
    assert_eq!(
        shorts(&trial.states(13)),
        ["sent", "accepted"],
        "{:?}",
        trial.states(13)
    );
}

#[test]
fn sr_010_a_cancel_of_all_does_not_end_an_interrupting_insert_whose_begin_was_not_heard() {
    for flown in [true, false] {
        let mut trial = Trial::under_way();
        trial.ask(0, [interrupting(11)]);
        trial.run_for(0.5);
        // The insert begins when it is accepted (SPI 7.5), and the BFMBS of that was lost.
        assert_eq!(shorts(&trial.states(11)), ["sent", "accepted"]);
        if !flown {
            trial.vehicle.inserted.remove(&1);
        }
        order(&mut trial, Order::CancelAll);
        trial.run_for(5.0);
        assert_eq!(
            shorts(&states(&trial, RequestKind::CancelAll)),
            ["sent", "accepted", "ended"]
        );
        if flown {
            assert_eq!(shorts(&trial.states(11)), ["sent", "accepted", "unknown", "accepted"]);
            refused_for(&mut trial, interrupting(12), 12, "interrupt");
        } else {
            assert_eq!(shorts(&trial.states(11)), ["sent", "accepted", "unknown", "failed"]);
            trial.ask(0, [interrupting(13)]);
            trial.run_for(0.5);
            assert_eq!(shorts(&trial.states(13)), ["sent", "accepted"]);
        }
    }
}

#[test]
fn cancels_need_control() {
    for prepare in [
        |trial: &mut Trial| trial.operator(Operator::Hold),
        |trial: &mut Trial| trial.cut(),
        |trial: &mut Trial| trial.vehicle.navigates = false,
    ] {
        let mut trial = Trial::under_way();
        prepare(&mut trial);
        trial.unreachable = true;
        trial.run_for(3.0);
        for (made, kind) in [
            (Order::CancelAll, RequestKind::CancelAll),
            (Order::CancelCurrent, RequestKind::CancelCurrent),
            (Order::CancelElement, RequestKind::CancelElement),
        ] {
            order(&mut trial, made);
            assert!(rejection(&trial, kind).starts_with("control: "), "{kind:?}");
        }
    }
}

#[test]
fn the_current_behavior_is_cancelled_only_if_it_is_our_insert() {
    let mut trial = Trial::under_way();
    let attempt = |trial: &mut Trial| {
        order(trial, Order::CancelCurrent);
        trial.run_for(0.3);
        trial.commands("RCB").len()
    };
    assert_eq!(attempt(&mut trial), 0, "a planned behavior is current");
    assert!(rejection(&trial, RequestKind::CancelCurrent).contains("not known to be an insert of ours"));
    trial.ask(0, [interrupting(11)]);
    trial.run_for(0.3);
    let now = trial.now;
    trial.vehicle.begin(now, None, Some(4_000_000));
    trial.run_for(0.2);
    assert_eq!(attempt(&mut trial), 0, "another payload's");
    assert!(rejection(&trial, RequestKind::CancelCurrent).contains("not ours"));
    let now = trial.now;
    trial.vehicle.begin(now, None, Some(1));
    trial.run_for(0.2);
    assert_eq!(attempt(&mut trial), 1);
    assert_eq!(wire(&trial.commands("RCB")[0].1), "$BPRCB,0");
    assert_eq!(
        shorts(&states(&trial, RequestKind::CancelCurrent)[2..]),
        ["sent", "accepted", "ended"]
    );
    assert_eq!(shorts(&trial.states(11)).last(), Some(&"started"), "its BFMBE ends it");
    let now = trial.now;
    trial.vehicle.end(now, None, Some(1));
    trial.run_for(0.2);
    assert_eq!(shorts(&trial.states(11)).last(), Some(&"ended"));
    assert_eq!(attempt(&mut trial), 1, "it has ended");
}

#[test]
fn the_current_behavior_is_unknown_after_a_reconnect() {
    let mut trial = Trial::under_way();
    trial.ask(0, [interrupting(11)]);
    trial.run_for(0.3);
    let now = trial.now;
    trial.vehicle.begin(now, None, Some(1));
    trial.run_for(0.2);
    trial.cut();
    trial.run_for(3.0);
    order(&mut trial, Order::CancelCurrent);
    assert!(rejection(&trial, RequestKind::CancelCurrent).contains("not known to be an insert of ours"));
}

#[test]
fn sr_002_sr_020_the_way_from_a_cancelled_behavior_to_the_next_one_is_checked() {
    // The vehicle is north of the wreck. The first of the two next inserts begins south of it.
    for (next_start, clear) in [((0.0, -1400.0), false), ((900.0, -400.0), true)] {
        let mut trial = Trial::new();
        trial.vehicle.start = backseat_units::EastNorth::new(-10.0, -600.0);
        trial.run_for(2.0);
        let (east_m, north_m) = next_start;
        trial.ask(
            0,
            [
                Request::Trackline(line(11, (900.0, -500.0), (1200.0, -500.0))),
                Request::Trackline(line(12, (1200.0, -700.0), (1200.0, -1000.0))),
            ],
        );
        trial.run_for(0.3);
        trial.ask(
            0,
            [
                Request::Trackline(line(13, (east_m + 60.0, north_m), (east_m + 160.0, north_m))),
                Request::Cancel(12),
            ],
        );
        trial.run_for(0.3);
        assert_eq!(
            shorts(&trial.states(13)),
            ["sent", "accepted"],
            "{:?}",
            trial.states(13)
        );
        let now = trial.now;
        trial.vehicle.begin(now, None, Some(1));
        trial.run_for(0.2);
        order(&mut trial, Order::CancelCurrent);
        if clear {
            assert_eq!(shorts(&states(&trial, RequestKind::CancelCurrent))[0], "sent");
        } else {
            let text = rejection(&trial, RequestKind::CancelCurrent);
            assert!(text.starts_with("keep-out: inside keep-out zone 'wreck'"), "{text}");
            assert!(trial.commands("RCB").is_empty());
        }
    }
}

#[test]
fn a_cancel_of_the_element_is_sent_as_ordered() {
    for (reply, end) in [
        (Reply::Ok, "ended"),
        (Reply::Refuse, "failed"),
        (Reply::Silent, "timed out"),
    ] {
        let mut trial = Trial::under_way();
        trial.vehicle.replies.insert("RCE", reply);
        order(&mut trial, Order::CancelElement);
        trial.run_for(4.0);
        assert_eq!(wire(&trial.commands("RCE")[0].1), "$BPRCE,0");
        assert_eq!(shorts(&states(&trial, RequestKind::CancelElement)).last(), Some(&end));
    }
}

#[test]
fn an_answer_on_a_new_connection_does_not_belong_to_an_old_cancel() {
    let mut trial = Trial::under_way();
    trial.vehicle.replies.insert("RCE", Reply::Silent);
    order(&mut trial, Order::CancelElement);
    trial.run_for(0.2);
    let asked = trial.commands("RCE")[0].1.created().unwrap();
    trial.cut();
    trial.run_for(5.0);
    let now = trial.now;
    trial
        .vehicle
        .acknowledge(now, ("RCE", asked, None, AckStatus::Succeeded));
    trial.run_for(1.0);
    assert_eq!(
        shorts(&states(&trial, RequestKind::CancelElement)),
        ["sent", "timed out"]
    );
    assert_eq!(trial.commands("RCE").len(), 1);
}
