//! Circles and corridors contain what is in them, to a centimetre, and nothing else.
#![expect(clippy::unwrap_used, reason = "a panic fails the test")]

use backseat_fence::{Fence, Rule, Shape, Sweep, VerticalExtent};
use backseat_units::{EastNorth, LocalFrame, Position};
use proptest::prelude::*;
use serde_json::{Value, json};

const VERTICAL: VerticalExtent = VerticalExtent {
    depth_min_m: 5.0,
    depth_max_m: 20.0,
    altitude_min_m: 10.0,
};

fn position(at: EastNorth) -> Position {
    LocalFrame::new(Position::from_deg(42.0, -70.0).unwrap()).to_position(at)
}

fn degrees(at: EastNorth) -> Value {
    let position = position(at);
    json!([position.longitude.as_deg(), position.latitude.as_deg()])
}

fn line(points: &[(f64, f64)]) -> Value {
    let points: Vec<_> = points
        .iter()
        .map(|(east, north)| degrees(EastNorth::new(*east, *north)))
        .collect();
    json!({ "type": "LineString", "coordinates": points })
}

fn point(east_m: f64, north_m: f64) -> Value {
    json!({ "type": "Point", "coordinates": degrees(EastNorth::new(east_m, north_m)) })
}

fn keep_in(key: &str, value: f64) -> Value {
    json!({ "name": "in", "kind": "keep-in", "margin_m": 0, "depth_max_m": 30, "altitude_min_m": 3, key: value })
}

fn keep_out(key: &str, value: f64) -> Value {
    json!({ "name": "out", "kind": "keep-out", "margin_m": 0, key: value })
}

fn load(features: &[(Value, Value)]) -> Result<Fence, String> {
    let features: Vec<_> = features
        .iter()
        .map(|(properties, geometry)| json!({ "type": "Feature", "properties": properties, "geometry": geometry }))
        .collect();
    let text = json!({ "type": "FeatureCollection", "features": features }).to_string();
    Fence::from_geojson(&text).map_err(|error| error.to_string())
}

/// The clearance at a place; negative if the place is a breach.
fn clearance(fence: &Fence, east_m: f64, north_m: f64) -> f64 {
    let at = fence.frame().to_local(position(EastNorth::new(east_m, north_m)));
    match fence.check(&Sweep::new(Shape::point(at), 0.0), &VERTICAL) {
        Ok(clearance) => clearance.metres,
        Err(breach) => -breach.metres,
    }
}

fn from_line_m(points: &[(f64, f64)], at: EastNorth) -> f64 {
    let distance = |ends: &[(f64, f64)]| {
        let (a, b) = (
            EastNorth::new(ends[0].0, ends[0].1),
            EastNorth::new(ends[1].0, ends[1].1),
        );
        let (way, off) = (b - a, at - a);
        let length2 = way.east_m * way.east_m + way.north_m * way.north_m;
        let t = ((off.east_m * way.east_m + off.north_m * way.north_m) / length2).clamp(0.0, 1.0);
        (a + way * t).distance_m(at)
    };
    points.windows(2).map(distance).fold(f64::INFINITY, f64::min)
}

#[test]
fn circles_are_round_to_a_centimetre_and_never_laxer() {
    for radius_m in [0.5, 20.0, 300.0, 20_000.0] {
        let within = load(&[(keep_in("radius_m", radius_m), point(0.0, 0.0))]).unwrap();
        let around = load(&[
            (keep_in("radius_m", 24_000.0), point(0.0, 0.0)),
            (keep_out("radius_m", radius_m), point(0.0, 0.0)),
        ])
        .unwrap();
        for step in 0..200 {
            let bearing = f64::from(step) * 1.8;
            for off_m in [(-0.3 * radius_m).max(-900.0), -0.02, 0.02, 0.1 * radius_m] {
                let at = EastNorth::default().offset(bearing, radius_m + off_m);
                // The fence and this test have the same frame: both have their origin in the circle's middle.
                let held_m = clearance(&within, at.east_m, at.north_m);
                assert!(
                    (-0.0122..=0.0).contains(&(held_m + off_m)),
                    "{radius_m} {off_m} {held_m}"
                );
                if off_m < 2_000.0 {
                    let kept_m = clearance(&around, at.east_m, at.north_m);
                    assert!(
                        (-0.0122..=0.0).contains(&(kept_m - off_m)),
                        "{radius_m} {off_m} {kept_m}"
                    );
                }
            }
        }
    }
}

