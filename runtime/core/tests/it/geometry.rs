use backseat_core::plugin::Rule;
use backseat_core::plugin::{ModifyRequest, Request, TrackcircleRequest, TracklineRequest, VerticalRequest};
use backseat_core::{Limits, Start, plugin::Judge};
use backseat_units::EastNorth;

use crate::course::{LIFTED, circle, harbour, limits, line, modify, turn};
use crate::trial::{Setup, Trial, shorts};

/// The rejection of a request that must never reach the vehicle.
fn rejected(trial: &mut Trial, request: Request, tag: u64) -> String {
    trial.ask(0, [request]);
    trial.run_for(0.5);
    assert!(
        trial.commands("RTK").is_empty() && trial.commands("RTC").is_empty(),
        "{:?}",
        trial.states(tag)
    );
    trial.rejection(tag)
}

#[track_caller]
fn names_edge_and_metres(text: &str, zone: &str) {
    assert!(
        text.contains(zone) && text.contains(" edge ") && text.contains(" m "),
        "{text}"
    );
}

#[test]
fn sr_002_a_line_that_leaves_the_box_is_rejected_with_edge_and_metres() {
    let mut trial = Trial::under_way();
    let text = rejected(
        &mut trial,
        Request::Trackline(line(1, (0.0, 500.0), (2500.0, 500.0))),
        1,
    );
    names_edge_and_metres(&text, "outside keep-in zone 'box'");
}

#[test]
fn sr_002_the_lead_in_and_lead_out_belong_to_the_line() {
    // The line itself keeps 60 m from the edge. Leads of 50 m leave 10 m of that, and the margins need more.
    for (from, to) in [((0.0, 500.0), (1930.0, 500.0)), ((1930.0, 500.0), (0.0, 500.0))] {
        let mut trial = Trial::under_way();
        let text = rejected(&mut trial, Request::Trackline(line(1, from, to)), 1);
        names_edge_and_metres(&text, "outside keep-in zone 'box'");
        let limits = Limits {
            lead_max_m: 0.0,
            ..limits()
        };
        let mut trial = Trial::with_under_way(Setup {
            limits,
            ..Setup::default()
        });
        trial.ask(0, [Request::Trackline(line(1, from, to))]);
        trial.run_for(0.5);
        assert_eq!(shorts(&trial.states(1)), ["sent", "accepted"], "{:?}", trial.states(1));
    }
}

#[test]
fn sr_002_the_transit_to_the_line_is_checked() {
    // The line is south of the wreck. The way there from the end of the planned leg is clear; the way of an
    // interrupting insert, from here, is not.
    let across = line(1, (600.0, -1600.0), (300.0, -1600.0));
    let mut trial = Trial::new();
    trial.vehicle.start = EastNorth::new(-500.0, -400.0);
    trial.run_for(2.0);
    let text = rejected(
        &mut trial,
        Request::Trackline(TracklineRequest {
            interrupt: true,
            ..across
        }),
        1,
    );
    names_edge_and_metres(&text, "inside keep-out zone 'wreck'");
}

#[test]
fn sr_002_the_way_to_a_line_abeam_is_checked_with_the_width_of_a_turn() {
    // The straight way passes the wreck some 12 m or 33 m outside its margin and the errors. A turn at 1.5 m/s takes 22
    // m of that, and the current takes another 7 m.
    let asked = |east_m: f64| {
        let mut trial = Trial::under_way();
        let by = line(1, (east_m, -1400.0), (east_m + 300.0, -1400.0));
        trial.ask(0, [Request::Trackline(TracklineRequest { interrupt: true, ..by })]);
        trial.run_for(0.5);
        trial
    };
    names_edge_and_metres(&asked(565.0).rejection(1), "inside keep-out zone 'wreck'");
    let trial = asked(610.0);
    assert_eq!(shorts(&trial.states(1)), ["sent", "accepted"], "{:?}", trial.states(1));
}

#[test]
fn sr_002_the_way_from_an_insert_to_the_next_behavior_is_checked() {
    // From the end of the line the way to waypoint 2, 600 m east and 300 m north, leads over the wreck.
    let line = line(1, (600.0, -1700.0), (-500.0, -1700.0));
    let mut trial = Trial::under_way();
    let text = rejected(&mut trial, Request::Trackline(line), 1);
    names_edge_and_metres(&text, "inside keep-out zone 'wreck'");
}

