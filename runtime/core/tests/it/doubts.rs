//! What the vehicle may fly although nobody heard it begin, and the ways that follow from that.

use backseat_core::plugin::Request;
use backseat_spi::AckStatus;
use backseat_units::EastNorth;

use crate::course::{line, modify};
use crate::scene::{accepted, begins, ends, hands_over, outage, outage_with, with_plan};
use crate::trial::{Setup, Trial};
use crate::unheard::damage;
use crate::vehicle::Reply;
use crate::ways::{fate, put, refused, wreck};

/// Another payload inserts too. It inserts 41, which interrupts; the BFMBS is damaged. 41 runs along a leg of the plan.
#[test]
fn sr_002_another_payloads_insert_that_nobody_heard_is_not_seen_on_the_plan() {
    let mut fates = Vec::new();
    for link in [false, true] {
        let mut trial = Trial::under_way();
        begins(&mut trial, None, Some(40));
        ends(&mut trial, None, Some(40));
        begins(&mut trial, Some(3), None);
        if link {
            // 41 begins during the outage; the plan names only what waits.
            outage(&mut trial);
        } else {
            trial.way = Some(Box::new(damage("BFMBS", "")));
            begins(&mut trial, None, Some(41));
            trial.way = None;
        }
        put(&mut trial, 90.0, 0.0, 0.0);
        trial.run_for(20.0);
        let fate = fate(&mut trial, Request::Modify(modify(9)), 9);
        println!("link {link}: {fate}");
        fates.push(fate);
    }
    for fate in fates {
        refused("41", &fate);
    }
}

/// Ours was interrupted by another payload's, and is taken up again; that BFMBS is damaged.
#[test]
fn sr_002_an_insert_that_may_be_taken_up_again_is_not_seen_on_the_plan() {
    let mut trial = Trial::under_way();
    accepted(&mut trial, Request::Trackline(line(1, (-500.0, 0.0), (1500.0, 0.0))), 1);
    trial.vehicle.inserted.remove(&1);
    ends(&mut trial, Some(1), None);
    begins(&mut trial, None, Some(1));
    ends(&mut trial, None, Some(1));
    begins(&mut trial, None, Some(40));
    ends(&mut trial, None, Some(40));
    trial.way = Some(Box::new(damage("BFMBS", "")));
    begins(&mut trial, None, Some(1));
    trial.way = None;
    put(&mut trial, 90.0, 0.0, 0.0);
    trial.run_for(20.0);
    refused("left", &fate(&mut trial, Request::Modify(modify(9)), 9));
}

const TIE: &[(u32, &[(f64, f64)])] = &[
    (1, &[(-300.0, -1900.0), (-300.0, 1900.0)]),
    (2, &[(900.0, 1000.0)]),
    (3, &[(900.0, -300.0), (-250.0, -300.0)]),
    (4, &[(-250.0, 300.0)]),
];

/// A modify has led the vehicle 150 m east of its leg; the link is lost; it comes back to the leg along a tie line.
#[test]
fn sr_002_the_way_back_to_a_leg_may_run_along_another_leg() {
    let flown = |lose: bool| {
        let mut trial = with_plan(TIE, (-300.0, -400.0));
        begins(&mut trial, Some(1), None);
        if lose {
            outage_with(&mut trial, TIE);
        }
        put(&mut trial, 270.0, -150.0, -300.0);
        trial.run_for(20.0);
        put(&mut trial, 90.0, 300.0, -1000.0);
        fate(&mut trial, Request::Modify(modify(9)), 9)
    };
    wreck("heard", &flown(false));
    refused("lost", &flown(true));
}

const NEAR: &[(u32, &[(f64, f64)])] = &[
    (1, &[(0.0, -300.0), (-400.0, -600.0), (-400.0, -1500.0)]),
    (2, &[(-200.0, 300.0)]),
    (3, &[(-200.0, -300.0), (900.0, -300.0)]),
];

/// The vehicle is close to the first point of its leg, and 4 m aside, when the ten seconds along another leg are over.
#[test]
fn sr_002_a_first_point_that_is_close_and_aside_counts_as_ahead() {
    let flown = |aside_m: f64, lose: bool| {
        let mut trial = with_plan(NEAR, (-600.0, 900.0));
        begins(&mut trial, Some(1), None);
        if lose {
            outage_with(&mut trial, NEAR);
        }
        put(&mut trial, 90.0, -5.0, -300.0 - aside_m);
        put(&mut trial, 90.0, 300.0, -1000.0);
        fate(&mut trial, Request::Modify(modify(9)), 9)
    };
    wreck("heard", &flown(4.0, false));
    refused("ahead", &flown(0.0, true));
    refused("aside", &flown(4.0, true));
}

