//! Messages of the plan out of order, and holds without a text.

use std::time::Duration;

use backseat_core::Operator;
use backseat_core::plugin::Request;
use backseat_spi::{AckStatus, FromVehicle, PlanElementKind, Text};
use backseat_units::EastNorth;

use crate::course::line;
use crate::scene::{at_once, begins};
use crate::trial::Trial;
use crate::vehicle::Reply;
use crate::ways::{fate, refused, wreck};

/// What happens to the messages of the plan.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Series {
    Good,
    Repeated(usize),
    FirstAgain(usize),
    Swapped(usize),
    AfterEnd,
    PendingAfter(usize),
}

fn tells(trial: &mut Trial, plan: &[(u32, usize, (f64, f64))], series: Series) {
    let Some((_, command)) = trial.commands("RMP").pop() else {
        panic!("no BPRMP")
    };
    let created = command.created().unwrap();
    let pending = |trial: &mut Trial| {
        let now = trial.now;
        trial
            .vehicle
            .acknowledge(now, ("RMP", created, None, AckStatus::Pending));
        trial.run_for(0.1);
    };
    let mut order: Vec<usize> = (0..plan.len()).collect();
    let mut late = None;
    match series {
        Series::Good | Series::PendingAfter(_) => {}
        Series::Repeated(at) => order.insert(at, at),
        Series::FirstAgain(at) => order.insert(at, 0),
        Series::Swapped(at) => order.swap(at, at + 1),
        Series::AfterEnd => late = order.pop(),
    }
    if !matches!(series, Series::PendingAfter(_)) {
        pending(trial);
    }
    // The vehicle has made one every 5 ms.
    let frame = *crate::course::fence().frame();
    let from = trial.now;
    let message = |trial: &Trial, at: usize| -> FromVehicle {
        let (number, index, (east_m, north_m)) = plan[at];
        backseat_spi::PlanElement {
            created: trial.vehicle.clock(from + Duration::from_millis(5 * at as u64)),
            number: Some(number),
            identifier: None,
            index: u32::try_from(index).unwrap(),
            element: match (number, index % 2) {
                (1, 0) => PlanElementKind::TracklineStart,
                (1, _) => PlanElementKind::TracklineEnd,
                _ => PlanElementKind::Waypoint,
            },
            position: frame.to_position(EastNorth::new(east_m, north_m)),
        }
        .into()
    };
    trial.run_for(0.1);
    for (count, at) in order.into_iter().enumerate() {
        if series == Series::PendingAfter(count) {
            pending(trial);
        }
        let said = message(trial, at);
        trial.hear_now([said]);
        trial.run_for(0.02);
    }
    let now = trial.now;
    trial
        .vehicle
        .acknowledge(now, ("RMP", created, None, AckStatus::Succeeded));
    trial.run_for(0.2);
    if let Some(at) = late {
        let said = message(trial, at);
        trial.hear_now([said]);
    }
    trial.run_for(0.4);
}

fn way_on(plan: &[(u32, usize, (f64, f64))], series: Series) -> String {
    let mut trial = Trial::new();
    trial.vehicle.replies.insert("RMP", Reply::Silent);
    trial.vehicle.start = EastNorth::new(-900.0, 0.0);
    trial.run_for(1.0);
    tells(&mut trial, plan, series);
    begins(&mut trial, Some(plan[0].0), None);
    trial.run_for(5.0);
    let after = line(1, (-300.0, -700.0), (-600.0, -1000.0));
    fate(&mut trial, Request::Trackline(after), 1)
}

/// Two lines of one behavior, the end of the first comes twice.
#[test]
fn sr_002_a_repeated_message_of_the_plan_does_not_hide_the_start_of_the_next_line() {
    const TWO: &[(u32, usize, (f64, f64))] = &[
        (1, 0, (-900.0, 0.0)),
        (1, 1, (-300.0, 0.0)),
        (1, 2, (900.0, -1000.0)),
        (1, 3, (900.0, 600.0)),
        (3, 0, (-900.0, 600.0)),
    ];
    wreck("good", &way_on(TWO, Series::Good));
    refused("repeated", &way_on(TWO, Series::Repeated(1)));
}

const PLACES: &[(u32, usize, (f64, f64))] = &[
    (2, 0, (-900.0, 0.0)),
    (2, 1, (-300.0, 0.0)),
    (4, 0, (900.0, -1000.0)),
    (5, 0, (-900.0, 600.0)),
];

