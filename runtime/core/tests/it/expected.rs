//! The plan that the operator had checked, and the one that the vehicle flies.

use backseat_core::plugin::Request;
use backseat_core::{ExpectedElement, ExpectedPath, ExpectedPlan, Settings};
use backseat_units::EastNorth;

use crate::course::{self, good_line, modify};
use crate::trial::{Setup, Trial, shorts};
use crate::vehicle::Reply;

/// The course's own plan.
fn plan() -> ExpectedPlan {
    let frame = *course::fence().frame();
    let elements = course::PLAN.map(|(number, points)| ExpectedElement {
        number,
        path: ExpectedPath::Points(
            points
                .iter()
                .map(|(east_m, north_m)| frame.to_position(EastNorth::new(*east_m, *north_m)))
                .collect(),
        ),
    });
    ExpectedPlan {
        elements: elements.to_vec(),
        tolerance_m: 2.0,
    }
}

fn expecting(plan: ExpectedPlan) -> Setup {
    Setup {
        settings: Settings {
            expected_plan: Some(plan),
            ..Settings::default()
        },
        ..Setup::default()
    }
}

/// The difference as the operator reads it. It must leave the runtime without control.
#[track_caller]
fn unlike(setup: Setup, arrange: impl FnOnce(&mut Trial)) -> String {
    let mut trial = Trial::with(setup);
    arrange(&mut trial);
    trial.run_for(2.0);
    assert!(!trial.core.has_control());
    trial.ask(0, [Request::Modify(modify(1)), good_line(2)]);
    trial.run_for(0.5);
    for tag in [1, 2] {
        assert_eq!(
            trial.rejection(tag),
            "control: the vehicle's plan is not the one that was checked"
        );
    }
    assert!(trial.sent("RMB").is_empty() && trial.sent("RTK").is_empty());
    let notes = trial.notes();
    let told = notes.iter().map(|(_, note)| note.to_string());
    let told: Vec<String> = told
        .filter(|text| text.contains("the one that was checked: "))
        .collect();
    assert_eq!(told.len(), 1, "{told:?}");
    told[0].split_once("checked: ").unwrap().1.to_owned()
}

#[test]
fn sr_001_the_checked_plan_leaves_control_as_usual() {
    let mut trial = Trial::with_under_way(expecting(plan()));
    trial.ask(0, [Request::Modify(modify(1)), good_line(2)]);
    trial.run_for(0.5);
    assert!(trial.core.is_steering());
    assert_eq!(shorts(&trial.states(2)), ["sent", "accepted"]);
    // A difference within the tolerance of 2 m does not make another plan.
    let mut near = Trial::with(expecting(plan()));
    near.vehicle.moved = Some((2, EastNorth::new(1.2, -1.2)));
    near.run_for(2.0);
    assert!(near.core.has_control());
}

#[test]
fn sr_001_with_another_plan_nothing_that_steers_is_sent_and_the_difference_is_reported() {
    let moved = |by| move |trial: &mut Trial| trial.vehicle.moved = Some(by);
    let text = unlike(expecting(plan()), moved((2, EastNorth::new(0.0, 2.1))));
    assert_eq!(text, "element 2: its point 1 is 2.1 m from the expected one");
    let text = unlike(expecting(plan()), moved((1, EastNorth::new(-30.0, 0.0))));
    assert_eq!(text, "element 1: its point 1 is 30.0 m from the expected one");

    let mut longer = plan();
    longer.elements.push(ExpectedElement {
        number: 4,
        ..longer.elements[2].clone()
    });
    let text = unlike(expecting(longer), |_| {});
    assert_eq!(text, "it has 3 elements, expected 4: element 4 is not in it");
    let mut shorter = plan();
    shorter.elements.pop();
    assert_eq!(unlike(expecting(shorter), |_| {}), "it has 3 elements, expected 2");

    let mut another = plan();
    another.elements[0].path = another.elements[1].path.clone();
    let text = unlike(expecting(another), |_| {});
    assert_eq!(text, "element 1: it is a trackline, expected a waypoint");
    let mut another = plan();
    another.elements[2].path = another.elements[0].path.clone();
    let text = unlike(expecting(another), |_| {});
    assert_eq!(text, "element 3: it is a waypoint, expected a trackline");
    let mut another = plan();
    another.elements[1].path = ExpectedPath::Circle {
        centre: course::fence().frame().origin(),
        radius_m: 100.0,
    };
    let text = unlike(expecting(another), |_| {});
    assert_eq!(text, "element 2: it is a waypoint, expected a trackcircle");
}

#[test]
fn sr_001_until_the_plan_is_known_on_this_connection_there_is_no_control() {
    let mut trial = Trial::with(expecting(plan()));
    trial.vehicle.replies.insert("RMP", Reply::Silent);
    trial.run_for(2.0);
    assert!(!trial.core.has_control());
    trial.ask(0, [Request::Modify(modify(1))]);
    trial.run_for(0.5);
    assert_eq!(
        trial.rejection(1),
        "control: the vehicle's plan has not been compared with the one that was checked"
    );
    trial.vehicle.replies.clear();
    trial.run_for(20.0);
    assert!(trial.core.has_control());
    // Another connection, perhaps another plan.
    trial.vehicle.moved = Some((3, EastNorth::new(50.0, 0.0)));
    trial.cut();
    trial.run_for(20.0);
    assert!(trial.is_connected() && !trial.core.has_control());
}

#[test]
fn sr_001_inserts_in_the_vehicles_plan_do_not_count_as_a_difference() {
    let mut trial = Trial::with_under_way(expecting(plan()));
    trial.ask(0, [good_line(1)]);
    trial.run_for(0.5);
    trial.vehicle.others.push((77, (100.0, 100.0)));
    trial.cut();
    trial.run_for(20.0);
    assert!(trial.is_connected() && trial.core.has_control(), "{:#?}", trial.notes());
}