#[test]
fn sr_002_the_way_from_one_insert_to_the_next_is_checked() {
    let mut trial = Trial::under_way();
    trial.ask(0, [Request::Trackline(line(1, (600.0, -300.0), (900.0, -1000.0)))]);
    trial.run_for(0.5);
    assert_eq!(shorts(&trial.states(1)), ["sent", "accepted"], "{:?}", trial.states(1));
    trial.ask(0, [Request::Trackline(line(2, (-600.0, -1000.0), (-600.0, -300.0)))]);
    trial.run_for(0.5);
    names_edge_and_metres(&trial.rejection(2), "inside keep-out zone 'wreck'");
}

#[test]
fn sr_002_a_circles_whole_rim_is_checked() {
    // Its centre and its entry in the north are far from the edge.
    let mut trial = Trial::under_way();
    let text = rejected(&mut trial, Request::Trackcircle(circle(1, (1500.0, 500.0), 480.0)), 1);
    names_edge_and_metres(&text, "outside keep-in zone 'box'");
    let mut trial = Trial::under_way();
    let text = rejected(&mut trial, Request::Trackcircle(circle(1, (400.0, -1000.0), 300.0)), 1);
    names_edge_and_metres(&text, "inside keep-out zone 'wreck'");
}

#[test]
fn sr_002_a_circle_whose_entry_the_vehicle_chooses_is_checked_for_every_entry() {
    // The circle is around the wreck. Entered in the north it is clear, but the vehicle may enter it anywhere and cross
    // the wreck.
    let around = circle(1, (0.0, -1000.0), 400.0);
    let mut trial = Trial::under_way();
    trial.ask(0, [Request::Trackcircle(around)]);
    trial.run_for(0.5);
    assert_eq!(shorts(&trial.states(1)), ["sent", "accepted"], "{:?}", trial.states(1));
    let mut trial = Trial::under_way();
    let open = TrackcircleRequest {
        entry_angle_deg: None,
        ..around
    };
    let text = rejected(&mut trial, Request::Trackcircle(open), 1);
    names_edge_and_metres(&text, "inside keep-out zone 'wreck'");
}

#[test]
fn sr_002_depths_and_altitudes_of_an_insert_are_checked() {
    let good = line(1, (0.0, 500.0), (300.0, 500.0));
    for (vertical, part) in [
        (VerticalRequest::DepthM(60.0), "deeper than the 60 m"),
        (VerticalRequest::AltitudeM(2.5), "m "),
        (VerticalRequest::AltitudeM(30.0), "deeper than the 60 m"),
    ] {
        let mut trial = Trial::under_way();
        let text = rejected(&mut trial, Request::Trackline(TracklineRequest { vertical, ..good }), 1);
        assert!(text.contains(part), "{vertical:?}: {text}");
    }
}

#[test]
fn an_altitude_needs_bottom_lock_or_a_known_depth() {
    let limits = Limits {
        water_depth_min_m: None,
        water_depth_max_m: None,
        ..limits()
    };
    let mut trial = Trial::with(Setup {
        limits,
        ..Setup::default()
    });
    trial.vehicle.altitude_m = None;
    trial.run_for(2.0);
    let climb = |tag| {
        Request::Modify(ModifyRequest {
            vertical: VerticalRequest::AltitudeM(60.0),
            ..modify(tag)
        })
    };
    trial.ask(0, [climb(1)]);
    trial.run_for(0.5);
    assert!(trial.rejection(1).contains("needs bottom lock"));
    trial.vehicle.altitude_m = Some(70.0);
    trial.run_for(0.5);
    trial.ask(0, [climb(2)]);
    trial.run_for(0.5);
    assert!(trial.core.is_steering(), "{:?}", trial.states(2));
    trial.vehicle.altitude_m = None;
    trial.run_for(7.0);
    assert!(
        !trial.core.is_steering(),
        "5 s after the last lock the altitude cannot be judged"
    );
}