#[test]
fn a_circle_has_one_edge() {
    let fence = load(&[(keep_in("radius_m", 300.0), point(0.0, 0.0))]).unwrap();
    for bearing in [0.0, 100.0, 200.0, 300.0] {
        let at = EastNorth::default().offset(bearing, 200.0);
        let edge = fence.contains(at).unwrap().edge.unwrap();
        assert_eq!(fence.describe_edge(edge).unwrap().to_string(), "edge 1");
    }
}

#[test]
fn a_corridor_allows_its_line_and_nothing_outside() {
    let way = [(0.0, 0.0), (1000.0, 0.0), (1000.0, 800.0), (1800.0, 1500.0)];
    let fence = load(&[(keep_in("half_width_m", 50.0), line(&way))]).unwrap();
    let local = |(east_m, north_m)| fence.frame().to_local(position(EastNorth::new(east_m, north_m)));
    for (ends, edge) in way.windows(2).zip(1..) {
        // The corridor is one polygon that contains each leg of the line with its corners.
        let leg = Sweep::new(Shape::leg(local(ends[0]), local(ends[1])), 0.0);
        let held = fence.check(&leg, &VERTICAL).unwrap();
        assert!((49.4..=50.0).contains(&held.metres), "{held:?}");
        let middle = local(((ends[0].0 + ends[1].0) / 2.0, (ends[0].1 + ends[1].1) / 2.0));
        let nearest = fence.contains(middle).unwrap().edge.unwrap();
        assert_eq!(fence.describe_edge(nearest).unwrap().number, edge);
    }
    let short_cut = Sweep::new(Shape::leg(local(way[0]), local(way[2])), 0.0);
    assert_eq!(fence.check(&short_cut, &VERTICAL).unwrap_err().rule, Rule::KeepIn);
    // The corridor goes 50 m beyond the line's start.
    assert!(clearance(&fence, -49.0, 0.0) > 0.0 && clearance(&fence, -51.0, 0.0) < 0.0);
}

#[test]
fn a_corridor_that_cannot_be_drawn_is_refused_with_its_place() {
    let refused =
        |points: &[(f64, f64)], width_m: f64| load(&[(keep_in("half_width_m", width_m), line(points))]).unwrap_err();
    assert_eq!(
        refused(&[(0.0, 0.0), (500.0, 0.0), (500.0, 30.0), (0.0, 30.0)], 50.0),
        "feature 'in': turns too tightly at vertex 2 for its `half_width_m` of 50, expected longer legs, a smaller width, or a polygon"
    );
    assert!(refused(&[(0.0, 0.0), (500.0, 0.0), (10.0, 0.0)], 5.0).contains("turns too tightly at vertex 2"));
    // The last leg crosses the first.
    let crossing = refused(
        &[
            (0.0, 0.0),
            (500.0, 0.0),
            (500.0, 120.0),
            (250.0, 120.0),
            (250.0, -200.0),
        ],
        50.0,
    );
    assert!(crossing.contains("crosses or touches"), "{crossing}");
    assert!(refused(&[(0.0, 0.0)], 50.0).starts_with("feature 'in'"));
    assert!(refused(&[(0.0, 0.0), (0.0, 0.0)], 50.0).contains("line without length"));
    assert!(refused(&[(0.0, 0.0), (0.0, 90_000.0)], 50.0).contains("km across"));
    // None of this matters for a keep-out zone.
    let both = load(&[
        (keep_in("radius_m", 5000.0), point(0.0, 0.0)),
        (
            keep_out("half_width_m", 50.0),
            line(&[(0.0, 0.0), (500.0, 0.0), (10.0, 0.0), (10.0, 20.0)]),
        ),
    ]);
    assert!(clearance(&both.unwrap(), 300.0, 40.0) < 0.0);
}

