//! Messages that come later than those that were made after them.

use std::time::Duration;

use backseat_core::plugin::Request;
use backseat_core::{ControlHook, Operator, Settings};
use backseat_spi::{AckStatus, MissionCommand, MissionStatus, Text};

use crate::course::{good_line, modify};
use crate::scene::{accepted, begins, ends, outage};
use crate::trial::{Setup, Trial};
use crate::vehicle::Reply;
use crate::ways::{fate, put, refused};

fn status(trial: &Trial, file: &str, status: &str) -> MissionStatus {
    MissionStatus {
        created: trial.vehicle.clock(trial.now),
        dive_file: Text::cleaned(file),
        status: Text::cleaned(status),
        details: Text::cleaned(""),
    }
}

fn command(trial: &Trial, text: &str) -> MissionCommand {
    MissionCommand {
        created: trial.vehicle.clock(trial.now),
        text: Text::cleaned(text),
    }
}

/// The revocation was made just before the hold and comes just after it.
#[test]
fn sr_001_a_revocation_that_is_older_than_the_hold_takes_control_away_all_the_same() {
    let settings = Settings {
        control: ControlHook::MissionCommand {
            grant: "backseat go".to_owned(),
            revoke: "backseat stop".to_owned(),
        },
        hold_text: Some("hold".to_owned()),
        release_text: Some("release".to_owned()),
        ..Settings::default()
    };
    let mut trial = Trial::with(Setup {
        settings,
        ..Setup::default()
    });
    trial.run_for(2.0);
    let go = command(&trial, "backseat go");
    trial.hear_now([go.into()]);
    trial.run_for(1.0);
    assert!(trial.core.has_control());
    let stop = command(&trial, "backseat stop");
    trial.run_for(0.5);
    let hold = command(&trial, "hold");
    trial.hear_now([hold.into()]);
    trial.run_for(0.5);
    trial.hear_now([stop.into()]);
    trial.run_for(1.0);
    trial.operator(Operator::Release);
    let release = command(&trial, "release");
    trial.hear_now([release.into()]);
    trial.run_for(1.0);
    assert!(!trial.core.has_control(), "the revocation was ignored");
}

/// A late "Completed" of the mission before ends the inserts of this one.
#[test]
fn sr_009_an_older_end_of_the_mission_ends_no_insert() {
    let mut trial = Trial::under_way();
    let over = status(&trial, "survey.dive", "Completed");
    trial.run_for(1.0);
    let running = status(&trial, "survey.dive", "Running");
    trial.hear_now([running.into()]);
    trial.run_for(1.0);
    accepted(&mut trial, good_line(2), 2);
    trial.hear_now([over.into()]);
    trial.run_for(1.0);
    assert_eq!(trial.core.open_requests(), 1, "{:?}", trial.states(2));
}

#[test]
fn sr_002_after_an_older_end_of_the_mission_an_insert_may_still_be_flown() {
    let mut trial = Trial::under_way();
    let over = status(&trial, "survey.dive", "Completed");
    trial.run_for(1.0);
    let running = status(&trial, "survey.dive", "Running");
    trial.hear_now([running.into()]);
    trial.run_for(1.0);
    accepted(&mut trial, good_line(2), 2);
    trial.vehicle.inserted.remove(&1);
    ends(&mut trial, Some(1), None);
    begins(&mut trial, None, Some(1));
    trial.hear_now([over.into()]);
    trial.run_for(1.0);
    outage(&mut trial);
    put(&mut trial, 90.0, 0.0, 0.0);
    trial.run_for(20.0);
    refused("late Completed", &fate(&mut trial, Request::Modify(modify(9)), 9));
}

/// The third dive is named after the vehicle's clock was set back.
fn third_dive(back: bool) -> Trial {
    let mut trial = Trial::under_way();
    let other = status(&trial, "other.dive", "Running");
    trial.hear_now([other.into()]);
    trial.run_for(5.0);
    begins(&mut trial, Some(1), None);
    trial.run_for(8.0);
    if back {
        trial.vehicle.clock_nanos -= 3_600_000_000_000;
    }
    trial.run_for(16.0);
    trial.ask(0, [Request::Modify(modify(1))]);
    trial.run_for(1.0);
    assert!(trial.core.is_steering(), "{:?}", trial.states(1));
    trial.vehicle.replies.insert("RMP", Reply::Silent);
    let third = status(&trial, "third.dive", "Running");
    trial.hear_now([third.into()]);
    trial.run_for(1.0);
    trial
}

#[test]
fn the_status_of_a_third_dive_ends_the_lease() {
    assert!(!third_dive(false).core.is_steering());
}

#[test]
fn sr_025_the_status_of_a_third_dive_ends_the_lease_although_the_clock_was_set_back() {
    assert!(!third_dive(true).core.is_steering());
}

/// Another payload's insert begins soon after a change of dive, and the clock was set back between.
fn foreign(back: bool) -> String {
    let mut trial = Trial::under_way();
    let other = status(&trial, "other.dive", "Running");
    trial.hear_now([other.into()]);
    trial.run_for(5.0);
    if back {
        trial.vehicle.clock_nanos -= 3_600_000_000_000;
    }
    trial.run_for(16.0);
    begins(&mut trial, None, Some(40));
    put(&mut trial, 90.0, 0.0, 0.0);
    trial.run_for(30.0);
    fate(&mut trial, Request::Modify(modify(9)), 9)
}

#[test]
fn another_payloads_insert_after_a_change_of_dive_is_not_seen_on_the_plan() {
    refused("40", &foreign(false));
}

#[test]
fn sr_002_another_payloads_insert_is_not_seen_on_the_plan_although_the_clock_was_set_back() {
    refused("40", &foreign(true));
}

