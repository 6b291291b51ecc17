//! Prints the fence's rows, each beside parry's plain query of the same distance. The plain queries know neither margin
//! nor side, and find the nearest edge however far away it is.

use std::fmt::Write as _;
use std::hint::black_box;

use backseat_bench::{HEADER, in_turn, row};
use backseat_fence::{Fence, Shape, Sweep, VerticalExtent};
use backseat_units::{EastNorth, LocalFrame, Position};
use parry2d_f64::math::{Pose, Vector};
use parry2d_f64::query;
use parry2d_f64::shape::{ConvexPolygon, Polyline, Segment};

const EXTENT: VerticalExtent = VerticalExtent {
    depth_min_m: 10.0,
    depth_max_m: 20.0,
    altitude_min_m: 5.0,
};
const PLAIN: &str = "parry's plain distance to a Polyline";
/// Every part of a measurement uses all shapes several times.
const CALLS: u32 = 16 * 256;

pub(crate) fn print() {
    println!("{HEADER}");
    legs(100, "400 ns");
    legs(10_000, "2000 ns");
    reachable();
    load(10_000);
}

/// A ring with this many vertices around 42 N 70 W, each 3000 m or a little more from the middle.
fn ring(vertices: u32, more_m: impl Fn(u32) -> f64) -> Vec<EastNorth> {
    let vertex = |index: u32| {
        let bearing_deg = 360.0 * f64::from(index) / f64::from(vertices);
        EastNorth::default().offset(bearing_deg, 3000.0 + more_m(index))
    };
    (0..vertices).map(vertex).collect()
}

fn star(vertices: u32) -> Vec<EastNorth> {
    ring(vertices, |vertex| {
        f64::from((vertex + 1) % 2) * 2.0e3 / f64::from(vertices)
    })
}

fn text(points: &[EastNorth]) -> String {
    let frame = LocalFrame::new(Position::from_deg(42.0, -70.0).expect("a position"));
    let mut ring = String::new();
    for point in points.iter().chain(points.first()) {
        let position = frame.to_position(*point);
        let comma = if ring.is_empty() { "" } else { "," };
        let (longitude, latitude) = (position.longitude.as_deg(), position.latitude.as_deg());
        write!(ring, "{comma}[{longitude},{latitude}]").expect("a string");
    }
    format!(
        r#"{{"type":"FeatureCollection","features":[{{"type":"Feature","properties":{{"name":"sea","kind":"keep-in","margin_m":10,"depth_max_m":50,"altitude_min_m":3}},"geometry":{{"type":"Polygon","coordinates":[[{ring}]]}}}}]}}"#
    )
}

fn fence(points: &[EastNorth]) -> Fence {
    Fence::from_geojson(&text(points)).expect("a ring is a fence")
}

fn polyline(points: &[EastNorth]) -> Polyline {
    Polyline::new(points.iter().chain(points.first()).map(vector).collect(), None)
}

fn vector(point: &EastNorth) -> Vector {
    Vector::new(point.east_m, point.north_m)
}

fn distance_m(polyline: &Polyline, shape: &dyn parry2d_f64::shape::Shape) -> f64 {
    let here = Pose::IDENTITY;
    let found = query::distance(&here, polyline, &here, shape);
    found.expect("parry measures these").distance
}

fn legs(vertices: u32, aim: &str) {
    let points = star(vertices);
    let (fence, polyline) = (fence(&points), polyline(&points));
    let legs: Vec<(EastNorth, EastNorth)> = (0..64)
        .map(|leg| {
            let start = EastNorth::default().offset(f64::from(leg) * 37.0, f64::from(leg) * 40.0);
            (start, start.offset(f64::from(leg) * 101.0, 300.0))
        })
        .collect();
    let (mut ours, mut plain) = (legs.iter().cycle(), legs.iter().cycle());
    let times = in_turn(
        CALLS,
        || {
            let (start, end) = ours.next().expect("it goes round");
            black_box(
                fence
                    .check(&Sweep::new(Shape::leg(*start, *end), 20.0), &EXTENT)
                    .is_ok(),
            );
        },
        || {
            let (start, end) = plain.next().expect("it goes round");
            black_box(distance_m(&polyline, &Segment::new(vector(start), vector(end))));
        },
    );
    row(&format!("leg + margin against {vertices} vertices"), times, PLAIN, aim);
}

/// What core asks the fence for a modify: the reachable set with the way back to the planned leg, and from there to the
/// next one. The fence is a jagged coast: its radius jumps by up to 20 m from vertex to vertex.
fn reachable() {
    let points = ring(10_000, |vertex| f64::from((vertex * 7919) % 101) / 5.0);
    let (fence, polyline) = (fence(&points), polyline(&points));
    let sets: Vec<[EastNorth; 5]> = (0..64)
        .map(|at| {
            let at = f64::from(at);
            let start = EastNorth::default().offset(at * 37.0, at * 30.0);
            let end = start.offset(at * 53.0, 600.0);
            let here = start + (end - start) * 0.4;
            let (ahead, next) = (here.offset(at * 101.0, 12.0), end.offset(at * 53.0 + 90.0, 100.0));
            [here, ahead, start, end, next]
        })
        .collect();
    let hulls: Vec<ConvexPolygon> = sets
        .iter()
        .flat_map(|[here, ahead, start, end, next]| [vec![here, ahead, start, end], vec![here, ahead, next]])
        .filter_map(|corners| ConvexPolygon::from_convex_hull(&corners.into_iter().map(vector).collect::<Vec<_>>()))
        .collect();
    let (mut ours, mut plain) = (sets.iter().cycle(), hulls.chunks(2).cycle());
    let times = in_turn(
        CALLS,
        || {
            let [here, ahead, start, end, next] = *ours.next().expect("it goes round");
            let ways = [
                Shape::quadrilateral([here, ahead, start, end]),
                Shape::triangle(here, ahead, next),
            ];
            let depths_m = [EXTENT.depth_min_m, EXTENT.depth_max_m];
            black_box(fence.check_all(&ways, 55.0, &EXTENT, depths_m).is_ok());
        },
        || {
            for hull in plain.next().expect("it goes round") {
                black_box(distance_m(&polyline, hull));
            }
        },
    );
    row(
        "a modify's reachable set against a coast of 10000 vertices",
        times,
        PLAIN,
        "5000 ns",
    );
}

/// A fence from its file to its first answer: the text, the projection, all checks of polygons, and the index.
fn load(vertices: u32) {
    let text = text(&star(vertices));
    let times = in_turn(
        5,
        || {
            black_box(Fence::from_geojson(black_box(&text)).expect("a star is a fence"));
        },
        || {
            black_box(serde_json::from_str::<serde_json::Value>(black_box(&text)).expect("it is JSON"));
        },
    );
    row(
        &format!("index built, {vertices} vertices, from the file's text"),
        times,
        "the text read as JSON",
        "10000000 ns",
    );
}
