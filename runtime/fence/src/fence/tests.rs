//! Fences on the plane, without a file, so that coordinates are exact.

use std::sync::Arc;

use backseat_units::{EastNorth, LocalFrame, Position};

use super::{Fence, Map};
use crate::polygon::{GoodRing, Polygon};
use crate::sweep::{Shape, Sweep, VerticalExtent};
use crate::verdict::{Breach, Clearance, Rule};
use crate::window::Window;
use crate::zone::{Band, Kind, Zone};

mod edges;
mod reference;
mod surfacing;
mod time;

type Points = Vec<(f64, f64)>;

const KEEP_IN: Kind = Kind::KeepIn {
    depth: Band {
        min_m: 0.0,
        max_m: 50.0,
    },
    altitude_min_m: 3.0,
    surfacing: false,
};
const KEEP_OUT: Kind = Kind::KeepOut { depth: None };
const VERTICAL: VerticalExtent = VerticalExtent {
    depth_min_m: 5.0,
    depth_max_m: 20.0,
    altitude_min_m: 10.0,
};

/// A zone of one polygon. The outer ring is counterclockwise, holes are clockwise, and none is closed.
fn zone(name: &str, kind: Kind, margin_m: f64, rings: &[Points]) -> Zone {
    let ring = |points: &Points| {
        let mut vertices: Vec<_> = points
            .iter()
            .map(|(east, north)| EastNorth::new(*east, *north))
            .collect();
        vertices.push(vertices[0]);
        GoodRing {
            vertices,
            numbers: (1..).take(points.len()).collect(),
        }
    };
    let polygon = Polygon::new(rings.iter().map(ring).collect());
    Zone {
        name: name.to_owned(),
        kind,
        margin_m,
        window: Window::default(),
        polygons: vec![polygon],
    }
}

fn fence(zones: Vec<Zone>) -> Fence {
    let frame = LocalFrame::new(Position::from_deg(42.0, -70.0).unwrap());
    Fence {
        map: Arc::new(Map::new(frame, zones)),
    }
}

/// A rectangle, counterclockwise.
fn rectangle(west: f64, south: f64, east: f64, north: f64) -> Points {
    vec![(west, south), (east, south), (east, north), (west, north)]
}

fn reversed(mut points: Points) -> Points {
    points.reverse();
    points
}

fn at(east: f64, north: f64) -> EastNorth {
    EastNorth::new(east, north)
}

fn leg(from: (f64, f64), to: (f64, f64)) -> Shape {
    Shape::leg(at(from.0, from.1), at(to.0, to.1))
}

fn check(fence: &Fence, shape: Shape, radius_m: f64) -> Result<Clearance, Breach> {
    fence.check(&Sweep::new(shape, radius_m), &VERTICAL)
}

fn refused(fence: &Fence, shape: Shape, radius_m: f64) -> (Rule, f64) {
    let breach = check(fence, shape, radius_m).unwrap_err();
    assert!(breach.metres > 0.0, "{breach}");
    (breach.rule, breach.metres)
}

fn spare(fence: &Fence, shape: Shape, radius_m: f64) -> f64 {
    check(fence, shape, radius_m).unwrap().metres
}
