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
