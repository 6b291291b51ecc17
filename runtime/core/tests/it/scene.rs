//! What several tests do to a vehicle, and check.

use backseat_core::plugin::{Request, TracklineRequest};
use backseat_spi::{AckStatus, BehaviorBegin, BehaviorEnd, BehaviorId, FromVehicle, MissionStatus, Text};
use backseat_units::EastNorth;

use crate::trial::{Trial, short, shorts};
use crate::vehicle::Reply;

/// Brings the vehicle to this place, and leaves navigation 12 s to become steady again.
pub(crate) fn led_to(trial: &mut Trial, east_m: f64, north_m: f64) {
    let then_s = trial.now.as_nanos() as f64 / 1e9 + 12.0;
    trial.vehicle.start = EastNorth::new(east_m - trial.vehicle.speed_mps * then_s, north_m);
    trial.run_for(12.0);
}

pub(crate) fn begins(trial: &mut Trial, number: Option<u32>, identifier: Option<u32>) {
    let now = trial.now;
    trial.vehicle.begin(now, number, identifier);
    trial.run_for(1.0);
}

pub(crate) fn ends(trial: &mut Trial, number: Option<u32>, identifier: Option<u32>) {
    let now = trial.now;
    trial.vehicle.end(now, number, identifier);
    trial.run_for(0.3);
}

/// A vehicle that keeps silent on BPRMP tells its plan: one behavior with these places.
pub(crate) fn tells_plan(trial: &mut Trial, places: &[(f64, f64)]) {
    tells_plan_of(trial, &[(1, places)]);
}

/// The same with several behaviors, each with its number and its places.
pub(crate) fn tells_plan_of(trial: &mut Trial, plan: &[(u32, &[(f64, f64)])]) {
    let Some((_, command)) = trial.commands("RMP").pop() else {
        panic!("no BPRMP")
    };
    let created = command.created().unwrap();
    let now = trial.now;
    trial
        .vehicle
        .acknowledge(now, ("RMP", created, None, AckStatus::Pending));
    trial.run_for(0.3);
    for (number, places) in plan {
        for (index, place) in places.iter().enumerate() {
            let now = trial.now;
            trial.vehicle.say_element(now, Some(*number), None, index, *place);
        }
    }
    trial.run_for(0.2);
    let now = trial.now;
    trial
        .vehicle
        .acknowledge(now, ("RMP", created, None, AckStatus::Succeeded));
    trial.run_for(0.5);
}

/// The vehicle says that its mission runs and that we have control.
pub(crate) fn hands_over(trial: &mut Trial) {
    let now = trial.now;
    trial.vehicle.set_status(now, "Running");
    trial.vehicle.set_control(now, true);
}

/// The link is lost and comes back. The vehicle does not say again what it flies, because it sends a BFMBS only as a
/// behavior begins (SPI 6.9).
pub(crate) fn outage(trial: &mut Trial) {
    trial.vehicle.replays = false;
    trial.cut();
    trial.run_for(3.0);
    assert!(trial.is_connected());
    hands_over(trial);
    trial.run_for(2.0);
    assert!(trial.core.has_control(), "{:#?}", trial.notes());
}

pub(crate) fn at_once(line: TracklineRequest) -> Request {
    Request::Trackline(TracklineRequest {
        interrupt: true,
        ..line
    })
}

pub(crate) fn accepted(trial: &mut Trial, request: Request, tag: u64) {
    trial.ask(0, [request]);
    trial.run_for(0.5);
    assert_eq!(
        shorts(&trial.states(tag)),
        ["sent", "accepted"],
        "{:?}",
        trial.states(tag)
    );
}

#[track_caller]
pub(crate) fn refused_for(trial: &mut Trial, request: Request, tag: u64, why: &str) {
    trial.ask(0, [request]);
    trial.run_for(0.5);
    let states = trial.states(tag);
    assert!(
        states.iter().any(|state| short(state) == "rejected"),
        "it was sent: {states:?}"
    );
    assert!(trial.rejection(tag).contains(why), "{}", trial.rejection(tag));
}

pub(crate) const WEST: ((f64, f64), (f64, f64)) = ((-900.0, -1500.0), (-1200.0, -1500.0));

pub(crate) const EAST: ((f64, f64), (f64, f64)) = ((900.0, -1500.0), (1200.0, -1500.0));

/// A vehicle that keeps silent on BPRMP has told its plan, and is at this place.
pub(crate) fn with_plan(plan: &[(u32, &[(f64, f64)])], start: (f64, f64)) -> Trial {
    let mut trial = Trial::new();
    trial.vehicle.replies.insert("RMP", Reply::Silent);
    trial.vehicle.start = EastNorth::new(start.0, start.1);
    trial.run_for(1.0);
    tells_plan_of(&mut trial, plan);
    assert!(trial.core.has_control(), "{:#?}", trial.notes());
    trial
}

/// Such a vehicle loses the link, and tells its plan on the next one.
pub(crate) fn outage_with(trial: &mut Trial, plan: &[(u32, &[(f64, f64)])]) {
    trial.vehicle.replays = false;
    trial.cut();
    trial.run_for(1.5);
    assert!(trial.is_connected());
    tells_plan_of(trial, plan);
    hands_over(trial);
    trial.run_for(0.5);
    // `Running` makes core ask again.
    tells_plan_of(trial, plan);
    assert!(trial.core.has_control(), "{:#?}", trial.notes());
}

/// A BFMBS that the vehicle makes now.
pub(crate) fn begin_of(
    trial: &Trial,
    dive: &str,
    number: Option<u32>,
    identifier: Option<u32>,
    kind: &str,
) -> FromVehicle {
    BehaviorBegin {
        created: trial.vehicle.clock(trial.now),
        dive_file: Text::cleaned(dive),
        number,
        identifier: identifier.map(BehaviorId::new),
        kind: Text::cleaned(kind),
    }
    .into()
}

/// A BFMBE that the vehicle makes now.
pub(crate) fn end_of(trial: &Trial, number: Option<u32>, identifier: Option<u32>, kind: &str) -> FromVehicle {
    BehaviorEnd {
        created: trial.vehicle.clock(trial.now),
        dive_file: Text::cleaned(""),
        number,
        identifier: identifier.map(BehaviorId::new),
        kind: Text::cleaned(kind),
    }
    .into()
}

/// A BFMIS that the vehicle makes now.
pub(crate) fn status_of(trial: &Trial, dive: &str, status: &str) -> FromVehicle {
    MissionStatus {
        created: trial.vehicle.clock(trial.now),
        dive_file: Text::cleaned(dive),
        status: Text::cleaned(status),
        details: Text::cleaned(""),
    }
    .into()
}
