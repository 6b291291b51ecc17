use std::time::Duration;

use backseat_core::plugin::{FaultKind, ModifyRequest, Request, RequestState, VerticalRequest};
use backseat_core::{HeadingFrame, Limits, Operator, Settings};
use backseat_spi::{AckStatus, HorizontalMode, ModifySpeedMode, ModifyVerticalMode, ToVehicle};
use backseat_units::{EastNorth, TimeOfDay, Timestamp};

use crate::course::{LIFTED, limits, line, modify, modify_for, turn};
use crate::scene::{begins, led_to};
use crate::trial::{Setup, Trial, shorts};
use crate::vehicle::Reply;

/// The BPRMB of this number, from 0.
fn modified(trial: &Trial, number: usize) -> backseat_spi::ModifyBehavior {
    match trial.commands("RMB").get(number) {
        Some((_, ToVehicle::ModifyBehavior(modify))) => modify.clone(),
        other => panic!("BPRMB {number} is {other:?}"),
    }
}

/// The last BPRMB.
fn last_modify(trial: &Trial) -> backseat_spi::ModifyBehavior {
    match trial.commands("RMB").pop() {
        Some((_, ToVehicle::ModifyBehavior(modify))) => modify,
        other => panic!("{other:?}"),
    }
}

#[test]
fn sr_003_a_lease_is_sent_at_once_and_refreshed_each_second_until_its_term_ends() {
    let mut trial = Trial::under_way();
    let asked = trial.now;
    trial.ask(0, [modify_for(1, Duration::from_secs(10))]);
    trial.run_for(15.0);
    let sent = trial.sent("RMB");
    assert!(sent[0].since(asked) < Duration::from_millis(120), "{:?}", sent[0]);
    for pair in sent.windows(2) {
        assert_eq!(pair[1].since(pair[0]), Duration::from_secs(1));
    }
    let ended = trial.sent("EMB");
    assert_eq!((sent.len(), ended.len()), (10, 1));
    assert_eq!(ended[0].since(sent[0]), Duration::from_secs(10));
    assert_eq!(shorts(&trial.states(1)), ["sent", "accepted", "ended"]);
    assert_eq!(trial.core.open_requests(), 0);
}

#[test]
fn sr_003_a_modify_always_contains_all_three_values() {
    let mut trial = Trial::steering();
    let said = last_modify(&trial);
    assert_eq!(
        (said.horizontal, said.horizontal_mode),
        (Some(90.0), Some(HorizontalMode::Heading))
    );
    assert_eq!(
        (said.vertical_m, said.vertical_mode),
        (Some(20.0), Some(ModifyVerticalMode::Depth))
    );
    assert_eq!(
        (said.speed, said.speed_mode),
        (Some(1.5), Some(ModifySpeedMode::MetresPerSecond))
    );
    let climb = ModifyRequest {
        vertical: VerticalRequest::AltitudeM(50.0),
        speed_mps: 1.2,
        ..modify(1)
    };
    trial.ask(0, [Request::Modify(climb)]);
    trial.run_for(0.5);
    let said = last_modify(&trial);
    assert_eq!(
        (said.vertical_m, said.vertical_mode, said.speed),
        (Some(50.0), Some(ModifyVerticalMode::Altitude), Some(1.2))
    );
}

#[test]
fn a_changed_modify_is_sent_at_once_and_at_most_five_times_a_second() {
    let mut trial = Trial::steering();
    let start = trial.now;
    let mut heading = 90.0;
    trial.script(0, move |_| {
        heading += 1.0;
        (Duration::from_millis(1), Ok(vec![turn(1, heading)]))
    });
    trial.run_for(4.0);
    let sent = trial.sent_since("RMB", start);
    assert!((18..=21).contains(&sent.len()), "{}", sent.len());
    // The judge of the trial refuses pauses below 200 ms.
    assert!(
        sent.windows(2)
            .all(|pair| pair[1].since(pair[0]) <= Duration::from_millis(310))
    );
}

