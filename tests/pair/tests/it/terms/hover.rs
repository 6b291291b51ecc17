use std::time::Duration;

use backseat_core::plugin::{Request, StationRequest, StationTarget};
use backseat_core::{BottomBox, Grant, Limits, StationLimits};
use backseat_pair::{Dive, Setup, course_plugin};
use backseat_units::Timestamp;

use super::scene::{ORIGIN, Zone, closest_admitted, exact, fence, setup, world};

/// Allows everything up to some x, and makes nothing uncertain.
pub(super) fn limits(x_max_m: f64, link_delay_max_s: f64) -> Limits {
    Limits {
        speed_min_mps: 0.4,
        speed_max_mps: 0.7,
        link_delay_max_s,
        navigation_age_max_s: 2.0,
        station: Some(StationLimits {
            speed_max_mps: 0.7,
            speed_default_mps: 0.7,
            position_error_m: 0.01,
            relative_age_max_s: 2.0,
            jump_allowance_m: 2.0,
            term_max_s: 60.0,
            altitude_min_m: 2.0,
            sonar_angle_min_deg: None,
            sonar_angle_max_deg: None,
            hull_box: None,
            bottom_box: Some(BottomBox {
                name: String::new(),
                x_min_m: -200.0,
                x_max_m,
                y_min_m: -200.0,
                y_max_m: 200.0,
                depth_min_m: 0.0,
                depth_max_m: 30.0,
            }),
            keep_out_hull: Vec::new(),
            keep_out_bottom: Vec::new(),
        }),
        ..exact()
    }
}

/// A hovering vehicle that moves ahead at 0.7 m/s, and 20 s later is asked to stay in place.
fn asks(x_max_m: f64, link_delay_max_s: f64, before: impl FnOnce(&mut Dive)) -> Dive {
    let plan = "[[plan]]\nkind = \"trackline\"\nstart = { east_m = 0, north_m = 0 }\nend = { east_m = 0, north_m = 150 }\n\
        depth_m = 20\nspeed_mps = 0.7\ndynamic = true\n";
    let hovering = "[vehicle]\nclass = \"hovering\"\n[hovering]\nspeed_limit_mps = 0.7\ndrift_m_per_sqrt_h = 0\n\
        bearing_drift_deg_per_sqrt_h = 0\nposition_noise_m = 0\nrelative_hz = 10\n";
    let world = world(ORIGIN, (0.0, 0.0, 0.0), plan, hovering);
    let inside = Zone::inside([-700.0, -700.0, 700.0, 700.0]);
    let setup = Setup {
        plugin: course_plugin(&[Grant::Station], &[]),
        ..setup(world, fence(ORIGIN, &[inside]), limits(x_max_m, link_delay_max_s))
    };
    let mut dive = Dive::new(setup);
    dive.run_for(20.0);
    assert!(dive.core.has_control(), "{:#?}", dive.notes);
    before(&mut dive);
    dive.lost = vec!["$BPCON", "$BPRES"];
    dive.ask(Request::Station(StationRequest {
        tag: 1,
        target: StationTarget::Here,
        speed_mps: None,
        duration: Duration::from_secs(30),
    }));
    dive.run_for(0.15);
    dive
}

/// The clearance inside its box for some time after the request, while the vehicle receives nothing more: the mission
/// is resumed after two seconds.
fn suspended(dive: &mut Dive, x_max_m: f64, seconds: f64) -> f64 {
    let mut least_m = f64::MAX;
    while dive.now < Timestamp::from_millis(20_000) + Duration::from_secs_f64(seconds) {
        dive.run_for(0.05);
        least_m = least_m.min(x_max_m - dive.mvc.hovering_truth().map_or(f64::NAN, |truth| truth.x_m));
    }
    least_m
}

#[test]
fn the_two_seconds_of_silence_are_the_way_that_it_takes_to_stop() {
    let (x_max_m, mut dive) = closest_admitted((5.0, 25.0), |x_max_m| asks(x_max_m, 0.05, |_| ()));
    let least_m = suspended(&mut dive, x_max_m, 2.1);
    assert!((0.0..1.4).contains(&least_m), "{least_m}");
}

#[test]
fn the_delay_of_the_link_to_station_keeping() {
    let late = |dive: &mut Dive| dive.delay[0] = Duration::from_millis(900);
    let (x_max_m, mut dive) = closest_admitted((5.0, 25.0), |x_max_m| asks(x_max_m, 0.9, late));
    let least_m = suspended(&mut dive, x_max_m, 3.0);
    assert!((0.0..0.9 * 0.7).contains(&least_m), "{least_m}");
}

#[test]
fn the_age_of_relative_navigation() {
    let unheard = |dive: &mut Dive| {
        dive.unheard = vec!["$BFCNV"];
        dive.run_for(1.5);
    };
    let (x_max_m, mut dive) = closest_admitted((5.0, 25.0), |x_max_m| asks(x_max_m, 0.05, unheard));
    let least_m = suspended(&mut dive, x_max_m, 1.5 + 2.1);
    assert!((0.0..1.5 * 0.7).contains(&least_m), "{least_m}");
}
