use std::time::Duration;

use backseat_core::plugin::{Event, Failure, Request, RequestState, TracklineRequest};
use backseat_core::{Identifiers, Limits, Start};
use backseat_spi::{AckStatus, CircleEntry, Interrupt, ToVehicle};
use backseat_units::EastNorth;

use crate::course::{circle, good_line, interrupting, limits, line};
use crate::scene::begins;
use crate::trial::{Setup, Trial, shorts};
use crate::vehicle::Reply;

fn begin(trial: &mut Trial, identifier: u32) {
    trial.vehicle.begin(trial.now, None, Some(identifier));
    trial.run_for(0.3);
}

fn end(trial: &mut Trial, identifier: u32) {
    trial.vehicle.end(trial.now, None, Some(identifier));
    trial.run_for(0.3);
}

/// An accepted insert under tag 1 with identifier 1.
fn accepted() -> Trial {
    let mut trial = Trial::under_way();
    trial.ask(0, [good_line(1)]);
    trial.run_for(0.5);
    assert_eq!(shorts(&trial.states(1)), ["sent", "accepted"], "{:?}", trial.states(1));
    trial
}

#[test]
fn sr_009_an_insert_goes_through_each_state_once() {
    let mut trial = Trial::under_way();
    trial
        .vehicle
        .replies
        .insert("RTK", Reply::Pending(Duration::from_millis(1500), AckStatus::Succeeded));
    trial.ask(0, [good_line(1)]);
    trial.run_for(2.5);
    begin(&mut trial, 1);
    end(&mut trial, 1);
    let states = ["sent", "pending", "accepted", "started", "ended"];
    assert_eq!(shorts(&trial.states(1)), states);
    let told: Vec<RequestState> = trial
        .events(0)
        .into_iter()
        .filter_map(|event| match event {
            Event::Outcome { tag: 1, state } => Some(state),
            _ => None,
        })
        .collect();
    assert_eq!(shorts(&told), states, "the plugin learns of each");
    let behaviors = trial.events(0).into_iter().filter(|event| match event {
        Event::BehaviorBegan(behavior) | Event::BehaviorEnded(behavior) => behavior.tag == Some(1),
        _ => false,
    });
    assert_eq!(behaviors.count(), 2);
    assert!(!trial.events(1).iter().any(|event| match event {
        Event::BehaviorBegan(behavior) | Event::BehaviorEnded(behavior) => behavior.tag.is_some(),
        Event::Outcome { .. } => true,
        _ => false,
    }));
    assert_eq!(trial.core.open_requests(), 0);
}

#[test]
fn a_trackline_and_a_trackcircle_are_encoded_as_requested() {
    let mut trial = Trial::under_way();
    trial.ask(
        0,
        [interrupting(1), Request::Trackcircle(circle(2, (0.0, 600.0), 50.0))],
    );
    trial.run_for(0.5);
    let Some((_, ToVehicle::Trackline(sent))) = trial.commands("RTK").pop() else {
        panic!("no BPRTK")
    };
    assert_eq!(
        (sent.vertical_m, sent.speed, sent.interrupt),
        (20.0, 1.5, Interrupt::InterruptCurrent)
    );
    let Some((_, ToVehicle::Trackcircle(sent))) = trial.commands("RTC").pop() else {
        panic!("no BPRTC")
    };
    assert_eq!(
        (sent.radius_m, sent.orbits, sent.entry_angle_deg),
        (50.0, 1.0, CircleEntry::Angle(0.0))
    );
    assert_eq!(sent.interrupt, Interrupt::AfterCurrent);
}

#[test]
fn sr_009_a_refused_insert_fails() {
    for reply in [
        Reply::Refuse,
        Reply::Pending(Duration::from_millis(1500), AckStatus::Failed),
        Reply::Late(Duration::from_millis(1500), AckStatus::Invalid),
    ] {
        let mut trial = Trial::under_way();
        trial.vehicle.replies.insert("RTK", reply);
        trial.ask(0, [good_line(1)]);
        trial.run_for(6.0);
        assert_eq!(
            trial.states(1).last(),
            Some(&RequestState::Failed(Failure::Vehicle("as told".to_owned()))),
            "{reply:?}"
        );
        assert_eq!(trial.core.open_requests(), 0);
    }
}

