//! The ways that the vehicle may take after begins and ends that were not heard.

use backseat_core::plugin::Request;
use backseat_units::EastNorth;

use crate::course::{line, modify, turn};
use crate::scene::{accepted, at_once, begins, ends, hands_over, led_to, outage, outage_with, tells_plan_of};
use crate::trial::{Setup, Trial, shorts};
use crate::unheard::damage;
use crate::vehicle::Reply;

/// What became of a request.
pub(crate) fn fate(trial: &mut Trial, request: Request, tag: u64) -> String {
    trial.ask(0, [request]);
    trial.run_for(0.5);
    let states = trial.states(tag);
    match shorts(&states).last() {
        Some(&"rejected") => trial.rejection(tag),
        _ => format!("{states:?}"),
    }
}

#[track_caller]
pub(crate) fn refused(what: &str, fate: &str) {
    assert!(
        !fate.contains("Accepted") && !fate.contains("Sent") && !fate.contains("Ended"),
        "{what}: it was sent: {fate}"
    );
}

#[track_caller]
pub(crate) fn wreck(what: &str, fate: &str) {
    assert!(fate.contains("wreck"), "{what}: {fate}");
}

/// The vehicle is here now, with this heading, and navigation has 12 s to become steady.
pub(crate) fn put(trial: &mut Trial, heading_deg: f64, east_m: f64, north_m: f64) {
    trial.vehicle.heading_deg = heading_deg;
    let then_s = trial.now.as_nanos() as f64 / 1e9 + 12.0;
    trial.vehicle.start = EastNorth::new(east_m, north_m).offset(heading_deg + 180.0, trial.vehicle.speed_mps * then_s);
    trial.run_for(12.0);
}

/// The begin of the leg that was interrupted was lost, but core still has the begin of another leg.
#[test]
fn sr_002_the_begin_of_another_leg_does_not_show_what_is_taken_up() {
    let flown = |lose: bool| {
        let mut trial = Trial::new();
        // The second behavior is a place at (-600, 0).
        trial.vehicle.moved = Some((2, EastNorth::new(-1200.0, -300.0)));
        trial.run_for(2.0);
        // The first behavior is about to end (time limit) south-west of the wreck.
        put(&mut trial, 90.0, -600.0, -1400.0);
        accepted(&mut trial, at_once(line(1, (700.0, -1500.0), (700.0, -900.0))), 1);
        ends(&mut trial, Some(1), None);
        if lose {
            trial.way = Some(Box::new(damage("BFMBS", "")));
        }
        begins(&mut trial, Some(2), None);
        trial.way = None;
        begins(&mut trial, None, Some(1));
        // On the line of the insert.
        put(&mut trial, 0.0, 700.0, -1200.0);
        trial.run_for(30.0);
        put(&mut trial, 0.0, 700.0, -1000.0);
        fate(&mut trial, Request::Modify(modify(9)), 9)
    };
    wreck("heard", &flown(false));
    refused("lost", &flown(true));
}

/// The same over a link loss, nothing heard after it.
#[test]
fn sr_002_the_begin_of_another_leg_does_not_show_what_is_taken_up_after_an_outage() {
    let mut trial = Trial::new();
    trial.vehicle.moved = Some((2, EastNorth::new(-1200.0, -300.0)));
    trial.run_for(2.0);
    put(&mut trial, 90.0, -600.0, -1400.0);
    accepted(&mut trial, at_once(line(1, (700.0, -1500.0), (700.0, -900.0))), 1);
    outage(&mut trial);
    put(&mut trial, 0.0, 700.0, -1200.0);
    trial.run_for(30.0);
    put(&mut trial, 0.0, 700.0, -1000.0);
    refused("outage", &fate(&mut trial, Request::Modify(modify(9)), 9));
}

const WEST_LEG: &[(u32, &[(f64, f64)])] = &[(1, &[(-1900.0, 0.0), (-700.0, 0.0)])];

fn on_the_west_leg() -> Trial {
    let mut trial = Trial::new();
    trial.vehicle.replies.insert("RMP", Reply::Silent);
    trial.vehicle.start = EastNorth::new(-1300.0, 0.0);
    trial.run_for(1.0);
    tells_plan_of(&mut trial, WEST_LEG);
    assert!(trial.core.has_control(), "{:#?}", trial.notes());
    trial
}

