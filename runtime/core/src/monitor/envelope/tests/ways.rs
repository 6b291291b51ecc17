//! Where inserts begin and end, what lies between, how long that is and how long it lasts.

use super::*;

#[test]
fn a_line_begins_and_ends_anywhere_on_its_leads() {
    let envelope = envelope();
    let (start, end) = (at(100.0, 200.0), at(400.0, 600.0));
    let flown = line(&envelope, start, end, deep(15.0));
    let (first, last) = envelope.ends(&flown);
    let (led_in, led_out) = (at(82.0, 176.0), at(418.0, 624.0));
    near_end(first, End::between(led_in, start));
    near_end(last, End::between(led_out, end));
    let (plain_start, plain_end) = envelope.line_without_leads(&flown).unwrap();
    near_point(plain_start, start);
    near_point(plain_end, end);
    let [from, to] = envelope.path_begins(&flown, at(0.0, 0.0));
    near_point(from, led_in);
    near_point(to, start);
    let legs = envelope.legs(&flown);
    assert_eq!(legs.len(), 1);
    near_point(legs[0].0, led_in);
    near_point(legs[0].1, led_out);
    near(envelope.length_m(&flown), 560.0);
}

#[test]
fn a_circle_begins_and_ends_at_its_entry_angle_or_anywhere_on_it() {
    let envelope = envelope();
    let (centre, radius_m) = (at(50.0, -20.0), 100.0);
    let anywhere = circle(&envelope, centre, radius_m, None);
    let (first, last) = envelope.ends(&anywhere);
    near_end(first, End::Anywhere { centre, radius_m });
    near_end(last, End::Anywhere { centre, radius_m });
    assert!(envelope.line_without_leads(&anywhere).is_none());
    near(envelope.length_m(&anywhere), 2.0 * PI * 100.0 * 2.25);

    let entered = circle(&envelope, centre, radius_m, Some(30.0));
    let convergence_deg = envelope.fence.frame().convergence_deg(position(&envelope, centre));
    let (first, last) = envelope.ends(&entered);
    near_end(first, End::At(centre.offset(30.0 - convergence_deg, radius_m)));
    // Two and a quarter orbits to the left.
    near_end(last, End::At(centre.offset(300.0 - convergence_deg, radius_m)));
    let begins = envelope.path_begins(&entered, at(900.0, 0.0));
    for begin in begins {
        near_point(begin, centre.offset(30.0 - convergence_deg, radius_m));
    }
}

#[test]
fn a_circle_without_an_entry_angle_is_entered_between_its_two_tangents() {
    let envelope = envelope();
    let (centre, radius_m) = (at(500.0, 0.0), 300.0);
    let flown = circle(&envelope, centre, radius_m, None);
    // The tangents from the origin meet the circle at an angle whose sine is 0.6. Abeam of the centre they are
    // 500 m times the tangent of that angle away from it.
    let [left, right] = envelope.path_begins(&flown, at(0.0, 0.0));
    near_point(left, at(500.0, -375.0));
    near_point(right, at(500.0, 375.0));
    // From inside, or as good as inside, in any direction.
    let close = at(500.0 - 304.0, 0.0);
    let [ahead, astern] = envelope.path_begins(&flown, close);
    near_point(ahead, at(196.0 + 600.0, 0.0));
    near_point(astern, at(196.0 - 600.0, 0.0));
    let outside = envelope.path_begins(&flown, at(500.0 - 306.0, 0.0));
    let off_m = 300.0 * 306.0 / (306.0f64 * 306.0 - 300.0 * 300.0).sqrt();
    near_point(outside[0], at(500.0, -off_m));
    near_point(outside[1], at(500.0, off_m));
}

#[test]
fn the_sides_around_a_circle_and_around_a_gps_hit_close() {
    let envelope = envelope();
    for (flown, radius_m) in [
        (circle(&envelope, at(50.0, -20.0), 100.0, None), 100.0),
        (surfacing(&envelope, at(50.0, -20.0)), 60.0),
    ] {
        let corners = [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0), (-1.0, -1.0)]
            .map(|(east, north)| at(50.0 + east * radius_m, -20.0 + north * radius_m));
        let legs = envelope.legs(&flown);
        assert_eq!(legs.len(), 4);
        for (side, (start, end)) in legs.into_iter().enumerate() {
            near_point(start, corners[side]);
            near_point(end, corners[side + 1]);
        }
    }
}