#[test]
fn sr_009_an_unanswered_insert_is_called_back_and_times_out() {
    for reply in [Reply::Silent, Reply::PendingForEver] {
        let mut trial = Trial::under_way();
        trial.vehicle.replies.insert("RTK", reply);
        trial.ask(0, [good_line(1)]);
        trial.run_for(8.0);
        assert_eq!(trial.states(1).last(), Some(&RequestState::TimedOut), "{reply:?}");
        assert_eq!(trial.commands("RCN").len(), 1);
        assert_eq!(trial.core.open_requests(), 0);
    }
}

#[test]
fn sr_009_an_answer_that_comes_after_the_end_changes_nothing() {
    let mut trial = Trial::under_way();
    trial
        .vehicle
        .replies
        .insert("RTK", Reply::Late(Duration::from_secs(3), AckStatus::Succeeded));
    trial.ask(0, [good_line(1)]);
    trial.run_for(10.0);
    assert_eq!(shorts(&trial.states(1)), ["sent", "timed out"]);
}

/// An insert whose answer was lost with the link. The argument says whether the vehicle has it.
fn in_doubt(vehicle_has_it: bool) -> Trial {
    let mut trial = Trial::under_way();
    trial.vehicle.replies.insert("RTK", Reply::Silent);
    trial.ask(0, [good_line(1)]);
    trial.run_for(0.5);
    if vehicle_has_it {
        trial.vehicle.inserted.insert(1);
    }
    trial.vehicle.replies.clear();
    trial.cut();
    assert_eq!(shorts(&trial.states(1)), ["sent", "unknown"]);
    trial
}

#[test]
fn sr_009_an_insert_in_doubt_is_resolved_by_the_vehicles_plan() {
    for has in [true, false] {
        let mut trial = in_doubt(has);
        trial.run_for(8.0);
        let end = if has { "accepted" } else { "failed" };
        assert_eq!(shorts(&trial.states(1)), ["sent", "unknown", end]);
        trial.ask(0, [good_line(2)]);
        trial.run_for(0.5);
        assert_eq!(shorts(&trial.states(2)), ["sent", "accepted"]);
        let identifiers: Vec<u32> = trial
            .commands("RTK")
            .iter()
            .map(|(_, command)| crate::vehicle::name_of(command).1.unwrap())
            .collect();
        assert_eq!(identifiers, [1, 2], "no identifier is used twice");
    }
}

#[test]
fn sr_009_no_insert_is_sent_while_another_is_in_doubt() {
    let mut trial = in_doubt(true);
    trial.vehicle.replies.insert("RMP", Reply::Silent);
    trial.run_for(3.0);
    trial.ask(0, [good_line(2)]);
    trial.run_for(0.5);
    assert_eq!(shorts(&trial.states(2)), ["rejected"]);
    begin(&mut trial, 1);
    assert_eq!(
        shorts(&trial.states(1)),
        ["sent", "unknown", "started"],
        "BFMBS names it"
    );
    end(&mut trial, 1);
    assert_eq!(shorts(&trial.states(1)).last(), Some(&"ended"));
    trial.vehicle.replies.clear();
    begins(&mut trial, Some(1), None);
    trial.run_for(16.0);
    trial.ask(0, [good_line(3)]);
    trial.run_for(0.5);
    assert_eq!(shorts(&trial.states(3)), ["sent", "accepted"]);
}

#[test]
fn sr_009_a_cancel_whose_answer_was_lost_does_not_stay_in_doubt() {
    let mut trial = accepted();
    trial.vehicle.replies.insert("RCN", Reply::Silent);
    trial.ask(0, [Request::Cancel(1)]);
    trial.run_for(0.5);
    trial.cut();
    trial.vehicle.replies.clear();
    trial.run_for(5.0);
    trial.ask(0, [good_line(2)]);
    trial.run_for(0.5);
    assert_eq!(shorts(&trial.states(2)), ["sent", "accepted"], "{:?}", trial.states(2));
    let now = trial.now;
    trial.vehicle.set_status(now, "Completed");
    trial.run_for(5.0);
    assert_eq!(trial.core.open_requests(), 0);
}