#[test]
fn circles_and_corridors_need_a_length_within_the_range() {
    let refused = |properties: Value, geometry: Value| load(&[(properties, geometry)]).unwrap_err();
    let mut bare = keep_in("radius_m", 5.0);
    bare.as_object_mut().unwrap().remove("radius_m");
    assert_eq!(
        refused(bare.clone(), point(0.0, 0.0)),
        "feature 'in': `radius_m` is missing, expected metres, 0.1 to 25000"
    );
    assert!(refused(bare, line(&[(0.0, 0.0), (9.0, 9.0)])).contains("`half_width_m` is missing"));
    for wrong in [0.0, -1.0, 25_001.0] {
        assert!(refused(keep_in("radius_m", wrong), point(0.0, 0.0)).contains("expected metres within 0.1 to 25000"));
    }
    assert!(refused(keep_in("half_width_m", 5.0), point(0.0, 0.0)).contains("unknown key `half_width_m`"));
    let pole = json!({ "type": "Point", "coordinates": [0.0, 89.0] });
    assert!(refused(keep_in("radius_m", 5.0), pole).contains("feature 'in' vertex 1: latitude 89 deg"));
    let date_line = json!({ "type": "Point", "coordinates": [179.999, 10.0] });
    assert!(refused(keep_in("radius_m", 500.0), date_line).contains("crosses the antimeridian"));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(100))]

    #[test]
    fn corridors_are_judged_by_the_distance_from_their_line(
        legs in prop::collection::vec((-100.0..100.0f64, 100.0..900.0f64), 1..8),
        half_width_m in 1.0..60.0f64,
        places in prop::collection::vec((any::<prop::sample::Index>(), 0.0..1.0f64, 0.0..360.0f64, 0.0..1.5f64), 20),
    ) {
        let (mut way, mut bearing) = (vec![(0.0, 0.0)], 0.0);
        for (turn, length_m) in legs {
            bearing += turn;
            let last = way[way.len() - 1];
            let next = EastNorth::new(last.0, last.1).offset(bearing, length_m);
            way.push((next.east_m, next.north_m));
        }
        let wide = (keep_in("radius_m", 20_000.0), point(0.0, 0.0));
        let around = load(&[wide, (keep_out("half_width_m", half_width_m), line(&way))]).unwrap();
        let within = load(&[(keep_in("half_width_m", half_width_m), line(&way))]);
        // Corners are round to a hundredth of the width, and to at least a centimetre. The frames differ a little.
        let tolerance_m = 0.03 + 0.0101 * half_width_m;
        for (leg, share, bearing, reach) in places {
            let leg = leg.index(way.len() - 1);
            let (a, b) = (EastNorth::new(way[leg].0, way[leg].1), EastNorth::new(way[leg + 1].0, way[leg + 1].1));
            let at = (a + (b - a) * share).offset(bearing, reach * half_width_m);
            let off_m = from_line_m(&way, at) - half_width_m;
            let kept_m = clearance(&around, at.east_m, at.north_m);
            if off_m > 0.0 {
                prop_assert!((-tolerance_m..=0.02).contains(&(kept_m - off_m)), "{kept_m} {off_m}");
            } else {
                prop_assert!(kept_m < 0.02, "{kept_m} {off_m}");
            }
            // Lines that cross themselves have no outline.
            if let Ok(within) = &within {
                let held_m = clearance(within, at.east_m, at.north_m);
                if off_m < 0.0 {
                    prop_assert!(held_m > -off_m - tolerance_m, "{held_m} {off_m}");
                } else {
                    prop_assert!(held_m < 0.02, "{held_m} {off_m}");
                }
            }
        }
    }
}
