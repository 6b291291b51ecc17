//! Compares the verdicts on random fences and sweeps with those of judges that share no code with the fence's search:
//! the `geo` crate, parry's own queries, and a plain scan that measures by searching along the shapes.

use geo::{
    Area, Contains, ConvexHull, Distance, Euclidean, Geometry, LineString, MultiPoint, Point, Polygon as GeoPolygon,
};
use parry2d_f64::math::{Pose, Vector};
use parry2d_f64::query;
use parry2d_f64::shape::{ConvexPolygon, Polyline, Segment, Shape as Shape2};
use proptest::prelude::*;

use super::*;
use crate::map::CLEARANCE_MAX_M;

/// Within this distance of the threshold both verdicts are right, because the judges round, metres.
const TIE_M: f64 = 1e-7;

/// A star around a middle: every ray from there meets the ring once, so the ring never crosses itself.
fn star(middle: (f64, f64), radii: &[(f64, f64)], scale: f64) -> Points {
    let count = radii.len() as f64;
    let point = |(index, (radius, jitter)): (usize, &(f64, f64))| {
        let bearing = (index as f64 + 0.8 * jitter) / count * 360.0;
        // Bearings run clockwise, so this goes backwards to make a counterclockwise ring.
        let end = at(middle.0, middle.1).offset(-bearing, radius * scale);
        (end.east_m, end.north_m)
    };
    radii.iter().enumerate().map(point).collect()
}

fn radii() -> impl Strategy<Value = Vec<(f64, f64)>> {
    prop::collection::vec((50.0..1000.0f64, 0.0..1.0f64), 4..40)
}

/// A zone to judge: rings and margin.
#[derive(Clone, Debug)]
struct Plan {
    rings: Vec<Points>,
    margin_m: f64,
}

fn plan(middle: f64, size: f64) -> impl Strategy<Value = Plan> {
    let middle = (-middle..=middle, -middle..=middle);
    let margin = prop_oneof![Just(0.0), 0.0..40.0f64];
    (middle, radii(), prop::option::of(0.05..0.9f64), margin).prop_map(move |(middle, radii, hole, margin_m)| {
        let mut rings = vec![star(middle, &radii, size)];
        // The same star, made smaller, is wholly inside.
        rings.extend(hole.map(|scale| reversed(star(middle, &radii, size * scale))));
        Plan { rings, margin_m }
    })
}

#[derive(Clone, Debug)]
struct Case {
    keep_ins: Vec<Plan>,
    keep_outs: Vec<Plan>,
}

impl Case {
    fn fence(&self) -> Fence {
        let zones = |plans: &[Plan], kind| -> Vec<Zone> {
            plans
                .iter()
                .map(|plan| zone("zone", kind, plan.margin_m, &plan.rings))
                .collect()
        };
        let mut all = zones(&self.keep_ins, KEEP_IN);
        all.extend(zones(&self.keep_outs, KEEP_OUT));
        fence(all)
    }
}

fn case() -> impl Strategy<Value = Case> {
    (
        prop::collection::vec(plan(200.0, 1.0), 1..3),
        prop::collection::vec(plan(700.0, 0.2), 0..5),
    )
        .prop_map(|(keep_ins, keep_outs)| Case { keep_ins, keep_outs })
}

/// A point anywhere, or at some distance between a micrometre and a kilometre from a vertex of the first ring.
fn near(case: &Case, (vertex, bearing, magnitude): (prop::sample::Index, f64, f64)) -> EastNorth {
    let plans: Vec<_> = case
        .keep_ins
        .iter()
        .chain(&case.keep_outs)
        .flat_map(|plan| &plan.rings)
        .flatten()
        .collect();
    let (east, north) = vertex.get(&plans);
    at(*east, *north).offset(bearing, backseat_units::math::pow(10.0, magnitude))
}

type Whereabouts = (prop::sample::Index, f64, f64);

fn whereabouts() -> impl Strategy<Value = Whereabouts> {
    (any::<prop::sample::Index>(), 0.0..360.0f64, -5.0..3.0f64)
}

fn radius() -> impl Strategy<Value = f64> {
    prop_oneof![Just(0.0), 0.0..5.0f64, 0.0..200.0f64]
}

fn geo_polygon(rings: &[Points]) -> GeoPolygon {
    let mut rings = rings.iter().map(|ring| LineString::from(ring.clone()));
    let outer = rings.next().unwrap();
    GeoPolygon::new(outer, rings.collect())
}

