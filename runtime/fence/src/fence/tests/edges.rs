//! Cases at the limits, written by hand.

use super::*;

fn box_fence(margin_m: f64) -> Fence {
    fence(vec![zone(
        "box",
        KEEP_IN,
        margin_m,
        &[rectangle(-100.0, -100.0, 100.0, 100.0)],
    )])
}

#[test]
fn a_sweep_that_keeps_exactly_margin_and_radius_holds() {
    let fence = box_fence(10.0);
    for shape in [
        Shape::point(at(0.0, 85.0)),
        leg((-85.0, 85.0), (85.0, 85.0)),
        leg((-85.0, -85.0), (85.0, 85.0)),
        Shape::triangle(at(-85.0, -85.0), at(85.0, -85.0), at(85.0, 85.0)),
        Shape::quadrilateral([at(-85.0, -85.0), at(85.0, 85.0), at(85.0, -85.0), at(-85.0, 85.0)]),
        Shape::rim(at(0.0, 0.0), 85.0),
    ] {
        assert_eq!(spare(&fence, shape, 5.0), 0.0, "{shape:?}");
        let (rule, metres) = refused(&fence, shape, 5.000_001);
        assert_eq!(rule, Rule::KeepIn);
        assert!((metres - 1e-6).abs() < 1e-9, "{metres}");
    }
}

#[test]
fn the_edge_itself_is_outside_even_without_margin_and_radius() {
    let fence = box_fence(0.0);
    for shape in [
        Shape::point(at(100.0, 3.0)),
        Shape::point(at(100.0, 100.0)),
        leg((0.0, 0.0), (100.0, 0.0)),
        leg((100.0, -50.0), (100.0, 50.0)),
        Shape::rim(at(0.0, 0.0), 100.0),
    ] {
        assert_eq!(refused(&fence, shape, 0.0).0, Rule::KeepIn, "{shape:?}");
    }
    assert!(spare(&fence, Shape::point(at(99.0, 0.0)), 0.0) > 0.999);
}

#[test]
fn a_breach_reports_how_far_out_the_worst_point_is() {
    let fence = box_fence(10.0);
    let shape = leg((0.0, 0.0), (130.0, 0.0));
    assert_eq!(refused(&fence, shape, 2.0), (Rule::KeepIn, 42.0));
    assert_eq!(refused(&fence, Shape::point(at(95.0, 0.0)), 2.0), (Rule::KeepIn, 7.0));
    assert_eq!(
        refused(&fence, leg((130.0, 0.0), (170.0, 0.0)), 0.0),
        (Rule::KeepIn, 80.0)
    );
    assert_eq!(
        refused(&fence, Shape::rim(at(60.0, 0.0), 50.0), 0.0),
        (Rule::KeepIn, 20.0)
    );
}

#[test]
fn a_leg_without_length_is_a_point() {
    let fence = box_fence(10.0);
    for nearly in [0.0, 1e-300, 1e-12] {
        assert!((spare(&fence, leg((50.0, 0.0), (50.0 + nearly, 0.0)), 1.0) - 39.0).abs() < 1e-9);
        let points = [at(50.0, 0.0), at(50.0, nearly), at(50.0 - nearly, 0.0), at(50.0, 0.0)];
        assert!((spare(&fence, Shape::quadrilateral(points), 1.0) - 39.0).abs() < 1e-9);
        assert_eq!(refused(&fence, leg((100.0, nearly), (100.0, 0.0)), 1.0).0, Rule::KeepIn);
    }
}

#[test]
fn corners_on_one_line_make_a_leg() {
    let fence = box_fence(0.0);
    let shape = Shape::quadrilateral([at(0.0, 0.0), at(90.0, 0.0), at(30.0, 0.0), at(-40.0, 0.0)]);
    assert_eq!(spare(&fence, shape, 1.0), 9.0);
    let outside = Shape::quadrilateral([at(0.0, 0.0), at(30.0, 0.0), at(110.0, 0.0), at(-40.0, 0.0)]);
    assert_eq!(refused(&fence, outside, 1.0), (Rule::KeepIn, 11.0));
}

