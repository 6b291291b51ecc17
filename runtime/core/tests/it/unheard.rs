//! What the vehicle may fly though nobody has heard it: over a lost link, without an answer, after a killed process.

use std::time::Duration;

use backseat_core::Grant;
use backseat_core::plugin::{GpsHitRequest, Request};
use backseat_spi::{AckStatus, BehaviorBegin, BehaviorId, FromVehicle, Text};
use backseat_units::EastNorth;

use crate::course::{self, at, interrupting, line, modify, turn};
use crate::scene::{EAST, WEST, accepted, at_once, begins, ends, led_to, outage, refused_for};
use crate::trial::{Setup, Trial, granted, shorts};
use crate::vehicle::Reply;

/// Known: the planned leg is flown. From (-600, -1500) the way back to the leg's east leads over the wreck.
#[test]
fn where_the_plan_is_flown_the_way_back_leads_over_the_wreck() {
    let mut trial = Trial::under_way();
    led_to(&mut trial, -600.0, -1500.0);
    refused_for(&mut trial, Request::Modify(modify(9)), 9, "wreck");
}

#[test]
fn sr_002_over_a_lost_link_an_insert_that_was_flown_may_have_ended() {
    let mut trial = Trial::under_way();
    accepted(&mut trial, at_once(line(1, WEST.0, WEST.1)), 1);
    ends(&mut trial, Some(1), None);
    begins(&mut trial, None, Some(1));
    // While the link is down the insert ends and the plan goes on; the vehicle's plan has the insert no more.
    trial.vehicle.inserted.remove(&1);
    outage(&mut trial);
    led_to(&mut trial, -600.0, -1500.0);
    refused_for(&mut trial, Request::Modify(modify(9)), 9, "current behavior unknown");
}

#[test]
fn sr_002_over_a_lost_link_an_insert_that_waited_may_have_been_flown() {
    let first = Request::Trackline(line(1, (-900.0, -1300.0), (-1200.0, -1300.0)));
    let second = || Request::Trackline(line(2, (-300.0, -1700.0), (-900.0, -1700.0)));
    // Control: all is heard.
    let mut trial = Trial::under_way();
    accepted(&mut trial, first.clone(), 1);
    begins(&mut trial, None, Some(1));
    trial.vehicle.inserted.remove(&1);
    ends(&mut trial, None, Some(1));
    begins(&mut trial, Some(2), None);
    refused_for(&mut trial, second(), 2, "wreck");
    let mut trial = Trial::under_way();
    accepted(&mut trial, first, 1);
    trial.vehicle.inserted.remove(&1);
    outage(&mut trial);
    refused_for(&mut trial, second(), 2, "current behavior unknown");
}

/// An insert that was accepted begins before the outage or during it.
#[test]
fn sr_002_over_a_lost_link_an_insert_that_waited_may_have_begun() {
    let flown = |heard: bool| {
        let mut trial = Trial::under_way();
        // Its start is south-west of the wreck, and it leads along the wreck's south to the east.
        accepted(
            &mut trial,
            Request::Trackline(line(1, (-900.0, -1300.0), (900.0, -1300.0))),
            1,
        );
        if heard {
            begins(&mut trial, None, Some(1));
        }
        outage(&mut trial);
        led_to(&mut trial, -500.0, -700.0);
        trial
    };
    refused_for(
        &mut flown(true),
        Request::Modify(modify(8)),
        8,
        "current behavior unknown",
    );
    refused_for(
        &mut flown(false),
        Request::Modify(modify(9)),
        9,
        "current behavior unknown",
    );
}

#[test]
fn sr_002_over_a_lost_link_a_gps_hit_may_have_begun() {
    let setup = granted(&[Grant::Surface], &[]);
    let mut trial = Trial::with_under_way(Setup {
        fence: course::harbour(),
        ..setup
    });
    let hit = GpsHitRequest {
        tag: 1,
        position: at(0.0, 500.0),
    };
    accepted(&mut trial, Request::GpsHit(hit), 1);
    outage(&mut trial);
    trial.run_for(12.0);
    refused_for(&mut trial, turn(9, 90.0), 9, "GPS hit");
}

#[test]
fn sr_010_nothing_interrupts_what_may_have_begun_to_interrupt_over_a_lost_link() {
    let mut trial = Trial::under_way();
    trial.vehicle.replies.insert("RTK", Reply::Silent);
    trial.ask(0, [interrupting(1)]);
    trial.run_for(0.5);
    trial.vehicle.replies.remove("RTK");
    // It was begun during the outage, and the plan names what waits (SPI 6.20 does not say that it names what is flown).
    outage(&mut trial);
    refused_for(&mut trial, interrupting(2), 2, "interrupt");
}

#[test]
fn sr_009_a_plan_says_nothing_of_an_insert_that_the_vehicle_may_not_have_decided_on() {
    let mut trial = Trial::under_way();
    trial
        .vehicle
        .replies
        .insert("RTK", Reply::Pending(Duration::from_millis(1900), AckStatus::Succeeded));
    trial.ask(0, [interrupting(1)]);
    trial.run_for(0.2);
    trial.cut();
    // It will be accepted on 1.9 s after it was asked for (SPI 4.4), and begins at once.
    trial.run_for(1.2);
    assert!(trial.is_connected());
    assert_ne!(
        shorts(&trial.states(1)).last(),
        Some(&"failed"),
        "{:?}",
        trial.states(1)
    );
}

