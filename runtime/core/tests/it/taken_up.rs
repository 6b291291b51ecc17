//! The ways back, and the ways on, from the place to which the vehicle was led.

use std::collections::BTreeSet;

use backseat_core::plugin::{FaultKind, Request, TrackcircleRequest, TracklineRequest};
use backseat_core::{FailAction, Limits, Operator, Order, PluginSetup};
use backseat_units::EastNorth;

use crate::course::{self, circle, good_line, interrupting, limits, line, modify, plugin, turn};
use crate::scene::{EAST, accepted, at_once, begins, ends, led_to, outage, refused_for, tells_plan};
use crate::trial::{Setup, Trial, shorts};
use crate::vehicle::{Reply, name_of};

#[test]
fn sr_002_the_way_back_from_a_modify_to_the_leg_that_an_insert_has_interrupted_is_checked() {
    let mut trial = Trial::new();
    trial.vehicle.start = EastNorth::new(700.0, -1300.0);
    trial.run_for(2.0);
    accepted(&mut trial, at_once(line(1, EAST.0, EAST.1)), 1);
    ends(&mut trial, Some(1), None);
    begins(&mut trial, None, Some(1));
    // The interrupted leg lies straight north of here, abeam, and the wreck lies between.
    led_to(&mut trial, 100.0, -1500.0);
    refused_for(&mut trial, Request::Modify(modify(9)), 9, "wreck");
}

#[test]
fn sr_002_sr_020_the_way_back_to_an_interrupted_insert_is_checked_before_the_interrupting_one_is_cancelled() {
    let mut trial = Trial::under_way();
    // This insert leads from south to north, east of the wreck.
    accepted(
        &mut trial,
        Request::Trackline(line(1, (900.0, -1500.0), (900.0, -300.0))),
        1,
    );
    begins(&mut trial, None, Some(1));
    led_to(&mut trial, 900.0, -350.0);
    // This insert leads from west to east, north of the wreck.
    accepted(&mut trial, at_once(line(2, (-700.0, -500.0), (700.0, -500.0))), 2);
    ends(&mut trial, None, Some(1));
    begins(&mut trial, None, Some(2));
    led_to(&mut trial, -750.0, -500.0);
    trial.operator(Operator::Order(Order::CancelCurrent));
    trial.run_for(0.5);
    assert!(
        trial.sent("RCB").is_empty(),
        "the way back to the insert that was interrupted leads over the wreck"
    );
}

#[test]
fn sr_019_an_insert_that_is_interrupted_without_a_bfmbe_stays_open() {
    let limits = Limits {
        inserts_open_max: 2,
        ..limits()
    };
    let mut trial = Trial::with_under_way(Setup {
        limits,
        ..Setup::default()
    });
    accepted(&mut trial, good_line(1), 1);
    begins(&mut trial, None, Some(1));
    accepted(&mut trial, interrupting(2), 2);
    // The insert has not ended: it is interrupted (SPI 6.10), and the vehicle may resume it.
    begins(&mut trial, None, Some(2));
    assert_eq!(
        shorts(&trial.states(1)).last(),
        Some(&"started"),
        "{:?}",
        trial.states(1)
    );
}

/// An insert east of the wreck begins, and one waits in the far east. Then another begins that interrupts the first, if
/// `interrupted`, or after the first has ended. After that the vehicle flies the waiting one.
fn flies_what_waited(interrupted: bool) -> Trial {
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
        Request::Trackline(line(2, (1000.0, -400.0), (300.0, -400.0))),
        2,
    );
    if interrupted {
        accepted(&mut trial, at_once(line(3, (1000.0, -300.0), (1100.0, -300.0))), 3);
    }
    ends(&mut trial, None, Some(1));
    if interrupted {
        begins(&mut trial, None, Some(3));
        ends(&mut trial, None, Some(3));
    }
    begins(&mut trial, None, Some(2));
    trial
}