#[test]
fn a_gps_hit_begins_at_its_place_and_ends_adrift() {
    let envelope = envelope();
    let hit = surfacing(&envelope, at(50.0, -20.0));
    let (first, last) = envelope.ends(&hit);
    near_end(first, End::At(at(50.0, -20.0)));
    near_end(
        last,
        End::Anywhere {
            centre: at(50.0, -20.0),
            radius_m: 60.0,
        },
    );
    near(envelope.length_m(&hit), 0.0);
    for begin in envelope.path_begins(&hit, at(0.0, 0.0)) {
        near_point(begin, at(50.0, -20.0));
    }
}

#[test]
fn an_insert_lasts_as_long_as_the_longest_transit_its_own_length_and_two_turns() {
    let envelope = envelope();
    let flown = line(&envelope, at(0.0, 0.0), at(300.0, 400.0), deep(15.0));
    // From the farthest place to the start of the lead-in at (-18, -24).
    let from = [End::At(at(0.0, 10.0)), End::At(at(-18.0, 976.0))];
    near(envelope.duration_s(&flown, &[]), 560.0 / 1.2 + 44.0);
    near(envelope.duration_s(&flown, &from), (560.0 + 1000.0) / 1.2 + 44.0);
    // The vehicle flies a GPS hit at a speed of its own choice, and waits.
    let hit = surfacing(&envelope, at(0.0, 0.0));
    near(envelope.duration_s(&hit, &[]), 44.0 + 200.0);
    near(
        envelope.duration_s(&hit, &[End::At(at(300.0, 400.0))]),
        500.0 / 0.8 + 44.0 + 200.0,
    );
    let around = circle(&envelope, at(0.0, 0.0), 100.0, Some(0.0));
    near(envelope.duration_s(&around, &[]), 2.0 * PI * 225.0 / 1.2 + 44.0);

    // With the way on to what may come next: straight, or by way of a line.
    let (led_out, alone_s) = (at(318.0, 424.0), 560.0 / 1.2 + 44.0);
    let to = |point: EastNorth| Route {
        to: vec![End::At(at(318.0, 424.0)), End::At(point)],
        ..Route::default()
    };
    near(
        envelope.lasts_s(&flown, &to(led_out + at(-600.0, -800.0))),
        alone_s + (970.0f64.max(1000.0)) / 0.8,
    );
    let mut both = to(led_out + at(-600.0, -800.0));
    both.onto = vec![Track::Line(led_out + at(-480.0, -640.0), led_out)];
    near(envelope.lasts_s(&flown, &both), alone_s + SQRT_2 * 800.0 / 0.8);
    both.onto = vec![Track::Line(led_out + at(-360.0, -480.0), led_out)];
    near(envelope.lasts_s(&flown, &both), alone_s + 1000.0 / 0.8);
    both.from = vec![End::At(at(-18.0, 976.0))];
    near(envelope.lasts_s(&flown, &both), alone_s + 1000.0 / 1.2 + 1000.0 / 0.8);
}

