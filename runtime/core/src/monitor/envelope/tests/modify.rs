//! Where a modify can lead.

use backseat_units::utm_convergence_deg;

use super::*;

/// The navigation is half a second old at this time.
const NOW: Timestamp = Timestamp::from_millis(10_000);
/// The vehicle obeys for so long after our last BPRMB: the timeout of SPI 7.12, the age of navigation, the link.
const OBEYED_S: f64 = 5.0 + 0.5 + 1.7;

fn setpoint(heading_deg: f64, vertical: Vertical) -> Setpoint {
    Setpoint {
        heading: Heading::from_deg(heading_deg).unwrap(),
        vertical,
        speed: Speed::from_mps(1.5).unwrap(),
    }
}

fn judge(envelope: &Envelope, here: EastNorth, heading_deg: f64, water_m: f64, route: &Route) -> Result<f64, Refusal> {
    let lock = Some(BottomLock {
        water_depth_m: water_m,
        at: here + at(30.0, 40.0),
    });
    let setpoint = setpoint(heading_deg, Vertical::Depth(depth(20.0)));
    envelope.judge_modify(&setpoint, &navigation(envelope, here), lock, route, (NOW, CLOCKS))
}

/// How far beside the line ahead the vehicle may come, by the formula of safety requirement 002, if it turns by an angle
/// at 1.5 m/s and its plan is flown at `fastest_mps`.
fn reach_m(envelope: &Envelope, here: EastNorth, turn_deg: f64, fastest_mps: f64) -> f64 {
    let radius_m = |mps: f64| mps / (PI / 20.0);
    let other_north_m = 1.5 * OBEYED_S * utm_convergence_deg(position(envelope, here)).to_radians().abs();
    radius_m(1.5) * (1.0 - cos(turn_deg.to_radians()))
        + 1.5 * 2.0
        + (2.0 * radius_m(fastest_mps) + fastest_mps * 2.0)
        + 0.3 * (OBEYED_S + 22.0)
        + 5.0
        + other_north_m
}

fn ahead(envelope: &Envelope, here: EastNorth, heading_deg: f64) -> EastNorth {
    let convergence_deg = envelope.fence.frame().convergence_deg(position(envelope, here));
    here.offset(heading_deg - convergence_deg, 1.5 * OBEYED_S)
}

#[test]
fn a_modify_keeps_everything_that_it_can_reach_from_the_fence() {
    let envelope = envelope();
    let here = at(1200.0, 600.0);
    for (heading_deg, turn_deg) in [(90.0, 0.0), (60.0, 30.0), (180.0, 90.0), (270.0, 180.0)] {
        for (seen_mps, fastest_mps) in [(0.0, 2.0), (2.6, 2.6)] {
            let route = Route {
                seen_mps,
                ..Route::default()
            };
            let leg = Shape::leg(here, ahead(&envelope, here, heading_deg));
            let radius_m = reach_m(&envelope, here, turn_deg, fastest_mps);
            near(
                judge(&envelope, here, heading_deg, 90.0, &route).unwrap(),
                clearance_m(&envelope, [leg], radius_m),
            );
        }
    }
}

#[test]
fn a_vehicle_that_is_faster_than_the_request_reaches_farther() {
    let envelope = envelope();
    let here = at(1200.0, 0.0);
    let mut sample = navigation(&envelope, here);
    (sample.east_mps, sample.north_mps) = (1.5, 2.0);
    let setpoint = setpoint(90.0, Vertical::Depth(depth(20.0)));
    let clear_m = envelope
        .judge_modify(&setpoint, &sample, None, &Route::default(), (NOW, CLOCKS))
        .err();
    assert!(clear_m.is_some(), "without bottom lock the altitude is not known");
    let lock = Some(BottomLock {
        water_depth_m: 90.0,
        at: here,
    });
    let clear_m = envelope
        .judge_modify(&setpoint, &sample, lock, &Route::default(), (NOW, CLOCKS))
        .unwrap();
    let convergence_deg = envelope.fence.frame().convergence_deg(sample.position);
    let leg = Shape::leg(here, here.offset(90.0 - convergence_deg, 2.5 * OBEYED_S));
    let other_north_m = 2.5 * OBEYED_S * utm_convergence_deg(sample.position).to_radians().abs();
    let radius_m = 2.5 * 2.0 + (2.0 * 2.5 / (PI / 20.0) + 2.5 * 2.0) + 0.3 * (OBEYED_S + 22.0) + 5.0 + other_north_m;
    near(clear_m, clearance_m(&envelope, [leg], radius_m));
}