#[test]
fn sr_002_the_way_back_to_an_interrupted_insert_is_checked_until_the_plan_goes_on() {
    let west = |tag| Request::Trackline(line(tag, (-600.0, -600.0), (-700.0, -1000.0)));
    accepted(&mut flies_what_waited(false), west(4), 4);
    let mut trial = flies_what_waited(true);
    // After the inserts of the set the vehicle may return to what the first has interrupted (SPI 7.5).
    refused_for(&mut trial, west(4), 4, "wreck");
    assert_eq!(shorts(&trial.states(1)).last(), Some(&"started"));
    ends(&mut trial, None, Some(2));
    begins(&mut trial, Some(2), None);
    assert!(
        format!("{:?}", trial.states(1)).contains("Interrupted"),
        "{:?}",
        trial.states(1)
    );
}

#[test]
fn sr_019_an_insert_stays_open_if_one_that_interrupts_may_have_begun_unheard() {
    for interrupting in [false, true] {
        let mut trial = Trial::under_way();
        accepted(&mut trial, good_line(1), 1);
        begins(&mut trial, None, Some(1));
        accepted(&mut trial, good_line(2), 2);
        if interrupting {
            accepted(&mut trial, course::interrupting(3), 3);
        }
        outage(&mut trial);
        begins(&mut trial, None, Some(2));
        let states = trial.states(1);
        let last = shorts(&states).last().map(|last| (*last).to_owned());
        assert_eq!(
            last.as_deref(),
            Some(if interrupting { "started" } else { "ended" }),
            "{states:?}"
        );
    }
}

#[test]
fn sr_019_an_insert_stays_open_if_another_payload_may_have_interrupted_it() {
    let mut trial = Trial::under_way();
    accepted(&mut trial, good_line(1), 1);
    begins(&mut trial, None, Some(1));
    begins(&mut trial, None, Some(40));
    assert_eq!(
        shorts(&trial.states(1)).last(),
        Some(&"started"),
        "{:?}",
        trial.states(1)
    );
    begins(&mut trial, Some(2), None);
    assert_eq!(shorts(&trial.states(1)).last(), Some(&"ended"), "{:?}", trial.states(1));
}

#[test]
fn sr_002_the_way_on_from_an_interrupting_insert_to_another_payloads_insert_is_checked() {
    let mut trial = Trial::new();
    trial.vehicle.moved = Some((1, EastNorth::new(900.0, 0.0)));
    trial.vehicle.start = EastNorth::new(400.0, 0.0);
    trial.vehicle.others = vec![(40, (-600.0, -700.0))];
    trial.run_for(2.0);
    refused_for(
        &mut trial,
        at_once(line(1, (900.0, -1500.0), (600.0, -1500.0))),
        1,
        "wreck",
    );
}

#[test]
fn sr_010_another_payloads_insert_is_not_interrupted() {
    let mut trial = Trial::under_way();
    begins(&mut trial, None, Some(40));
    refused_for(&mut trial, interrupting(1), 1, "interrupt");
}

#[test]
fn sr_002_another_payloads_insert_that_the_plan_does_not_name_is_not_modified() {
    let mut trial = Trial::under_way();
    // Another payload inserted it after core had asked for the plan.
    begins(&mut trial, None, Some(40));
    refused_for(&mut trial, turn(9, 90.0), 9, "neither in the plan nor an open insert");
}

fn beside_the_plan() -> Trial {
    let mut trial = Trial::under_way();
    begins(&mut trial, Some(9), None);
    trial.run_for(12.0);
    assert!(trial.core.has_control());
    trial
}

#[test]
fn sr_002_a_planned_behavior_that_is_missing_from_the_plan_is_not_modified() {
    let mut trial = beside_the_plan();
    // The wreck lies between here and the whole plan.
    led_to(&mut trial, 0.0, -1300.0);
    refused_for(&mut trial, Request::Modify(modify(9)), 9, "");
}

#[test]
fn sr_002_after_a_planned_behavior_that_is_missing_from_the_plan_any_other_may_come() {
    let mut trial = beside_the_plan();
    led_to(&mut trial, 0.0, -1300.0);
    refused_for(
        &mut trial,
        Request::Trackline(line(2, (0.0, -1400.0), (300.0, -1400.0))),
        2,
        "",
    );
}