#[test]
fn sr_009_identifiers_are_reserved_before_they_are_sent_and_never_used_twice() {
    let mut trial = Trial::under_way();
    for tag in 0..60 {
        trial.ask(0, [good_line(tag)]);
        trial.run_for(0.3);
        trial.ask(0, [Request::Cancel(tag)]);
        trial.run_for(0.3);
        if tag % 20 == 19 {
            trial.cut();
            trial.run_for(5.0);
        }
    }
    // The judge of the trial compares each identifier with those that were reserved and used.
    assert_eq!(trial.commands("RTK").len(), 60);
    assert_eq!(trial.core.open_requests(), 0);
}

#[test]
fn sr_009_a_restarted_process_continues_after_the_reserved_identifiers_and_without_state_sends_no_insert() {
    let setup = Setup::default();
    let start = Start {
        identifiers: Some(Identifiers {
            next: 500,
            reserved: 500,
            first: 500,
            ..Identifiers::default()
        }),
        ..setup.start
    };
    let mut trial = Trial::with_under_way(Setup { start, ..setup });
    trial.ask(0, [good_line(1)]);
    trial.run_for(0.5);
    let Some((_, ToVehicle::Trackline(sent))) = trial.commands("RTK").pop() else {
        panic!("no BPRTK")
    };
    assert_eq!(sent.identifier.get(), 500);

    let setup = Setup::default();
    let start = Start {
        identifiers: None,
        ..setup.start
    };
    let mut trial = Trial::with_under_way(Setup { start, ..setup });
    trial.ask(0, [good_line(1)]);
    trial.run_for(0.5);
    assert!(trial.rejection(1).contains("state on disk is missing") && trial.commands("RTK").is_empty());
}

#[test]
fn sr_019_inserts_that_a_killed_process_left_count_under_the_cap_until_they_are_flown() {
    let mut setup = Setup::default().after(0, 0);
    setup.limits.inserts_open_max = 2;
    let mut trial = Trial::with(setup);
    trial.vehicle.inserted.extend([7, 8]);
    trial.run_for(2.0);
    trial.ask(0, [good_line(1)]);
    trial.run_for(0.5);
    assert!(
        trial.rejection(1).contains("cap: open inserts is 3"),
        "{}",
        trial.rejection(1)
    );
    begin(&mut trial, 7);
    end(&mut trial, 7);
    begins(&mut trial, Some(2), None);
    trial.ask(0, [good_line(2)]);
    trial.run_for(0.5);
    assert_eq!(shorts(&trial.states(2)), ["sent", "accepted"], "{:?}", trial.states(2));
}

#[test]
fn sr_009_a_meaningless_mission_status_takes_control_and_leaves_the_inserts_open() {
    let mut trial = accepted();
    let now = trial.now;
    trial.vehicle.set_status(now, " ");
    trial.run_for(0.5);
    assert!(!trial.core.has_control());
    assert_eq!(trial.core.open_requests(), 1, "the vehicle may still fly it");
    let now = trial.now;
    trial.vehicle.set_status(now, "Completed");
    trial.run_for(0.5);
    assert_eq!(trial.core.open_requests(), 0);
}

#[test]
fn sr_002_the_transit_from_an_unanswered_insert_is_checked() {
    let mut trial = Trial::under_way();
    trial.vehicle.replies.insert("RTK", Reply::Silent);
    trial.vehicle.replies.insert("RCN", Reply::Refuse);
    trial.ask(0, [Request::Trackline(line(1, (600.0, -300.0), (900.0, -1000.0)))]);
    trial.run_for(4.0);
    assert_eq!(shorts(&trial.states(1)), ["sent", "timed out"]);
    // The way from its end leads over the wreck, the way from the planned leg's end does not.
    trial.ask(0, [Request::Trackline(line(2, (-600.0, -1000.0), (-600.0, -300.0)))]);
    trial.run_for(0.5);
    assert!(
        trial.rejection(2).contains("inside keep-out zone 'wreck'"),
        "{:?}",
        trial.states(2)
    );
}