#[test]
fn sr_002_two_messages_of_the_plan_in_the_wrong_order_do_not_make_a_plan() {
    wreck("good", &way_on(PLACES, Series::Good));
    refused("swapped", &way_on(PLACES, Series::Swapped(2)));
}

#[test]
fn sr_002_the_first_message_of_the_plan_that_comes_again_does_not_cut_the_plan() {
    refused("first again", &way_on(PLACES, Series::FirstAgain(3)));
}

#[test]
fn sr_002_a_message_of_the_plan_that_comes_after_its_end_shows_that_the_plan_is_not_complete() {
    let plan = &PLACES[..3];
    wreck("good", &way_on(plan, Series::Good));
    refused("after the end", &way_on(plan, Series::AfterEnd));
}

#[test]
fn sr_002_a_pending_answer_that_comes_late_does_not_cut_the_plan() {
    const PLAN: &[(u32, usize, (f64, f64))] = &[
        (1, 0, (-900.0, -1000.0)),
        (1, 1, (-500.0, -1000.0)),
        (2, 0, (-900.0, 600.0)),
    ];
    let flown = |series| {
        let mut trial = Trial::new();
        trial.vehicle.replies.insert("RMP", Reply::Silent);
        trial.vehicle.start = EastNorth::new(-900.0, 400.0);
        trial.run_for(1.0);
        tells(&mut trial, PLAN, series);
        begins(&mut trial, Some(1), None);
        trial.run_for(5.0);
        fate(&mut trial, at_once(line(1, (400.0, -900.0), (400.0, -1000.0))), 1)
    };
    wreck("good", &flown(Series::Good));
    let late = flown(Series::PendingAfter(2));
    refused("late", &late);
}

/// A second hold, after the vehicle has refused five cancels of a previous run's insert.
#[test]
fn sr_015_a_second_hold_cancels_a_previous_runs_insert_again() {
    let mut trial = Trial::with(crate::trial::Setup::default().after(3, 0));
    trial.vehicle.inserted.insert(2);
    trial.vehicle.replies.insert("RCN", Reply::Refuse);
    trial.run_for(3.0);
    trial.operator(Operator::Hold);
    trial.run_for(60.0);
    assert!(!trial.sent("RCN").is_empty());
    trial.vehicle.replies.remove("RCN");
    trial.operator(Operator::Release);
    trial.run_for(5.0);
    let at = trial.now;
    trial.operator(Operator::Hold);
    trial.run_for(60.0);
    assert!(!trial.sent_since("RCN", at).is_empty());
}

fn said(trial: &Trial, text: &str) -> FromVehicle {
    backseat_spi::MissionCommand {
        created: trial.vehicle.clock(trial.now),
        text: Text::cleaned(text),
    }
    .into()
}

fn held_and_released_by_text() -> Trial {
    let settings = backseat_core::Settings {
        hold_text: Some("hold".to_owned()),
        release_text: Some("release".to_owned()),
        ..backseat_core::Settings::default()
    };
    let mut trial = Trial::with(crate::trial::Setup {
        settings,
        ..crate::trial::Setup::default()
    });
    trial.run_for(3.0);
    trial
}

/// A release by text was made before the operator's hold by a signal, and comes after it: late, or once more.
#[test]
fn sr_015_a_release_that_was_made_before_a_hold_by_signal_does_not_release() {
    for again in [false, true] {
        let mut trial = held_and_released_by_text();
        assert!(trial.core.has_control(), "{:?}", trial.core.uncontrolled());
        let release = said(&trial, "release");
        if again {
            trial.hear_now([release.clone()]);
        }
        trial.run_for(1.0);
        trial.operator(Operator::Hold);
        trial.run_for(2.0);
        assert!(!trial.core.has_control());
        trial.hear_now([release]);
        trial.run_for(1.0);
        assert!(!trial.core.has_control(), "again {again}");
    }
}

#[test]
fn sr_015_a_release_after_a_hold_by_signal_releases() {
    let mut trial = held_and_released_by_text();
    trial.operator(Operator::Hold);
    trial.run_for(2.0);
    let release = said(&trial, "release");
    trial.hear_now([release]);
    trial.run_for(1.0);
    assert!(trial.core.has_control());
}