#[test]
fn sr_002_the_transit_to_the_first_leg_counts_even_if_it_runs_along_another_leg() {
    // The last leg of the plan passes the place where the behavior begins, 23 degrees off the way from there to its
    // first point.
    let led_off = |last: [(f64, f64); 2]| {
        const WAY_DEG: f64 = 36.5;
        let mut trial = Trial::new();
        trial.vehicle.replies.insert("RMP", Reply::Silent);
        trial.vehicle.speed_mps = 1.0;
        trial.vehicle.heading_deg = WAY_DEG;
        trial.vehicle.start = EastNorth::new(-300.0, -1410.0).offset(WAY_DEG + 180.0, 4.0);
        trial.run_for(1.0);
        tells_plan(
            &mut trial,
            &[
                (300.0, -600.0),
                (1000.0, -600.0),
                (1000.0, -1800.0),
                (-700.0, -1800.0),
                last[0],
                last[1],
            ],
        );
        assert!(trial.core.has_control());
        begins(&mut trial, Some(1), None);
        trial.run_for(15.0);
        (trial.vehicle.speed_mps, trial.vehicle.heading_deg) = (1.5, 90.0);
        led_to(&mut trial, 500.0, -1200.0);
        trial
    };
    refused_for(
        &mut led_off([(-560.0, -1760.0), (-213.0, -1560.0)]),
        Request::Modify(modify(8)),
        8,
        "wreck",
    );
    refused_for(
        &mut led_off([(-560.0, -1560.0), (-213.0, -1360.0)]),
        Request::Modify(modify(9)),
        9,
        "wreck",
    );
}

#[test]
fn sr_002_the_entry_of_a_circle_may_lie_as_far_aside_as_a_tangent_touches_it() {
    let led_off = |entry_angle_deg| {
        let mut trial = Trial::new();
        trial.vehicle.start = EastNorth::new(571.0, -4.0);
        trial.run_for(2.0);
        let around = TrackcircleRequest {
            entry_angle_deg,
            interrupt: true,
            ..circle(1, (637.0, -4.0), 60.0)
        };
        accepted(&mut trial, Request::Trackcircle(around), 1);
        begins(&mut trial, None, Some(1));
        led_to(&mut trial, -1725.0, -4.0);
        trial
    };
    // The circle begins when the vehicle is at (575, -4), 2 m west of its rim. As seen from there, the rim point at the
    // entry angle 330 is 58 degrees to the left of the circle's middle (up to 76 are possible). The line of the way to
    // it, where it is abeam of here, is in the middle of the wreck.
    refused_for(&mut led_off(Some(330.0)), Request::Modify(modify(8)), 8, "wreck");
    refused_for(&mut led_off(None), Request::Modify(modify(9)), 9, "wreck");
}

#[test]
fn sr_002_a_waiting_insert_is_called_back_when_its_way_on_is_no_longer_good() {
    let mut trial = Trial::new();
    trial.vehicle.moved = Some((3, EastNorth::new(-300.0, -2000.0)));
    trial.run_for(2.0);
    let asked = |tag| Request::Trackline(line(tag, (800.0, -300.0), (450.0, -500.0)));
    accepted(&mut trial, asked(1), 1);
    ends(&mut trial, Some(1), None);
    begins(&mut trial, Some(2), None);
    trial.run_for(5.0);
    // If it were requested now, it would be rejected.
    refused_for(&mut trial, asked(2), 2, "wreck");
    assert_eq!(trial.sent("RCN").len(), 1, "it was not called back");
}

/// From its end the next behavior lies to the north. The leg lies to the north-west, behind the wreck.
fn beside_the_wreck(tag: u64) -> Request {
    Request::Trackline(line(tag, (700.0, -1200.0), (700.0, -1800.0)))
}

/// An interrupting insert far from the wreck.
fn by_the_leg(tag: u64) -> Request {
    at_once(line(tag, (-300.0, 200.0), (0.0, 200.0)))
}

#[test]
fn sr_002_an_interrupting_insert_is_refused_if_a_waiting_one_has_no_way_back_to_the_interrupted_leg() {
    let mut trial = Trial::under_way();
    accepted(&mut trial, beside_the_wreck(1), 1);
    refused_for(&mut trial, by_the_leg(2), 2, "wreck");
    trial.ask(0, [Request::Cancel(1)]);
    trial.run_for(1.0);
    accepted(&mut trial, by_the_leg(3), 3);
    // Now the vehicle may go back to the leg.
    refused_for(&mut trial, beside_the_wreck(4), 4, "wreck");
}