/// An insert behind the wreck. The way to its start is clear from the end of the planned line, but leads over the wreck
/// from the west of the line.
fn beyond_the_wreck(tag: u64) -> Request {
    Request::Trackline(line(tag, (300.0, -1300.0), (600.0, -1300.0)))
}

/// An insert in the east, clear of the wreck all the way. The way from its end to [`beyond_the_wreck`] is clear too.
fn in_the_east(tag: u64) -> Request {
    Request::Trackline(line(tag, (900.0, -600.0), (900.0, -1300.0)))
}

fn is_over_the_wreck(trial: &Trial, tag: u64) {
    let refused = trial.rejection(tag);
    assert!(
        refused.contains("keep-out zone 'wreck'"),
        "{refused} {:?}",
        trial.states(tag)
    );
}

#[test]
fn sr_002_the_transit_to_an_insert_is_checked_from_the_whole_planned_line_because_it_may_time_out() {
    let mut trial = Trial::under_way();
    trial.ask(0, [beyond_the_wreck(1), in_the_east(2)]);
    trial.run_for(0.5);
    is_over_the_wreck(&trial, 1);
    assert_eq!(shorts(&trial.states(2)), ["sent", "accepted"]);
    // After insert 2 the vehicle no longer comes from the planned line.
    trial.ask(0, [beyond_the_wreck(3)]);
    trial.run_for(0.5);
    assert_eq!(shorts(&trial.states(3)), ["sent", "accepted"], "{:?}", trial.states(3));
    // Without insert 2 it would, so insert 2 cannot be cancelled.
    trial.ask(0, [Request::Cancel(2)]);
    trial.run_for(0.5);
    let states = trial.cancel_states(2);
    assert_eq!(shorts(&states), ["rejected"], "{states:?}");
}

#[test]
fn sr_002_the_transit_to_an_insert_is_also_checked_in_case_the_insert_before_it_is_refused() {
    let mut trial = Trial::under_way();
    trial.ask(0, [in_the_east(1), beyond_the_wreck(2)]);
    trial.run_for(0.5);
    assert_eq!(shorts(&trial.states(1)), ["sent", "accepted"]);
    is_over_the_wreck(&trial, 2);
}

#[test]
fn sr_002_an_insert_that_follows_another_planned_behavior_is_checked_from_there_or_called_back() {
    let mut trial = Trial::new();
    trial.vehicle.start = EastNorth::new(100.0, 200.0);
    trial.run_for(2.0);
    let now = trial.now;
    trial.vehicle.begin(now, Some(3), None);
    trial.run_for(0.3);
    trial.ask(0, [beyond_the_wreck(1)]);
    trial.run_for(0.5);
    assert_eq!(shorts(&trial.states(1)), ["sent", "accepted"], "{:?}", trial.states(1));
    // This vehicle flies the insert only after the next behavior.
    let now = trial.now;
    trial.vehicle.begin(now, Some(2), None);
    trial.run_for(0.3);
    assert_eq!(trial.sent("RCN").len(), 0, "the way from there is clear too");
    let now = trial.now;
    trial.vehicle.begin(now, Some(1), None);
    trial.run_for(0.5);
    assert_eq!(trial.sent("RCN").len(), 1, "{:#?}", trial.notes());
    assert_eq!(shorts(&trial.states(1)), ["sent", "accepted", "cancelled"]);
}

