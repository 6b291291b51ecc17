//! Terms that the mock's vehicles do not need, because another term is greater, are checked by their values: each metre
//! of an error must cost a metre of clearance.

use std::time::Duration;

use backseat_core::plugin::{
    CartesianSample, GpsHitRequest, Judge, NavigationSample, Request, StationRequest, StationTarget, StepInput,
    TrackcircleRequest, VerticalRequest,
};
use backseat_core::{Envelope, Limits};
use backseat_fence::Fence;
use backseat_units::{Altitude, Depth, Heading, Timestamp, Utc};

use super::hover;
use super::scene::{ORIGIN, Zone, exact, fence, frame, modify, place, trackline};

/// The clearance of a request of a vehicle in the middle of a box, metres.
fn clearance_m(limits: &Limits, request: &Request, cartesian: Option<CartesianSample>) -> f64 {
    let harbour = "\"depth_max_m\":60,\"altitude_min_m\":2,\"surfacing\":true";
    let inside = Zone("keep-in", [-700.0, -700.0, 700.0, 700.0], harbour.to_owned());
    let fence = Fence::from_geojson(&fence(ORIGIN, &[inside])).expect("the test's fence is right");
    let position = frame(ORIGIN).origin();
    let navigation = NavigationSample {
        solution: Timestamp::from_millis(900),
        position,
        local: fence.frame().to_local(position),
        depth: Depth::from_m(20.0).expect("a depth"),
        altitude: Some(Altitude::from_m(70.0).expect("an altitude")),
        heading: Heading::from_deg(0.0).expect("a heading"),
        roll_deg: 0.0,
        pitch_deg: 0.0,
        east_mps: 0.0,
        north_mps: 0.0,
        down_mps: 0.0,
        yaw_rate_dps: 0.0,
        gps: false,
    };
    let input = StepInput {
        now: Timestamp::from_millis(1000),
        utc: Utc::from_unix_nanos(0),
        clocks_apart: None,
        navigation: Some(navigation),
        relative: None,
        cartesian,
        control: true,
        events: Vec::new(),
    };
    let judged = Envelope::new(fence, limits.clone()).judge(request, &input);
    judged.expect("it is in the middle of the box")
}

/// How much less the clearance is with other limits, metres.
fn costs_m(request: &Request, changed: impl FnOnce(&mut Limits)) -> f64 {
    let limits = exact();
    let mut worse = limits.clone();
    changed(&mut worse);
    clearance_m(&limits, request, None) - clearance_m(&worse, request, None)
}

fn assert_costs(what: &str, cost_m: f64, expected_m: f64) {
    assert!(
        (cost_m - expected_m).abs() < 1e-6,
        "{what} costs {cost_m} m, not {expected_m} m"
    );
}

/// The mock keeps to its lines within a decimetre, and to its circles within two metres. A turn's width, which is also
/// counted, is more. A vehicle that is off its line and then turns needs both.
#[test]
fn what_the_vehicle_strays_counts_in_full() {
    let circle = Request::Trackcircle(TrackcircleRequest {
        tag: 1,
        centre: place(100.0, 100.0),
        radius_m: 50.0,
        orbits: 1.0,
        vertical: VerticalRequest::DepthM(20.0),
        speed_mps: 2.0,
        entry_angle_deg: Some(0.0),
        interrupt: true,
    });
    let line = trackline((0.0, 100.0), (300.0, 100.0), 2.0);
    let surface = Request::GpsHit(GpsHitRequest {
        tag: 1,
        position: place(100.0, 0.0),
    });
    let turn_m = |turn_rate_dps: f64| 2.0 * 2.0 / turn_rate_dps.to_radians();
    for (what, request) in [("a line", line), ("a circle", circle), ("a GPS hit", surface)] {
        let cost_m = costs_m(&request, |limits| limits.tracking_error_m += 10.0);
        assert_costs(&format!("the tracking error of {what}"), cost_m, 10.0);
        let cost_m = costs_m(&request, |limits| limits.navigation_error_m += 10.0);
        assert_costs(&format!("the navigation error of {what}"), cost_m, 10.0);
        let cost_m = costs_m(&request, |limits| limits.turn_rate_dps = 7.0);
        assert_costs(&format!("the turn of {what}"), cost_m, turn_m(7.0) - turn_m(14.0));
    }
}

/// The current's part while the vehicle obeys a modify. The speed over ground may hide it where it is along the path.
#[test]
fn the_current_counts_while_it_obeys_and_while_it_turns() {
    let cost_m = costs_m(&modify(0.0, 2.0), |limits| limits.current_max_mps += 0.5);
    // Since the solution: 0.1 s, 5 s, and the longest delay of a sentence.
    assert_costs("the current", cost_m, 0.5 * (0.1 + 5.0 + 0.05 + 180.0 / 14.0));
}

/// In the mock, an error of relative navigation can only be set as noise.
#[test]
fn the_error_of_relative_navigation_counts_in_full() {
    let cartesian = CartesianSample {
        measured: Timestamp::from_millis(900),
        x_m: 0.0,
        y_m: 0.0,
        z_m: 20.0,
        heading_deg: 0.0,
    };
    let station = Request::Station(StationRequest {
        tag: 1,
        target: StationTarget::Here,
        speed_mps: None,
        duration: Duration::from_secs(30),
    });
    let limits = hover::limits(40.0, 0.05);
    let mut worse = limits.clone();
    worse.station.as_mut().unwrap().position_error_m += 3.0;
    let cost_m = clearance_m(&limits, &station, Some(cartesian)) - clearance_m(&worse, &station, Some(cartesian));
    assert_costs("the error of relative navigation", cost_m, 3.0);
}
