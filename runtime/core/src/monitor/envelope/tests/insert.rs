//! How near an insert comes, how deep, and when.

use super::*;

fn start() -> EastNorth {
    at(200.0, 300.0)
}

/// 400 m long, to the east.
fn end() -> EastNorth {
    at(600.0, 300.0)
}

fn flown(envelope: &Envelope) -> Insert {
    line(envelope, start(), end(), deep(15.0))
}

fn judge(envelope: &Envelope, insert: &Insert, lock: Option<f64>, route: &Route) -> Result<f64, Refusal> {
    let lock = lock.map(|water_depth_m| BottomLock {
        water_depth_m,
        at: at(185.0, 260.0),
    });
    envelope.judge_insert(insert, depth(20.0), lock, route, CLOCKS)
}

fn led_out() -> EastNorth {
    at(630.0, 300.0)
}

/// The middle of the lead-in as an end, a third of the way from `led_in` to twice `start`, is so far from the lock.
fn lock_off_m() -> f64 {
    at(190.0, 300.0).distance_m(at(185.0, 260.0))
}

/// The water depth from which a vehicle at 20 m keeps 2 m of altitude on a line at 15 m, if the seabed may rise on the
/// way from the lock to the end of the reach.
fn least_water_m(reach_m: f64) -> f64 {
    15.0 + 1.5 + 2.0 + 0.1 * (lock_off_m() + reach_m)
}

fn routes() -> [Route; 4] {
    let far = at(-700.0, -400.0);
    let from = Route {
        from: vec![End::At(at(0.0, 0.0)), End::At(far)],
        ..Route::default()
    };
    let to = Route {
        to: vec![End::At(at(0.0, 0.0)), End::At(far)],
        ..Route::default()
    };
    let onto = Route {
        onto: vec![Track::Line(at(0.0, -100.0), far)],
        ..Route::default()
    };
    [Route::default(), from, to, onto]
}

/// The longest way to or from the line, on each of the routes.
fn ways_m() -> [f64; 4] {
    let far = at(-700.0, -400.0);
    // From far away the start is farther than the beginning of its lead-in; to it, the end of the lead-out is.
    [
        0.0,
        start().distance_m(far),
        led_out().distance_m(far),
        led_out().distance_m(far),
    ]
}

#[test]
fn a_line_keeps_its_cross_track_allowance_and_its_leads_from_the_fence() {
    let envelope = envelope();
    let (start, end) = (at(1050.0, 0.0), at(1250.0, 0.0));
    let near_edge = line(&envelope, start, end, deep(20.0));
    let clear_m = judge(&envelope, &near_edge, Some(400.0), &Route::default()).unwrap();
    let shape = Shape::leg(at(1020.0, 0.0), at(1280.0, 0.0));
    near(clear_m, clearance_m(&envelope, [shape], beside_m(1.5)));
}

#[test]
fn a_circle_keeps_its_cross_track_allowance_from_the_fence() {
    let envelope = envelope();
    let centre = at(900.0, 0.0);
    let around = circle(&envelope, centre, 300.0, None);
    let clear_m = judge(&envelope, &around, Some(400.0), &Route::default()).unwrap();
    let rim = Shape::Rim {
        centre,
        radius_m: 300.0,
    };
    near(clear_m, clearance_m(&envelope, [rim], beside_m(1.5)));
    // Its reach is its diameter.
    let least_m = 15.0 + 1.5 + 2.0 + 0.1 * (centre.distance_m(at(185.0, 260.0)) + 600.0 + beside_m(1.5));
    passes_from(least_m, 1e-3, |water_m| {
        judge(&envelope, &around, Some(water_m), &Route::default())
    });
}