/// It goes east along y = 0, and is then led to the south of the wreck.
fn along_the_leg_then_led_off(mut trial: Trial) -> String {
    put(&mut trial, 90.0, -900.0, 0.0);
    trial.run_for(20.0);
    put(&mut trial, 90.0, 0.0, -1500.0);
    fate(&mut trial, Request::Modify(modify(9)), 9)
}

/// An insert that was not answered is flown. Its line runs along a leg, and on.
#[test]
fn sr_002_a_vehicle_that_may_fly_an_unanswered_insert_is_not_seen_on_the_plan() {
    let asked = || Request::Trackline(line(1, (-1000.0, 0.0), (900.0, 0.0)));
    let mut trial = on_the_west_leg();
    accepted(&mut trial, asked(), 1);
    ends(&mut trial, Some(1), None);
    begins(&mut trial, None, Some(1));
    wreck("heard", &along_the_leg_then_led_off(trial));

    let mut trial = on_the_west_leg();
    trial.vehicle.replies.insert("RTK", Reply::Silent);
    trial.vehicle.replies.insert("RCN", Reply::Silent);
    trial.ask(0, [asked()]);
    trial.run_for(5.0);
    assert_eq!(shorts(&trial.states(1)), ["sent", "timed out"]);
    outage_with(&mut trial, WEST_LEG);
    refused("seen", &along_the_leg_then_led_off(trial));
}

/// A waiting insert begins unheard, and the way to it runs along a leg, and on.
#[test]
fn sr_002_a_vehicle_that_may_be_on_the_way_to_an_insert_is_not_seen_on_the_plan() {
    let flown = |heard: bool| {
        let mut trial = on_the_west_leg();
        accepted(&mut trial, Request::Trackline(line(1, (900.0, 0.0), (1200.0, 0.0))), 1);
        if heard {
            ends(&mut trial, Some(1), None);
            begins(&mut trial, None, Some(1));
        } else {
            trial.vehicle.inserted.insert(1);
            outage_with(&mut trial, WEST_LEG);
        }
        along_the_leg_then_led_off(trial)
    };
    wreck("heard", &flown(true));
    refused("seen", &flown(false));
}

/// A waiting circle that touches a leg begins unheard: a circle counts as no line that may be flown.
#[test]
fn sr_002_a_vehicle_that_may_fly_a_circle_is_not_seen_on_the_plan() {
    use crate::course::circle;
    let flown = |heard: bool| {
        let mut trial = on_the_west_leg();
        // The circle's north is on the leg. Its east is at (-200, -600).
        accepted(&mut trial, Request::Trackcircle(circle(1, (-800.0, -600.0), 600.0)), 1);
        if heard {
            ends(&mut trial, Some(1), None);
            begins(&mut trial, None, Some(1));
        } else {
            trial.vehicle.inserted.insert(1);
            outage_with(&mut trial, WEST_LEG);
        }
        put(&mut trial, 90.0, -820.0, 0.0);
        trial.run_for(14.0);
        put(&mut trial, 90.0, 600.0, -950.0);
        fate(&mut trial, Request::Modify(modify(9)), 9)
    };
    wreck("heard", &flown(true));
    refused("seen", &flown(false));
}

/// As `sr_002_the_transit_to_the_first_leg_counts_even_if_it_runs_along_another_leg`, but one sentence is damaged.
#[test]
fn sr_002_the_transit_counts_even_if_core_only_sees_a_later_leg_that_it_runs_along() {
    let led_off = |lose: bool| {
        const WAY_DEG: f64 = 36.5;
        let mut trial = Trial::new();
        trial.vehicle.replies.insert("RMP", Reply::Silent);
        trial.vehicle.speed_mps = 1.0;
        trial.vehicle.heading_deg = WAY_DEG;
        trial.vehicle.start = EastNorth::new(-300.0, -1410.0).offset(WAY_DEG + 180.0, 4.0);
        trial.run_for(1.0);
        tells_plan_of(
            &mut trial,
            &[(
                1,
                &[
                    (300.0, -600.0),
                    (1000.0, -600.0),
                    (1000.0, -1800.0),
                    (-700.0, -1800.0),
                    (-308.0, -1421.0),
                    (-213.0, -1293.0),
                ],
            )],
        );
        begins(&mut trial, Some(1), None);
        if lose {
            // Any sentence: here one of navigation.
            trial.hear_bytes(b"$BFSVS,120000.000,1500.0*00\r\n");
        }
        trial.run_for(30.0);
        (trial.vehicle.speed_mps, trial.vehicle.heading_deg) = (1.5, 90.0);
        led_to(&mut trial, 500.0, -1200.0);
        fate(&mut trial, Request::Modify(modify(9)), 9)
    };
    wreck("heard", &led_off(false));
    refused("lost", &led_off(true));
}