#[test]
fn sr_002_sr_020_the_way_back_to_the_line_of_an_interrupted_leg_is_checked_before_an_insert_is_cancelled() {
    let mut trial = Trial::new();
    // The leg begins at (700, 0).
    trial.vehicle.moved = Some((1, EastNorth::new(1300.0, 0.0)));
    trial.vehicle.start = EastNorth::new(800.0, 0.0);
    trial.run_for(2.0);
    accepted(
        &mut trial,
        Request::Trackline(line(1, (300.0, -1900.0), (50.0, -1900.0))),
        1,
    );
    accepted(
        &mut trial,
        Request::Trackline(line(2, (700.0, -1500.0), (700.0, -1000.0))),
        2,
    );
    accepted(&mut trial, at_once(line(3, (900.0, 200.0), (1200.0, 200.0))), 3);
    ends(&mut trial, Some(1), None);
    begins(&mut trial, None, Some(3));
    // From the end of the first insert the way to the start of the leg is clear, but the way to its line is not.
    trial.ask(0, [Request::Cancel(2)]);
    trial.run_for(0.5);
    let states = format!("{:?}", trial.cancel_states(2));
    assert!(states.contains("wreck"), "{states}");
}

#[test]
fn sr_002_a_waiting_insert_is_called_back_when_another_payload_interrupts() {
    let mut trial = Trial::new();
    trial.vehicle.others = vec![(40, (500.0, 100.0))];
    trial.run_for(2.0);
    accepted(&mut trial, beside_the_wreck(1), 1);
    ends(&mut trial, Some(1), None);
    begins(&mut trial, None, Some(40));
    assert_eq!(trial.sent("RCN").len(), 1, "it was not called back");
}

#[test]
fn sr_002_the_last_remaining_insert_is_also_called_back_if_its_way_on_is_no_longer_good() {
    let failing = PluginSetup {
        on_failure: FailAction::Cancel,
        ..plugin("second")
    };
    let mut trial = Trial::with(Setup {
        plugins: vec![plugin("first"), failing],
        ..Setup::default()
    });
    trial.vehicle.moved = Some((3, EastNorth::new(-300.0, -2000.0)));
    trial.run_for(2.0);
    accepted(
        &mut trial,
        Request::Trackline(line(1, (800.0, -300.0), (450.0, -500.0))),
        1,
    );
    trial.ask(1, [Request::Trackline(line(2, (480.0, -470.0), (500.0, -400.0)))]);
    trial.run_for(0.5);
    trial.vehicle.replies.insert("RCN", Reply::Silent);
    trial.fail(1, FaultKind::Trap);
    trial.run_for(0.5);
    let called_back =
        |trial: &Trial| BTreeSet::from_iter(trial.commands("RCN").iter().map(|(_, command)| name_of(command).1));
    assert_eq!(called_back(&trial), [Some(2)].into());
    ends(&mut trial, Some(1), None);
    begins(&mut trial, Some(2), None);
    assert_eq!(called_back(&trial), [Some(1), Some(2)].into());
}

#[test]
fn sr_002_the_turn_away_from_a_slow_modify_is_checked_at_the_speed_of_the_plan() {
    let at_edge = |speed_mps: f64| {
        let mut trial = Trial::new();
        // The plan is flown at 2 m/s.
        trial.vehicle.heading_deg = 0.0;
        trial.vehicle.speed_mps = 2.0;
        trial.vehicle.start = EastNorth::new(1500.0, -200.0);
        trial.run_for(5.0);
        // A modify has slowed the vehicle down.
        trial.vehicle.speed_mps = speed_mps;
        trial.vehicle.start = EastNorth::new(1948.0, 0.0);
        trial.run_for(12.0);
        trial
    };
    let north = |speed_mps, tag| {
        Request::Modify(backseat_core::plugin::ModifyRequest {
            heading_deg: 0.0,
            speed_mps,
            ..modify(tag)
        })
    };
    refused_for(&mut at_edge(2.0), north(2.0, 8), 8, "box");
    refused_for(&mut at_edge(1.0), north(1.0, 9), 9, "box");
}