/// The convex hull by `geo`, which is solid even if it is flat.
fn geo_convex_hull(points: &[EastNorth]) -> Geometry {
    let points: Vec<_> = points
        .iter()
        .map(|point| Point::new(point.east_m, point.north_m))
        .collect();
    match points[..] {
        [a] => Geometry::Point(a),
        [a, b] => Geometry::Line(geo::Line::new(a.0, b.0)),
        _ => Geometry::Polygon(MultiPoint::new(points).convex_hull()),
    }
}

/// The distance to the rings, and whether the shape is inside if it does not touch them.
struct Measured {
    distance_m: f64,
    inside: bool,
}

fn by_geo(plan: &Plan, shape: &Geometry, witness: EastNorth) -> Measured {
    let polygon = geo_polygon(&plan.rings);
    let rings = std::iter::once(polygon.exterior()).chain(polygon.interiors());
    let distance_m = rings
        .map(|ring| Euclidean.distance(&Geometry::LineString(ring.clone()), shape))
        .fold(f64::INFINITY, f64::min);
    Measured {
        distance_m,
        inside: polygon.contains(&Point::new(witness.east_m, witness.north_m)),
    }
}

/// The distance by parry's own search and dispatch, and the side by `geo`.
fn by_parry(plan: &Plan, shape: &dyn Shape2, witness: EastNorth) -> Measured {
    let here = Pose::IDENTITY;
    let rings = plan.rings.iter().map(|ring| {
        let closed = ring.iter().chain(ring.first());
        Polyline::new(closed.map(|(east, north)| Vector::new(*east, *north)).collect(), None)
    });
    let distance_m = rings
        .map(|ring| query::distance(&here, &ring, &here, shape).unwrap().distance)
        .fold(f64::INFINITY, f64::min);
    Measured {
        distance_m,
        inside: geo_polygon(&plan.rings).contains(&Point::new(witness.east_m, witness.north_m)),
    }
}

/// The clearance from the measures of every zone, negative if the fence is breached.
fn verdict(case: &Case, radius_m: f64, measure: impl Fn(&Plan) -> Measured) -> f64 {
    let reach_m = |plan: &Plan| (plan.margin_m + radius_m).max(1e-6);
    let keep_in = case.keep_ins.iter().map(|plan| {
        let measured = measure(plan);
        if measured.inside {
            measured.distance_m - reach_m(plan)
        } else {
            -1.0
        }
    });
    let keep_out = case.keep_outs.iter().map(|plan| {
        let measured = measure(plan);
        if measured.inside {
            -1.0
        } else {
            measured.distance_m - reach_m(plan)
        }
    });
    keep_in
        .fold(f64::NEG_INFINITY, f64::max)
        .min(keep_out.fold(f64::INFINITY, f64::min))
        .min(CLEARANCE_MAX_M)
}

fn agree(answer: &Result<Clearance, Breach>, expected_m: f64) -> Result<(), TestCaseError> {
    match answer {
        Ok(clearance) => {
            prop_assert!(
                (clearance.metres - expected_m).abs() < TIE_M,
                "{clearance:?}, not {expected_m}"
            );
        }
        Err(breach) => {
            prop_assert!(expected_m < TIE_M, "{breach:?}, not {expected_m}");
            prop_assert!(breach.metres > 0.0 && breach.metres.is_finite(), "{breach:?}");
        }
    }
    Ok(())
}

/// The least distance of the points `along(t)` of a straight line to a segment, by ternary search over t in 0 to 1: the
/// distance to a segment is convex along a straight line.
fn searched_m(from: EastNorth, to: EastNorth, a: EastNorth, b: EastNorth) -> f64 {
    let to_edge = |p: EastNorth| {
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..60 {
            let (s, t) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
            if p.distance_m(a + (b - a) * s) < p.distance_m(a + (b - a) * t) {
                high = t
            } else {
                low = s
            }
        }
        p.distance_m(a + (b - a) * low)
    };
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..60 {
        let (s, t) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if to_edge(from + (to - from) * s) < to_edge(from + (to - from) * t) {
            high = t
        } else {
            low = s
        }
    }
    to_edge(from + (to - from) * low)
}

