//! From a file's degrees to verdicts.
#![expect(clippy::unwrap_used, reason = "a panic fails the test")]

use std::fmt::Write;

use backseat_fence::{Fence, Kind, Rule, Shape, Span, Sweep, VerticalExtent};
use backseat_units::{EastNorth, LocalFrame, Position, Utc};
use proptest::prelude::*;

const VERTICAL: VerticalExtent = VerticalExtent {
    depth_min_m: 5.0,
    depth_max_m: 20.0,
    altitude_min_m: 10.0,
};
const KEEP_IN: &str = r#""kind": "keep-in", "margin_m": 10, "depth_max_m": 30, "altitude_min_m": 3"#;

fn position(latitude: f64, longitude: f64) -> Position {
    Position::from_deg(latitude, longitude).unwrap()
}

fn document(zones: &[(&str, &str, String)]) -> String {
    let feature = |(name, rest, rings): &(&str, &str, String)| {
        format!(
            r#"{{"type": "Feature", "properties": {{"name": "{name}", {rest}}}, "geometry": {{"type": "Polygon", "coordinates": [{rings}]}}}}"#
        )
    };
    let features: Vec<_> = zones.iter().map(feature).collect();
    format!(
        r#"{{"type": "FeatureCollection", "features": [{}]}}"#,
        features.join(",")
    )
}

/// A closed ring in the form of the file.
fn ring(points: &[Position]) -> String {
    let mut text = String::from("[");
    for point in points.iter().chain(points.first()) {
        let comma = if text.len() > 1 { "," } else { "" };
        write!(
            text,
            "{comma}[{}, {}]",
            point.longitude.as_deg(),
            point.latitude.as_deg()
        )
        .unwrap();
    }
    text + "]"
}

fn rectangle(south: f64, west: f64, north: f64, east: f64) -> Vec<Position> {
    vec![
        position(south, west),
        position(south, east),
        position(north, east),
        position(north, west),
    ]
}

fn check(fence: &Fence, at: Position, radius_m: f64) -> Result<f64, (Rule, f64)> {
    let shape = Shape::point(fence.frame().to_local(at));
    let verdict = fence.check(&Sweep::new(shape, radius_m), &VERTICAL);
    verdict
        .map(|clearance| clearance.metres)
        .map_err(|breach| (breach.rule, breach.metres))
}

#[test]
fn the_winding_of_rings_does_not_matter() {
    let outer = rectangle(42.0, -70.0, 42.02, -69.98);
    let hole = rectangle(42.009, -69.991, 42.011, -69.989);
    let turned = |points: &[Position]| points.iter().rev().copied().collect::<Vec<_>>();
    for (outer, hole) in [
        (outer.clone(), hole.clone()),
        (turned(&outer), hole.clone()),
        (outer.clone(), turned(&hole)),
        (turned(&outer), turned(&hole)),
    ] {
        let text = document(&[("box", KEEP_IN, format!("{},{}", ring(&outer), ring(&hole)))]);
        let fence = Fence::from_geojson(&text).unwrap();
        assert!(check(&fence, position(42.005, -69.995), 5.0).is_ok());
        assert_eq!(check(&fence, position(42.01, -69.99), 5.0).unwrap_err().0, Rule::KeepIn);
        assert_eq!(check(&fence, position(42.03, -69.99), 5.0).unwrap_err().0, Rule::KeepIn);
    }
}