#[test]
fn the_order_of_a_convex_hulls_corners_does_not_matter() {
    let fence = box_fence(0.0);
    let corners = [at(-50.0, -50.0), at(60.0, -50.0), at(60.0, 70.0), at(-50.0, 40.0)];
    for order in [[0, 1, 2, 3], [3, 2, 1, 0], [0, 2, 1, 3], [2, 0, 3, 1], [1, 3, 0, 2]] {
        assert_eq!(
            spare(&fence, Shape::quadrilateral(order.map(|index| corners[index])), 5.0),
            25.0
        );
    }
}

#[test]
fn a_leg_through_a_thin_hole_is_refused() {
    let hole = reversed(rectangle(-0.001, -50.0, 0.001, 50.0));
    let fence = fence(vec![zone(
        "box",
        KEEP_IN,
        0.0,
        &[rectangle(-100.0, -100.0, 100.0, 100.0), hole],
    )]);
    assert_eq!(refused(&fence, leg((-80.0, 0.0), (80.0, 0.0)), 0.0).0, Rule::KeepIn);
    assert_eq!(refused(&fence, Shape::point(at(0.0, 0.0)), 0.0).0, Rule::KeepIn);
    assert_eq!(spare(&fence, leg((-80.0, 60.0), (80.0, 60.0)), 1.0), 9.0);
    let breach = check(&fence, leg((-80.0, 0.0), (80.0, 0.0)), 0.0).unwrap_err();
    assert_eq!(fence.describe_edge(breach.edge.unwrap()).unwrap().hole, Some(1));
}

#[test]
fn a_leg_that_crosses_an_edge_almost_along_it_is_refused() {
    use parry2d_f64::math::{Pose, Vector};
    use parry2d_f64::query;
    use parry2d_f64::shape::Segment;

    // parry's query for two segments reports them a sixth of a millimetre apart.
    let edge = [
        (-20574.405144916982, -3111.4465800436574),
        (-21382.10248824897, -10502.06597039965),
    ];
    let ends = [
        (-20597.265843415546, -3320.6257879954437),
        (-21611.731354879594, -12603.225475629079),
    ];
    let segment = |[a, b]: [(f64, f64); 2]| Segment::new(Vector::new(a.0, a.1), Vector::new(b.0, b.1));
    let here = Pose::IDENTITY;
    let theirs = query::distance(&here, &segment(edge), &here, &segment(ends)).unwrap();
    assert!(theirs.distance > 1e-4, "parry has fixed this query: {theirs:?}");

    let ring = vec![edge[0], edge[1], (0.0, -20000.0), (0.0, 0.0)];
    let sea = fence(vec![zone("sea", KEEP_IN, 0.0, &[ring])]);
    assert_eq!(refused(&sea, leg(ends[0], ends[1]), 0.0).0, Rule::KeepIn);
    let breach = check(&sea, leg(ends[0], edge[0]), 0.0).unwrap_err();
    assert_eq!(breach.edge.map(|edge| edge.edge), Some(0), "{breach}");
}

#[test]
fn a_keep_out_zone_or_hole_wholly_inside_a_solid_is_touched() {
    let outer = rectangle(-100.0, -100.0, 100.0, 100.0);
    let small = rectangle(-1.0, -1.0, 1.0, 1.0);
    let triangle = Shape::triangle(at(-80.0, -80.0), at(80.0, -80.0), at(0.0, 80.0));
    let wreck = fence(vec![
        zone("box", KEEP_IN, 0.0, std::slice::from_ref(&outer)),
        zone("wreck", KEEP_OUT, 0.0, std::slice::from_ref(&small)),
    ]);
    assert_eq!(refused(&wreck, triangle, 0.0).0, Rule::KeepOut);
    let hole = fence(vec![zone("box", KEEP_IN, 0.0, &[outer, reversed(small)])]);
    assert_eq!(refused(&hole, triangle, 0.0).0, Rule::KeepIn);
    // The legs of the triangle alone touch neither.
    for fence in [wreck, hole] {
        assert!(check(&fence, leg((-80.0, -80.0), (80.0, -80.0)), 0.0).is_ok());
        assert!(check(&fence, leg((80.0, -80.0), (0.0, 80.0)), 0.0).is_ok());
    }
}

