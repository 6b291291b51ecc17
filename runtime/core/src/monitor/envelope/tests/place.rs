//! Where the vehicle is.

use super::*;

/// Over the seabed at an altitude, at a depth.
fn sample(envelope: &Envelope, local: EastNorth, depth_m: f64, altitude_m: Option<f64>) -> NavigationSample {
    NavigationSample {
        depth: depth(depth_m),
        altitude: altitude_m.map(|metres| Altitude::from_m(metres).unwrap()),
        ..navigation(envelope, local)
    }
}

#[test]
fn a_place_is_good_with_some_room_above_and_below_it_if_there_is_room() {
    let envelope = envelope();
    let here = at(1200.0, 0.0);
    let clear_m = clearance_m(&envelope, [Shape::point(here)], 5.0);
    let good = |depth_m, altitude_m| {
        envelope
            .judge_place(&sample(&envelope, here, depth_m, altitude_m), START)
            .map(|good| good.unwrap())
    };
    for (depth_m, altitude_m, [shallowest_m, deepest_m, least_m]) in [
        (20.0, Some(10.0), [18.0, 22.0, 8.0]),
        (1.0, Some(10.0), [0.0, 3.0, 8.0]),
        (-0.2, Some(10.0), [0.0, 2.0, 8.0]),
        // No room to the greatest depth of the zone, or to its least altitude.
        (99.0, Some(10.0), [99.0, 99.0, 10.0]),
        (20.0, Some(3.0), [20.0, 20.0, 3.0]),
    ] {
        let good = good(depth_m, altitude_m).unwrap();
        assert_eq!(good.at, here);
        near(good.clearance_m, clear_m);
        near(good.depth_min_m, shallowest_m);
        near(good.depth_max_m, deepest_m);
        near(good.altitude_min_m, least_m);
    }
    assert!(good(20.0, None).unwrap().altitude_min_m > 1e5);
    assert!(good(101.0, None).is_err());
    assert!(good(20.0, Some(1.9)).is_err());
}

#[test]
fn a_good_place_covers_what_is_nearer_than_its_clearance_and_within_its_depths() {
    let envelope = envelope();
    let good = Good {
        at: at(0.0, 0.0),
        clearance_m: 10.0,
        depth_min_m: 5.0,
        depth_max_m: 25.0,
        altitude_min_m: 4.0,
    };
    let covers = |local, depth_m, altitude_m| good.covers(&sample(&envelope, local, depth_m, altitude_m));
    assert!(covers(at(6.0, 7.9), 20.0, Some(4.0)));
    assert!(covers(at(6.0, 7.9), 20.0, None));
    assert!(covers(at(0.0, 0.0), 5.0, Some(4.0)));
    assert!(covers(at(0.0, 0.0), 25.0, Some(4.0)));
    assert!(!covers(at(6.0, 8.0), 20.0, Some(4.0)));
    assert!(!covers(at(0.0, 0.0), 4.9, Some(4.0)));
    assert!(!covers(at(0.0, 0.0), 25.1, Some(4.0)));
    assert!(!covers(at(0.0, 0.0), 20.0, Some(3.9)));
    // On the surface, which moves.
    let afloat = Good {
        depth_min_m: 0.0,
        ..good
    };
    assert!(afloat.covers(&sample(&envelope, at(0.0, 0.0), -0.3, None)));
}

#[test]
fn a_place_is_well_inside_with_the_room_and_the_error_of_navigation() {
    let envelope = envelope();
    let inside = |east_m: f64, room_m: f64| {
        envelope.is_well_inside(&sample(&envelope, at(east_m, 0.0), 20.0, None), room_m, START)
    };
    let clear_m = clearance_m(&envelope, [Shape::point(at(1200.0, 0.0))], 5.0);
    assert!(inside(1200.0, clear_m - 1e-3));
    assert!(!inside(1200.0, clear_m + 1e-3));
    // The room is in the plane only.
    let deep = sample(&envelope, at(0.0, 0.0), 99.5, Some(2.5));
    assert!(envelope.is_well_inside(&deep, 30.0, START));
}

#[test]
fn a_place_is_judged_at_this_moment_and_for_it_alone_if_the_fence_changes() {
    let envelope = closing(10.0);
    let here = sample(&envelope, at(0.0, 300.0), 20.0, None);
    assert!(envelope.judge_place(&here, START).unwrap().is_none());
    assert!(envelope.judge_place(&here, START + Duration::from_secs(10)).is_err());
    assert!(!envelope.is_well_inside(&here, 1.0, START + Duration::from_secs(10)));
}