#[test]
fn a_fence_gives_its_zones_for_pictures() {
    let outer = ring(&rectangle(42.0, -70.0, 42.02, -69.98));
    let hole = ring(&rectangle(42.009, -69.991, 42.011, -69.989));
    let net = r#""kind": "keep-out", "margin_m": 2.5, "depth_min_m": 10"#;
    let text = document(&[("box", KEEP_IN, format!("{outer},{hole}")), ("net", net, hole.clone())]);
    let fence = Fence::from_geojson(&text).unwrap();
    let zones: Vec<_> = fence.zones().collect();
    assert_eq!(zones.iter().map(|zone| zone.name()).collect::<Vec<_>>(), ["box", "net"]);
    assert_eq!(zones[1].margin_m(), 2.5);
    let Kind::KeepOut { depth: Some(band) } = zones[1].kind() else {
        panic!("{:?}", zones[1].kind())
    };
    assert_eq!((band.min_m, band.max_m), (10.0, f64::INFINITY));
    let rings: Vec<_> = zones[0].rings().collect();
    assert_eq!(rings.iter().map(|ring| ring.hole).collect::<Vec<_>>(), [None, Some(1)]);
    for ring in rings {
        assert_eq!(ring.points.first(), ring.points.last());
        // The frame's origin is the centroid of the outer ring.
        assert!(
            ring.points
                .iter()
                .all(|point| point.distance_m(EastNorth::default()) < 1500.0)
        );
    }
    let origin = fence.frame().origin();
    assert!((origin.latitude.as_deg() - 42.01).abs() < 1e-9 && (origin.longitude.as_deg() + 69.99).abs() < 1e-9);
}

#[test]
fn each_polygon_of_a_multipolygon_counts_by_itself() {
    let west = ring(&rectangle(42.0, -70.0, 42.01, -69.99));
    let east = ring(&rectangle(42.0, -69.985, 42.01, -69.975));
    let text = document(&[("pair", KEEP_IN, west)])
        .replace("\"Polygon\"", "\"MultiPolygon\"")
        .replace("[[[", "[[[[")
        .replace("]]]", &format!("]]],[{east}]]"));
    let fence = Fence::from_geojson(&text).unwrap();
    assert!(check(&fence, position(42.005, -69.995), 5.0).is_ok());
    assert!(check(&fence, position(42.005, -69.98), 5.0).is_ok());
    assert!(check(&fence, position(42.005, -69.9875), 5.0).is_err());
    let local = |longitude| fence.frame().to_local(position(42.005, longitude));
    let leg = Sweep::new(Shape::leg(local(-69.995), local(-69.98)), 5.0);
    let breach = fence.check(&leg, &VERTICAL).unwrap_err();
    assert_eq!(breach.zone(), Some("pair"));
    let east_edge = fence
        .check(&Sweep::new(Shape::point(local(-69.976)), 5.0), &VERTICAL)
        .unwrap()
        .edge
        .unwrap();
    assert_eq!(fence.describe_edge(east_edge).unwrap().to_string(), "polygon 2 edge 2");
}

#[test]
fn long_edges_follow_the_straight_line_of_the_file() {
    // 40 km along the parallel of 60 N: its middle bulges by 54 m from the plane's straight line.
    let text = document(&[("box", KEEP_IN, ring(&rectangle(60.0, 10.0, 60.1, 10.72)))]);
    let fence = Fence::from_geojson(&text).unwrap();
    for longitude in [10.01, 10.1, 10.2, 10.36, 10.5, 10.6, 10.71] {
        // 0.001 degrees of latitude are 111.4 m there.
        let inside = check(&fence, position(60.001, longitude), 0.0).unwrap();
        assert!((inside - 101.4).abs() < 0.1, "{longitude} {inside}");
        let (rule, outside) = check(&fence, position(59.999, longitude), 0.0).unwrap_err();
        assert!(
            rule == Rule::KeepIn && (outside - 121.4).abs() < 0.1,
            "{longitude} {outside}"
        );
    }
    // All pieces of an edge have the number of that edge.
    for (latitude, longitude, edge) in [
        (60.001, 10.2, 1),
        (60.05, 10.71, 2),
        (60.099, 10.4, 3),
        (60.05, 10.01, 4),
    ] {
        let local = fence.frame().to_local(position(latitude, longitude));
        let nearest = fence.contains(local).unwrap().edge.unwrap();
        assert_eq!(fence.describe_edge(nearest).unwrap().number, edge);
    }
}

#[test]
fn null_counts_as_absent() {
    let rings = ring(&rectangle(42.0, -70.0, 42.01, -69.99));
    let small = ring(&rectangle(42.004, -69.996, 42.005, -69.995));
    let nulls =
        r#""kind": "keep-out", "margin_m": 0, "depth_min_m": null, "depth_max_m": null, "altitude_min_m": null"#;
    let fence = Fence::from_geojson(&document(&[("box", KEEP_IN, rings), ("wreck", nulls, small)])).unwrap();
    assert!(matches!(
        fence.zones().nth(1).unwrap().kind(),
        Kind::KeepOut { depth: None }
    ));
}