#[test]
fn sr_002_sr_020_bottom_lock_gives_the_height_above_the_seabed_on_the_remaining_ways() {
    let waiting = |altitude_m| {
        let mut trial = Trial::with_under_way(Setup {
            limits: Limits {
                water_depth_min_m: None,
                seabed_slope_max: 0.01,
                ..limits()
            },
            ..Setup::default()
        });
        trial.ask(0, [good_line(1)]);
        trial.run_for(0.5);
        trial.ask(0, [Request::Trackline(line(2, (0.0, 600.0), (300.0, 600.0)))]);
        trial.run_for(0.5);
        assert_eq!(shorts(&trial.states(2)), ["sent", "accepted"], "{:?}", trial.states(2));
        trial.vehicle.altitude_m = altitude_m;
        // This is longer than a lost bottom lock still counts.
        trial.run_for(60.0);
        trial
    };
    let mut trial = waiting(Some(70.0));
    let now = trial.now;
    trial.vehicle.begin(now, Some(2), None);
    trial.run_for(0.5);
    assert_eq!(trial.sent("RCN").len(), 0, "{:#?}", trial.notes());
    trial.ask(0, [Request::Cancel(1)]);
    trial.run_for(0.5);
    assert_eq!(shorts(&trial.cancel_states(1)), ["sent", "accepted", "ended"]);
    // Without bottom lock the height above the seabed is unknown.
    let mut trial = waiting(None);
    trial.ask(0, [Request::Cancel(1)]);
    trial.run_for(0.5);
    assert_eq!(shorts(&trial.cancel_states(1)), ["rejected"]);
}

#[test]
fn sr_002_the_way_back_to_an_interrupted_line_is_checked_for_the_inserts_before_it() {
    let mut trial = Trial::under_way();
    trial.ask(0, [interrupting(1)]);
    trial.run_for(0.5);
    begin(&mut trial, 1);
    trial.ask(0, [Request::Trackline(line(2, (0.0, 600.0), (300.0, 600.0)))]);
    trial.run_for(0.5);
    end(&mut trial, 1);
    begin(&mut trial, 2);
    assert_eq!(shorts(&trial.states(2)), ["sent", "accepted", "started"]);
    // From its end the way to the next behavior is clear, but the way back to the line that the first insert
    // interrupted is not.
    let behind = |tag| Request::Trackline(line(tag, (400.0, -1100.0), (400.0, -1300.0)));
    trial.ask(0, [behind(3)]);
    trial.run_for(0.5);
    is_over_the_wreck(&trial, 3);
    end(&mut trial, 2);
    let now = trial.now;
    trial.vehicle.begin(now, Some(3), None);
    trial.run_for(0.3);
    trial.ask(0, [Request::Trackline(line(4, (0.0, 600.0), (300.0, 600.0)))]);
    trial.run_for(0.5);
    trial.ask(0, [behind(5)]);
    trial.run_for(0.5);
    assert_eq!(shorts(&trial.states(5)), ["sent", "accepted"], "{:?}", trial.states(5));
}

#[test]
fn sr_002_the_transit_from_another_payloads_insert_is_checked() {
    let mut trial = Trial::under_way();
    let good = || Request::Trackline(line(1, (0.0, 500.0), (300.0, 500.0)));
    trial.ask(0, [good()]);
    trial.run_for(0.5);
    assert_eq!(shorts(&trial.states(1)), ["sent", "accepted"], "alone it is good");

    let mut trial = Trial::new();
    // Another payload's insert ends outside the fence: the way from there to ours would lead through its edge.
    trial.vehicle.others.push((4_000_000, (1e4, 1e4)));
    trial.run_for(2.0);
    trial.ask(0, [good()]);
    trial.run_for(0.5);
    assert!(trial.rejection(1).starts_with("keep-in: "), "{}", trial.rejection(1));
}

#[test]
fn sr_019_the_number_of_open_inserts_is_capped() {
    let mut trial = Trial::under_way();
    trial.ask(0, (1..=5).map(good_line));
    trial.run_for(0.5);
    assert_eq!(trial.commands("RTK").len(), 4);
    assert!(
        trial.rejection(5).contains("open inserts is 5"),
        "{}",
        trial.rejection(5)
    );
    begin(&mut trial, 1);
    end(&mut trial, 1);
    begins(&mut trial, Some(1), None);
    trial.ask(0, [good_line(6)]);
    trial.run_for(0.5);
    assert_eq!(shorts(&trial.states(6)), ["sent", "accepted"]);
}