#[test]
fn sr_004_a_changed_modify_that_is_requested_again_is_sent_no_later() {
    let mut trial = Trial::under_way();
    let mut step = 0;
    trial.script(0, move |_| {
        step += 1;
        let heading = if step == 1 { 90.0 } else { 270.0 };
        (Duration::from_millis(1), Ok(vec![turn(1, heading)]))
    });
    trial.run_for(3.0);
    let sent = trial.sent("RMB");
    let after = sent[1].since(sent[0]);
    assert!(after <= Duration::from_millis(310), "{after:?}");
    assert_ne!(modified(&trial, 0).horizontal, modified(&trial, 1).horizontal);
    assert!(
        sent[2].since(sent[1]) >= Duration::from_millis(990),
        "it does not change again"
    );
}

/// The plugin changes its mind, and back again before the change is sent.
#[test]
fn a_change_that_is_taken_back_before_it_is_sent_causes_no_bprmb() {
    let mut trial = Trial::under_way();
    let mut step = 0;
    trial.script(0, move |_| {
        step += 1;
        let heading = if step == 2 { 270.0 } else { 90.0 };
        (Duration::from_millis(1), Ok(vec![turn(1, heading)]))
    });
    trial.run_for(1.5);
    let sent = trial.sent("RMB");
    assert_eq!(sent.len(), 2, "{sent:?}");
    assert_eq!(modified(&trial, 0).horizontal, modified(&trial, 1).horizontal);
}

#[test]
fn an_unchanged_modify_that_is_requested_again_is_not_sent_more_often() {
    let mut trial = Trial::steering();
    trial.script(0, |_| (Duration::from_millis(1), Ok(vec![Request::Modify(modify(1))])));
    let start = trial.now;
    trial.run_for(10.0);
    assert!((9..=11).contains(&trial.sent_since("RMB", start).len()));
    assert!(trial.lease_ends().is_empty());
    assert_eq!(trial.core.open_requests(), 1);
}

#[test]
fn leases_that_end_and_begin_are_sent_at_most_five_times_a_second() {
    let mut trial = Trial::under_way();
    trial.script(0, |_| {
        (
            Duration::from_millis(1),
            Ok(vec![
                turn(1, 90.0),
                Request::EndModify,
                turn(2, 91.0),
                Request::EndModify,
            ]),
        )
    });
    trial.run_for(3.0);
    assert!(trial.sent("RMB").len() <= 16);
}

#[test]
fn sr_003_a_lease_ends_with_one_bpemb_whatever_ends_it() {
    type End = fn(&mut Trial);
    let ends: [(&str, End); 11] = [
        ("its plugin ended it", |trial| trial.ask(0, [Request::EndModify])),
        ("its plugin failed", |trial| trial.fail(0, FaultKind::Error)),
        ("its plugin failed", |trial| trial.fail(0, FaultKind::Trap)),
        ("the vehicle refused it", |trial| {
            trial.vehicle.replies.insert("RMB", Reply::Refuse);
        }),
        ("the vehicle refused it", |trial| {
            trial.vehicle.replies.insert("RMB", Reply::Nak);
        }),
        ("the vehicle refused it", |trial| {
            let reply = Reply::Pending(Duration::from_millis(500), AckStatus::Failed);
            trial.vehicle.replies.insert("RMB", reply);
        }),
        ("the vehicle did not acknowledge it", |trial| {
            trial.vehicle.replies.insert("RMB", Reply::Silent);
        }),
        ("a behavior began during it", |trial| {
            let now = trial.now;
            trial.vehicle.begin(now, Some(2), None);
        }),
        ("a behavior ended during it", |trial| {
            let now = trial.now;
            trial.vehicle.end(now, Some(1), None);
        }),
        ("the operator's hold is set", |trial| trial.operator(Operator::Hold)),
        ("the run is ending", |trial| trial.operator(Operator::Stop)),
    ];
    for (reason, end) in ends {
        let mut trial = Trial::steering();
        let before = trial.now;
        end(&mut trial);
        trial.run_for(4.0);
        let ended = trial.lease_ends();
        assert_eq!(ended.len(), 1, "{reason}");
        assert!(ended[0].1.starts_with(reason), "{reason}: {}", ended[0].1);
        let emb = trial.sent_since("EMB", before);
        assert_eq!(emb, [ended[0].0], "{reason}");
        assert!(trial.sent_since("RMB", emb[0]).is_empty(), "silence after: {reason}");
        assert!(!trial.core.is_steering() && trial.core.open_requests() == 0, "{reason}");
    }
}