#[test]
fn sr_002_a_modify_is_checked_for_everything_in_reach_until_it_lapses() {
    // At 1.5 m/s the vehicle moves 9 m until a modify lapses, and then needs the width of a turn.
    let mut trial = Trial::new();
    trial.vehicle.start = EastNorth::new(1940.0, 500.0);
    trial.run_for(2.0);
    trial.ask(0, [Request::Modify(modify(1))]);
    trial.run_for(0.5);
    names_edge_and_metres(&trial.rejection(1), "outside keep-in zone 'box'");
}

#[test]
fn sr_002_the_way_back_from_a_modify_to_the_plan_is_checked() {
    // The vehicle is south of the wreck and heads east: nothing is in reach, but the wreck bars the way back to the
    // planned leg.
    let mut trial = Trial::new();
    trial.vehicle.start = EastNorth::new(-50.0, -1500.0);
    trial.run_for(2.0);
    trial.ask(0, [Request::Modify(modify(1))]);
    trial.run_for(0.5);
    names_edge_and_metres(&trial.rejection(1), "inside keep-out zone 'wreck'");
}

#[test]
fn sr_002_the_way_back_from_a_modify_to_any_part_of_the_planned_leg_is_checked() {
    // Here the way to the next waypoint is clear, but the wreck bars the way to the western part of the current leg.
    let mut trial = Trial::new();
    trial.vehicle.start = EastNorth::new(600.0, -1500.0);
    trial.run_for(2.0);
    trial.ask(0, [Request::Modify(modify(1))]);
    trial.run_for(0.5);
    names_edge_and_metres(&trial.rejection(1), "inside keep-out zone 'wreck'");
}

/// A vehicle that steers to a line meets it abeam, possibly before the line's start. The wreck lies there.
fn with_a_leg_east_of_the_wreck(start: EastNorth) -> Trial {
    let mut trial = Trial::new();
    trial.vehicle.moved = Some((1, EastNorth::new(1300.0, -1000.0)));
    trial.vehicle.start = start;
    trial.run_for(2.0);
    trial
}

#[test]
fn sr_002_the_way_back_from_a_modify_to_a_legs_line_before_its_start_is_checked() {
    let mut trial = with_a_leg_east_of_the_wreck(EastNorth::new(0.0, -500.0));
    trial.ask(0, [Request::Modify(modify(1))]);
    trial.run_for(0.5);
    names_edge_and_metres(&trial.rejection(1), "inside keep-out zone 'wreck'");
    // Farther east nothing bars that way.
    let mut trial = with_a_leg_east_of_the_wreck(EastNorth::new(300.0, -500.0));
    trial.ask(0, [Request::Modify(modify(1))]);
    trial.run_for(0.5);
    assert_eq!(shorts(&trial.states(1)), ["sent", "accepted"], "{:?}", trial.states(1));
}

#[test]
fn sr_002_the_way_from_an_interrupting_insert_back_to_the_interrupted_line_is_checked() {
    let insert = |interrupt, end| {
        let mut trial = with_a_leg_east_of_the_wreck(EastNorth::new(-700.0, -500.0));
        let line = line(1, (-500.0, -500.0), end);
        trial.ask(0, [Request::Trackline(TracklineRequest { interrupt, ..line })]);
        trial.run_for(0.5);
        trial
    };
    let text = insert(true, (0.0, -500.0)).rejection(1);
    names_edge_and_metres(&text, "inside keep-out zone 'wreck'");
    for (interrupt, end) in [(false, (0.0, -500.0)), (true, (300.0, -500.0))] {
        let trial = insert(interrupt, end);
        assert_eq!(shorts(&trial.states(1)), ["sent", "accepted"], "{:?}", trial.states(1));
    }
}