#[test]
fn sr_002_an_insert_that_was_not_answered_may_be_what_a_modify_leads_back_to() {
    let mut trial = Trial::under_way();
    trial.vehicle.replies.insert("RTK", Reply::Silent);
    trial.vehicle.replies.insert("RCN", Reply::Silent);
    trial.ask(0, [Request::Trackline(line(1, EAST.0, EAST.1))]);
    trial.run_for(5.0);
    assert_eq!(shorts(&trial.states(1)), ["sent", "timed out"]);
    led_to(&mut trial, -400.0, -900.0);
    refused_for(&mut trial, Request::Modify(modify(9)), 9, "wreck");
}

#[test]
fn sr_002_an_insert_that_was_not_answered_and_is_flown_is_not_modified() {
    let mut trial = Trial::under_way();
    trial.vehicle.replies.insert("RTK", Reply::Silent);
    trial.vehicle.replies.insert("RCN", Reply::Refuse);
    trial.ask(0, [Request::Trackline(line(1, EAST.0, EAST.1))]);
    trial.run_for(5.0);
    begins(&mut trial, None, Some(1));
    led_to(&mut trial, -400.0, -900.0);
    refused_for(&mut trial, Request::Modify(modify(9)), 9, "plan");
}

#[test]
fn sr_002_an_insert_that_was_refused_and_is_flown_is_not_modified() {
    let mut trial = Trial::under_way();
    trial.vehicle.replies.insert("RTK", Reply::Refuse);
    trial.ask(0, [Request::Trackline(line(1, EAST.0, EAST.1))]);
    trial.run_for(0.5);
    assert_eq!(shorts(&trial.states(1)), ["sent", "failed"]);
    begins(&mut trial, None, Some(1));
    led_to(&mut trial, -400.0, -900.0);
    refused_for(&mut trial, Request::Modify(modify(9)), 9, "plan");
}

#[test]
fn sr_002_the_way_on_from_an_interrupt_leads_to_what_was_not_answered_too() {
    let ask = |reply| {
        let mut trial = Trial::under_way();
        trial.vehicle.replies.insert("RTK", reply);
        trial.vehicle.replies.insert("RCN", Reply::Silent);
        trial.ask(0, [Request::Trackline(line(1, EAST.0, EAST.1))]);
        trial.run_for(5.0);
        trial.vehicle.replies.remove("RTK");
        trial
    };
    // It ends in the west of the wreck; the first one begins in the south-east of it.
    let second = || at_once(line(2, (-700.0, -800.0), (-400.0, -800.0)));
    refused_for(&mut ask(Reply::Ok), second(), 2, "wreck");
    refused_for(&mut ask(Reply::Silent), second(), 2, "wreck");
}

#[test]
fn sr_002_after_a_planned_behavior_has_ended_it_is_not_known_which_is_flown_until_one_begins() {
    let mut trial = Trial::new();
    trial.vehicle.moved = Some((3, EastNorth::new(-300.0, -2000.0)));
    trial.run_for(2.0);
    ends(&mut trial, Some(1), None);
    trial.way = Some(Box::new(damage("BFMBS", "")));
    begins(&mut trial, Some(2), None);
    trial.way = None;
    led_to(&mut trial, 600.0, -100.0);
    refused_for(&mut trial, Request::Modify(modify(9)), 9, "current behavior unknown");
}

#[test]
fn sr_002_of_what_was_lost_on_the_link_any_may_have_been_a_begin() {
    let mut trial = Trial::new();
    trial.vehicle.moved = Some((3, EastNorth::new(-300.0, -2000.0)));
    trial.run_for(2.0);
    trial.way = Some(Box::new(damage("BFMB", "")));
    ends(&mut trial, Some(1), None);
    begins(&mut trial, Some(2), None);
    trial.way = None;
    led_to(&mut trial, 600.0, -100.0);
    refused_for(&mut trial, Request::Modify(modify(9)), 9, "current behavior unknown");
}

/// Noise on the line: a bit of each such sentence is turned.
fn damage(name: &'static str, part: &'static str) -> impl FnMut(Vec<u8>) -> Vec<u8> {
    move |bytes| {
        let text = String::from_utf8(bytes).unwrap();
        let line = |line: &str| {
            if line.contains(name) && line.contains(part) {
                line.replacen('*', "1*", 1)
            } else {
                line.to_owned()
            }
        };
        text.split_inclusive('\n').map(line).collect::<String>().into_bytes()
    }
}

fn successor(gps_hits: u32) -> Trial {
    Trial::with(granted(&[Grant::Surface, Grant::Station], &[]).after(3, gps_hits))
}

#[test]
fn sr_002_a_gps_hit_of_a_killed_process_that_is_heard_to_begin_is_flown() {
    let mut trial = successor(2);
    trial.run_for(2.0);
    // BFPLN has no code for a GPS hit, and the plan does not name it.
    begins(&mut trial, Some(1), None);
    let created = trial.vehicle.clock(trial.now);
    trial.hear_now([FromVehicle::BehaviorBegin(BehaviorBegin {
        created,
        dive_file: Text::cleaned(""),
        number: None,
        identifier: Some(BehaviorId::new(5)),
        kind: Text::cleaned("gps"),
    })]);
    trial.run_for(0.5);
    refused_for(&mut trial, turn(9, 90.0), 9, "GPS hit");
}

#[test]
fn sr_002_a_successor_does_not_know_what_the_vehicle_comes_back_to_until_it_goes_along_a_line() {
    let mut trial = successor(0);
    trial.vehicle.replays = false;
    trial.vehicle.moved = Some((1, EastNorth::new(900.0, -600.0)));
    // The behavior began at (-300, -1400), and a modify of the previous run has led it here.
    trial.vehicle.start = EastNorth::new(500.0, -1200.0);
    trial.run_for(1.0);
    let now = trial.now;
    trial.vehicle.set_status(now, "Running");
    trial.vehicle.set_control(now, true);
    trial.run_for(1.0);
    refused_for(&mut trial, Request::Modify(modify(9)), 9, "");
}