#[test]
fn sr_002_a_plan_that_is_only_seen_shows_its_speed_too() {
    // The vehicle flies its plan at this speed, after an outage, and then slowly beside the eastern edge.
    let at_edge = |plan_mps: f64| {
        let mut trial = Trial::under_way();
        outage(&mut trial);
        trial.vehicle.speed_mps = plan_mps;
        led_to(&mut trial, -400.0, 0.0);
        trial.run_for(20.0);
        (trial.vehicle.speed_mps, trial.vehicle.heading_deg) = (1.0, 0.0);
        trial.vehicle.start = EastNorth::new(1932.0, 0.0);
        trial.run_for(12.0);
        trial
    };
    let north = |tag| {
        Request::Modify(backseat_core::plugin::ModifyRequest {
            heading_deg: 0.0,
            speed_mps: 1.0,
            ..modify(tag)
        })
    };
    accepted(&mut at_edge(1.9), north(8), 8);
    refused_for(&mut at_edge(2.6), north(9), 9, "box");
}

#[test]
fn sr_002_the_way_on_from_a_slow_insert_is_checked_at_the_speed_of_the_plan() {
    let asked = |speed_mps| {
        let mut trial = Trial::under_way();
        // The insert leads north beside the eastern edge. The next behavior lies behind it.
        let by = TracklineRequest {
            speed_mps,
            ..line(1, (1946.0, 600.0), (1946.0, 900.0))
        };
        trial.ask(0, [Request::Trackline(by)]);
        trial.run_for(0.5);
        trial.rejection(1)
    };
    assert!(asked(2.0).contains("box"));
    assert!(
        asked(1.0).contains("box"),
        "the plan that it goes on to is flown at up to 2 m/s"
    );
}

#[test]
fn sr_002_the_depth_of_an_insert_does_not_count_as_that_of_the_plan() {
    let after = |seconds: f64| {
        let mut trial = Trial::with(Setup {
            fence: course::harbour(),
            ..Setup::default()
        });
        trial.vehicle.moved = Some((2, EastNorth::new(400.0, -300.0)));
        trial.vehicle.depth_m = 4.0;
        trial.run_for(seconds);
        accepted(&mut trial, at_once(line(1, (-300.0, -400.0), (0.0, -400.0))), 1);
        ends(&mut trial, Some(1), None);
        begins(&mut trial, None, Some(1));
        trial.vehicle.depth_m = 20.0;
        trial.run_for(8.0);
        led_to(&mut trial, 1000.0, 600.0);
        trial
    };
    // The next behavior is at (1000, 0), south of the shoals, a keep-out zone down to 5 m.
    refused_for(&mut after(9.0), Request::Modify(modify(8)), 8, "shoals");
    refused_for(&mut after(2.0), Request::Modify(modify(9)), 9, "shoals");
}

#[test]
fn sr_002_the_depth_of_another_payloads_insert_is_unknown() {
    let mut trial = Trial::with(Setup {
        fence: course::harbour(),
        ..Setup::default()
    });
    trial.vehicle.others = vec![(40, (1000.0, 0.0))];
    trial.run_for(9.0);
    led_to(&mut trial, 1000.0, 600.0);
    refused_for(&mut trial, Request::Modify(modify(9)), 9, "shoals");
}

#[test]
fn sr_002_an_insert_whose_cancel_was_refused_may_no_longer_come_before_the_next_one() {
    // The wreck bars the way from the leg to the start of the second insert, but not the way from the end of the first.
    let first = || Request::Trackline(line(1, (800.0, -300.0), (800.0, -1500.0)));
    let second = || Request::Trackline(line(2, (0.0, -1500.0), (500.0, -1500.0)));
    let mut trial = Trial::under_way();
    accepted(&mut trial, first(), 1);
    accepted(&mut trial, second(), 2);

    let mut trial = Trial::under_way();
    accepted(&mut trial, first(), 1);
    trial.vehicle.replies.insert("RCN", Reply::Refuse);
    trial.ask(0, [Request::Cancel(1)]);
    trial.run_for(0.5);
    assert_eq!(shorts(&trial.cancel_states(1)), ["sent", "failed"]);
    refused_for(&mut trial, second(), 2, "wreck");
}