#[test]
fn sr_002_the_way_back_from_a_modify_to_the_transit_before_a_leg_is_checked() {
    let led_off = |began: EastNorth| {
        let mut trial = Trial::new();
        trial.vehicle.moved = Some((1, EastNorth::new(900.0, -600.0)));
        trial.vehicle.start = began;
        trial.run_for(2.0);
        let now = trial.now;
        trial.vehicle.begin(now, Some(1), None);
        trial.run_for(1.0);
        trial.vehicle.start = EastNorth::new(500.0, -1200.0);
        trial.run_for(12.0);
        trial.ask(0, [Request::Modify(modify(1))]);
        trial.run_for(0.5);
        trial
    };
    // The wreck lies between the place where the behavior began and the start of the leg, and the vehicle would come
    // back to the straight way between these two.
    let text = led_off(EastNorth::new(-300.0, -1400.0)).rejection(1);
    names_edge_and_metres(&text, "inside keep-out zone 'wreck'");
    let trial = led_off(EastNorth::new(500.0, -1400.0));
    assert_eq!(shorts(&trial.states(1)), ["sent", "accepted"], "{:?}", trial.states(1));
}

#[test]
fn sr_002_a_behavior_that_begins_during_a_jump_may_have_begun_before_or_after_it() {
    const AWAY: EastNorth = EastNorth::new(-800.0, 0.0);
    let led_off = |east_m, jumps: fn(&mut Trial)| {
        let mut trial = Trial::new();
        trial.vehicle.moved = Some((1, EastNorth::new(900.0, -600.0)));
        trial.vehicle.start = EastNorth::new(east_m, -1400.0);
        trial.run_for(2.0);
        jumps(&mut trial);
        trial.vehicle.start = EastNorth::new(500.0, -1200.0);
        trial.vehicle.jump = EastNorth::default();
        trial.run_for(15.0);
        trial.ask(0, [Request::Modify(modify(1))]);
        trial.run_for(0.5);
        trial
    };
    // The wreck bars the way back to the transit from the other place.
    let at_once = led_off(500.0, |trial| {
        trial.vehicle.begin(trial.now, Some(1), None);
        trial.vehicle.jump = AWAY;
        trial.run_for(1.0);
    });
    names_edge_and_metres(&at_once.rejection(1), "inside keep-out zone 'wreck'");
    let unheard = led_off(500.0, |trial| {
        trial.vehicle.jump = AWAY;
        trial.run_for(1.0);
        trial.cut();
        trial.vehicle.jump = EastNorth::default();
    });
    names_edge_and_metres(&unheard.rejection(1), "inside keep-out zone 'wreck'");
    // On a new connection the begin arrives before any navigation.
    let unplaced = led_off(-300.0, |_| ());
    names_edge_and_metres(&unplaced.rejection(1), "inside keep-out zone 'wreck'");
    let later = led_off(500.0, |trial| {
        trial.vehicle.begin(trial.now, Some(1), None);
        trial.run_for(1.0);
        trial.vehicle.jump = AWAY;
        trial.run_for(1.0);
    });
    assert_eq!(shorts(&later.states(1)), ["sent", "accepted"], "{:?}", later.states(1));
}

#[test]
fn sr_002_the_way_to_an_insert_is_checked_with_and_without_its_lead_in() {
    let led_off = |start: (f64, f64)| {
        let mut trial = Trial::new();
        trial.vehicle.start = EastNorth::new(300.0, -400.0);
        trial.run_for(2.0);
        let end = (start.0 + 300.0, start.1);
        let line = TracklineRequest {
            interrupt: true,
            ..line(1, start, end)
        };
        trial.ask(0, [Request::Trackline(line)]);
        trial.run_for(1.0);
        let now = trial.now;
        trial.vehicle.end(now, Some(1), None);
        trial.vehicle.begin(now, None, Some(1));
        trial.run_for(1.0);
        trial.vehicle.start = EastNorth::new(-400.0, -900.0);
        trial.run_for(12.0);
        trial.ask(0, [Request::Modify(modify(2))]);
        trial.run_for(0.5);
        trial
    };
    // The insert began 20 m south of the start of its line. Without a lead-in the way to the line leads north, and to
    // come back to that way the vehicle would pass the wreck. With the longest lead-in it leads west.
    let text = led_off((300.0, -380.0)).rejection(2);
    names_edge_and_metres(&text, "inside keep-out zone 'wreck'");
    let trial = led_off((500.0, -350.0));
    assert_eq!(shorts(&trial.states(2)), ["sent", "accepted"], "{:?}", trial.states(2));
}