#[test]
fn the_ways_to_and_from_an_insert_are_flown_at_the_greatest_speed() {
    let envelope = envelope();
    let middle = line(&envelope, at(-200.0, 0.0), at(200.0, 0.0), deep(15.0));
    let corner = at(1100.0, 1100.0);
    let widest_m = beside_m(2.6);
    let from = Route {
        from: vec![End::At(corner)],
        seen_mps: 2.6,
        ..Route::default()
    };
    let to_it = ways(End::At(corner), End::between(at(-230.0, 0.0), at(-200.0, 0.0)));
    near(
        judge(&envelope, &middle, Some(400.0), &from).unwrap(),
        clearance_m(&envelope, to_it, widest_m),
    );
    // From the surface, the climb may have led it farther.
    let climb_m = 40.0 * (3.0f64).sqrt() / 2.0 + 0.3 * 40.0 / 1.1;
    let up = Route {
        from_surface: true,
        ..from.clone()
    };
    let to_it = ways(End::At(corner), End::between(at(-230.0, 0.0), at(-200.0, 0.0)));
    near(
        judge(&envelope, &middle, Some(400.0), &up).unwrap(),
        clearance_m(&envelope, to_it, widest_m + climb_m),
    );
    let to = Route {
        to: vec![End::At(corner)],
        seen_mps: 2.6,
        ..Route::default()
    };
    let from_it = || ways(End::between(at(230.0, 0.0), at(200.0, 0.0)), End::At(corner));
    near(
        judge(&envelope, &middle, Some(400.0), &to).unwrap(),
        clearance_m(&envelope, from_it(), widest_m),
    );
    // The climb to the surface after the insert is part of the GPS hit, and not of the insert.
    let up = Route {
        to_surface: true,
        ..to.clone()
    };
    near(
        judge(&envelope, &middle, Some(400.0), &up).unwrap(),
        clearance_m(&envelope, from_it(), widest_m),
    );
    let track = Track::Line(at(800.0, -700.0), at(1100.0, -700.0));
    let onto = Route {
        onto: vec![track],
        seen_mps: 2.6,
        ..Route::default()
    };
    let back = track.onto(&[at(230.0, 0.0), at(200.0, 0.0), at(200.0, 0.0)]);
    near(
        judge(&envelope, &middle, Some(400.0), &onto).unwrap(),
        clearance_m(&envelope, back, widest_m),
    );
}

#[test]
fn the_water_depth_counts_for_the_line_and_for_its_ways() {
    let envelope = envelope();
    for (route, way_m) in routes().into_iter().zip(ways_m()) {
        // The line with its leads is 460 m long.
        let least_m = least_water_m(460.0 + way_m + beside_m(1.5));
        passes_from(least_m, 1e-3, |water_m| {
            judge(&envelope, &flown(&envelope), Some(water_m), &route)
        });
    }
}

#[test]
fn an_insert_must_be_over_before_a_zone_closes() {
    let [_, from, to, onto] = routes();
    let alone_s = 460.0 / 1.2 + 44.0;
    let delayed = Route {
        before_s: 100.0,
        ..Route::default()
    };
    let surfaced = Route {
        from_surface: true,
        ..Route::default()
    };
    let [_, from_m, to_m, onto_m] = ways_m();
    for (route, lasts_s) in [
        (Route::default(), alone_s),
        (from, alone_s + from_m / 1.2),
        (to, alone_s + to_m / 0.8),
        (onto, alone_s + SQRT_2 * onto_m / 0.8),
        (delayed, alone_s + 100.0),
        // 20 m deep at 30 degrees.
        (surfaced, alone_s + 40.0 / 1.1),
    ] {
        // By the vehicle's clock, three seconds later.
        passes_from(lasts_s + 3.0, 1e-2, |after_s| {
            let envelope = closing(after_s);
            judge(&envelope, &flown(&envelope), Some(400.0), &route)
        });
    }
}