#[test]
fn a_sweep_inside_a_keep_out_zone_is_refused_however_far_its_edges_are() {
    let fence = fence(vec![
        zone("box", KEEP_IN, 0.0, &[rectangle(-100.0, -100.0, 100.0, 100.0)]),
        zone("field", KEEP_OUT, 0.0, &[rectangle(-90.0, -90.0, 99.5, 90.0)]),
    ]);
    assert_eq!(
        refused(&fence, Shape::point(at(60.0, 0.0)), 0.0),
        (Rule::KeepOut, 39.5 + 1e-6)
    );
    assert_eq!(refused(&fence, leg((95.0, 0.0), (98.0, 0.0)), 0.0).0, Rule::KeepOut);
    assert_eq!(refused(&fence, Shape::rim(at(20.0, 0.0), 5.0), 0.0).0, Rule::KeepOut);
}

#[test]
fn a_rim_around_a_keep_out_zone_passes_and_one_through_it_does_not() {
    let fence = fence(vec![
        zone("box", KEEP_IN, 0.0, &[rectangle(-100.0, -100.0, 100.0, 100.0)]),
        zone("wreck", KEEP_OUT, 5.0, &[rectangle(-10.0, -10.0, 10.0, 10.0)]),
    ]);
    let spare_m = spare(&fence, Shape::rim(at(0.0, 0.0), 40.0), 1.0);
    assert!((spare_m - (40.0 - 200.0_f64.sqrt() - 6.0)).abs() < 1e-12);
    for radius in [2.0, 9.0, 12.0, 15.0, 19.0] {
        assert_eq!(
            refused(&fence, Shape::rim(at(0.0, 0.0), radius), 1.0).0,
            Rule::KeepOut,
            "{radius}"
        );
    }
    assert_eq!(refused(&fence, Shape::rim(at(0.0, 0.0), 101.0), 1.0).0, Rule::KeepIn);
    assert_eq!(refused(&fence, Shape::rim(at(0.0, 0.0), 0.0), 1.0).0, Rule::KeepOut);
    // Around the whole fence: it touches no edge and is still outside.
    assert_eq!(refused(&fence, Shape::rim(at(0.0, 0.0), 500.0), 1.0).0, Rule::KeepIn);
}

#[test]
fn a_rim_around_a_hole_passes() {
    let hole = reversed(rectangle(-10.0, -10.0, 10.0, 10.0));
    let fence = fence(vec![zone(
        "box",
        KEEP_IN,
        5.0,
        &[rectangle(-100.0, -100.0, 100.0, 100.0), hole],
    )]);
    assert!(check(&fence, Shape::rim(at(0.0, 0.0), 40.0), 1.0).is_ok());
    assert_eq!(refused(&fence, Shape::rim(at(0.0, 0.0), 18.0), 1.0).0, Rule::KeepIn);
}

#[test]
fn zones_are_not_joined() {
    let fence = fence(vec![
        zone("west", KEEP_IN, 0.0, &[rectangle(-100.0, -10.0, 1.0, 10.0)]),
        zone("east", KEEP_IN, 0.0, &[rectangle(-1.0, -10.0, 100.0, 10.0)]),
    ]);
    assert!(check(&fence, leg((-50.0, 0.0), (0.5, 0.0)), 0.0).is_ok());
    assert!(check(&fence, leg((-0.5, 0.0), (50.0, 0.0)), 0.0).is_ok());
    assert_eq!(
        refused(&fence, leg((-50.0, 0.0), (20.0, 0.0)), 0.0),
        (Rule::KeepIn, 19.0 + 1e-6)
    );
}

#[test]
fn the_clearance_is_that_of_the_zone_with_the_most_room() {
    let fence = fence(vec![
        zone("small", KEEP_IN, 0.0, &[rectangle(-10.0, -10.0, 10.0, 10.0)]),
        zone("large", KEEP_IN, 5.0, &[rectangle(-100.0, -100.0, 100.0, 100.0)]),
    ]);
    let clearance = check(&fence, Shape::point(at(0.0, 0.0)), 1.0).unwrap();
    assert_eq!(clearance.metres, 94.0);
    assert_eq!(fence.describe_edge(clearance.edge.unwrap()).unwrap().zone, "large");
}