#[test]
fn sr_019_the_number_of_all_inserts_of_a_mission_is_capped() {
    let limits = Limits {
        inserts_total_max: 2,
        ..limits()
    };
    let mut trial = Trial::with_under_way(Setup {
        limits,
        ..Setup::default()
    });
    for tag in 1..=3 {
        trial.ask(0, [good_line(tag)]);
        trial.run_for(0.5);
        trial.ask(0, [Request::Cancel(tag)]);
        trial.run_for(0.5);
    }
    assert!(trial.rejection(3).contains("inserts of the mission is 3"));
}

#[test]
fn sr_019_the_duration_of_open_inserts_is_capped() {
    // A line of 300 m with leads and transit takes some 20 minutes at the worst.
    let limits = Limits {
        inserts_duration_max_s: 2000.0,
        ..limits()
    };
    let mut trial = Trial::with_under_way(Setup {
        limits,
        ..Setup::default()
    });
    trial.ask(0, (1..=4).map(good_line));
    trial.run_for(0.5);
    let sent = trial.commands("RTK").len();
    assert!((1..4).contains(&sent), "{sent}");
    assert!(
        trial.rejection(4).contains("expected at most 2000 s"),
        "{}",
        trial.rejection(4)
    );
}

#[test]
fn sr_019_unanswered_inserts_count_under_the_caps_until_they_are_called_back() {
    let caps = [
        Limits {
            inserts_open_max: 1,
            ..limits()
        },
        Limits {
            inserts_duration_max_s: 1500.0,
            ..limits()
        },
    ];
    for limits in caps {
        for called_back in [false, true] {
            let mut trial = Trial::with_under_way(Setup {
                limits: limits.clone(),
                ..Setup::default()
            });
            trial.vehicle.replies.insert("RTK", Reply::Silent);
            if !called_back {
                trial.vehicle.replies.insert("RCN", Reply::Silent);
            }
            trial.ask(0, [good_line(1)]);
            trial.run_for(5.0);
            assert_eq!(shorts(&trial.states(1)), ["sent", "timed out"], "{:?}", trial.states(1));
            trial.vehicle.replies.remove("RTK");
            trial.ask(0, [good_line(2)]);
            trial.run_for(0.5);
            let expected = if called_back { "sent" } else { "rejected" };
            assert_eq!(shorts(&trial.states(2))[0], expected, "{:?}", trial.states(2));
        }
    }
}

#[test]
fn sr_010_nothing_interrupts_an_interrupting_insert() {
    let mut trial = Trial::under_way();
    trial.ask(0, [interrupting(1)]);
    trial.run_for(0.5);
    trial.ask(1, [interrupting(2)]);
    trial.run_for(0.5);
    assert!(trial.rejection(2).contains("interrupt"));
    begin(&mut trial, 1);
    trial.ask(1, [interrupting(3), good_line(4)]);
    trial.run_for(0.5);
    assert!(trial.rejection(3).contains("interrupt"));
    assert_eq!(
        shorts(&trial.states(4)),
        ["sent", "accepted"],
        "a waiting insert is allowed"
    );
    end(&mut trial, 1);
    // Until a behavior begins, core does not know what an insert would follow.
    trial.ask(1, [good_line(6)]);
    trial.run_for(0.5);
    assert!(
        trial.rejection(6).contains("current behavior unknown"),
        "{}",
        trial.rejection(6)
    );
    begins(&mut trial, Some(1), None);
    trial.ask(1, [interrupting(5)]);
    trial.run_for(0.5);
    assert_eq!(shorts(&trial.states(5)), ["sent", "accepted"]);
}

#[test]
fn sr_010_an_unanswered_interrupting_insert_may_be_flown_and_is_not_interrupted() {
    let mut trial = Trial::under_way();
    trial.vehicle.replies.insert("RTK", Reply::Silent);
    trial.vehicle.replies.insert("RCN", Reply::Silent);
    trial.ask(0, [interrupting(1)]);
    trial.run_for(5.0);
    assert_eq!(shorts(&trial.states(1)), ["sent", "timed out"]);
    trial.vehicle.replies.clear();
    trial.ask(0, [interrupting(2)]);
    trial.run_for(0.5);
    assert_eq!(shorts(&trial.states(2)), ["rejected"]);
}