#[test]
fn sr_003_a_missing_acknowledgement_ends_the_lease_after_a_second() {
    let mut trial = Trial::under_way();
    trial.vehicle.replies.insert("RMB", Reply::Silent);
    trial.ask(0, [Request::Modify(modify(1))]);
    trial.run_for(3.0);
    let (first, end) = (trial.sent("RMB")[0], trial.sent("EMB")[0]);
    assert_eq!(end.since(first), Duration::from_secs(1));
    assert_eq!(shorts(&trial.states(1)), ["sent", "timed out"]);
}

#[test]
fn sr_003_an_acknowledgement_may_come_late_within_the_second() {
    let mut trial = Trial::under_way();
    trial
        .vehicle
        .replies
        .insert("RMB", Reply::Late(Duration::from_millis(900), AckStatus::Succeeded));
    trial.ask(0, [Request::Modify(modify(1))]);
    trial.run_for(5.0);
    assert!(trial.lease_ends().is_empty());
}

/// The link may change a digit of a BPRMB's time without its checksum, and a vehicle may refuse what it took before.
/// Which BPRMB it means does not matter: the lease has no other end that it could mean.
#[test]
fn sr_003_a_refusal_of_any_time_within_the_lease_ends_it() {
    let refusals: [fn(&Trial) -> TimeOfDay; 2] = [
        // The first BPRMB, which was accepted.
        |trial| modified(trial, 0).created,
        // No BPRMB.
        |trial| TimeOfDay::from_nanos(modified(trial, 1).created.as_nanos() - 17_000_000).unwrap(),
    ];
    for refused in refusals {
        let mut trial = Trial::under_way();
        trial.ask(0, [Request::Modify(modify(1))]);
        trial.run_for(1.5);
        let echo = refused(&trial);
        let before = trial.now;
        trial
            .vehicle
            .acknowledge(before, ("RMB", echo, None, AckStatus::Failed));
        trial.run_for(0.1);
        assert_eq!(trial.sent_since("EMB", before).len(), 1);
        trial.ask(0, [Request::Modify(modify(2))]);
        trial.run_for(0.5);
        assert!(trial.rejection(2).starts_with("pause: "), "{}", trial.rejection(2));
    }
}

#[test]
fn sr_003_a_refusal_of_a_time_before_the_lease_does_not_end_it() {
    let mut trial = Trial::under_way();
    trial.ask(0, [Request::Modify(modify(1))]);
    trial.run_for(1.5);
    trial.ask(0, [Request::EndModify]);
    trial.run_for(1.5);
    trial.ask(0, [Request::Modify(modify(2))]);
    trial.run_for(1.5);
    let echo = modified(&trial, 0).created;
    let before = trial.now;
    trial
        .vehicle
        .acknowledge(before, ("RMB", echo, None, AckStatus::Failed));
    trial.run_for(3.0);
    assert!(trial.core.is_steering() && trial.sent_since("EMB", before).is_empty());
}

#[test]
fn sr_003_a_refusal_ends_a_lease_that_was_renewed_meanwhile() {
    let mut trial = Trial::under_way();
    trial
        .vehicle
        .replies
        .insert("RMB", Reply::Late(Duration::from_millis(300), AckStatus::Failed));
    trial.script(0, |_| (Duration::from_millis(1), Ok(vec![Request::Modify(modify(1))])));
    trial.run_for(0.2);
    trial.run_for(0.5);
    assert!(
        !trial.lease_ends().is_empty(),
        "the vehicle refuses every BPRMB and the lease goes on"
    );
}

#[test]
fn sr_003_a_wake_up_late_by_over_half_a_second_ends_the_lease_before_any_input_is_handled() {
    let mut trial = Trial::steering();
    let asleep = trial.now;
    trial.asleep_until = asleep + Duration::from_millis(1800);
    trial.run_for(3.0);
    let woke = trial.lease_ends()[0].0;
    assert_eq!(woke, trial.asleep_until);
    assert_eq!(trial.lease_ends()[0].1, "the runtime woke late");
    assert_eq!(trial.core.late_count(), 1);
    assert_eq!(trial.names_since(woke)[0], "EMB", "before all else");
    assert!(trial.sent_since("RMB", woke).is_empty());
}

