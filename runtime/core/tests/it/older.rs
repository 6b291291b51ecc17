//! Begins that are older than a loss, and what the operator cancels while the vehicle has yet to decide.

use std::time::Duration;

use backseat_core::plugin::Request;
use backseat_core::{Operator, Order};
use backseat_spi::AckStatus;
use backseat_units::EastNorth;

use crate::course::{good_line, line, modify};
use crate::scene::{accepted, begin_of, begins, end_of, ends, tells_plan_of};
use crate::trial::{Trial, shorts};
use crate::unheard::damage;
use crate::vehicle::Reply;
use crate::ways::{fate, put, refused, wreck};

fn late_begin(lose: bool, late: bool) -> String {
    let mut trial = Trial::under_way();
    accepted(
        &mut trial,
        Request::Trackline(line(2, (900.0, -1500.0), (-900.0, -1500.0))),
        2,
    );
    let leg = begin_of(&trial, "", Some(2), None, "waypoint");
    if !late {
        trial.hear_now([leg.clone()]);
    }
    trial.run_for(0.5);
    if lose {
        trial.way = Some(Box::new(damage("BFMB", "")));
    }
    ends(&mut trial, Some(2), None);
    begins(&mut trial, None, Some(1));
    trial.way = None;
    trial.vehicle.inserted.remove(&1);
    if late {
        trial.hear_now([leg]);
    }
    put(&mut trial, 270.0, 300.0, -700.0);
    fate(&mut trial, Request::Modify(modify(9)), 9)
}

/// The begin of the leg comes 2 s late, after the begin of the insert was damaged.
#[test]
fn sr_002_a_first_begin_that_is_older_than_a_loss_does_not_show_what_is_flown() {
    wreck("heard", &late_begin(false, false));
    refused("lost", &late_begin(true, false));
    refused("late, not lost", &late_begin(false, true));
    refused("late and lost", &late_begin(true, true));
}

/// Our insert's begin comes late, after its end and the next leg's begin were damaged.
#[test]
fn sr_002_a_late_begin_of_our_insert_after_a_loss_does_not_show_that_it_is_flown() {
    let mut trial = Trial::under_way();
    accepted(
        &mut trial,
        Request::Trackline(line(2, (300.0, -500.0), (600.0, -500.0))),
        2,
    );
    let insert = begin_of(&trial, "", None, Some(1), "trackline");
    trial.run_for(0.5);
    trial.way = Some(Box::new(damage("BFMB", "")));
    ends(&mut trial, None, Some(1));
    begins(&mut trial, Some(2), None);
    trial.way = None;
    trial.vehicle.inserted.remove(&1);
    trial.hear_now([insert]);
    trial.run_for(1.0);
    assert!(!shorts(&trial.states(2)).contains(&"started"), "{:?}", trial.states(2));
}

/// The begin of the leg comes half a minute late, and the plan lacks the insert that is flown.
#[test]
fn sr_009_a_begin_older_than_a_loss_does_not_end_an_insert_that_began_unheard() {
    let mut trial = Trial::under_way();
    accepted(&mut trial, good_line(2), 2);
    let leg = begin_of(&trial, "", Some(2), None, "waypoint");
    trial.run_for(0.5);
    trial.way = Some(Box::new(damage("BFMB", "")));
    ends(&mut trial, Some(2), None);
    begins(&mut trial, None, Some(1));
    trial.way = None;
    trial.vehicle.inserted.remove(&1);
    trial.run_for(35.0);
    trial.hear_now([leg]);
    trial.run_for(0.5);
    assert_eq!(trial.core.open_requests(), 1, "{:?}", trial.states(2));
}

const WEST_LEG: &[(u32, &[(f64, f64)])] = &[(1, &[(-1900.0, 0.0), (-700.0, 0.0)])];