/// The plan has named another payload's insert, and later does not.
#[test]
fn sr_002_a_plan_that_named_another_payloads_insert_shows_that_there_is_one() {
    let flown = |named: bool, heard: bool| {
        let mut trial = Trial::new();
        trial.vehicle.replays = false;
        if named {
            trial.vehicle.others = vec![(40, (900.0, 900.0))];
        }
        trial.vehicle.moved = Some((1, EastNorth::new(900.0, -600.0)));
        trial.vehicle.start = EastNorth::new(500.0, -1200.0);
        trial.run_for(1.0);
        hands_over(&mut trial);
        trial.run_for(1.0);
        begins(&mut trial, Some(3), None);
        // 40 is cancelled by its payload.
        trial.vehicle.others.clear();
        if heard {
            begins(&mut trial, None, Some(40));
            ends(&mut trial, None, Some(40));
            begins(&mut trial, Some(3), None);
        }
        let now = trial.now;
        trial.vehicle.set_status(now, "Paused");
        trial.run_for(0.5);
        hands_over(&mut trial);
        trial.run_for(2.0);
        // During the outage behavior 1 begins, and 41 interrupts it, and ends. 1 is taken up again.
        outage(&mut trial);
        begins(&mut trial, Some(1), None);
        trial.run_for(1.0);
        fate(&mut trial, Request::Modify(modify(9)), 9)
    };
    refused("heard", &flown(false, true));
    refused("named", &flown(true, false));
}

/// Another payload's insert is interrupted by one more of another payload. The plan names only what is flown and waits.
#[test]
fn sr_002_another_payloads_insert_that_was_interrupted_may_be_taken_up_again() {
    let flown = |said: bool| {
        let mut trial = Trial::under_way();
        trial.vehicle.others = vec![(40, (900.0, -1000.0))];
        ends(&mut trial, Some(1), None);
        begins(&mut trial, None, Some(40));
        trial.run_for(2.0);
        if said {
            ends(&mut trial, None, Some(40));
            trial.vehicle.others.clear();
        }
        trial.vehicle.others.push((41, (-600.0, -300.0)));
        begins(&mut trial, None, Some(41));
        trial.run_for(5.0);
        fate(
            &mut trial,
            Request::Trackline(line(4, (-600.0, -600.0), (-700.0, -1000.0))),
            4,
        )
    };
    let (unsaid, said) = (flown(false), flown(true));
    println!("no BFMBE: {unsaid}; BFMBE: {said}");
    refused("no BFMBE", &unsaid);
    refused("BFMBE", &said);
}

/// A refused insert is in the plan after all (its late acknowledgement is damaged), begins unheard, and runs along a leg.
#[test]
fn sr_002_an_insert_that_the_plan_names_may_be_flown_although_it_was_refused() {
    let mut trial = Trial::under_way();
    trial.vehicle.replies.insert("RTK", Reply::Refuse);
    trial.ask(0, [Request::Trackline(line(1, (-500.0, 0.0), (1500.0, 0.0)))]);
    trial.run_for(0.5);
    trial.vehicle.inserted.insert(1);
    trial.vehicle.replies.insert("RCN", Reply::Refuse);
    outage(&mut trial);
    put(&mut trial, 90.0, 0.0, 0.0);
    trial.run_for(20.0);
    refused("refused", &fate(&mut trial, Request::Modify(modify(9)), 9));
}

/// The same; it waits, and the plan names it. A modify leads where the way to it is bad.
#[test]
fn sr_002_the_way_to_a_refused_insert_that_the_plan_names_is_judged() {
    let flown = |reply| {
        let mut trial = Trial::under_way();
        trial.vehicle.replies.insert("RTK", reply);
        trial.ask(0, [Request::Trackline(line(1, (900.0, -1500.0), (1200.0, -1500.0)))]);
        trial.run_for(0.5);
        trial.vehicle.inserted.insert(1);
        trial.vehicle.replies.insert("RCN", Reply::Refuse);
        outage(&mut trial);
        begins(&mut trial, Some(1), None);
        trial.run_for(2.0);
        put(&mut trial, 90.0, -400.0, -900.0);
        fate(&mut trial, Request::Modify(modify(9)), 9)
    };
    wreck("accepted", &flown(Reply::Ok));
    refused("refused", &flown(Reply::Refuse));
}

/// An element without a number and without an identifier runs along the leg of another.
#[test]
fn sr_002_an_element_without_a_number_may_be_flown() {
    let mut trial = with_plan(TIE, (-300.0, 900.0));
    trial.vehicle.replays = false;
    trial.cut();
    trial.run_for(1.5);
    let plan = |trial: &mut Trial| {
        let Some((_, command)) = trial.commands("RMP").pop() else {
            panic!()
        };
        let created = command.created().unwrap();
        let now = trial.now;
        trial
            .vehicle
            .acknowledge(now, ("RMP", created, None, AckStatus::Pending));
        trial.run_for(0.3);
        let of: [(Option<u32>, usize, (f64, f64)); 4] = [
            (None, 0, (-200.0, -300.0)),
            (None, 1, (-900.0, -300.0)),
            (Some(3), 0, (900.0, -300.0)),
            (Some(3), 1, (-250.0, -300.0)),
        ];
        for (number, index, place) in of {
            let now = trial.now;
            trial.vehicle.say_element(now, number, None, index, place);
        }
        trial.run_for(0.2);
        let now = trial.now;
        trial
            .vehicle
            .acknowledge(now, ("RMP", created, None, AckStatus::Succeeded));
        trial.run_for(0.5);
    };
    plan(&mut trial);
    hands_over(&mut trial);
    trial.run_for(0.5);
    plan(&mut trial);
    put(&mut trial, 270.0, -215.0, -300.0);
    trial.run_for(10.0);
    refused("unnumbered", &fate(&mut trial, Request::Modify(modify(9)), 9));
}

