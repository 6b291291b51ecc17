//! What the vehicle may fly without core's knowledge: after a link loss, without an answer, after a killed process.

use std::time::Duration;

use backseat_core::Grant;
use backseat_core::plugin::{GpsHitRequest, Request};
use backseat_spi::{AckStatus, BehaviorBegin, BehaviorId, FromVehicle, Text};
use backseat_units::EastNorth;

use crate::course::{self, at, interrupting, line, modify, turn};
use crate::scene::{EAST, WEST, accepted, at_once, begins, ends, hands_over, led_to, outage, refused_for};
use crate::trial::{Setup, Trial, granted, shorts};
use crate::vehicle::Reply;

/// For comparison: core knows that the planned leg is flown. From (-600, -1500) the way back to the leg's east leads
/// over the wreck.
#[test]
fn while_the_plan_is_flown_the_way_back_leads_over_the_wreck() {
    let mut trial = Trial::under_way();
    led_to(&mut trial, -600.0, -1500.0);
    refused_for(&mut trial, Request::Modify(modify(9)), 9, "wreck");
}

#[test]
fn sr_002_during_a_link_loss_the_flown_insert_may_have_ended() {
    let mut trial = Trial::under_way();
    accepted(&mut trial, at_once(line(1, WEST.0, WEST.1)), 1);
    ends(&mut trial, Some(1), None);
    begins(&mut trial, None, Some(1));
    // While the link is down, the insert ends and the plan goes on. The vehicle's plan no longer has the insert.
    trial.vehicle.inserted.remove(&1);
    outage(&mut trial);
    led_to(&mut trial, -600.0, -1500.0);
    refused_for(&mut trial, Request::Modify(modify(9)), 9, "current behavior unknown");
}

