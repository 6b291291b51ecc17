use backseat_core::Limits;
use backseat_core::plugin::{GpsHitRequest, Request, TrackcircleRequest, VerticalRequest};
use backseat_mvc::Truth;
use backseat_pair::Dive;
use backseat_units::EastNorth;

use super::scene::{
    ORIGIN, Zone, closest_admitted, exact, fence, line, outside_of, place, setup, south_of, trackline, watch, world,
};

/// A wide box.
const INSIDE: [f64; 4] = [-700.0, -700.0, 700.0, 700.0];

/// On the plan's line to the east for some seconds, in a box with this northern edge; then it makes the request.
fn asks(edge_m: f64, plan: &str, (limits, more): (&Limits, &str), after_s: f64, request: &Request) -> Dive {
    let inside = Zone::inside([-700.0, -700.0, 700.0, edge_m]);
    let world = world(ORIGIN, (-600.0, 0.0, 90.0), plan, more);
    let mut dive = Dive::new(setup(world, fence(ORIGIN, &[inside]), limits.clone()));
    dive.run_for(after_s);
    assert!(dive.core.has_control(), "{:#?}", dive.notes);
    dive.ask(request.clone());
    dive.run_for(0.3);
    dive
}

#[test]
fn the_error_of_navigation_on_a_line() {
    let limits = Limits {
        navigation_error_m: 25.0,
        ..exact()
    };
    let fault = "[[faults.fault]]\nat_s = 0.5\nkind = \"navigation_jump\"\neast_m = 0\nnorth_m = -25\n";
    let plan = line((-600.0, 0.0), (600.0, 0.0));
    let request = trackline((-500.0, 60.0), (-400.0, 60.0), 2.0);
    let (edge_m, mut dive) = closest_admitted((60.0, 200.0), |edge_m| {
        asks(edge_m, &plan, (&limits, fault), 20.0, &request)
    });
    let least_m = watch(&mut dive, 150.0, &south_of(edge_m));
    assert_eq!(dive.states(1).last(), Some(&"ended"));
    assert!((0.0..25.0).contains(&least_m), "{least_m}");
}

#[test]
fn the_width_of_a_turn() {
    // Its destination is behind it and a little to the north, so that it turns that way.
    let plan = line((-600.0, 0.0), (-500.0, 0.0));
    let request = trackline((-590.0, 4.0), (-650.0, -20.0), 2.0);
    let (edge_m, mut dive) = closest_admitted((4.0, 100.0), |edge_m| {
        asks(edge_m, &plan, (&exact(), ""), 43.0, &request)
    });
    let least_m = watch(&mut dive, 30.0, &south_of(edge_m));
    assert!((0.0..16.0).contains(&least_m), "{least_m}");
}

#[test]
fn the_current_in_a_turn() {
    let limits = Limits {
        current_max_mps: 0.6,
        turn_rate_dps: 14.9,
        ..exact()
    };
    // From a line to the north-east it turns left to the west, while the current sets it to the north.
    let end = EastNorth::new(-525.5, 43.0);
    let plan = line((-600.0, 0.0), (end.east_m, end.north_m));
    let request = trackline((-560.0, 49.0), (-620.0, 20.0), 2.0);
    let current = "[current]\nspeed_mps = 0.6\ntowards_deg = 0\n";
    let (edge_m, mut dive) = closest_admitted((43.0, 200.0), |edge_m| {
        let inside = Zone::inside([-800.0, -700.0, 700.0, edge_m]);
        let world = world(ORIGIN, (-600.0, 0.0, 60.0), &plan, current);
        let mut dive = Dive::new(setup(world, fence(ORIGIN, &[inside]), limits.clone()));
        dive.run_for(6.0);
        assert!(dive.run_until(60.0, |dive| dive.mvc.truth().local.distance_m(end) < 3.0));
        dive.ask(request.clone());
        dive.run_for(0.3);
        dive
    });
    let least_m = watch(&mut dive, 60.0, &south_of(edge_m));
    assert!((0.0..0.6 * 180.0 / 14.9).contains(&least_m), "{least_m}");
}