/// A pending insert is accepted after a plan that lacks it, after a cancel that was refused.
#[test]
fn an_insert_whose_cancel_was_refused_before_it_was_accepted_is_not_called_cancelled() {
    let mut trial = Trial::under_way();
    trial.vehicle.replies.insert("RCN", Reply::Refuse);
    trial
        .vehicle
        .replies
        .insert("RTK", Reply::Pending(Duration::from_secs(1000), AckStatus::Succeeded));
    trial.ask(0, [good_line(2)]);
    trial.run_for(0.5);
    let backseat_spi::ToVehicle::Trackline(sent) = trial.commands("RTK").pop().unwrap().1 else {
        panic!()
    };
    trial.ask(0, [Request::Cancel(2)]);
    for _ in 0..12 {
        let now = trial.now;
        trial
            .vehicle
            .acknowledge(now, ("RTK", sent.created, Some(1), AckStatus::Pending));
        trial.run_for(2.0);
    }
    let now = trial.now;
    trial
        .vehicle
        .acknowledge(now, ("RTK", sent.created, Some(1), AckStatus::Succeeded));
    trial.vehicle.inserted.insert(1);
    trial.run_for(0.2);
    let now = trial.now;
    trial.vehicle.begin(now, Some(2), None);
    trial.run_for(0.2);
    assert!(
        !format!("{:?}", trial.states(2)).contains("Cancelled"),
        "{:?}",
        trial.states(2)
    );
}

fn policies() -> Trial {
    let on = |text: &str, order| backseat_core::Policy {
        when: backseat_core::Condition::MissionCommand(text.to_owned()),
        order,
    };
    let policies = vec![
        on("payload hold", backseat_core::Order::Hold),
        on("payload release", backseat_core::Order::Release),
        on(
            "payload abort",
            backseat_core::Order::Abort {
                text: "leak, in BAY 2 RMB".to_owned(),
                errors: true,
            },
        ),
    ];
    Trial::with_under_way(Setup {
        settings: Settings {
            policies,
            ..Settings::default()
        },
        ..Setup::default()
    })
}

/// The abort was made just before the hold and comes just after it.
#[test]
fn sr_015_an_abort_that_is_older_than_the_hold_is_carried_out_all_the_same() {
    let mut trial = policies();
    let abort = command(&trial, "payload abort");
    trial.run_for(0.5);
    let hold = command(&trial, "payload hold");
    trial.hear_now([hold.into()]);
    trial.run_for(0.5);
    trial.hear_now([abort.into()]);
    trial.run_for(1.0);
    assert!(!trial.sent("ABT").is_empty());
}

/// A second hold by policy; the release from before it comes late.
#[test]
fn sr_015_an_older_release_does_not_overrule_a_second_hold_by_policy() {
    let mut trial = policies();
    let hold = command(&trial, "payload hold");
    trial.hear_now([hold.into()]);
    trial.run_for(1.0);
    let release = command(&trial, "payload release");
    trial.run_for(1.0);
    let hold = command(&trial, "payload hold");
    trial.hear_now([hold.into()]);
    trial.run_for(0.5);
    trial.hear_now([release.into()]);
    trial.run_for(1.0);
    assert!(!trial.core.has_control(), "the older release overruled the second hold");
}

/// Two revocations with the clock set back between; a grant from before the second comes after the first is forgotten.
#[test]
fn sr_001_an_older_grant_does_not_overrule_a_revocation_although_the_clock_was_set_back() {
    let control = |trial: &Trial, granted| backseat_spi::BackseatControl {
        created: trial.vehicle.clock(trial.now),
        granted,
    };
    let mut trial = Trial::under_way();
    trial.vehicle.replays = false;
    let revoked = control(&trial, false);
    trial.hear_now([revoked.into()]);
    trial.run_for(1.0);
    trial.vehicle.clock_nanos -= 3_600_000_000_000;
    trial.run_for(52.0);
    let granted = control(&trial, true);
    trial.run_for(2.0);
    let revoked = control(&trial, false);
    trial.hear_now([revoked.into()]);
    trial.run_for(6.0);
    trial.hear_now([granted.into()]);
    trial.run_for(1.0);
    assert!(!trial.core.has_control(), "the older grant came late");
}

/// The BFMBS of the leg comes again while our insert is flown, in one and the same dive.
#[test]
fn sr_009_a_begin_that_comes_again_does_not_end_the_insert_that_is_flown() {
    let mut trial = Trial::under_way();
    let leg = backseat_spi::BehaviorBegin {
        created: trial.vehicle.clock(trial.now),
        dive_file: Text::cleaned("survey.dive"),
        number: Some(1),
        identifier: None,
        kind: Text::cleaned("trackline"),
    };
    trial.hear_now([leg.clone().into()]);
    trial.run_for(1.0);
    accepted(&mut trial, good_line(2), 2);
    trial.vehicle.inserted.remove(&1);
    ends(&mut trial, Some(1), None);
    begins(&mut trial, None, Some(1));
    trial.run_for(2.0);
    trial.hear_now([leg.into()]);
    trial.run_for(0.5);
    assert_eq!(trial.core.open_requests(), 1, "{:?}", trial.states(2));
}

/// For comparison.
#[test]
fn a_hold_and_an_abort_by_policy_in_order() {
    let mut trial = policies();
    for text in ["payload hold", "payload release", "payload hold"] {
        let said = command(&trial, text);
        trial.hear_now([said.into()]);
        trial.run_for(1.0);
    }
    assert!(!trial.core.has_control());
    let abort = command(&trial, "payload abort");
    trial.hear_now([abort.into()]);
    trial.run_for(1.0);
    assert!(!trial.sent("ABT").is_empty());
}