#[test]
fn ten_thousand_vertices_load_and_a_crossing_among_them_is_found() {
    let frame = LocalFrame::new(position(42.0, -70.0));
    let mut points: Vec<_> = (0..10_000)
        .map(|index| {
            let radius = 5000.0 + f64::from(index % 7);
            frame.to_position(EastNorth::default().offset(f64::from(index) * 0.036, radius))
        })
        .collect();
    let good = Fence::from_geojson(&document(&[("coast", KEEP_IN, ring(&points))])).unwrap();
    assert_eq!(
        good.zones().next().unwrap().rings().next().unwrap().points.len(),
        10_001
    );
    points.swap(5_000, 5_001);
    let error = Fence::from_geojson(&document(&[("coast", KEEP_IN, ring(&points))])).unwrap_err();
    assert!(
        error.to_string().contains("edge 5000 crosses or touches edge 5002"),
        "{error}"
    );
}

proptest! {
    #[test]
    fn no_text_makes_the_reader_panic(text in r#"[\[\]{},:"a-z0-9.\-\\ ]{0,60}"#) {
        prop_assert!(Fence::from_geojson(&text).is_err());
    }

    #[test]
    fn random_rings_are_accepted_or_refused_without_a_panic(
        rings in prop::collection::vec(prop::collection::vec((0..6u8, 0..6u8), 0..8), 1..3),
        close in any::<bool>(),
    ) {
        // A coarse grid: vertices often repeat, touch and line up.
        let rings: Vec<_> = rings.iter().map(|ring_points| {
            let points: Vec<_> = ring_points.iter()
                .map(|(east, north)| position(42.0 + f64::from(*north) * 1e-3, -70.0 + f64::from(*east) * 1e-3)).collect();
            if close { ring(&points) } else { format!("[{}", ring(&points).trim_start_matches(|c| c != ',').trim_start_matches(',')) }
        }).collect();
        let keep_in = KEEP_IN.replace("\"margin_m\": 10", "\"margin_m\": 0");
        if let Ok(fence) = Fence::from_geojson(&document(&[("grid", &keep_in, rings.join(","))])) {
            // Every vertex is on the edge, and so outside.
            for zone in fence.zones() {
                for point in zone.rings().flat_map(|ring| ring.points.to_vec()) {
                    prop_assert!(fence.contains(point).is_err());
                }
            }
        }
    }
}

#[test]
fn windows_are_read_and_respected() {
    let outer = ring(&rectangle(42.0, -70.0, 42.02, -69.98));
    let small = ring(&rectangle(42.009, -69.991, 42.011, -69.989));
    let convoy = r#""kind": "keep-out", "margin_m": 5, "valid_from": "2026-05-01T08:00:00Z", "valid_until": "2026-05-01T10:30:00+02:00""#;
    let text = document(&[("box", KEEP_IN, outer), ("convoy", convoy, small)]);
    let fence = Fence::from_geojson(&text).unwrap();
    let window = fence.zones().nth(1).unwrap().window();
    assert_eq!(
        window.to_string(),
        "from 2026-05-01T08:00:00Z until 2026-05-01T08:30:00Z"
    );
    let sweep = Sweep::new(Shape::point(fence.frame().to_local(position(42.01, -69.99))), 5.0);
    let at = |seconds: u64| Utc::from_unix_nanos(seconds * 1_000_000_000);
    let span = |from, until| Span {
        from: at(from),
        until: at(until),
    };
    assert!(
        fence
            .during(span(1_777_620_000, 1_777_622_399))
            .check(&sweep, &VERTICAL)
            .is_ok()
    );
    let inside = fence
        .during(span(1_777_620_000, 1_777_622_400))
        .check(&sweep, &VERTICAL);
    assert_eq!(inside.unwrap_err().rule, Rule::KeepOut);
}
