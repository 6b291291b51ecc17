//! The start of an empty mission.

use backseat_core::{Operator, Order, RequestKind};

use super::{order, rejection, states, wire};
use crate::trial::{Trial, shorts};
use crate::vehicle::Reply;

fn ready() -> Trial {
    let mut trial = Trial::new();
    trial.vehicle.status = "Ready";
    trial.run_for(2.0);
    trial
}

#[test]
fn an_order_to_start_an_empty_mission_ends_when_bfmis_says_running() {
    for (duration_s, said) in [
        (5400, "90,1"),
        (7200, "2,0"),
        (45, "45,2"),
        (999_999_999, "999999999,2"),
    ] {
        let mut trial = ready();
        order(&mut trial, Order::StartEmptyMission { duration_s });
        trial.run_for(1.0);
        assert_eq!(wire(&trial.commands("SEM")[0].1), format!("$BPSEM,{said}"));
        assert_eq!(
            shorts(&states(&trial, RequestKind::StartEmptyMission)),
            ["sent", "accepted"]
        );
        let now = trial.now;
        trial.vehicle.set_status(now, "Running");
        trial.run_for(2.0);
        assert_eq!(
            shorts(&states(&trial, RequestKind::StartEmptyMission)),
            ["sent", "accepted", "started", "ended"]
        );
        trial.run_for(60.0);
        assert!(trial.core.has_control());
        assert_eq!(trial.core.open_requests(), 0);
    }
}

#[test]
fn every_order_to_start_an_empty_mission_gets_its_outcome() {
    let ends = |reply: Option<Reply>, cut: bool, status: Option<&'static str>| {
        let mut trial = ready();
        if let Some(reply) = reply {
            trial.vehicle.replies.insert("SEM", reply);
        }
        order(&mut trial, Order::StartEmptyMission { duration_s: 60 });
        trial.run_for(0.5);
        if cut {
            if let Some(status) = status {
                trial.vehicle.status = status;
            }
            trial.cut();
        }
        trial.run_for(40.0);
        assert_eq!(trial.core.open_requests(), 0);
        assert_eq!(trial.commands("SEM").len(), 1);
        shorts(&states(&trial, RequestKind::StartEmptyMission)).split_off(1)
    };
    assert_eq!(ends(Some(Reply::Refuse), false, None), ["failed"]);
    assert_eq!(ends(Some(Reply::Silent), false, None), ["timed out"]);
    assert_eq!(ends(None, false, None), ["accepted", "timed out"]);
    assert_eq!(ends(Some(Reply::Silent), true, None), ["unknown", "timed out"]);
    assert_eq!(
        ends(Some(Reply::Silent), true, Some("Running")),
        ["unknown", "started", "ended"]
    );
    assert_eq!(ends(None, true, Some("Running")), ["accepted", "started", "ended"]);
}

#[test]
fn an_empty_mission_needs_a_link_a_duration_no_running_mission_and_no_hold() {
    let rejected = |trial: &mut Trial, duration_s| {
        order(trial, Order::StartEmptyMission { duration_s });
        rejection(trial, RequestKind::StartEmptyMission)
    };
    assert!(rejected(&mut Trial::under_way(), 60).contains("a mission is running"));
    assert!(rejected(&mut ready(), 0).contains("duration of the empty mission is 0; expected at least 1 s"));
    assert!(rejected(&mut Trial::new(), 60).contains("the link is down"));
    let mut held = ready();
    held.operator(Operator::Hold);
    assert!(rejected(&mut held, 60).contains("the operator's hold is set"));
    let mut ending = ready();
    let now = ending.now;
    ending.vehicle.set_status(now, "WrappingUp");
    ending.run_for(0.5);
    assert!(rejected(&mut ending, 60).contains("a mission is ending"));
    let now = ending.now;
    ending.vehicle.set_status(now, " ");
    ending.run_for(0.5);
    assert!(rejected(&mut ending, 60).contains("has not said whether a mission runs"));
    let mut silent = Trial::new();
    silent.vehicle.replays = false;
    silent.run_for(2.0);
    assert!(rejected(&mut silent, 60).contains("has not said whether a mission runs"));
    let mut twice = ready();
    order(&mut twice, Order::StartEmptyMission { duration_s: 60 });
    assert!(rejected(&mut twice, 60).contains("already being started"));
}