/// After a restart a leg is taken up again; the link is lost, and the vehicle repeats the BFMBS.
#[test]
fn sr_002_a_link_loss_does_not_make_a_leg_that_is_taken_up_again_begin_here() {
    let taken_up = |lose: &dyn Fn(&mut Trial)| {
        let mut trial = Trial::with(Setup::default().after(3, 0));
        trial.vehicle.replays = false;
        trial.vehicle.moved = Some((1, EastNorth::new(900.0, -600.0)));
        trial.vehicle.start = EastNorth::new(500.0, -1200.0);
        trial.run_for(1.0);
        hands_over(&mut trial);
        trial.run_for(1.0);
        begins(&mut trial, Some(1), None);
        lose(&mut trial);
        begins(&mut trial, Some(1), None);
        trial.run_for(2.0);
        fate(&mut trial, Request::Modify(modify(9)), 9)
    };
    refused("repeated", &taken_up(&|_| {}));
    refused("link lost", &taken_up(&outage));
}

#[test]
fn sr_002_a_damaged_sentence_does_not_make_a_leg_that_is_taken_up_again_begin_here() {
    let mut trial = Trial::with(Setup::default().after(3, 0));
    trial.vehicle.replays = false;
    trial.vehicle.moved = Some((1, EastNorth::new(900.0, -600.0)));
    trial.vehicle.start = EastNorth::new(500.0, -1200.0);
    trial.run_for(1.0);
    hands_over(&mut trial);
    trial.run_for(1.0);
    begins(&mut trial, Some(1), None);
    trial.hear_bytes(b"$BFSVS,120000.000,1500.0*00\r\n");
    begins(&mut trial, Some(1), None);
    trial.run_for(2.0);
    refused("damaged", &fate(&mut trial, Request::Modify(modify(9)), 9));
}

/// Our insert that interrupts has begun unheard while another of ours was flown.
#[test]
fn sr_002_our_insert_that_another_of_ours_interrupted_unheard_may_be_taken_up_again() {
    let flown = |heard: bool| {
        let mut trial = Trial::under_way();
        accepted(
            &mut trial,
            Request::Trackline(line(1, (900.0, -1500.0), (900.0, -300.0))),
            1,
        );
        ends(&mut trial, Some(1), None);
        begins(&mut trial, None, Some(1));
        led_to(&mut trial, 900.0, -350.0);
        accepted(&mut trial, at_once(line(2, (-700.0, -500.0), (700.0, -500.0))), 2);
        if heard {
            begins(&mut trial, None, Some(2));
        } else {
            trial.vehicle.inserted.clear();
            trial.vehicle.inserted.insert(2);
            outage(&mut trial);
        }
        put(&mut trial, 90.0, -600.0, -500.0);
        trial.run_for(20.0);
        put(&mut trial, 270.0, -700.0, -1000.0);
        fate(&mut trial, turn(9, 270.0), 9)
    };
    wreck("heard", &flown(true));
    refused("unheard", &flown(false));
}

/// A BFMBS with a right checksum that cannot be read.
#[test]
fn sr_002_a_begin_that_cannot_be_read_is_a_begin_that_was_not_heard() {
    let mut heard = Trial::new();
    heard.vehicle.moved = Some((3, EastNorth::new(-300.0, -2000.0)));
    heard.run_for(2.0);
    begins(&mut heard, Some(2), None);
    led_to(&mut heard, 600.0, -100.0);
    wreck("heard", &fate(&mut heard, Request::Modify(modify(9)), 9));
    let mut trial = Trial::new();
    trial.vehicle.moved = Some((3, EastNorth::new(-300.0, -2000.0)));
    trial.run_for(2.0);
    let body = "BFMBS,120000.000,survey.dive,2a,,waypoint";
    let sum = body.bytes().fold(0_u8, |sum, byte| sum ^ byte);
    trial.hear_bytes(format!("${body}*{sum:02X}\r\n").as_bytes());
    led_to(&mut trial, 600.0, -100.0);
    refused("unreadable", &fate(&mut trial, Request::Modify(modify(9)), 9));
}