#[test]
fn depth_and_altitude_limits_are_those_of_the_zone_that_contains_the_sweep() {
    let deep = Kind::KeepIn {
        depth: Band {
            min_m: 30.0,
            max_m: 90.0,
        },
        altitude_min_m: 10.0,
        surfacing: false,
    };
    let fence = fence(vec![
        zone("shallow", KEEP_IN, 0.0, &[rectangle(-100.0, -100.0, 100.0, 100.0)]),
        zone("deep", deep, 0.0, &[rectangle(-50.0, -50.0, 50.0, 50.0)]),
    ]);
    let sweep = Sweep::new(Shape::point(at(0.0, 0.0)), 1.0);
    let verdict = |min, max, altitude| {
        let vertical = VerticalExtent {
            depth_min_m: min,
            depth_max_m: max,
            altitude_min_m: altitude,
        };
        fence
            .check(&sweep, &vertical)
            .map(|clearance| clearance.metres)
            .map_err(|breach| (breach.rule, breach.metres))
    };
    assert_eq!(verdict(0.0, 50.0, 3.0), Ok(99.0));
    assert_eq!(verdict(30.0, 90.0, 10.0), Ok(49.0));
    // Neither zone allows 20 to 70 m: the shallow one lacks 20 m, the deep one 10 m.
    assert_eq!(verdict(20.0, 70.0, 20.0), Err((Rule::DepthMin, 10.0)));
    assert_eq!(verdict(10.0, 51.0, 20.0), Err((Rule::DepthMax, 1.0)));
    assert_eq!(verdict(-1.0, 5.0, 20.0), Err((Rule::DepthMin, 1.0)));
    assert_eq!(verdict(60.0, 80.0, 9.5), Err((Rule::AltitudeMin, 0.5)));
}

#[test]
fn a_keep_out_zone_counts_only_at_its_depths_including_both_ends() {
    let band = Kind::KeepOut {
        depth: Some(Band {
            min_m: 20.0,
            max_m: 30.0,
        }),
    };
    let fence = fence(vec![
        zone("box", KEEP_IN, 0.0, &[rectangle(-100.0, -100.0, 100.0, 100.0)]),
        zone("net", band, 0.0, &[rectangle(-10.0, -10.0, 10.0, 10.0)]),
    ]);
    let holds = |min, max| {
        let vertical = VerticalExtent {
            depth_min_m: min,
            depth_max_m: max,
            altitude_min_m: 5.0,
        };
        fence
            .check(&Sweep::new(Shape::point(at(0.0, 0.0)), 1.0), &vertical)
            .is_ok()
    };
    assert!(holds(0.0, 19.9) && holds(30.1, 50.0));
    for (min, max) in [(0.0, 20.0), (30.0, 40.0), (0.0, 50.0), (22.0, 23.0)] {
        assert!(!holds(min, max), "{min} {max}");
    }
    // A bare position has no depth.
    assert_eq!(fence.contains(at(0.0, 0.0)).unwrap_err().rule, Rule::KeepOut);
    assert_eq!(fence.contains(at(50.0, 0.0)).unwrap().metres, 40.0 - 1e-6);
}

#[test]
fn containment_ignores_margins() {
    let fence = box_fence(60.0);
    assert!((fence.contains(at(99.0, 0.0)).unwrap().metres - 1.0).abs() < 1e-5);
    assert_eq!(fence.contains(at(100.0, 0.0)).unwrap_err().rule, Rule::KeepIn);
    assert_eq!(fence.contains(at(103.0, 104.0)).unwrap_err().metres, 5.0 + 1e-6);
}

