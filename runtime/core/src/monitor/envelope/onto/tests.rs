use backseat_units::math::{sin, tan};
use proptest::prelude::*;

use super::*;

fn at(east_m: f64, north_m: f64) -> EastNorth {
    EastNorth::new(east_m, north_m)
}

#[test]
fn a_vehicle_behind_the_start_meets_the_line_abeam() {
    let line = (at(0.0, 0.0), at(100.0, 0.0));
    let solid = |here, ahead, first| vec![Shape::quadrilateral([here, ahead, first, line.1])];
    let (beside, behind, farther) = (at(50.0, 30.0), at(-40.0, 30.0), at(-60.0, 20.0));
    assert_eq!(onto_line(&[beside, beside], line), solid(beside, beside, at(0.0, 0.0)));
    assert_eq!(
        onto_line(&[beside, behind], line),
        solid(beside, behind, at(-40.0, 0.0))
    );
    assert_eq!(
        onto_line(&[farther, behind], line),
        solid(farther, behind, at(-60.0, 0.0))
    );
    let point = (at(5.0, 5.0), at(5.0, 5.0));
    assert_eq!(
        onto_line(&[beside, behind], point),
        [Shape::quadrilateral([beside, behind, point.0, point.1])]
    );
}

/// How far a point is outside of the nearest of the solids, metres.
fn outside_m(solids: &[Shape], point: EastNorth) -> f64 {
    let cross = |a: EastNorth, b: EastNorth| a.east_m * b.north_m - a.north_m * b.east_m;
    let from_line = |a: EastNorth, b: EastNorth| {
        let (way, off) = (b - a, point - a);
        let square_m2 = way.east_m * way.east_m + way.north_m * way.north_m;
        let share = (off.east_m * way.east_m + off.north_m * way.north_m) / square_m2.max(1e-12);
        point.distance_m(a + way * share.clamp(0.0, 1.0))
    };
    let from_solid = |solid: &Shape| {
        let Shape::Convex(convex) = solid else {
            panic!("{solid:?}")
        };
        let corners = convex.points();
        let triangles = (2..corners.len()).map(|third| [corners[0], corners[third - 1], corners[third]]);
        let within = |[a, b, c]: [EastNorth; 3]| {
            let turns = [
                cross(b - a, point - a),
                cross(c - b, point - b),
                cross(a - c, point - c),
            ];
            turns.iter().all(|turn| *turn >= 0.0) || turns.iter().all(|turn| *turn <= 0.0)
        };
        if triangles.into_iter().any(within) {
            return 0.0;
        }
        let sides = (0..corners.len()).map(|side| from_line(corners[side], corners[(side + 1) % corners.len()]));
        sides.fold(f64::INFINITY, f64::min)
    };
    solids.iter().map(from_solid).fold(f64::INFINITY, f64::min)
}

fn place(metres: f64) -> impl Strategy<Value = EastNorth> {
    (-metres..metres, -metres..metres).prop_map(|(east, north)| at(east, north))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4_000))]

    #[test]
    fn the_solids_contain_every_way_onto_an_approach(
        vehicle in [place(800.0), place(800.0)],
        begun in place(50.0),
        to in [place(80.0), place(80.0)],
        within_m in 0.0..4.0f64,
        (share, between) in (0.0..=1.0f64, 0.0..=1.0f64),
        (bearing_deg, off) in (0.0..360.0f64, 0.0..=1.0f64),
    ) {
        let approach = Approach { begun, within_m, to };
        let solids = approach.onto(&vehicle);
        // One of the possible approaches, and a vehicle somewhere between the two places.
        let begun = begun.offset(bearing_deg, off * within_m);
        let target = to[0] + (to[1] - to[0]) * share;
        let from = vehicle[0] + (vehicle[1] - vehicle[0]) * between;
        let way = target - begun;
        let length_m = begun.distance_m(target);
        prop_assume!(length_m > 1e-3);
        let along_m = ((from - begun).east_m * way.east_m + (from - begun).north_m * way.north_m) / length_m;
        let first = begun + way * (along_m.min(0.0) / length_m);
        for (a, b, c) in [(0.0, 0.0, 1.0), (0.5, 0.5, 0.0), (0.4, 0.2, 0.4), (0.0, 0.5, 0.5), (0.3, 0.0, 0.7)] {
            let passed = from * a + target * b + first * c;
            let outside_m = outside_m(&solids, passed);
            prop_assert!(outside_m <= within_m + 1e-6, "{outside_m} at {passed:?} of {solids:?}");
        }
    }
}

