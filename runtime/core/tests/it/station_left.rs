//! One station keeping after another, and station keeping during a GPS hit.

use std::time::Duration;

use backseat_core::Grant;
use backseat_core::plugin::{GpsHitRequest, Request, StationRequest, StationTarget};

use crate::course::{self, at};
use crate::scene::{accepted, begins, refused_for};
use crate::station::{setup, station_limits};
use crate::trial::Trial;

fn station(tag: u64, [horizontal_m, vertical_m, distance_m]: [f64; 3]) -> Request {
    Request::Station(StationRequest {
        tag,
        target: StationTarget::Hull {
            horizontal_m,
            vertical_m,
            distance_m,
        },
        speed_mps: Some(0.2),
        duration: Duration::from_secs(50),
    })
}

const SUSPENDED: [f64; 3] = [10.0, 10.0, 4.0];
const ASIDE: [f64; 3] = [10.0, 10.0, 11.0];
/// From here the way to where the mission was suspended leads through the screw.
const BEHIND_SCREW: [f64; 3] = [40.0, 10.0, 11.0];

fn moved_aside() -> Trial {
    let mut trial = Trial::with(setup(Some(station_limits())));
    trial.vehicle.speed_mps = 0.0;
    trial.vehicle.hull_m = Some(SUSPENDED);
    trial.run_for(3.0);
    trial.ask(0, [station(1, ASIDE)]);
    trial.run_for(0.5);
    assert!(trial.core.is_steering(), "{:?}", trial.states(1));
    for step in 1..=35 {
        trial.vehicle.hull_m = Some([10.0, 10.0, 4.0 + 0.2 * f64::from(step)]);
        trial.run_for(0.1);
    }
    trial.run_for(1.0);
    assert!(trial.core.is_steering(), "{:?}", trial.states(1));
    trial
}

#[test]
fn the_way_back_to_where_the_mission_was_suspended_leads_through_the_screw() {
    let mut trial = moved_aside();
    refused_for(&mut trial, station(9, BEHIND_SCREW), 9, "screw");
}

#[test]
fn sr_002_a_mission_that_has_not_gone_on_is_still_suspended_at_its_first_place() {
    let mut trial = moved_aside();
    trial.ask(0, [Request::EndStation]);
    trial.run_for(0.3);
    assert_eq!(trial.sent("RES").len(), 1);
    refused_for(&mut trial, station(9, BEHIND_SCREW), 9, "screw");
}

#[test]
fn sr_002_after_a_link_loss_a_mission_may_still_be_suspended_at_its_first_place() {
    let mut trial = moved_aside();
    trial.vehicle.replays = false;
    trial.cut();
    trial.run_for(3.0);
    let now = trial.now;
    trial.vehicle.set_status(now, "Running");
    trial.vehicle.set_control(now, true);
    trial.run_for(1.0);
    refused_for(&mut trial, station(9, BEHIND_SCREW), 9, "screw");
}

#[test]
fn sr_002_station_keeping_is_rejected_while_a_gps_hit_is_flown() {
    let mut setup = setup(Some(station_limits()));
    setup.fence = course::harbour();
    for plugin in &mut setup.plugins {
        plugin.grants.push(Grant::Surface);
    }
    let mut trial = Trial::with(setup);
    trial.vehicle.hull_m = Some([0.0, 5.0, 5.0]);
    trial.vehicle.speed_mps = 0.0;
    trial.run_for(3.0);
    let hit = GpsHitRequest {
        tag: 1,
        position: at(0.0, 500.0),
    };
    accepted(&mut trial, Request::GpsHit(hit), 1);
    begins(&mut trial, None, Some(1));
    let station = StationRequest {
        tag: 9,
        target: StationTarget::Hull {
            horizontal_m: 5.0,
            vertical_m: 5.0,
            distance_m: 5.0,
        },
        speed_mps: Some(0.2),
        duration: Duration::from_secs(20),
    };
    refused_for(&mut trial, Request::Station(station), 9, "GPS hit");
}