#[test]
fn unusable_numbers_never_pass() {
    let fence = box_fence(10.0);
    let good = at(0.0, 0.0);
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1e10, f64::MAX] {
        let point = at(bad, 0.0);
        for shape in [
            Shape::point(point),
            Shape::point(at(0.0, bad)),
            Shape::leg(good, point),
            Shape::triangle(good, point, good),
            Shape::quadrilateral([good, good, good, point]),
            Shape::rim(point, 1.0),
            Shape::rim(good, bad),
        ] {
            assert_eq!(
                check(&fence, shape, 1.0).unwrap_err().rule,
                Rule::NotFinite,
                "{shape:?}"
            );
        }
        assert_eq!(
            check(&fence, Shape::point(good), bad).unwrap_err().rule,
            Rule::NotFinite
        );
        assert_eq!(fence.contains(point).unwrap_err().rule, Rule::NotFinite);
        assert_eq!(fence.contains(at(0.0, bad)).unwrap_err().rule, Rule::NotFinite);
        for field in 0..3 {
            let mut values = [5.0, 20.0, 10.0];
            values[field] = bad;
            let [depth_min_m, depth_max_m, altitude_min_m] = values;
            let vertical = VerticalExtent {
                depth_min_m,
                depth_max_m,
                altitude_min_m,
            };
            let breach = fence
                .check(&Sweep::new(Shape::point(good), 1.0), &vertical)
                .unwrap_err();
            assert_eq!(breach.rule, Rule::NotFinite);
            assert!(breach.metres > 0.0 && breach.edge.is_none() && breach.zone().is_none());
        }
    }
    assert_eq!(refused(&fence, Shape::point(good), -1.0).0, Rule::NotFinite);
    assert_eq!(refused(&fence, Shape::rim(good, -1.0), 1.0).0, Rule::NotFinite);
    let vertical = VerticalExtent {
        depth_min_m: 20.0,
        depth_max_m: 5.0,
        altitude_min_m: 10.0,
    };
    let breach = fence
        .check(&Sweep::new(Shape::point(good), 1.0), &vertical)
        .unwrap_err();
    assert_eq!(
        breach.to_string(),
        "not a usable number: depth_max_m less than depth_min_m"
    );
}

#[test]
fn huge_sweeps_are_refused_in_metres() {
    let fence = box_fence(10.0);
    assert_eq!(
        refused(&fence, Shape::point(at(0.0, 0.0)), 1e9),
        (Rule::KeepIn, 1e9 - 90.0)
    );
    assert_eq!(refused(&fence, Shape::rim(at(0.0, 0.0), 1e9), 0.0).0, Rule::KeepIn);
    assert_eq!(
        refused(&fence, leg((-1e9, 0.0), (1e9, 0.0)), 0.0),
        (Rule::KeepIn, 1e9 - 90.0)
    );
    let far = Shape::triangle(at(-1e9, -1e9), at(1e9, -1e9), at(0.0, 1e9));
    assert_eq!(refused(&fence, far, 0.0).0, Rule::KeepIn);
}

#[test]
fn polygons_of_a_millimetre_are_judged_like_large_ones() {
    let fence = fence(vec![
        zone("box", KEEP_IN, 0.0, &[rectangle(0.0, 0.0, 0.001, 0.001)]),
        zone("speck", KEEP_OUT, 0.0, &[rectangle(0.0002, 0.0002, 0.0004, 0.0004)]),
    ]);
    assert!((spare(&fence, Shape::point(at(0.0007, 0.0007)), 0.0001) - 0.0002).abs() < 1e-12);
    assert_eq!(refused(&fence, Shape::point(at(0.0003, 0.0003)), 0.0).0, Rule::KeepOut);
    assert_eq!(refused(&fence, Shape::point(at(0.0011, 0.0005)), 0.0).0, Rule::KeepIn);
}

#[test]
fn edges_on_one_line_do_not_confuse_the_side() {
    // A rectangle with unnecessary vertices on its sides.
    let mut ring = Vec::new();
    ring.extend((0..10).map(|step| (f64::from(step) * 10.0, 0.0)));
    ring.extend([(100.0, 0.0), (100.0, 50.0), (50.0, 50.0), (0.0, 50.0)]);
    let fence = fence(vec![zone("box", KEEP_IN, 0.0, &[ring])]);
    for step in 0..=20 {
        let east = f64::from(step) * 5.0;
        assert_eq!(
            refused(&fence, Shape::point(at(east, -3.0)), 0.0),
            (Rule::KeepIn, 3.0 + 1e-6)
        );
        if step > 0 && step < 20 {
            let spare_m = spare(&fence, Shape::point(at(east, 3.0)), 0.0);
            assert!((spare_m - 3.0).abs() < 1e-5, "{spare_m}");
        }
    }
}