/// The leg ended unheard (time limit), and the way to the next behavior runs along the rest of it.
#[test]
fn sr_002_a_vehicle_that_is_seen_on_a_leg_may_be_on_the_way_to_the_next_behavior() {
    const PLAN: &[(u32, &[(f64, f64)])] = &[
        (1, &[(-600.0, 0.0), (600.0, 0.0)]),
        (2, &[(1200.0, 0.0)]),
        (3, &[(-400.0, -1600.0)]),
    ];
    let flown = |heard: bool| {
        let mut trial = Trial::new();
        trial.vehicle.replies.insert("RMP", Reply::Silent);
        trial.run_for(1.0);
        tells_plan_of(&mut trial, PLAN);
        if heard {
            ends(&mut trial, Some(1), None);
            begins(&mut trial, Some(2), None);
        } else {
            outage_with(&mut trial, PLAN);
        }
        put(&mut trial, 90.0, -400.0, 0.0);
        trial.run_for(20.0);
        // From here the way to the third behavior leads over the wreck.
        put(&mut trial, 0.0, 500.0, -500.0);
        fate(&mut trial, turn(9, 0.0), 9)
    };
    wreck("heard", &flown(true));
    refused("seen", &flown(false));
}

/// Our insert begins unheard, ours that interrupts ends it, and that end is heard.
#[test]
fn sr_002_our_insert_that_began_unheard_and_was_interrupted_may_be_taken_up_again() {
    let flown = |lose: bool, said: bool| {
        let mut trial = Trial::under_way();
        accepted(
            &mut trial,
            Request::Trackline(line(1, (900.0, -1500.0), (900.0, -300.0))),
            1,
        );
        led_to(&mut trial, 600.0, 0.0);
        accepted(&mut trial, at_once(line(2, (-700.0, -500.0), (700.0, -500.0))), 2);
        ends(&mut trial, Some(1), None);
        if lose {
            trial.way = Some(Box::new(damage("BFMBS", "")));
        }
        begins(&mut trial, None, Some(1));
        trial.way = None;
        if said {
            ends(&mut trial, None, Some(1));
        }
        begins(&mut trial, None, Some(2));
        put(&mut trial, 90.0, -600.0, -500.0);
        trial.run_for(20.0);
        put(&mut trial, 270.0, -700.0, -1000.0);
        fate(&mut trial, turn(9, 270.0), 9)
    };
    wreck("heard, BFMBE", &flown(false, true));
    wreck("heard, no BFMBE", &flown(false, false));
    refused("lost, BFMBE", &flown(true, true));
    refused("lost, no BFMBE", &flown(true, false));
}

/// A vehicle in control whose first leg leads from (700, 0) to the east. Nothing was heard to begin.
fn before_the_east_leg(setup: Setup, others: &[(u32, (f64, f64))]) -> Trial {
    let mut trial = Trial::with(setup);
    trial.vehicle.others = others.to_vec();
    trial.vehicle.replays = false;
    trial.vehicle.moved = Some((1, EastNorth::new(1300.0, 0.0)));
    trial.run_for(1.0);
    hands_over(&mut trial);
    trial.run_for(1.0);
    trial
}

/// North of the leg's start, then led to the south. The way that began at (-700, -1300) lies behind the wreck.
fn led_to_the_south_of_the_wreck(mut trial: Trial) -> String {
    put(&mut trial, 90.0, 300.0, -1500.0);
    fate(&mut trial, Request::Modify(modify(9)), 9)
}