#[test]
fn the_longest_lead() {
    let limits = Limits {
        lead_max_m: 50.0,
        ..exact()
    };
    let plan = line((-600.0, 0.0), (600.0, 0.0));
    // Straight away from the edge, with the longest lead-in of any vehicle.
    let request = trackline((-400.0, 60.0), (-400.0, 40.0), 2.0);
    let lead = "[interpretation]\nlead_in_m = 50\n";
    let (edge_m, mut dive) = closest_admitted((60.0, 300.0), |edge_m| {
        asks(edge_m, &plan, (&limits, lead), 20.0, &request)
    });
    let least_m = watch(&mut dive, 200.0, &south_of(edge_m));
    assert!((0.0..50.0).contains(&least_m), "{least_m}");
}

/// In a wide box with a keep-out zone in it.
fn asks_beside(zone: [f64; 4], plan: &str, request: &Request) -> Dive {
    let world = world(ORIGIN, (-600.0, 0.0, 90.0), plan, "");
    let zones = [Zone::inside(INSIDE), Zone::outside(zone)];
    let mut dive = Dive::new(setup(world, fence(ORIGIN, &zones), exact()));
    dive.run_for(12.0);
    assert!(dive.core.has_control(), "{:#?}", dive.notes);
    dive.ask(request.clone());
    dive.run_for(0.3);
    dive
}

#[test]
fn the_way_to_a_line() {
    let plan = line((-600.0, 0.0), (600.0, 0.0));
    let request = trackline((-300.0, 300.0), (-200.0, 300.0), 2.0);
    // A zone beside the straight path to the line, far enough to the west to be beside no other path.
    let zone = |west_by_m: f64| [-480.0 - west_by_m, 140.0, -420.0 - west_by_m, 160.0];
    let (by_m, mut dive) = closest_admitted((0.0, 100.0), |by_m| asks_beside(zone(by_m), &plan, &request));
    let least_m = watch(&mut dive, 250.0, &|truth: &Truth| outside_of(zone(by_m), truth.local));
    assert!((0.0..40.0).contains(&least_m), "{least_m}");
}

#[test]
fn the_way_on_from_a_line() {
    let plan = format!(
        "{}[[plan]]\nkind = \"waypoint\"\nat = {{ east_m = 100, north_m = 600 }}\ndepth_m = 20\nspeed_mps = 2\n",
        line((-600.0, 0.0), (0.0, 0.0))
    );
    let request = trackline((-500.0, 100.0), (-400.0, 100.0), 2.0);
    // The path from the line's end leads to the north-east.
    let zone = |west_by_m: f64| [-180.0 - west_by_m, 340.0, -120.0 - west_by_m, 360.0];
    let (by_m, mut dive) = closest_admitted((0.0, 150.0), |by_m| asks_beside(zone(by_m), &plan, &request));
    let least_m = watch(&mut dive, 450.0, &|truth: &Truth| outside_of(zone(by_m), truth.local));
    assert!((0.0..40.0).contains(&least_m), "{least_m}");
}

#[test]
fn a_circle_that_is_entered_anywhere_is_left_anywhere() {
    let plan = format!(
        "{}[[plan]]\nkind = \"waypoint\"\nat = {{ east_m = 100, north_m = 600 }}\ndepth_m = 20\nspeed_mps = 2\n",
        line((-600.0, 0.0), (0.0, 0.0))
    );
    // The circle is entered in the south-west and left in the north-west.
    let request = Request::Trackcircle(TrackcircleRequest {
        tag: 1,
        centre: place(-300.0, 200.0),
        radius_m: 150.0,
        orbits: 0.25,
        vertical: VerticalRequest::DepthM(20.0),
        speed_mps: 2.0,
        entry_angle_deg: None,
        interrupt: true,
    });
    let zone = |west_by_m: f64| [-120.0 - west_by_m, 480.0, -60.0 - west_by_m, 500.0];
    let (by_m, mut dive) = closest_admitted((0.0, 300.0), |by_m| asks_beside(zone(by_m), &plan, &request));
    let least_m = watch(&mut dive, 600.0, &|truth: &Truth| outside_of(zone(by_m), truth.local));
    assert!((0.0..40.0).contains(&least_m), "{least_m}");
}