#[test]
fn a_gps_hit_keeps_the_climb_the_drift_and_the_allowance_of_the_greatest_speed() {
    let envelope = envelope();
    let hit = surfacing(&envelope, at(1000.0, 0.0));
    let climb_m = 40.0 * (3.0f64).sqrt() / 2.0 + 0.3 * 40.0 / 1.1;
    let alone = Route {
        seen_mps: 2.6,
        ..Route::default()
    };
    let place = Shape::point(at(1000.0, 0.0));
    near(
        judge(&envelope, &hit, Some(400.0), &alone).unwrap(),
        clearance_m(&envelope, [place], beside_m(2.6) + climb_m + 60.0),
    );
    // What comes before may lead deeper, and then the climb is longer.
    let deeper = Route {
        deepest_m: 35.0,
        ..alone
    };
    let climb_m = 70.0 * (3.0f64).sqrt() / 2.0 + 0.3 * 70.0 / 1.1;
    near(
        judge(&envelope, &hit, Some(400.0), &deeper).unwrap(),
        clearance_m(&envelope, [place], beside_m(2.6) + climb_m + 60.0),
    );
    // The ways to and from it.
    let corner = at(1100.0, 1100.0);
    let middle = surfacing(&envelope, at(0.0, 0.0));
    let from = Route {
        from: vec![End::At(corner)],
        deepest_m: 35.0,
        ..Route::default()
    };
    near(
        judge(&envelope, &middle, Some(400.0), &from).unwrap(),
        clearance_m(&envelope, [Shape::leg(at(0.0, 0.0), corner)], beside_m(2.0) + climb_m),
    );
    let to = Route {
        to: vec![End::At(corner)],
        deepest_m: 35.0,
        ..Route::default()
    };
    let adrift = End::Anywhere {
        centre: at(0.0, 0.0),
        radius_m: 60.0,
    };
    near(
        judge(&envelope, &middle, Some(400.0), &to).unwrap(),
        clearance_m(&envelope, ways(adrift, End::At(corner)), beside_m(2.0) + climb_m),
    );
    let track = Track::Line(at(800.0, -700.0), at(1100.0, -700.0));
    let onto = Route {
        onto: vec![track],
        deepest_m: 35.0,
        ..Route::default()
    };
    near(
        judge(&envelope, &middle, Some(400.0), &onto).unwrap(),
        clearance_m(&envelope, track.onto(&adrift.corners()), beside_m(2.0) + climb_m),
    );
}

#[test]
fn a_gps_hit_reaches_as_far_as_it_drifts_and_lasts_as_long_as_its_climb() {
    let envelope = envelope();
    let place = at(200.0, 300.0);
    let hit = |envelope: &Envelope| surfacing(envelope, place);
    let far = at(-700.0, -400.0);
    let from = Route {
        from: vec![End::At(far)],
        deepest_m: 35.0,
        ..Route::default()
    };
    // At 35 m, and as far as the drift, the way and the allowance reach.
    let reach_m = 60.0 + place.distance_m(far) + beside_m(2.0);
    let least_m = 35.0 + 1.5 + 2.0 + 0.1 * (place.distance_m(at(185.0, 260.0)) + reach_m);
    passes_from(least_m, 1e-3, |water_m| {
        judge(&envelope, &hit(&envelope), Some(water_m), &from)
    });
    let lasts_s = place.distance_m(far) / 0.8 + 44.0 + 200.0 + 70.0 / 1.1;
    passes_from(lasts_s + 3.0, 1e-2, |after_s| {
        let envelope = closing(after_s);
        judge(&envelope, &hit(&envelope), Some(400.0), &from)
    });
}

