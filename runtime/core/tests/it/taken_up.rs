//! What the vehicle goes back to, or on to, from where it has been led.

use std::collections::BTreeSet;

use backseat_core::plugin::{FaultKind, Request, TrackcircleRequest, TracklineRequest};
use backseat_core::{FailAction, Limits, Operator, Order, PluginSetup};
use backseat_spi::AckStatus;
use backseat_units::EastNorth;

use crate::course::{self, circle, good_line, interrupting, limits, line, modify, plugin, turn};
use crate::scene::{EAST, accepted, at_once, begins, ends, led_to, refused_for};
use crate::trial::{Setup, Trial, shorts};
use crate::vehicle::{Reply, name_of};

#[test]
fn sr_002_what_an_insert_has_interrupted_may_be_taken_up_from_where_a_modify_has_led() {
    let mut trial = Trial::new();
    trial.vehicle.start = EastNorth::new(700.0, -1300.0);
    trial.run_for(2.0);
    accepted(&mut trial, at_once(line(1, EAST.0, EAST.1)), 1);
    ends(&mut trial, Some(1), None);
    begins(&mut trial, None, Some(1));
    // Straight north of here, abeam, lies the leg that was interrupted, and between them the wreck.
    led_to(&mut trial, 100.0, -1500.0);
    refused_for(&mut trial, Request::Modify(modify(9)), 9, "wreck");
}