#[test]
fn an_approach_leads_in_the_directions_between_its_two_points_and_a_bit_more() {
    let approach = |begun, within_m, to| Approach { begun, within_m, to };
    let is = |approach: Approach, first_deg: f64, span_deg: f64| {
        let (first, span) = approach.directions_deg();
        let apart_deg = (first - first_deg + 180.0).rem_euclid(360.0) - 180.0;
        assert!(
            apart_deg.abs() < 1e-6 && (span - span_deg).abs() < 1e-6,
            "{first} and {span} instead of {first_deg} and {span_deg}"
        );
    };
    let (begun, north_east, south_east) = (at(10.0, 20.0), at(40.0, 50.0), at(40.0, -10.0));
    // From 45 to 135 degrees, whichever comes first.
    is(approach(begun, 0.0, [north_east, south_east]), 45.0, 90.0);
    is(approach(begun, 0.0, [south_east, north_east]), 45.0, 90.0);
    // The nearest point between the two is 30 m away, abeam; half of that is an angle of 30 degrees.
    is(approach(begun, 15.0, [north_east, south_east]), 15.0, 150.0);
    // The nearest point is an end: 50 m away, and 100 m.
    let (close, far) = (at(40.0, 60.0), at(70.0, 100.0));
    let bearing_deg = asin(0.6).to_degrees();
    is(approach(begun, 25.0, [close, far]), bearing_deg - 30.0, 60.0);
    is(approach(begun, 25.0, [far, close]), bearing_deg - 30.0, 60.0);
    // Across north.
    is(
        approach(at(0.0, 0.0), 0.0, [at(-30.0, 30.0), at(30.0, 30.0)]),
        315.0,
        90.0,
    );
    // Both points are one.
    is(approach(begun, 0.0, [close, close]), bearing_deg, 0.0);
    // So near that it may lead anywhere.
    is(
        approach(begun, 20.9, [north_east, south_east]),
        90.0 - 45.0 - asin(20.9 / 30.0).to_degrees(),
        90.0 + 2.0 * asin(20.9 / 30.0).to_degrees(),
    );
    is(approach(begun, 21.1, [north_east, south_east]), 0.0, 360.0);
    is(approach(begun, 1.0, [begun, begun]), 0.0, 360.0);
    is(approach(begun, f64::NAN, [close, far]), 0.0, 360.0);
}

#[test]
fn the_solids_onto_an_approach_are_no_larger_than_they_must_be() {
    // Behind the begin of an approach that leads east, from 81 to 99 degrees: the feet lie on the lines to its points.
    let (begun, to) = (
        at(0.0, 0.0),
        [
            at(100.0, 100.0 * tan((9.0f64).to_radians())),
            at(100.0, -100.0 * tan((9.0f64).to_radians())),
        ],
    );
    let approach = Approach {
        begun,
        within_m: 0.0,
        to,
    };
    let solids = approach.onto(&[at(-100.0, 0.0), at(-100.0, 0.0)]);
    // The feet on the two lines are at 100 cos(9) along them, moved outwards by 1/cos(18) from the middle, (-50, 0).
    let foot = |deg: f64| {
        let side = EastNorth::new(sin(deg.to_radians()), cos(deg.to_radians()));
        let middle = at(-50.0, 0.0);
        middle + (side * -(100.0 * cos((9.0f64).to_radians())) - middle) * (1.0 / cos((18.0f64).to_radians()))
    };
    let expected = Shape::convex_hulls(&[begun, to[0], to[1], at(-100.0, 0.0), foot(81.0), foot(99.0)]);
    for point in [
        foot(81.0),
        foot(99.0),
        at(-100.0, 0.0),
        to[0],
        to[1],
        at(-20.0, 0.0),
        at(50.0, 0.0),
    ] {
        assert!(outside_m(&solids, point) < 1e-6, "{point:?}");
        assert!(outside_m(&expected, point) < 1e-6, "{point:?}");
    }
    let corners = |solids: &[Shape]| {
        let mut points: Vec<EastNorth> = Vec::new();
        for solid in solids {
            if let Shape::Convex(convex) = solid {
                points.extend(convex.points());
            }
        }
        points
    };
    for corner in corners(&solids) {
        assert!(outside_m(&expected, corner) < 1e-6, "{corner:?} is beyond {expected:?}");
    }
    // Ahead of the begin, the vehicle flies straight to the approach: no foot lies behind it.
    let ahead = approach.onto(&[at(50.0, 40.0), at(50.0, 40.0)]);
    for corner in corners(&ahead) {
        assert!(corner.east_m >= -1e-9, "{corner:?}");
    }
    // A range of directions that is wider than 20 degrees is covered by several solids.
    let wide = Approach {
        to: [at(100.0, 100.0), at(100.0, -100.0)],
        ..approach
    };
    let (few, many) = (approach.onto(&[at(-100.0, 0.0)]), wide.onto(&[at(-100.0, 0.0)]));
    // The vehicle is on the line between the feet, so rounding decides whether it is a corner of its own.
    assert!(few.len() <= 2, "{} solids", few.len());
    // From 45 to 135 degrees: five ranges.
    assert!(many.len() >= 5, "{} solids", many.len());
}

#[test]
fn two_points_in_one_direction_are_no_turn_apart_and_the_begin_has_room_up_to_a_limit() {
    let begun = at(0.0, 0.0);
    let mut rounded = 0;
    for (east, north) in (1..60).flat_map(|east| (1..60).map(move |north| (east, north))) {
        let near = at(0.7 * f64::from(east), 1.3 * f64::from(north));
        let to = [near, near * 3.3];
        let (_, span_deg) = Approach {
            begun,
            within_m: 0.0,
            to,
        }
        .directions_deg();
        assert!(span_deg < 1e-6, "{span_deg} of {to:?}");
        rounded += u32::from(atan2(to[1].east_m, to[1].north_m) != atan2(near.east_m, near.north_m));
    }
    assert!(rounded > 10, "rounding makes no difference here");
    // A sine of exactly 0.7 is the last that leaves a direction.
    let span_deg = |within_m| {
        let to = [at(0.0, 10.0); 2];
        Approach { begun, within_m, to }.directions_deg().1
    };
    assert!(span_deg(7.0) < 90.0);
    assert_eq!(span_deg(7.1), 360.0);
}