/// The winding number by summed angles, without rays, crossings or signs of cross products.
fn winds(rings: &[Points], p: EastNorth) -> bool {
    let mut turned_deg = 0.0;
    for ring in rings {
        for (index, a) in ring.iter().enumerate() {
            let b = ring[(index + 1) % ring.len()];
            let turn = p.bearing_deg(at(a.0, a.1)) - p.bearing_deg(at(b.0, b.1));
            turned_deg += backseat_units::math::wrap_180(turn);
        }
    }
    turned_deg > 180.0
}

/// The nearest and the farthest distance between a point and each edge of some rings.
fn reach_of_edges(rings: &[Points], p: EastNorth) -> Vec<(f64, f64)> {
    let edges = rings
        .iter()
        .flat_map(|ring| ring.iter().zip(ring.iter().cycle().skip(1)));
    edges
        .map(|(a, b)| {
            let (a, b) = (at(a.0, a.1), at(b.0, b.1));
            let line = geo::Line::new((a.east_m, a.north_m), (b.east_m, b.north_m));
            let near = Euclidean.distance(&line, &Point::new(p.east_m, p.north_m));
            (near, p.distance_m(a).max(p.distance_m(b)))
        })
        .collect()
}

proptest! {
    // Twelve sweeps per fence.
    #![proptest_config(ProptestConfig::with_cases(1_500))]

    #[test]
    fn convex_hulls_are_judged_as_geo_judges_them(
        case in case(),
        sweeps in prop::collection::vec((prop::collection::vec(whereabouts(), 1..=4), prop::option::of(1e-4..50.0f64), radius()), 12),
    ) {
        let fence = case.fence();
        for (corners, small, radius_m) in sweeps {
            let mut points: Vec<_> = corners.iter().map(|corner| near(&case, *corner)).collect();
            // Anywhere, or all close to the first.
            if let Some(size) = small {
                let first = points[0];
                for point in &mut points[1..] {
                    *point = first + (*point - first) * (size / (1.0 + first.distance_m(*point)));
                }
            }
            let shape = match points[..] {
                [a] => Shape::point(a),
                [a, b] => Shape::leg(a, b),
                [a, b, c] => Shape::triangle(a, b, c),
                _ => Shape::quadrilateral([points[0], points[1], points[2], points[3]]),
            };
            let convex = geo_convex_hull(&points);
            let expected_m = verdict(&case, radius_m, |plan| by_geo(plan, &convex, points[0]));
            agree(&check(&fence, shape, radius_m), expected_m)?;
            let bare = Case {
                keep_ins: case.keep_ins.iter().map(|plan| Plan { margin_m: 0.0, ..plan.clone() }).collect(),
                keep_outs: case.keep_outs.iter().map(|plan| Plan { margin_m: 0.0, ..plan.clone() }).collect(),
            };
            let alone = geo_convex_hull(&points[..1]);
            agree(&fence.contains(points[0]), verdict(&bare, 0.0, |plan| by_geo(plan, &alone, points[0])))?;
        }
    }

    #[test]
    fn legs_and_solids_are_judged_as_parry_judges_them(
        case in case(),
        sweeps in prop::collection::vec((prop::collection::vec(whereabouts(), 2..=4), radius()), 12),
    ) {
        let fence = case.fence();
        for (corners, radius_m) in sweeps {
            let points: Vec<_> = corners.iter().map(|corner| near(&case, *corner)).collect();
            let places: Vec<_> = points.iter().map(|point| Vector::new(point.east_m, point.north_m)).collect();
            // parry makes no convex hull of flat ones.
            let solid = || ConvexPolygon::from_convex_hull(&places).map(|convex| Box::new(convex) as Box<dyn Shape2>);
            let (shape, theirs) = match points[..] {
                [a, b] => (Shape::leg(a, b), Some(Box::new(Segment::new(places[0], places[1])) as _)),
                [a, b, c] => (Shape::triangle(a, b, c), solid()),
                _ => (Shape::quadrilateral([points[0], points[1], points[2], points[3]]), solid()),
            };
            let Some(theirs) = theirs else { continue };
            let expected_m = verdict(&case, radius_m, |plan| by_parry(plan, &*theirs, points[0]));
            agree(&check(&fence, shape, radius_m), expected_m)?;
        }
    }

    #[test]
    fn rims_are_judged_by_the_nearest_and_farthest_place_of_each_edge(
        case in case(),
        sweeps in prop::collection::vec((whereabouts(), prop_oneof![0.0..20.0f64, 0.0..1500.0f64], radius()), 12),
    ) {
        let fence = case.fence();
        for (centre, rim_m, radius_m) in sweeps {
            let centre = near(&case, centre);
            let expected_m = verdict(&case, radius_m, |plan| {
                let distance_m = reach_of_edges(&plan.rings, centre)
                    .into_iter()
                    .map(|(near, far)| (near - rim_m).max(rim_m - far).max(0.0))
                    .fold(f64::INFINITY, f64::min);
                Measured { distance_m, inside: winds(&plan.rings, centre.offset(77.0, rim_m)) }
            });
            agree(&check(&fence, Shape::rim(centre, rim_m), radius_m), expected_m)?;
        }
    }

    #[test]
    fn no_point_of_a_rim_is_nearer_than_the_rim(case in case(), centre in whereabouts(), rim_m in 0.1..1000.0f64) {
        let fence = case.fence();
        let centre = near(&case, centre);
        if let Ok(clearance) = check(&fence, Shape::rim(centre, rim_m), 0.5) {
            for step in 0..90 {
                let point = centre.offset(f64::from(step) * 4.0, rim_m);
                let alone = check(&fence, Shape::point(point), 0.5);
                prop_assert!(alone.is_ok_and(|alone| alone.metres > clearance.metres - TIE_M), "{step}");
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    #[test]
    fn legs_are_judged_like_a_search_along_them(case in case(), ends in (whereabouts(), whereabouts()), radius_m in radius()) {
        let fence = case.fence();
        let (from, to) = (near(&case, ends.0), near(&case, ends.1));
        let expected_m = verdict(&case, radius_m, |plan| {
            let edges = plan.rings.iter().flat_map(|ring| ring.iter().zip(ring.iter().cycle().skip(1)));
            let distance_m = edges
                .map(|(a, b)| searched_m(from, to, at(a.0, a.1), at(b.0, b.1)))
                .fold(f64::INFINITY, f64::min);
            Measured { distance_m, inside: winds(&plan.rings, from) }
        });
        // The search is less exact: ternary search cannot resolve less than the square root of the precision.
        match check(&fence, leg((from.east_m, from.north_m), (to.east_m, to.north_m)), radius_m) {
            Ok(clearance) => prop_assert!((clearance.metres - expected_m).abs() < 1e-4, "{clearance:?} {expected_m}"),
            Err(breach) => prop_assert!(expected_m < 1e-4, "{breach:?} {expected_m}"),
        }
    }

    #[test]
    fn every_point_of_a_leg_that_passes_passes(case in case(), ends in (whereabouts(), whereabouts()), radius_m in radius()) {
        let fence = case.fence();
        let (from, to) = (near(&case, ends.0), near(&case, ends.1));
        let points = (0..=50).map(|step| from + (to - from) * (f64::from(step) / 50.0));
        let worst = points
            .map(|point| check(&fence, Shape::point(point), radius_m).map_or(-1.0, |clearance| clearance.metres))
            .fold(f64::INFINITY, f64::min);
        if let Ok(clearance) = check(&fence, Shape::leg(from, to), radius_m) {
            prop_assert!(worst > clearance.metres - TIE_M);
        }
    }
}

#[test]
fn a_fence_of_ten_thousand_vertices_is_judged_like_a_scan() {
    let radii: Vec<_> = (0..10_000_u32)
        .map(|index| {
            // A coast: waves of several lengths, and a fixed scatter.
            let wave = |period: f64| backseat_units::math::sin(f64::from(index) / period);
            let scatter = f64::from(index.wrapping_mul(2_654_435_761) >> 8) / f64::from(1_u32 << 24);
            (3000.0 + 700.0 * wave(900.0) + 100.0 * wave(31.0) + 2.0 * scatter, 0.5)
        })
        .collect();
    let plan = Plan {
        rings: vec![star((0.0, 0.0), &radii, 1.0)],
        margin_m: 5.0,
    };
    let fence = fence(vec![zone("coast", KEEP_IN, plan.margin_m, &plan.rings)]);
    let mut held = 0;
    for step in 0..200 {
        let from = at(0.0, 0.0).offset(f64::from(step) * 137.5, f64::from(step) * 17.0);
        let to = from.offset(f64::from(step) * 50.0, 400.0);
        let convex = geo_convex_hull(&[from, to]);
        let case = Case {
            keep_ins: vec![plan.clone()],
            keep_outs: Vec::new(),
        };
        let expected_m = verdict(&case, 10.0, |plan| {
            let ring = &plan.rings[0];
            let edges = ring.iter().zip(ring.iter().cycle().skip(1));
            let distance_m = edges
                .map(|(a, b)| Euclidean.distance(&Geometry::Line(geo::Line::new(*a, *b)), &convex))
                .fold(f64::INFINITY, f64::min);
            Measured {
                distance_m,
                inside: winds(&plan.rings, from),
            }
        });
        let answer = check(&fence, Shape::leg(from, to), 10.0);
        held += usize::from(answer.is_ok());
        agree(&answer, expected_m).unwrap();
    }
    assert!(
        (50..190).contains(&held),
        "{held} of 200 legs pass: the test proves little"
    );
}

/// A square with a small star in each cell of a grid, in an order that differs from that on the plane.
fn sieve() -> impl Strategy<Value = Case> {
    let hole = prop::collection::vec((0.2..1.0f64, 0.0..1.0f64), 3..9);
    (prop::collection::vec(hole, 64), 0.0..3.0f64).prop_map(|(holes, margin_m)| {
        let mut rings = vec![rectangle(-500.0, -500.0, 500.0, 500.0)];
        for (index, radii) in holes.iter().enumerate() {
            let cell = index * 37 % 64;
            let middle = (125.0 * (cell % 8) as f64 - 437.5, 125.0 * (cell / 8) as f64 - 437.5);
            rings.push(reversed(star(middle, radii, 55.0)));
        }
        Case {
            keep_ins: vec![Plan { rings, margin_m }],
            keep_outs: Vec::new(),
        }
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]

    #[test]
    fn many_holes_are_judged_as_geo_judges_them(
        case in sieve(),
        sweeps in prop::collection::vec((prop::collection::vec((-520.0..520.0f64, -520.0..520.0f64), 1..=4), 0.01..1.0f64, 0.0..10.0f64), 40),
    ) {
        let fence = case.fence();
        for (corners, size, radius_m) in sweeps {
            let first = at(corners[0].0, corners[0].1);
            // Sizes from the whole square down to less than a cell, where some sweeps keep the fence.
            let shrunk = |corner: &(f64, f64)| first + (at(corner.0, corner.1) - first) * (size * size);
            let points: Vec<_> = corners.iter().map(shrunk).collect();
            let shape = match points[..] {
                [a] => Shape::point(a),
                [a, b] => Shape::leg(a, b),
                [a, b, c] => Shape::triangle(a, b, c),
                _ => Shape::quadrilateral([points[0], points[1], points[2], points[3]]),
            };
            let convex = geo_convex_hull(&points);
            let expected_m = verdict(&case, radius_m, |plan| by_geo(plan, &convex, points[0]));
            agree(&check(&fence, shape, radius_m), expected_m)?;
        }
    }
}

proptest! {
    #[test]
    fn the_solids_of_a_convex_hull_cover_all_of_it(
        points in prop::collection::vec((-500.0..500.0f64, -500.0..500.0f64), 0..=12),
        flat in any::<bool>(),
    ) {
        let points: Vec<_> = points
            .iter()
            .map(|(east, north)| EastNorth::new(*east, if flat { 0.0 } else { *north }))
            .collect();
        let solids = Shape::convex_hulls(&points);
        prop_assert_eq!(solids.is_empty(), points.is_empty());
        let area = |points: &[EastNorth]| geo_convex_hull(points).unsigned_area();
        let mut sum_m2 = 0.0;
        for solid in &solids {
            let Shape::Convex(convex) = solid else { panic!("{solid:?}") };
            prop_assert!(convex.points().iter().all(|corner| points.contains(corner)));
            sum_m2 += area(convex.points());
        }
        if !points.is_empty() {
            prop_assert!((sum_m2 - area(&points)).abs() < 1e-6, "{solids:?}");
            let farthest_m = |points: &[EastNorth], east, north| {
                let along = |point: &EastNorth| east * point.east_m + north * point.north_m;
                points.iter().map(along).fold(f64::NEG_INFINITY, f64::max)
            };
            let corners: Vec<_> = solids
                .iter()
                .flat_map(|solid| match solid {
                    Shape::Convex(convex) => convex.points().to_vec(),
                    Shape::Rim { .. } => Vec::new(),
                })
                .collect();
            for (east, north) in [(1.0, 0.0), (-1.0, 0.0), (0.6, 0.8), (0.6, -0.8)] {
                prop_assert_eq!(farthest_m(&corners, east, north), farthest_m(&points, east, north));
            }
        }
    }
}