/// From the end of a line at 20 m, a GPS hit in a box in which the vehicle may surface.
fn asks_to_surface(
    edges_m: [f64; 4],
    shallows: Option<[f64; 4]>,
    next_east_m: f64,
    limits: &Limits,
    more: &str,
) -> Dive {
    let harbour = "\"depth_max_m\":60,\"altitude_min_m\":2,\"surfacing\":true";
    let mut zones = vec![Zone("keep-in", edges_m, harbour.to_owned())];
    zones.extend(shallows.map(|edges_m| {
        let depths = format!("\"depth_min_m\":0,\"depth_max_m\":{SHALLOW_M}");
        Zone("keep-out", edges_m, depths)
    }));
    let plan = format!(
        "{}[[plan]]\nkind = \"waypoint\"\nat = {{ east_m = {next_east_m}, north_m = 0 }}\n\
         depth_m = 20\nspeed_mps = 2\n",
        line((-600.0, 0.0), (-480.0, 0.0))
    );
    let world = world(ORIGIN, (-600.0, 0.0, 90.0), &plan, more);
    let world = world.replace("starts_after_s = 1\n", "starts_after_s = 1\ngps_fix_s = 215\n");
    let mut dive = Dive::new(setup(world, fence(ORIGIN, &zones), limits.clone()));
    dive.run_for(12.0);
    assert!(dive.core.has_control(), "{:#?}", dive.notes);
    dive.ask(Request::GpsHit(GpsHitRequest {
        tag: 1,
        position: place(-400.0, 0.0),
    }));
    dive.run_for(0.3);
    dive
}

/// The depth down to which there may be fishing gear, metres.
const SHALLOW_M: f64 = 8.0;

#[test]
fn the_drift_of_the_wait_for_gps() {
    let limits = Limits {
        current_max_mps: 0.5,
        gps_hit_duration_max_s: 240.0,
        ..exact()
    };
    let current = "[current]\nspeed_mps = 0.5\ntowards_deg = 0\n";
    let (edge_m, mut dive) = closest_admitted((10.0, 500.0), |edge_m| {
        asks_to_surface([-700.0, -700.0, 700.0, edge_m], None, 100.0, &limits, current)
    });
    let mut least_m = f64::MAX;
    while dive.states(1).last() != Some(&"ended") {
        least_m = least_m.min(watch(&mut dive, 1.0, &south_of(edge_m)));
    }
    assert!((0.0..120.0).contains(&least_m), "{least_m}");
}

#[test]
fn the_depths_on_the_way_from_the_surface() {
    let limits = Limits {
        gps_hit_duration_max_s: 240.0,
        ..exact()
    };
    // Beside the path after it, on which the vehicle dives again.
    let shallows = |north_m: f64| [-380.0, north_m, -250.0, north_m + 60.0];
    let (north_m, mut dive) = closest_admitted((-20.0, 100.0), |north_m| {
        asks_to_surface(INSIDE, Some(shallows(north_m)), 100.0, &limits, "")
    });
    let least_m = watch(&mut dive, 500.0, &|truth: &Truth| {
        outside_of(shallows(north_m), truth.local).max(truth.depth_m - SHALLOW_M)
    });
    assert_eq!(dive.states(1).last(), Some(&"ended"));
    assert!((0.0..20.0).contains(&least_m), "{north_m} {least_m}");
}

/// A torpedo that climbs in a straight line from the position of a GPS hit has moved on when it reaches the surface:
/// from 20 m by 57 m.
#[test]
fn a_climb_leads_on_from_the_place() {
    let limits = Limits {
        gps_hit_duration_max_s: 260.0,
        climb_angle_min_deg: 19.0,
        ..exact()
    };
    let (edge_m, mut dive) = closest_admitted((-395.0, 0.0), |edge_m| {
        asks_to_surface([-700.0, -700.0, edge_m, 700.0], None, -500.0, &limits, "")
    });
    let mut least_m = f64::MAX;
    while dive.states(1).last() != Some(&"ended") {
        least_m = least_m.min(watch(&mut dive, 1.0, &|truth: &Truth| edge_m - truth.local.east_m));
    }
    assert!((0.0..57.0).contains(&least_m), "{edge_m} {least_m}");
}