#[test]
fn points_beyond_a_sharp_corner_are_distinguished_from_those_inside() {
    // Points around the tip of a needle: their nearest place is the tip, and they lie on the left of one of its edges.
    for angle in [3e-4, 1e-3, 0.1, 1.0] {
        let needle = vec![(0.0, 0.0), (1000.0, -1000.0 * angle), (1000.0, 1000.0 * angle)];
        let keep_in = fence(vec![zone("needle", KEEP_IN, 0.0, std::slice::from_ref(&needle))]);
        let mut outer = rectangle(-2000.0, -2000.0, 2000.0, 2000.0);
        outer[0].0 -= 1.0;
        let hole = fence(vec![zone("box", KEEP_IN, 0.0, &[outer, reversed(needle)])]);
        for distance in [1e-5, 1e-3, 1.0, 100.0] {
            for step in -100..=100 {
                let point = at(0.0, 0.0).offset(-90.0 + f64::from(step) * 0.9, distance);
                assert!(keep_in.contains(point).is_err(), "{angle} {distance} {step}");
                assert!(hole.contains(point).is_ok(), "{angle} {distance} {step}");
            }
        }
        let within = at(500.0, 0.0);
        assert!(keep_in.contains(within).is_ok() && hole.contains(within).is_err());
    }
}

#[test]
fn a_breach_prints_by_itself() {
    let text = |fence: &Fence, shape| check(fence, shape, 2.0).unwrap_err().to_string();
    let plain = box_fence(10.0);
    assert_eq!(
        text(&plain, Shape::point(at(110.3, 0.0))),
        "outside keep-in zone 'box' with its margin of 10 m by 22.3 m at edge 2 (latitude 42.000000 longitude -69.998793)"
    );
    let wreck = fence(vec![
        zone("box", KEEP_IN, 0.0, &[rectangle(-100.0, -100.0, 100.0, 100.0)]),
        zone("wreck", KEEP_OUT, 0.0, &[rectangle(-10.0, -10.0, 10.0, 10.0)]),
    ]);
    assert_eq!(
        text(&wreck, Shape::point(at(0.0, 11.0))),
        "inside keep-out zone 'wreck' by 1.0 m at edge 3 (latitude 42.000090 longitude -70.000000)"
    );
    let sweep = Sweep::new(Shape::point(at(0.0, 50.0)), 1.0);
    let vertical = |depth_min_m, depth_max_m, altitude_min_m| VerticalExtent {
        depth_min_m,
        depth_max_m,
        altitude_min_m,
    };
    for (vertical, text) in [
        (
            vertical(10.0, 60.0, 5.0),
            "10.0 m deeper than the 50 m of keep-in zone 'box'",
        ),
        (
            vertical(-0.5, 5.0, 5.0),
            "0.5 m shallower than the 0 m of keep-in zone 'box'",
        ),
        (
            vertical(10.0, 20.0, 2.99),
            "0.010 m too deep for the altitude of 3 m of keep-in zone 'box'",
        ),
    ] {
        assert_eq!(wreck.check(&sweep, &vertical).unwrap_err().to_string(), text);
    }
}

#[test]
fn the_place_of_a_crossing_is_on_the_crossed_edge() {
    let fence = box_fence(0.0);
    let breach = check(&fence, leg((40.0, 90.0), (60.0, 110.0)), 0.0).unwrap_err();
    assert_eq!(breach.at, Some(at(60.0, 100.0)), "{breach}");
}

#[test]
fn a_fence_is_shared_between_threads() {
    fn shared<T: Send + Sync + Clone + 'static>(_: &T) {}
    shared(&box_fence(1.0));
    shared(&check(&box_fence(1.0), Shape::point(at(200.0, 0.0)), 0.0).unwrap_err());
}

#[test]
fn edges_that_a_fence_does_not_have_are_not_described() {
    let fence = box_fence(0.0);
    let mut edge = check(&fence, Shape::point(at(0.0, 99.0)), 0.5).unwrap().edge.unwrap();
    assert_eq!(fence.describe_edge(edge).unwrap().to_string(), "edge 3");
    for beyond in [4, 5, u32::MAX] {
        edge.edge = beyond;
        assert!(fence.describe_edge(edge).is_none(), "{beyond}");
    }
    edge = crate::EdgeId {
        zone: 1,
        polygon: 0,
        edge: 0,
    };
    assert!(fence.describe_edge(edge).is_none());
}