#[test]
fn a_slightly_late_wake_up_is_tolerated() {
    let mut trial = Trial::steering();
    trial.asleep_until = trial.now + Duration::from_millis(450);
    trial.run_for(3.0);
    assert!(trial.lease_ends().is_empty() && trial.core.late_count() == 0);
}

#[test]
fn sr_004_each_refresh_of_a_lease_is_checked_again_and_the_fence_ends_it() {
    // The vehicle drifts towards the western edge, some 1990 m from the middle, although the modify says east.
    let mut trial = Trial::new();
    trial.vehicle.start = EastNorth::new(-1850.0, 500.0);
    trial.vehicle.heading_deg = 270.0;
    trial.run_for(2.0);
    trial.ask(0, [modify_for(1, Duration::from_secs(60))]);
    trial.run_for(60.0);
    let (ended, reason) = trial.lease_ends().pop().expect("an end");
    assert!(
        reason.contains("outside keep-in zone 'box'") && reason.contains("edge"),
        "{reason}"
    );
    assert_eq!(trial.sent("EMB"), [ended]);
    let here = trial.core.navigation().unwrap().local.east_m;
    assert!(here > -1990.0, "{here}");
    assert!(trial.sent("RMB").len() > 10, "the lease went on at first");
    assert!(matches!(trial.states(1).last(), Some(RequestState::Ended(text)) if text.cause() == "keep-in"));
}

#[test]
fn sr_004_a_lease_that_comes_to_reach_the_margin_ends_at_that_sample_and_not_at_its_next_refresh() {
    // The seabed rises under the vehicle; only the bottom lock shows it.
    let setup = Setup {
        limits: Limits {
            water_depth_min_m: None,
            water_depth_max_m: None,
            integrity: LIFTED,
            ..limits()
        },
        ..Setup::default()
    };
    let mut trial = Trial::with_under_way(setup);
    trial.ask(0, [Request::Modify(modify(1))]);
    trial.run_for(1.5);
    let refreshed = *trial.sent("RMB").last().unwrap();
    while trial.now.since(refreshed) < Duration::from_millis(300) {
        trial.run_for(0.01);
    }
    trial.vehicle.altitude_m = Some(2.5);
    let risen = trial.now;
    trial.run_for(2.0);
    let (ended, reason) = trial.lease_ends().pop().expect("an end");
    assert!(ended.since(risen) <= Duration::from_millis(110), "{risen} {ended}");
    assert!(
        ended.since(refreshed) < Duration::from_millis(500),
        "before the next refresh"
    );
    assert!(
        reason.starts_with("altitude: ") && reason.contains("m too deep for the altitude of 2 m"),
        "{reason}"
    );
    assert_eq!(trial.sent_since("EMB", risen), [ended]);
}

/// A modify towards the eastern edge at 2 m/s, from this far east. If it `slows`, the plugin asks for 1 m/s in its
/// second step and later, and the first change waits for its turn. Returns how long after the first BPRMB the lease
/// ends, and when the second BPRMB is sent.
fn eastward(east_m: f64, slows: bool) -> [Option<Duration>; 2] {
    let mut trial = Trial::under_way();
    led_to(&mut trial, east_m, 0.0);
    begins(&mut trial, Some(1), None);
    let mut step = 0;
    trial.script(0, move |_| {
        step += 1;
        let speed_mps = if slows && step > 1 { 1.0 } else { 2.0 };
        let asked = ModifyRequest { speed_mps, ..modify(1) };
        (Duration::from_millis(1), Ok(vec![Request::Modify(asked)]))
    });
    let start = trial.now;
    trial.run_for(1.2);
    let sent = trial.sent_since("RMB", start);
    let Some(first) = sent.first() else { return [None; 2] };
    let ended = trial.sent_since("EMB", *first).first().map(|at| at.since(*first));
    [ended, sent.get(1).map(|at| at.since(*first))]
}