#[test]
fn an_end_covers_every_place_where_a_way_may_end() {
    let triangle = [at(0.0, 0.0), at(30.0, 0.0), at(0.0, 60.0)];
    let within = |radius_m| End::Within {
        corners: triangle,
        radius_m,
    };
    near_point(within(2.0).middle(), at(10.0, 20.0));
    assert_eq!(within(0.0).corners(), triangle);
    let (centre, radius_m) = (at(5.0, 6.0), 10.0);
    let octagon = End::Anywhere { centre, radius_m }.corners();
    assert_eq!(octagon.len(), 8);
    for (eighth, corner) in octagon.into_iter().enumerate() {
        near_point(corner, centre.offset(45.0 * eighth as f64, 10.0 / cos(PI / 8.0)));
    }
    let rounded = within(2.0).corners();
    assert_eq!(rounded.len(), 24);
    near_point(rounded[8], at(30.0, 2.0 / cos(PI / 8.0)));
    near(farthest_m(within(0.0), End::At(at(0.0, -40.0))), 100.0);
    near(farthest_m(End::At(at(3.0, 0.0)), End::At(at(0.0, 4.0))), 5.0);

    // On a track, or between it and somewhere else.
    let track = Track::Line(at(0.0, 0.0), at(100.0, 0.0));
    near_end(
        End::on_or_beside(&track, None),
        End::Within {
            corners: [at(0.0, 0.0), at(0.0, 0.0), at(100.0, 0.0)],
            radius_m: 0.0,
        },
    );
    // The middle of the triangle is as far from its farthest corner as (0, 60) is from (10, 20).
    let around_m = (100.0f64 + 1600.0).sqrt();
    near_end(
        End::on_or_beside(&track, Some(within(2.0))),
        End::Within {
            corners: [at(10.0, 20.0), at(0.0, 0.0), at(100.0, 0.0)],
            radius_m: around_m + 2.0,
        },
    );
    let approach = Track::Approach(Approach {
        begun: at(7.0, 0.0),
        within_m: 3.0,
        to: [at(50.0, 1.0), at(60.0, 1.0)],
    });
    near_end(
        End::on_or_beside(&approach, Some(End::At(at(1.0, 1.0)))),
        End::Within {
            corners: [at(1.0, 1.0), at(7.0, 0.0), at(50.0, 1.0)],
            radius_m: 3.0,
        },
    );
    let points = |track: &Track| track.points().collect::<Vec<_>>();
    assert_eq!(points(&track), [at(0.0, 0.0), at(100.0, 0.0), at(100.0, 0.0)]);
    assert_eq!(points(&approach), [at(7.0, 0.0), at(50.0, 1.0), at(60.0, 1.0)]);
    near(track.within_m(), 0.0);
    near(approach.within_m(), 3.0);
}

#[test]
fn a_route_goes_on_to_the_corners_of_its_ends_and_the_points_of_its_tracks() {
    let route = Route {
        to: vec![End::At(at(1.0, 2.0)), End::between(at(3.0, 4.0), at(5.0, 6.0))],
        onto: vec![Track::Line(at(7.0, 8.0), at(9.0, 10.0))],
        ..Route::default()
    };
    assert_eq!(
        route.goes_on_to().collect::<Vec<_>>(),
        [
            at(1.0, 2.0),
            at(3.0, 4.0),
            at(5.0, 6.0),
            at(5.0, 6.0),
            at(7.0, 8.0),
            at(9.0, 10.0),
            at(9.0, 10.0)
        ]
    );
    let extent = VerticalExtent {
        depth_min_m: 11.0,
        depth_max_m: 12.0,
        altitude_min_m: 0.0,
    };
    assert_eq!(route.passed_m(&extent), [11.0, 12.0]);
    let passing = Route {
        depths_m: Some([1.0, 30.0]),
        ..route
    };
    assert_eq!(passing.passed_m(&extent), [1.0, 30.0]);
}

#[test]
fn an_insert_is_flown_between_the_depth_now_and_its_own() {
    let envelope = envelope();
    let lock = Some(BottomLock {
        water_depth_m: 50.0,
        at: at(0.0, 0.0),
    });
    let (start, end) = (at(60.0, 0.0), at(160.0, 0.0));
    let at_depth = line(&envelope, start, end, deep(30.0));
    assert_eq!(envelope.depths_m(&at_depth, depth(20.0), None), Some([20.0, 31.5]));
    assert_eq!(envelope.deepest_m(&at_depth, depth(20.0), None), Some(31.5));
    let over = line(
        &envelope,
        start,
        end,
        flight(Vertical::Altitude(Altitude::from_m(5.0).unwrap())),
    );
    assert_eq!(envelope.depths_m(&over, depth(20.0), None), None);
    assert_eq!(envelope.deepest_m(&over, depth(20.0), None), None);
    // The middle of the lead-in and the start, (50, 0), is 50 m from the lock, and the line is 160 m long.
    let [shallowest_m, deepest_m] = envelope.depths_m(&over, depth(20.0), lock).unwrap();
    near(shallowest_m, 20.0);
    near(deepest_m, 50.0 + 0.1 * 210.0 - 5.0 + 1.5);
    near(envelope.deepest_m(&over, depth(20.0), lock).unwrap(), deepest_m);
    near(
        envelope.depths_m(&over, depth(40.0), lock).unwrap()[0],
        50.0 - 0.1 * 210.0 - 5.0 - 1.5,
    );
    let hit = surfacing(&envelope, start);
    assert_eq!(envelope.depths_m(&hit, depth(20.0), None), Some([0.0, 20.0]));
    assert_eq!(envelope.deepest_m(&hit, depth(20.0), None), Some(20.0));
    assert!(hit.surfaces() && !over.surfaces());
}