#[test]
fn sr_002_during_a_link_loss_a_waiting_insert_may_have_been_flown() {
    let first = Request::Trackline(line(1, (-900.0, -1300.0), (-1200.0, -1300.0)));
    let second = || Request::Trackline(line(2, (-300.0, -1700.0), (-900.0, -1700.0)));
    // For comparison: core hears everything.
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
fn sr_002_during_a_link_loss_a_waiting_insert_may_have_begun() {
    let flown = |heard: bool| {
        let mut trial = Trial::under_way();
        // The insert starts south-west of the wreck, and leads east along the wreck's south.
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
fn sr_002_during_a_link_loss_a_gps_hit_may_have_begun() {
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
fn sr_010_nothing_interrupts_an_interrupting_insert_that_may_have_begun_during_a_link_loss() {
    let mut trial = Trial::under_way();
    trial.vehicle.replies.insert("RTK", Reply::Silent);
    trial.ask(0, [interrupting(1)]);
    trial.run_for(0.5);
    trial.vehicle.replies.remove("RTK");
    // The insert began during the outage, and the plan names what waits (SPI 6.20 does not say that it names what is
    // flown).
    outage(&mut trial);
    refused_for(&mut trial, interrupting(2), 2, "interrupt");
}

#[test]
fn sr_009_a_plan_proves_nothing_about_an_insert_on_which_the_vehicle_may_not_have_decided() {
    let mut trial = Trial::under_way();
    trial
        .vehicle
        .replies
        .insert("RTK", Reply::Pending(Duration::from_millis(1900), AckStatus::Succeeded));
    trial.ask(0, [interrupting(1)]);
    trial.run_for(0.2);
    trial.cut();
    // The vehicle accepts the insert 1.9 s after the request (SPI 4.4), and begins it at once.
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
fn sr_002_the_way_back_from_a_modify_to_an_unanswered_insert_is_checked() {
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
fn sr_002_an_unanswered_insert_that_is_flown_is_not_modified() {
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
fn sr_002_a_refused_insert_that_is_flown_is_not_modified() {
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
fn sr_002_the_way_on_from_an_interrupting_insert_to_an_unanswered_one_is_checked() {
    let ask = |reply| {
        let mut trial = Trial::under_way();
        trial.vehicle.replies.insert("RTK", reply);
        trial.vehicle.replies.insert("RCN", Reply::Silent);
        trial.ask(0, [Request::Trackline(line(1, EAST.0, EAST.1))]);
        trial.run_for(5.0);
        trial.vehicle.replies.remove("RTK");
        trial
    };
    // The second insert ends west of the wreck, and the first one begins south-east of it.
    let second = || at_once(line(2, (-700.0, -800.0), (-400.0, -800.0)));
    refused_for(&mut ask(Reply::Ok), second(), 2, "wreck");
    refused_for(&mut ask(Reply::Silent), second(), 2, "wreck");
}

#[test]
fn sr_002_after_the_end_of_a_planned_behavior_the_current_one_is_unknown_until_one_begins() {
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
fn sr_002_any_sentence_that_was_lost_may_have_been_a_begin() {
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

/// Noise on the line: each such sentence gets one character too many, so that its checksum is wrong.
pub(crate) fn damage(name: &'static str, part: &'static str) -> impl FnMut(Vec<u8>) -> Vec<u8> {
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
fn sr_002_a_gps_hit_of_a_killed_process_counts_as_flown_once_its_begin_is_heard() {
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
fn sr_002_a_successor_knows_what_the_vehicle_comes_back_to_only_once_it_goes_along_a_line() {
    // The behavior began at (-300, -1400), and a modify of the previous run has led the vehicle here.
    let mut trial = on_its_way(successor(0));
    refused_for(&mut trial, Request::Modify(modify(9)), 9, "");
}

/// The vehicle is on its way to the first leg of its plan, which begins 600 m east and 600 m north of here.
fn on_its_way(mut trial: Trial) -> Trial {
    trial.vehicle.replays = false;
    trial.vehicle.moved = Some((1, EastNorth::new(900.0, -600.0)));
    trial.vehicle.start = EastNorth::new(500.0, -1200.0);
    trial.run_for(1.0);
    hands_over(&mut trial);
    trial.run_for(1.0);
    trial
}

/// An insert has interrupted the way to a leg, and the vehicle takes the leg up again. It may continue the way that it
/// followed before, and the process has not heard where that began.
#[test]
fn sr_002_a_behavior_that_is_taken_up_again_may_continue_from_a_begin_that_a_killed_process_heard() {
    // For comparison: the first process of a mission hears the leg begin.
    let mut trial = on_its_way(Trial::new());
    begins(&mut trial, Some(1), None);
    accepted(&mut trial, Request::Modify(modify(9)), 9);

    let mut trial = on_its_way(successor(0));
    begins(&mut trial, Some(1), None);
    refused_for(&mut trial, Request::Modify(modify(9)), 9, "current behavior unknown");
    // The same sentence may come twice.
    begins(&mut trial, Some(1), None);
    refused_for(&mut trial, Request::Modify(modify(10)), 10, "current behavior unknown");
    refused_for(&mut trial, line_here(11), 11, "current behavior unknown");
    // The next behavior begins for the first time.
    ends(&mut trial, Some(1), None);
    begins(&mut trial, Some(2), None);
    accepted(&mut trial, Request::Modify(modify(12)), 12);
}

/// The way to the line of what is taken up again may run along another line of the plan: here along the way to the third
/// behavior.
#[test]
fn sr_002_a_behavior_that_is_taken_up_again_is_seen_only_on_its_own_line() {
    let on_the_way_to_the_third = |heard: bool| {
        let mut trial = on_its_way(if heard { successor(0) } else { Trial::new() });
        if heard {
            begins(&mut trial, Some(1), None);
        } else {
            outage(&mut trial);
        }
        trial.vehicle.heading_deg = 270.0;
        let then_s = trial.now.as_nanos() as f64 / 1e9 + 12.0;
        trial.vehicle.start = EastNorth::new(500.0 + trial.vehicle.speed_mps * then_s, 300.0);
        trial.run_for(15.0);
        modified(trial)
    };
    // For comparison: nothing is heard and no insert may be flown, so what is seen counts.
    let seen = on_the_way_to_the_third(false);
    assert!(seen.contains("Accepted"), "{seen}");
    let heard = on_the_way_to_the_third(true);
    assert!(heard.contains("current behavior unknown"), "{heard}");
}

fn line_here(tag: u64) -> Request {
    Request::Trackline(line(tag, (600.0, -1300.0), (900.0, -1300.0)))
}

/// What became of a modify that was requested 12 s later.
fn modified(mut trial: Trial) -> String {
    trial.run_for(12.0);
    trial.ask(0, [Request::Modify(modify(9))]);
    trial.run_for(0.5);
    let states = trial.states(9);
    match shorts(&states).last() {
        Some(&"rejected") => trial.rejection(9),
        _ => format!("{states:?}"),
    }
}

/// The same over a lost link, and over a sentence that was lost.
#[test]
fn sr_002_a_behavior_that_is_taken_up_again_may_continue_from_a_begin_that_was_missed() {
    let interrupted = |lose: &dyn Fn(&mut Trial)| {
        let mut trial = on_its_way(Trial::new());
        begins(&mut trial, Some(3), None);
        accepted(&mut trial, at_once(line(1, EAST.0, EAST.1)), 1);
        ends(&mut trial, Some(3), None);
        lose(&mut trial);
        ends(&mut trial, None, Some(1));
        trial.vehicle.inserted.clear();
        begins(&mut trial, Some(1), None);
        modified(trial)
    };
    // For comparison: the leg begins and everything is heard.
    let heard = interrupted(&|trial| begins(trial, None, Some(1)));
    assert!(heard.contains("Steering") || heard.contains("Accepted"), "{heard}");
    // Here the leg may have begun before the insert.
    let link = interrupted(&outage);
    assert!(link.contains("current behavior unknown"), "{link}");
    let sentence = interrupted(&|trial| {
        trial.way = Some(Box::new(damage("BFMBS", "")));
        begins(trial, Some(1), None);
        trial.way = None;
        begins(trial, None, Some(1));
    });
    assert!(sentence.contains("current behavior unknown"), "{sentence}");
}

#[test]
fn sr_002_an_insert_of_another_payload_that_nobody_heard_begin_may_have_interrupted_what_begins_after_it() {
    let after_the_outage = |ended: Option<u32>| {
        let mut trial = on_its_way(Trial::new());
        begins(&mut trial, Some(3), None);
        outage(&mut trial);
        ends(&mut trial, Some(3).filter(|_| ended.is_none()), ended);
        begins(&mut trial, Some(1), None);
        modified(trial)
    };
    let planned = after_the_outage(None);
    assert!(planned.contains("Accepted"), "{planned}");
    let insert = after_the_outage(Some(40));
    assert!(insert.contains("current behavior unknown"), "{insert}");
}