#[test]
fn sr_004_until_a_changed_setpoint_is_sent_the_one_that_the_vehicle_flies_is_judged_too() {
    let mut found = 0;
    for tenths in 19_180..19_210 {
        let east_m = f64::from(tenths) / 10.0;
        let [Some(ended), _] = eastward(east_m, false) else {
            continue;
        };
        if ended > Duration::from_millis(10) && ended < Duration::from_millis(900) {
            found += 1;
            let [slower_ended, slower_sent] = eastward(east_m, true);
            let flown = slower_ended.into_iter().chain(slower_sent).min();
            // The vehicle flies the first setpoint no longer than a lease of that alone allows.
            assert!(
                flown.is_some_and(|flown| flown <= ended),
                "{east_m}: {ended:?} {slower_ended:?} {slower_sent:?}"
            );
        }
    }
    assert!(found >= 2, "{found}");
}

#[test]
fn sr_004_an_insert_requested_during_a_lease_is_at_once_part_of_the_way_back() {
    let mut trial = Trial::new();
    trial.vehicle.start = EastNorth::new(-640.0, 0.0);
    trial.run_for(2.0);
    trial.ask(0, [turn(1, 270.0)]);
    trial.run_for(0.5);
    assert!(trial.core.is_steering(), "{:?}", trial.states(1));
    let before = trial.now;
    // The insert itself is good, because the way there is clear of the wreck. But in a turn back to it a vehicle under
    // the lease may come nearer to the wreck.
    trial.ask(1, [Request::Trackline(line(2, (705.0, -1400.0), (990.0, -1400.0)))]);
    trial.run_for(0.35);
    assert_eq!(shorts(&trial.states(2)), ["sent", "accepted"]);
    let (ended, reason) = trial.lease_ends().pop().expect("an end");
    assert!(reason.contains("wreck"), "{reason}");
    assert!(ended.since(before) <= Duration::from_millis(350));
}

#[test]
fn the_heading_is_measured_from_the_north_that_the_vehicle_uses() {
    let heading = |frame| {
        let settings = Settings {
            heading_frame: frame,
            ..Settings::default()
        };
        let mut trial = Trial::with_under_way(Setup {
            settings,
            ..Setup::default()
        });
        trial.ask(0, [Request::Modify(modify(1))]);
        trial.run_for(0.5);
        last_modify(&trial).horizontal.unwrap()
    };
    assert_eq!(heading(HeadingFrame::True), 90.0);
    // At 42 N and a degree west of the zone's meridian the grid's north lies 0.67 degrees west of true north.
    let grid = heading(HeadingFrame::Grid);
    assert!((grid - 90.67).abs() < 0.02, "{grid}");
}

#[test]
fn a_plugin_of_higher_priority_takes_the_lease_and_one_of_lower_priority_is_rejected() {
    let mut trial = Trial::under_way();
    trial.ask(1, [Request::Modify(modify(1))]);
    trial.run_for(0.5);
    let taken = trial.now;
    trial.ask(0, [turn(2, 45.0)]);
    trial.run_for(0.5);
    assert_eq!(shorts(&trial.states(1)).last(), Some(&"ended"));
    assert_eq!(shorts(&trial.states(2)), ["sent", "accepted"]);
    assert!(
        trial.sent_since("EMB", taken).is_empty(),
        "the vehicle only gets another setpoint"
    );
    trial.ask(1, [Request::Modify(modify(3)), Request::EndModify]);
    trial.run_for(0.5);
    assert!(trial.rejection(3).contains("higher priority"));
    assert!(
        trial.core.is_steering(),
        "the plugin of lower priority cannot end it either"
    );
    trial.ask(0, [Request::EndModify]);
    trial.run_for(0.3);
    trial.ask(1, [Request::Modify(modify(4))]);
    trial.run_for(0.5);
    assert!(trial.core.is_steering());
}

#[test]
fn a_rejected_modify_of_a_plugin_of_higher_priority_leaves_the_other_steering() {
    let mut trial = Trial::under_way();
    trial.ask(1, [Request::Modify(modify(1))]);
    trial.run_for(0.5);
    trial.ask(0, [turn(2, f64::NAN)]);
    trial.run_for(0.5);
    assert!(trial.core.is_steering() && trial.lease_ends().is_empty());
    assert_eq!(shorts(&trial.states(2)), ["rejected"]);
}