/// An insert begins, unheard, before its acceptance is acknowledged; then the operator cancels all.
#[test]
fn sr_002_an_insert_that_began_unheard_before_its_answer_is_not_cancelled_by_bprca() {
    let flown = |before: bool| {
        let mut trial = Trial::new();
        trial.vehicle.replies.insert("RMP", Reply::Silent);
        trial.vehicle.start = EastNorth::new(-1300.0, 0.0);
        trial.run_for(1.0);
        tells_plan_of(&mut trial, WEST_LEG);
        assert!(trial.core.has_control());
        trial
            .vehicle
            .replies
            .insert("RTK", Reply::Pending(Duration::from_secs(3), AckStatus::Succeeded));
        trial.ask(0, [Request::Trackline(line(1, (-1000.0, 0.0), (900.0, 0.0)))]);
        trial.run_for(if before { 0.5 } else { 4.0 });
        trial.way = Some(Box::new(damage("BFMB", "")));
        ends(&mut trial, Some(1), None);
        begins(&mut trial, None, Some(1));
        trial.way = None;
        trial.run_for(4.0);
        assert_eq!(
            shorts(&trial.states(1)).last(),
            Some(&"accepted"),
            "{:?}",
            trial.states(1)
        );
        trial.operator(Operator::Order(Order::CancelAll));
        trial.run_for(1.0);
        for _ in 0..3 {
            tells_plan_of(&mut trial, WEST_LEG);
        }
        put(&mut trial, 90.0, -900.0, 0.0);
        trial.run_for(20.0);
        put(&mut trial, 90.0, 0.0, -1500.0);
        let last = fate(&mut trial, Request::Modify(modify(9)), 9);
        format!("{last} {:?}", trial.core.uncontrolled())
            .replace("Ended", "")
            .to_owned()
            + &format!("{:?}", shorts(&trial.states(1)))
    };
    for before in [false, true] {
        let f = flown(before);
        assert!(!f.contains("Accepted") && !f.contains("Sent"), "{before}: {f}");
    }
}

/// Two adjustments begin in the same millisecond.
#[test]
fn two_adjustments_that_begin_at_once_are_two() {
    let flown = |kinds: &[&str], end: bool| {
        let mut trial = Trial::under_way();
        trial.run_for(1.0);
        let all: Vec<_> = kinds
            .iter()
            .map(|kind| {
                if end {
                    end_of(&trial, None, None, kind)
                } else {
                    begin_of(&trial, "", None, None, kind)
                }
            })
            .collect();
        trial.hear_now(all);
        trial.run_for(1.0);
        fate(&mut trial, good_line(2), 2)
    };
    for end in [false, true] {
        let one = flown(&["trim"], end);
        assert!(one.contains("Accepted"), "one {end}: {one}");
        let two = flown(&["trim", "buoyancy"], end);
        assert!(two.contains("Accepted"), "two {end}: {two}");
    }
}

/// The operator holds while the vehicle decides on an insert; it accepts it 25 s later.
#[test]
fn sr_015_a_hold_cancels_an_insert_that_is_accepted_late() {
    let cancelled = |after: u64| {
        let mut trial = Trial::under_way();
        trial.vehicle.replies.insert("RCN", Reply::Refuse);
        trial
            .vehicle
            .replies
            .insert("RTK", Reply::Pending(Duration::from_secs(after), AckStatus::Succeeded));
        trial.ask(0, [good_line(1)]);
        trial.run_for(1.0);
        trial.operator(Operator::Hold);
        trial.run_for(after as f64);
        trial.vehicle.inserted.insert(1);
        trial.vehicle.replies.remove("RCN");
        trial.run_for(300.0);
        !trial.vehicle.inserted.contains(&1)
    };
    assert!(cancelled(3), "3 s");
    assert!(cancelled(10), "10 s");
    assert!(cancelled(25), "25 s");
}

/// A polyline that is sent as one start and several ends.
#[test]
fn sr_002_the_way_on_from_an_insert_to_an_inner_point_of_a_polyline_is_judged() {
    const LEGS: &[(u32, &[(f64, f64)])] = &[
        (1, &[(-900.0, 0.0), (900.0, -1000.0), (900.0, 600.0)]),
        (3, &[(-900.0, 600.0)]),
    ];
    let mut trial = Trial::new();
    trial.vehicle.replies.insert("RMP", Reply::Silent);
    trial.vehicle.start = EastNorth::new(-900.0, 0.0);
    trial.run_for(1.0);
    tells_plan_of(&mut trial, LEGS);
    begins(&mut trial, Some(1), None);
    trial.run_for(5.0);
    let after = line(1, (-600.0, -700.0), (-900.0, -1000.0));
    refused("inner", &fate(&mut trial, Request::Trackline(after), 1));
}
