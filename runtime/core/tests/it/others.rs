//! The ways to and from inserts that are not ours, that were refused, or that were not answered.

use backseat_core::plugin::Request;
use backseat_units::EastNorth;

use crate::course::{line, turn};
use crate::scene::{accepted, at_once, begins, ends, hands_over, outage};
use crate::trial::Trial;
use crate::vehicle::Reply;
use crate::ways::{fate, put, refused, wreck};

/// Another payload's insert has interrupted ours, and a new one comes after it.
#[test]
fn sr_002_the_way_from_another_payloads_insert_that_interrupts_ours_is_checked() {
    let flown = |ours: bool| {
        let mut trial = Trial::under_way();
        if ours {
            accepted(
                &mut trial,
                Request::Trackline(line(1, (300.0, 500.0), (600.0, 500.0))),
                1,
            );
            ends(&mut trial, Some(1), None);
            begins(&mut trial, None, Some(1));
        }
        trial.vehicle.others = vec![(40, (0.0, -1500.0))];
        begins(&mut trial, None, Some(40));
        trial.run_for(3.0);
        let after = line(2, (0.0, -500.0), (300.0, -500.0));
        fate(&mut trial, Request::Trackline(after), 2)
    };
    wreck("without ours", &flown(false));
    wreck("with ours", &flown(true));
}

/// Another payload's insert comes after ours that waits, and a new one comes after both.
#[test]
fn sr_002_the_way_from_another_payloads_insert_beside_ours_is_checked() {
    let flown = |ours: bool| {
        let mut trial = Trial::under_way();
        if ours {
            accepted(
                &mut trial,
                Request::Trackline(line(1, (900.0, -600.0), (900.0, -300.0))),
                1,
            );
        }
        trial.vehicle.others = vec![(40, (0.0, -1500.0))];
        outage(&mut trial);
        begins(&mut trial, Some(1), None);
        trial.run_for(3.0);
        let after = line(2, (0.0, -500.0), (300.0, -500.0));
        fate(&mut trial, Request::Trackline(after), 2)
    };
    wreck("without ours", &flown(false));
    wreck("with ours", &flown(true));
}

/// Another payload's insert that the plan does not name ends anywhere.
#[test]
fn sr_002_no_insert_follows_another_payloads_that_the_plan_does_not_name() {
    let flown = |named: bool| {
        let mut trial = Trial::under_way();
        if named {
            trial.vehicle.others = vec![(40, (0.0, -1500.0))];
        }
        begins(&mut trial, None, Some(40));
        trial.run_for(5.0);
        let after = line(2, (0.0, -500.0), (300.0, -500.0));
        fate(&mut trial, Request::Trackline(after), 2)
    };
    wreck("named", &flown(true));
    refused("unnamed", &flown(false));
}

/// A refused insert is flown after all. A new one comes after it.
#[test]
fn sr_002_no_insert_follows_a_refused_one_that_is_flown() {
    let flown = |reply| {
        let mut trial = Trial::under_way();
        trial.vehicle.replies.insert("RTK", reply);
        trial.ask(0, [Request::Trackline(line(1, (900.0, -1500.0), (600.0, -1500.0)))]);
        trial.run_for(0.5);
        trial.vehicle.replies.remove("RTK");
        trial.vehicle.inserted.insert(1);
        ends(&mut trial, Some(1), None);
        begins(&mut trial, None, Some(1));
        trial.run_for(3.0);
        fate(
            &mut trial,
            Request::Trackline(line(2, (-600.0, -600.0), (-700.0, -600.0))),
            2,
        )
    };
    wreck("accepted", &flown(Reply::Ok));
    refused("refused", &flown(Reply::Refuse));
}

/// BFMBE of our insert, and then another payload's insert begins: ours may be interrupted.
#[test]
fn sr_002_an_insert_that_ends_before_another_payloads_begins_may_be_taken_up_again() {
    let flown = |said: bool| {
        let mut trial = Trial::under_way();
        accepted(
            &mut trial,
            Request::Trackline(line(1, (900.0, -1500.0), (900.0, -300.0))),
            1,
        );
        ends(&mut trial, Some(1), None);
        begins(&mut trial, None, Some(1));
        if said {
            ends(&mut trial, None, Some(1));
        }
        trial.vehicle.others = vec![(40, (-600.0, -300.0))];
        begins(&mut trial, None, Some(40));
        trial.run_for(5.0);
        fate(
            &mut trial,
            Request::Trackline(line(4, (-600.0, -600.0), (-700.0, -1000.0))),
            4,
        )
    };
    wreck("no BFMBE", &flown(false));
    wreck("BFMBE", &flown(true));
}