#[test]
fn sr_002_without_the_vehicles_plan_a_modify_is_rejected_unless_the_mission_allows_it() {
    for needs in [true, false] {
        let limits = Limits {
            modify_needs_plan: needs,
            ..limits()
        };
        let mut trial = Trial::with(Setup {
            limits,
            ..Setup::default()
        });
        trial.vehicle.replies.insert("RMP", Reply::Refuse);
        trial.run_for(3.0);
        trial.ask(0, [Request::Modify(modify(1))]);
        trial.run_for(0.5);
        assert_eq!(trial.core.is_steering(), !needs);
        if needs {
            assert!(trial.rejection(1).contains("plan unknown"));
            trial.vehicle.replies.clear();
            trial.run_for(8.0);
            trial.ask(0, [Request::Modify(modify(2))]);
            trial.run_for(0.5);
            assert!(trial.core.is_steering(), "the plan is asked for again");
        }
    }
}

#[test]
fn sr_007_a_cut_link_ends_the_lease_and_nothing_is_sent_for_it_later() {
    let mut trial = Trial::steering();
    let cut = trial.now;
    trial.cut();
    trial.run_for(10.0);
    assert!(trial.sent_since("EMB", cut).is_empty() && trial.sent_since("RMB", cut).is_empty());
    assert_eq!(shorts(&trial.states(1)).last(), Some(&"ended"));
    assert_eq!(trial.core.open_requests(), 0);
}

#[test]
fn terms_and_figures_beyond_the_limits_are_rejected_and_never_clamped() {
    let mut trial = Trial::under_way();
    let bad = [
        modify_for(1, Duration::ZERO),
        modify_for(2, Duration::from_secs(61)),
        turn(3, f64::INFINITY),
        Request::Modify(ModifyRequest {
            speed_mps: 2.1,
            ..modify(4)
        }),
        Request::Modify(ModifyRequest {
            speed_mps: f64::NAN,
            ..modify(5)
        }),
        Request::Modify(ModifyRequest {
            vertical: VerticalRequest::DepthM(f64::NAN),
            ..modify(6)
        }),
        Request::Modify(ModifyRequest {
            vertical: VerticalRequest::DepthM(70.0),
            ..modify(7)
        }),
        Request::Modify(ModifyRequest {
            vertical: VerticalRequest::AltitudeM(1.0),
            ..modify(8)
        }),
        Request::Modify(ModifyRequest {
            vertical: VerticalRequest::DepthM(-5.0),
            ..modify(9)
        }),
    ];
    trial.ask(0, bad);
    trial.run_for(1.0);
    for tag in 1..=9 {
        assert!(!trial.rejection(tag).is_empty(), "{tag}");
    }
    assert!(
        trial.rejection(7).contains("m deeper than the 60 m"),
        "{}",
        trial.rejection(7)
    );
    assert!(trial.sent("RMB").is_empty());
}

#[test]
fn sr_003_the_end_of_a_lease_is_sent_within_100_ms_of_its_cause() {
    let mut trial = Trial::steering();
    let asked = trial.now;
    trial.vehicle.set_control(asked, false);
    trial.run_for(1.0);
    let emb = trial.sent_since("EMB", asked)[0];
    assert!(emb.since(asked + trial.delay) <= Duration::from_millis(100), "{emb}");
    assert_eq!(trial.sent_since("EMB", Timestamp::ZERO).len(), 1);
}

/// What `Core::reach` shows is what is judged: a keep-out zone that this capsule only just misses is not breached.
#[test]
fn the_reach_of_the_live_modify_is_what_people_are_shown() {
    let mut trial = Trial::under_way();
    trial.run_for(1.0);
    assert_eq!(trial.core.reach(), None, "nothing steers");
    let mut trial = Trial::steering();
    trial.run_for(1.0);
    let reach = trial.core.reach().expect("a modify steers");
    let navigation = *trial.core.navigation().expect("it is fresh");
    assert_eq!(reach.here, navigation.local);
    let along_m = reach.here.distance_m(reach.ahead);
    // At 1.5 m/s for 5 s of silence, the age of navigation and the delay of the link; or at the vehicle's own speed.
    assert!((7.5..40.0).contains(&along_m), "{along_m} m");
    assert!((5.0..120.0).contains(&reach.radius_m), "{} m", reach.radius_m);
    trial.operator(Operator::Hold);
    assert_eq!(trial.core.reach(), None, "the lease has ended");
}