#[test]
fn sr_002_sr_020_the_way_back_to_an_interrupted_insert_is_judged_before_what_interrupts_is_cancelled() {
    let mut trial = Trial::under_way();
    // East of the wreck, from the south to the north.
    accepted(
        &mut trial,
        Request::Trackline(line(1, (900.0, -1500.0), (900.0, -300.0))),
        1,
    );
    begins(&mut trial, None, Some(1));
    led_to(&mut trial, 900.0, -350.0);
    // North of the wreck, from the west to the east.
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
fn sr_019_an_insert_that_is_interrupted_without_a_word_is_open_still() {
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
    // It has not ended: it is interrupted (SPI 6.10), and may be taken up again.
    begins(&mut trial, None, Some(2));
    assert_eq!(
        shorts(&trial.states(1)).last(),
        Some(&"started"),
        "{:?}",
        trial.states(1)
    );
}

#[test]
fn sr_002_the_way_on_from_an_interrupt_leads_to_another_payloads_insert_too() {
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
fn sr_010_an_insert_of_another_payload_is_not_interrupted() {
    let mut trial = Trial::under_way();
    begins(&mut trial, None, Some(40));
    refused_for(&mut trial, interrupting(1), 1, "interrupt");
}

#[test]
fn sr_002_an_insert_of_another_payload_that_the_plan_does_not_name_is_not_modified() {
    let mut trial = Trial::under_way();
    // After the plan was asked for another payload has had it inserted.
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
fn sr_002_a_planned_behavior_that_the_plan_does_not_tell_of_is_not_modified() {
    let mut trial = beside_the_plan();
    // Between here and all of the plan lies the wreck.
    led_to(&mut trial, 0.0, -1300.0);
    refused_for(&mut trial, Request::Modify(modify(9)), 9, "");
}

#[test]
fn sr_002_after_a_planned_behavior_that_the_plan_does_not_tell_of_any_may_come() {
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
fn sr_002_a_way_to_a_leg_that_runs_along_another_is_still_to_be_kept_in_mind() {
    // Its last leg leads past the place where it begins, 23 degrees off the way from there to its first point.
    let led_off = |last: [(f64, f64); 2]| {
        const WAY_DEG: f64 = 36.5;
        let mut trial = Trial::new();
        trial.vehicle.replies.insert("RMP", Reply::Silent);
        trial.vehicle.speed_mps = 1.0;
        trial.vehicle.heading_deg = WAY_DEG;
        trial.vehicle.start = EastNorth::new(-300.0, -1410.0).offset(WAY_DEG + 180.0, 4.0);
        trial.run_for(1.0);
        let Some((_, command)) = trial.commands("RMP").pop() else {
            panic!("no BPRMP")
        };
        let created = command.created().unwrap();
        let now = trial.now;
        trial
            .vehicle
            .acknowledge(now, ("RMP", created, None, AckStatus::Pending));
        trial.run_for(0.3);
        let places = [
            (300.0, -600.0),
            (1000.0, -600.0),
            (1000.0, -1800.0),
            (-700.0, -1800.0),
            last[0],
            last[1],
        ];
        for (index, place) in places.into_iter().enumerate() {
            let now = trial.now;
            trial.vehicle.say_element(now, Some(1), None, index, place);
        }
        trial.run_for(0.2);
        let now = trial.now;
        trial
            .vehicle
            .acknowledge(now, ("RMP", created, None, AckStatus::Succeeded));
        trial.run_for(0.5);
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
fn sr_002_a_circle_may_be_entered_as_far_aside_as_a_line_touches_it() {
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
    // It begins at (575, -4), 2 m west of the circle. A rim point at the entry angle 330 is 58 degrees to the left of the
    // circle's middle as seen from there (it may be 76): abeam of here the way to it is in the midst of the wreck.
    refused_for(&mut led_off(Some(330.0)), Request::Modify(modify(8)), 8, "wreck");
    refused_for(&mut led_off(None), Request::Modify(modify(9)), 9, "wreck");
}

#[test]
fn sr_002_an_insert_that_waits_is_called_back_where_its_way_on_no_longer_holds() {
    let mut trial = Trial::new();
    trial.vehicle.moved = Some((3, EastNorth::new(-300.0, -2000.0)));
    trial.run_for(2.0);
    let asked = |tag| Request::Trackline(line(tag, (800.0, -300.0), (450.0, -500.0)));
    accepted(&mut trial, asked(1), 1);
    ends(&mut trial, Some(1), None);
    begins(&mut trial, Some(2), None);
    trial.run_for(5.0);
    // Asked for now, it does not hold.
    refused_for(&mut trial, asked(2), 2, "wreck");
    assert_eq!(trial.sent("RCN").len(), 1, "it was not called back");
}

/// From its end what comes next lies to the north, and the leg to the north-west, behind the wreck.
fn beside_the_wreck(tag: u64) -> Request {
    Request::Trackline(line(tag, (700.0, -1200.0), (700.0, -1800.0)))
}

/// Far from the wreck.
fn by_the_leg(tag: u64) -> Request {
    at_once(line(tag, (-300.0, 200.0), (0.0, 200.0)))
}

#[test]
fn sr_002_what_interrupts_is_refused_where_an_insert_that_waits_has_no_way_back_to_what_is_interrupted() {
    let mut trial = Trial::under_way();
    accepted(&mut trial, beside_the_wreck(1), 1);
    refused_for(&mut trial, by_the_leg(2), 2, "wreck");
    trial.ask(0, [Request::Cancel(1)]);
    trial.run_for(1.0);
    accepted(&mut trial, by_the_leg(3), 3);
    // Now the leg may be taken up again.
    refused_for(&mut trial, beside_the_wreck(4), 4, "wreck");
}

#[test]
fn sr_002_sr_020_the_way_back_to_the_line_of_an_interrupted_leg_is_judged_before_an_insert_is_cancelled() {
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
    // From the end of the first the way to the start of the leg is clear, and the one to its line is not.
    trial.ask(0, [Request::Cancel(2)]);
    trial.run_for(0.5);
    let states = format!("{:?}", trial.cancel_states(2));
    assert!(states.contains("wreck"), "{states}");
}

#[test]
fn sr_002_an_insert_that_waits_is_called_back_where_another_payload_interrupts() {
    let mut trial = Trial::new();
    trial.vehicle.others = vec![(40, (500.0, 100.0))];
    trial.run_for(2.0);
    accepted(&mut trial, beside_the_wreck(1), 1);
    ends(&mut trial, Some(1), None);
    begins(&mut trial, None, Some(40));
    assert_eq!(trial.sent("RCN").len(), 1, "it was not called back");
}

#[test]
fn sr_002_the_last_insert_that_stays_is_called_back_for_its_way_on_too() {
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
fn sr_002_the_turn_away_from_a_slow_modify_may_be_as_wide_as_the_plan_is_fast() {
    let at_edge = |speed_mps: f64| {
        let mut trial = Trial::new();
        // The plan is flown at 2 m/s.
        trial.vehicle.heading_deg = 0.0;
        trial.vehicle.speed_mps = 2.0;
        trial.vehicle.start = EastNorth::new(1500.0, -200.0);
        trial.run_for(5.0);
        // A modify has slowed it down.
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
fn sr_002_the_way_on_from_a_slow_insert_may_be_flown_faster() {
    let asked = |speed_mps| {
        let mut trial = Trial::under_way();
        // Beside the eastern edge to the north; what comes next is behind it.
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
fn sr_002_the_depth_of_an_insert_is_not_the_plans() {
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
    // What comes next is at (1000, 0), south of the shoals that are to be kept out of above 5 m.
    refused_for(&mut after(9.0), Request::Modify(modify(8)), 8, "shoals");
    refused_for(&mut after(2.0), Request::Modify(modify(9)), 9, "shoals");
}

#[test]
fn sr_002_the_depth_of_another_payloads_insert_nobody_knows() {
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
fn sr_002_an_insert_that_the_vehicle_would_not_take_back_may_be_gone_from_before_the_next() {
    // From the leg the wreck lies before the start of the second, and from the end of the first it does not.
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