/// An insert after the current leg of a behavior of several legs: the vehicle goes on to the next leg of it (SPI 7.5).
#[test]
fn sr_002_the_way_on_from_an_insert_to_the_next_leg_of_the_same_behavior_is_judged() {
    const LEGS: &[(u32, &[(f64, f64)])] = &[
        (1, &[(-900.0, 0.0), (-300.0, 0.0), (900.0, -1000.0), (900.0, 900.0)]),
        (2, &[(-900.0, 600.0)]),
    ];
    let mut trial = with_plan(LEGS, (-900.0, 0.0));
    begins(&mut trial, Some(1), None);
    trial.run_for(5.0);
    let after = line(1, (-300.0, -700.0), (-600.0, -1000.0));
    refused("next leg", &fate(&mut trial, Request::Trackline(after), 1));
}

/// With `modify_needs_plan = false`: an insert of ours has begun unheard. The way back to its line counts.
#[test]
fn sr_002_without_the_plan_the_line_of_an_insert_that_may_be_flown_counts() {
    let flown = |heard: bool| {
        let setup = Setup::default();
        let mut trial = Trial::with_under_way(Setup {
            limits: backseat_core::Limits {
                modify_needs_plan: false,
                ..setup.limits.clone()
            },
            ..setup
        });
        accepted(
            &mut trial,
            Request::Trackline(line(1, (-900.0, -1300.0), (900.0, -1300.0))),
            1,
        );
        if heard {
            begins(&mut trial, None, Some(1));
        } else {
            outage(&mut trial);
        }
        put(&mut trial, 90.0, -500.0, -700.0);
        fate(&mut trial, Request::Modify(modify(9)), 9)
    };
    let (heard, lost) = (flown(true), flown(false));
    println!("heard: {heard}; lost: {lost}");
    wreck("heard", &heard);
    refused("lost", &lost);
}

/// Where the mission goes on after a pause, the vehicle must be seen again.
#[test]
fn sr_002_what_was_seen_before_a_pause_of_the_mission_does_not_count_after_it() {
    let mut trial = Trial::under_way();
    outage(&mut trial);
    put(&mut trial, 90.0, 0.0, 0.0);
    trial.run_for(20.0);
    assert!(fate(&mut trial, Request::Modify(modify(9)), 9).contains("Accepted"));
    trial.ask(0, [Request::EndModify]);
    let now = trial.now;
    trial.vehicle.set_status(now, "Paused");
    trial.run_for(2.0);
    hands_over(&mut trial);
    trial.run_for(2.0);
    assert!(trial.core.has_control());
    let fate_at_once = fate(&mut trial, Request::Modify(modify(10)), 10);
    assert!(fate_at_once.contains("current behavior unknown"), "{fate_at_once}");
    trial.run_for(12.0);
    assert!(fate(&mut trial, Request::Modify(modify(11)), 11).contains("Accepted"));
}

/// The BPEMB of a lease that has just ended may be lost with the link. The vehicle flies the modify for 5 s more.
#[test]
fn sr_002_a_modify_that_ended_just_before_a_link_loss_may_still_lead_the_vehicle() {
    let steers_after_s = |asks: bool| {
        let mut trial = Trial::under_way();
        // On its line until the end.
        put(&mut trial, 90.0, -600.0, 0.0);
        if asks {
            trial.ask(0, [Request::Modify(modify(8))]);
            trial.run_for(0.5);
            assert!(trial.core.is_steering());
            trial.ask(0, [Request::EndModify]);
            trial.run_for(0.1);
            assert!(!trial.core.is_steering());
        }
        let lost = trial.now;
        trial.vehicle.replays = false;
        trial.cut();
        trial.run_for(1.5);
        hands_over(&mut trial);
        for tag in 10..60 {
            if fate(&mut trial, Request::Modify(modify(tag)), tag).contains("Accepted") {
                return trial.now.since(lost).as_secs_f64();
            }
        }
        panic!("it steers no more")
    };
    let (not_led, led) = (steers_after_s(false), steers_after_s(true));
    assert!(not_led < 14.0 && led > 15.0 && led < 20.0, "{not_led} s, {led} s");
}