/// An insert that interrupts; another payload's waiting one is flown after it, and then the leg is taken up again.
#[test]
fn sr_002_the_way_back_from_another_payloads_waiting_insert_to_the_interrupted_leg_is_checked() {
    let flown = |ours: bool| {
        let mut trial = Trial::new();
        if !ours {
            trial.vehicle.others = vec![(40, (300.0, -1500.0))];
        }
        trial.vehicle.start = EastNorth::new(500.0, 0.0);
        trial.run_for(2.0);
        if ours {
            accepted(
                &mut trial,
                Request::Trackline(line(3, (1000.0, -1500.0), (300.0, -1500.0))),
                3,
            );
        }
        fate(&mut trial, at_once(line(1, (900.0, -900.0), (900.0, -1500.0))), 1)
    };
    wreck("ours", &flown(true));
    wreck("another payload's", &flown(false));
}

/// An insert that timed out is flown, and another payload's interrupts it.
#[test]
fn sr_002_an_unanswered_insert_that_is_interrupted_may_be_taken_up_again() {
    let flown = |answered: bool| {
        let mut trial = Trial::under_way();
        if !answered {
            trial.vehicle.replies.insert("RTK", Reply::Silent);
            trial.vehicle.replies.insert("RCN", Reply::Silent);
        }
        trial.ask(0, [Request::Trackline(line(1, (900.0, -1500.0), (900.0, -300.0)))]);
        trial.run_for(5.0);
        trial.vehicle.replies.remove("RTK");
        ends(&mut trial, Some(1), None);
        begins(&mut trial, None, Some(1));
        trial.vehicle.others = vec![(40, (-600.0, -300.0))];
        begins(&mut trial, None, Some(40));
        trial.run_for(5.0);
        fate(
            &mut trial,
            Request::Trackline(line(4, (-600.0, -600.0), (-700.0, -1000.0))),
            4,
        )
    };
    wreck("answered", &flown(true));
    wreck("unanswered", &flown(false));
}

/// An insert in doubt that the plan does not name has begun during an outage, and another payload's interrupts it.
#[test]
fn sr_002_an_insert_in_doubt_that_is_interrupted_may_be_taken_up_again() {
    let mut trial = Trial::under_way();
    trial.vehicle.replies.insert("RTK", Reply::Silent);
    trial.ask(0, [Request::Trackline(line(1, (900.0, -1500.0), (900.0, -300.0)))]);
    trial.run_for(0.2);
    trial.vehicle.replies.remove("RTK");
    trial.vehicle.replays = false;
    trial.cut();
    trial.run_for(1.0);
    hands_over(&mut trial);
    begins(&mut trial, None, Some(40));
    trial.run_for(8.0);
    refused(
        "in doubt",
        &fate(
            &mut trial,
            Request::Trackline(line(4, (-600.0, -600.0), (-700.0, -1000.0))),
            4,
        ),
    );
}

/// As above, but a modify while our next insert is flown.
#[test]
fn sr_002_a_modify_after_an_insert_that_another_payloads_may_have_interrupted() {
    let flown = |said: bool| {
        let mut trial = Trial::under_way();
        accepted(
            &mut trial,
            Request::Trackline(line(1, (900.0, -1500.0), (900.0, -300.0))),
            1,
        );
        ends(&mut trial, Some(1), None);
        begins(&mut trial, None, Some(1));
        accepted(
            &mut trial,
            Request::Trackline(line(2, (700.0, -500.0), (-700.0, -500.0))),
            2,
        );
        if said {
            ends(&mut trial, None, Some(1));
        }
        begins(&mut trial, None, Some(40));
        ends(&mut trial, None, Some(40));
        begins(&mut trial, None, Some(2));
        put(&mut trial, 270.0, -700.0, -1000.0);
        fate(&mut trial, turn(9, 270.0), 9)
    };
    // Here the second insert is called back when 40 begins.
    refused("no BFMBE", &flown(false));
    refused("BFMBE", &flown(true));
}