#[test]
fn the_ways_of_an_insert_pass_the_depths_of_the_plan() {
    // North of the equator of this fence, keep out between 40 and 60 m. The line is south of it, the way to it is not.
    let envelope = Envelope::new(fence_with(Some(r#","depth_min_m":40,"depth_max_m":60"#)), distinct());
    let south = line(&envelope, at(0.0, -300.0), at(300.0, -300.0), deep(15.0));
    let route = |deepest_m: f64| Route {
        from: vec![End::At(at(0.0, 300.0))],
        depths_m: Some([0.0, deepest_m]),
        ..Route::default()
    };
    passes_from(-40.0, 1e-3, |minus_deepest_m| {
        judge(&envelope, &south, Some(400.0), &route(-minus_deepest_m))
    });
    let hit = surfacing(&envelope, at(0.0, -300.0));
    passes_from(-40.0, 1e-3, |minus_deepest_m| {
        judge(&envelope, &hit, Some(400.0), &route(-minus_deepest_m))
    });
}

#[test]
fn a_way_alone_is_judged_at_the_depth_now_or_at_the_depths_given() {
    let envelope = envelope();
    let passage = |lock: Option<f64>| Passage {
        depth: depth(20.0),
        lock: lock.map(|water_depth_m| BottomLock {
            water_depth_m,
            at: at(-400.0, -300.0),
        }),
        surfacing: false,
        deepest_m: 0.0,
        seen_mps: 2.6,
        depths_m: None,
        clocks: CLOCKS,
        before_s: 50.0,
    };
    let surfacing = |lock| Passage {
        surfacing: true,
        deepest_m: 35.0,
        ..passage(lock)
    };
    let climb_m = 70.0 * (3.0f64).sqrt() / 2.0 + 0.3 * 70.0 / 1.1;
    let ends = (End::At(at(600.0, 0.0)), End::At(at(1000.0, 0.0)));
    let leg = Shape::leg(at(600.0, 0.0), at(1000.0, 0.0));
    near(
        envelope.judge_way(ends, &passage(Some(400.0))).unwrap(),
        clearance_m(&envelope, [leg], beside_m(2.6)),
    );
    near(
        envelope.judge_way(ends, &surfacing(Some(400.0))).unwrap(),
        clearance_m(&envelope, [leg], beside_m(2.6) + climb_m),
    );
    let track = Track::Line(at(700.0, 300.0), at(1000.0, 300.0));
    let onto = (End::At(at(900.0, 0.0)), &track);
    let solids = || track.onto(&[at(900.0, 0.0)]);
    near(
        envelope.judge_way_onto(onto, &passage(Some(400.0))).unwrap(),
        clearance_m(&envelope, solids(), beside_m(2.6)),
    );
    near(
        envelope.judge_way_onto(onto, &surfacing(Some(400.0))).unwrap(),
        clearance_m(&envelope, solids(), beside_m(2.6) + climb_m),
    );
    // Where it began is known within 30 m.
    let approach = Track::Approach(Approach {
        begun: at(700.0, 300.0),
        within_m: 30.0,
        to: [at(1000.0, 300.0); 2],
    });
    let from = at(900.0, 0.0);
    near(
        envelope
            .judge_way_onto((End::At(from), &approach), &passage(Some(400.0)))
            .unwrap(),
        clearance_m(&envelope, approach.onto(&[from]), beside_m(2.6) + 30.0),
    );
    // A straight way of 400 m around its end, and one by way of a line, at most 500 m, around its beginning.
    let least_m = 20.0 + 2.0 + 0.1 * (at(1000.0, 0.0).distance_m(at(-400.0, -300.0)) + 400.0 + beside_m(2.6));
    passes_from(least_m, 1e-3, |water_m| {
        envelope.judge_way(ends, &passage(Some(water_m)))
    });
    let farthest_m = at(900.0, 0.0).distance_m(at(700.0, 300.0));
    let reach_m = at(900.0, 0.0).distance_m(at(-400.0, -300.0)) + SQRT_2 * farthest_m + beside_m(2.6);
    passes_from(20.0 + 2.0 + 0.1 * reach_m, 1e-3, |water_m| {
        envelope.judge_way_onto(onto, &passage(Some(water_m)))
    });
    // It begins at the latest after 50 s, and after the climb.
    let north = (End::At(at(600.0, 300.0)), End::At(at(1000.0, 300.0)));
    passes_from(50.0 + 400.0 / 0.8 + 3.0, 1e-2, |after_s| {
        closing(after_s).judge_way(north, &passage(Some(400.0)))
    });
    passes_from(50.0 + 70.0 / 1.1 + 400.0 / 0.8 + 3.0, 1e-2, |after_s| {
        closing(after_s).judge_way(north, &surfacing(Some(400.0)))
    });
    let onto = (End::At(at(900.0, 600.0)), &track);
    let farthest_m = at(900.0, 600.0).distance_m(at(700.0, 300.0));
    passes_from(50.0 + SQRT_2 * farthest_m / 0.8 + 3.0, 1e-2, |after_s| {
        closing(after_s).judge_way_onto(onto, &passage(Some(400.0)))
    });
    // A keep-out zone counts at the depth now, or at the depths that are passed.
    let deep = |min_m: f64, max_m: f64| {
        let zone = format!(r#","depth_min_m":{min_m},"depth_max_m":{max_m}"#);
        Envelope::new(fence_with(Some(&zone)), distinct())
    };
    assert!(deep(20.0, 20.0).judge_way(north, &passage(Some(400.0))).is_err());
    assert!(deep(21.0, 60.0).judge_way(north, &passage(Some(400.0))).is_ok());
    assert!(deep(10.0, 19.0).judge_way(north, &passage(Some(400.0))).is_ok());
    let passing = Passage {
        depths_m: Some([20.0, 30.0]),
        ..passage(Some(400.0))
    };
    assert!(deep(21.0, 60.0).judge_way(north, &passing).is_err());
}