#[test]
fn the_water_depth_counts_as_far_as_a_modify_reaches() {
    let envelope = envelope();
    let here = at(0.0, 0.0);
    // The lock was 50 m away.
    let farthest_m = 1.5 * OBEYED_S + reach_m(&envelope, here, 0.0, 2.0);
    let least_m = 20.0 + 1.5 + 2.0 + 0.1 * (50.0 + farthest_m);
    passes_from(least_m, 1e-3, |water_m| {
        judge(&envelope, here, 90.0, water_m, &Route::default())
    });
}

#[test]
fn the_way_back_of_a_modify_is_as_wide_as_its_reach() {
    let envelope = envelope();
    let here = at(0.0, 0.0);
    let ahead = ahead(&envelope, here, 90.0);
    let wide_m = reach_m(&envelope, here, 0.0, 2.0);
    let line = Track::Line(at(1000.0, 600.0), at(1000.0, 900.0));
    let legs = |legs: Vec<Track>| Route {
        legs,
        ..Route::default()
    };
    near(
        judge(&envelope, here, 90.0, 90.0, &legs(vec![line])).unwrap(),
        clearance_m(&envelope, line.onto(&[here, ahead]), wide_m),
    );
    let approach = Track::Approach(Approach {
        begun: at(900.0, 600.0),
        within_m: 6.5,
        to: [at(1000.0, 600.0), at(1020.0, 620.0)],
    });
    let solids = || {
        line.onto(&[here, ahead])
            .into_iter()
            .chain(approach.onto(&[here, ahead]))
    };
    near(
        judge(&envelope, here, 90.0, 90.0, &legs(vec![line, approach])).unwrap(),
        clearance_m(&envelope, solids(), wide_m + 6.5),
    );
    // What begins elsewhere, and where a leg ends, which the leg's own solids cover.
    let corner = at(-1100.0, 300.0);
    let next = |to: Vec<End>| Route {
        legs: vec![line],
        to,
        ..Route::default()
    };
    near(
        judge(&envelope, here, 90.0, 90.0, &next(vec![End::At(corner)])).unwrap(),
        clearance_m(&envelope, [Shape::triangle(here, ahead, corner)], wide_m).min(clearance_m(
            &envelope,
            line.onto(&[here, ahead]),
            wide_m,
        )),
    );
    // The fence gives the clearance of a shape around several others, so here only the answer is exact.
    let area = |centre| End::Anywhere { centre, radius_m: 50.0 };
    let mut corners = area(corner).corners();
    corners.extend([here, ahead]);
    let room_m = clearance_m(&envelope, Shape::convex_hulls(&corners), wide_m);
    passes_from(-1100.0 - room_m, 1e-3, |east_m| {
        judge(&envelope, here, 90.0, 90.0, &next(vec![area(at(east_m, 300.0))]))
    });
}

#[test]
fn a_modify_and_its_way_back_must_be_over_before_a_zone_closes() {
    let here = at(0.0, 300.0);
    let farthest_m = |envelope: &Envelope| 1.5 * OBEYED_S + reach_m(envelope, here, 0.0, 2.0);
    let lasts_s = OBEYED_S + 22.0;
    let alone = Route::default();
    let line = Route {
        legs: vec![Track::Line(at(300.0, 700.0), at(100.0, 300.0))],
        ..Route::default()
    };
    let next = Route {
        to: vec![End::At(at(300.0, 700.0)), End::At(at(300.0, 300.0))],
        ..Route::default()
    };
    let flown = Route {
        before_s: 900.0,
        ..line.clone()
    };
    let envelope = envelope();
    for (route, back_s) in [
        (alone, 0.0),
        (line, SQRT_2 * (500.0 + farthest_m(&envelope)) / 0.8),
        (next, (500.0 + farthest_m(&envelope)) / 0.8),
        // The insert that it changes may take longer than the way back.
        (flown, 900.0f64.max(SQRT_2 * (500.0 + farthest_m(&envelope)) / 0.8)),
    ] {
        passes_from(lasts_s + back_s + 3.0, 1e-2, |after_s| {
            judge(&closing(after_s), here, 90.0, 90.0, &route)
        });
    }
}

#[test]
fn a_modify_passes_the_depths_of_the_plan_on_its_way_back() {
    let envelope = Envelope::new(fence_with(Some(r#","depth_min_m":40,"depth_max_m":60"#)), distinct());
    let route = |deepest_m: f64| Route {
        legs: vec![Track::Line(at(0.0, 300.0), at(300.0, 300.0))],
        depths_m: Some([0.0, deepest_m]),
        ..Route::default()
    };
    passes_from(-40.0, 1e-3, |minus_deepest_m| {
        judge(&envelope, at(0.0, -300.0), 90.0, 90.0, &route(-minus_deepest_m))
    });
}