#[test]
fn an_insert_can_be_cancelled_only_before_it_begins() {
    let mut trial = accepted();
    trial.ask(0, [good_line(2)]);
    trial.run_for(0.5);
    begin(&mut trial, 1);
    trial.ask(0, [Request::Cancel(1), Request::Cancel(2), Request::Cancel(9)]);
    trial.run_for(0.5);
    assert_eq!(shorts(&trial.cancel_states(1)), ["rejected"]);
    assert_eq!(shorts(&trial.cancel_states(2)), ["sent", "accepted", "ended"]);
    assert_eq!(shorts(&trial.states(2)), ["sent", "accepted", "cancelled"]);
    assert_eq!(shorts(&trial.cancel_states(9)), ["rejected"]);
    let cancelled: Vec<_> = trial
        .commands("RCN")
        .iter()
        .map(|(_, command)| crate::vehicle::name_of(command).1.unwrap())
        .collect();
    assert_eq!(cancelled, [2]);
}

#[test]
fn a_plugin_cannot_cancel_another_plugins_insert() {
    let mut trial = accepted();
    trial.ask(1, [Request::Cancel(1)]);
    trial.run_for(0.5);
    assert!(trial.commands("RCN").is_empty());
}

#[test]
fn a_refused_or_unanswered_cancel_leaves_the_insert_as_it_was() {
    for (reply, end) in [(Reply::Refuse, "failed"), (Reply::Silent, "timed out")] {
        let mut trial = accepted();
        trial.vehicle.replies.insert("RCN", reply);
        trial.ask(0, [Request::Cancel(1)]);
        trial.run_for(4.0);
        assert_eq!(shorts(&trial.cancel_states(1)), ["sent", end]);
        assert_eq!(shorts(&trial.states(1)), ["sent", "accepted"]);
    }
}

#[test]
fn a_tag_names_one_open_insert() {
    let mut trial = accepted();
    trial.ask(0, [good_line(1)]);
    trial.run_for(0.5);
    assert!(trial.rejection(1).contains("still open"));
    trial.ask(1, [good_line(1)]);
    trial.run_for(0.5);
    assert_eq!(trial.commands("RTK").len(), 2, "tags are each plugin's own");
}

#[test]
fn sr_009_every_open_request_ends_with_the_mission() {
    let mut trial = accepted();
    trial.ask(0, [good_line(2), Request::Modify(crate::course::modify(3))]);
    trial.run_for(0.5);
    begin(&mut trial, 1);
    trial.vehicle.replies.insert("RTK", Reply::Silent);
    trial.ask(
        0,
        [Request::Trackline(TracklineRequest {
            tag: 4,
            ..line(4, (0.0, 500.0), (300.0, 500.0))
        })],
    );
    trial.run_for(0.2);
    let now = trial.now;
    trial.vehicle.set_status(now, "Completed");
    trial.run_for(6.0);
    assert_eq!(trial.core.open_requests(), 0);
    for tag in [1, 2, 3, 4] {
        assert_eq!(shorts(&trial.states(tag)).last(), Some(&"ended"), "{tag}");
    }
}

#[test]
fn sr_009_an_insert_whose_end_was_lost_with_the_link_ends_when_another_behavior_begins() {
    let mut trial = accepted();
    begin(&mut trial, 1);
    trial.vehicle.replays = false;
    trial.cut();
    trial.run_for(5.0);
    assert_eq!(shorts(&trial.states(1)), ["sent", "accepted", "started"]);
    let now = trial.now;
    trial.vehicle.begin(now, Some(2), None);
    trial.run_for(0.3);
    assert_eq!(shorts(&trial.states(1)), ["sent", "accepted", "started", "ended"]);
    assert_eq!(trial.core.open_requests(), 0);
}