fn heard_from_q() -> String {
    let mut trial = before_the_east_leg(Setup::default(), &[]);
    put(&mut trial, 90.0, -700.0, -1300.0);
    begins(&mut trial, Some(1), None);
    accepted(&mut trial, at_once(line(1, (300.0, 200.0), (600.0, 200.0))), 1);
    begins(&mut trial, None, Some(1));
    put(&mut trial, 90.0, 600.0, 200.0);
    ends(&mut trial, None, Some(1));
    begins(&mut trial, Some(1), None);
    led_to_the_south_of_the_wreck(trial)
}

/// As above, with a way that leads over the wreck: the killed process had heard the leg begin at (-700, -1300).
#[test]
fn sr_002_the_way_from_a_begin_that_a_killed_process_heard_is_still_unknown_after_a_loss() {
    wreck("heard", &heard_from_q());
    let taken_up = |loses: bool| {
        let mut trial = before_the_east_leg(Setup::default().after(3, 0), &[]);
        put(&mut trial, 90.0, 600.0, 200.0);
        begins(&mut trial, Some(1), None);
        if loses {
            outage(&mut trial);
        }
        begins(&mut trial, Some(1), None);
        led_to_the_south_of_the_wreck(trial)
    };
    refused("repeated", &taken_up(false));
    refused("repeated after a loss", &taken_up(true));
}

/// The plan named another payload's insert before the link was lost, and no longer afterwards.
#[test]
fn sr_002_another_payloads_insert_of_the_plan_may_have_interrupted_during_an_outage() {
    wreck("heard", &heard_from_q());
    let mut trial = before_the_east_leg(Setup::default(), &[(40, (600.0, 200.0))]);
    begins(&mut trial, Some(3), None);
    put(&mut trial, 90.0, -700.0, -1300.0);
    // Unheard: the third behavior ends, the first begins here, 40 interrupts it and ends at (600, 200).
    trial.vehicle.others.clear();
    outage(&mut trial);
    put(&mut trial, 90.0, 600.0, 200.0);
    begins(&mut trial, Some(1), None);
    refused("taken up", &led_to_the_south_of_the_wreck(trial));
}

/// The modify of before the link loss still steers along a leg while core looks on which line the vehicle is.
#[test]
fn sr_002_time_on_a_line_counts_only_when_the_modify_from_before_the_loss_is_over() {
    let mut trial = Trial::under_way();
    begins(&mut trial, Some(3), None);
    trial.ask(0, [Request::Modify(modify(1))]);
    trial.run_for(3.0);
    assert!(trial.core.is_steering());
    let lost = trial.now;
    trial.vehicle.replays = false;
    trial.cut();
    trial.run_for(1.5);
    hands_over(&mut trial);
    for tag in 10..200 {
        trial.ask(0, [Request::Modify(modify(tag))]);
        trial.run_for(0.1);
        if trial.core.is_steering() {
            // The vehicle forgets a modify after 5 s (SPI 7.12), the link may be late by 1 s, and then come 10 s on the line.
            let after_s = trial.now.since(lost).as_secs_f64();
            assert!((16.0..18.0).contains(&after_s), "after {after_s} s");
            return;
        }
    }
    panic!("steers no more: {}", trial.rejection(199));
}

/// A sentence is lost during a lease. The lease goes on, and the way from where the leg began no longer counts.
#[test]
fn sr_002_sr_004_a_lease_ends_when_a_lost_sentence_may_have_been_a_begin() {
    let lasts_s = |lose: bool| {
        let mut trial = before_the_east_leg(Setup::default(), &[]);
        put(&mut trial, 90.0, -700.0, -1300.0);
        begins(&mut trial, Some(1), None);
        put(&mut trial, 180.0, 800.0, -60.0);
        let south = backseat_core::plugin::ModifyRequest {
            heading_deg: 180.0,
            duration: std::time::Duration::from_secs(60),
            ..modify(9)
        };
        accepted(&mut trial, Request::Modify(south), 9);
        let began = trial.now;
        if lose {
            // Any sentence with a wrong checksum: it may have been a BFMBS.
            trial.hear_bytes(b"$BFSVS,120000.000,1500.0*00\r\n");
        }
        while trial.core.is_steering() {
            trial.run_for(0.1);
        }
        trial.now.since(began).as_secs_f64()
    };
    // The way back to the way from (-700, -1300) comes too near to the wreck.
    assert!(lasts_s(false) < 25.0);
    assert!(lasts_s(true) < 0.5);
}