#[test]
fn sr_002_the_way_back_from_a_modify_is_checked_at_the_depths_of_the_plan() {
    // East of the planned leg lie shoals, a keep-out zone down to 5 m. The modify is flown at 20 m.
    let started_and_asked_after = |start: Start, seconds: f64, flown_at_m: f64| {
        let mut trial = Trial::with(Setup {
            fence: harbour(),
            start,
            limits: Limits {
                integrity: LIFTED,
                ..limits()
            },
            ..Setup::default()
        });
        trial.vehicle.moved = Some((1, EastNorth::new(600.0, 0.0)));
        trial.vehicle.start = EastNorth::new(1000.0, 600.0);
        trial.vehicle.depth_m = flown_at_m;
        trial.vehicle.replays = false;
        trial.run_for(0.5);
        // What a process hears first, the vehicle may take up again. What comes after that begins for the first time.
        for number in [3, 1] {
            let now = trial.now;
            trial.vehicle.begin(now, Some(number), None);
        }
        let now = trial.now;
        trial.vehicle.set_status(now, "Running");
        trial.vehicle.set_control(now, true);
        trial.run_for(seconds - 0.5);
        trial.vehicle.depth_m = 20.0;
        trial.run_for(1.0);
        trial.ask(0, [Request::Modify(modify(1))]);
        trial.run_for(0.5);
        trial
    };
    let asked_after = |seconds, flown_at_m| started_and_asked_after(Setup::default().start, seconds, flown_at_m);
    let trial = asked_after(9.0, 20.0);
    assert_eq!(shorts(&trial.states(1)), ["sent", "accepted"], "{:?}", trial.states(1));
    names_edge_and_metres(&asked_after(9.0, 4.0).rejection(1), "inside keep-out zone 'shoals'");
    // The depth of the plan is not known yet.
    names_edge_and_metres(&asked_after(2.0, 20.0).rejection(1), "inside keep-out zone 'shoals'");
    // The depth at which a previous run has left the vehicle is not the plan's.
    let mut second = Setup::default().start;
    if let Some(identifiers) = &mut second.identifiers {
        (identifiers.next, identifiers.reserved) = (40, 40);
    }
    let trial = started_and_asked_after(second, 9.0, 20.0);
    names_edge_and_metres(&trial.rejection(1), "inside keep-out zone 'shoals'");
    let trial = started_and_asked_after(second, 20.0, 20.0);
    assert_eq!(shorts(&trial.states(1)), ["sent", "accepted"], "{:?}", trial.states(1));
}

#[test]
fn a_plugins_query_gets_the_same_verdict_as_its_request() {
    let mut trial = Trial::under_way();
    let envelope = crate::course::envelope(limits());
    let (_, input) = trial.steps(0).pop().unwrap();
    assert!(envelope.judge(&Request::Modify(modify(1)), &input).is_ok());
    let refusal = envelope
        .judge(&Request::Trackline(line(1, (0.0, 500.0), (2500.0, 500.0))), &input)
        .unwrap_err();
    assert_eq!(refusal.rule(), Rule::KeepIn);
    let text = rejected(
        &mut trial,
        Request::Trackline(line(1, (0.0, 500.0), (2500.0, 500.0))),
        1,
    );
    assert_eq!(text, refusal.to_string());
}

#[test]
fn a_heading_beyond_a_full_turn_is_rejected_and_nan_is_called_nan() {
    for (heading_deg, said) in [
        (361.0, "heading is 361; expected -360 to 360 deg"),
        (-360.5, "heading is -360.5; expected -360 to 360 deg"),
        (9000.0, "heading is 9000; expected -360 to 360 deg"),
        (f64::NAN, "heading is NaN; expected -360 to 360 deg"),
        (f64::INFINITY, "heading is infinite; expected -360 to 360 deg"),
    ] {
        let mut trial = Trial::under_way();
        let text = rejected(&mut trial, turn(1, heading_deg), 1);
        assert_eq!(text, format!("limit: {said}"));
        assert!(trial.commands("RMB").is_empty());
    }
    for heading_deg in [360.0, -360.0, -90.0] {
        let mut trial = Trial::under_way();
        trial.ask(0, [turn(1, heading_deg)]);
        trial.run_for(0.5);
        assert!(shorts(&trial.states(1)).contains(&"sent"), "{heading_deg}");
    }
}
