//! Makes circles and corridors into rings of positions, which all other zones have.
//!
//! A keep-in zone's ring lies inside the true outline, and a keep-out zone's ring lies around it, so neither is ever
//! laxer.

use core::f64::consts::{PI, TAU};

use backseat_units::math::{acos, atan2, sin_cos};
use backseat_units::{EastNorth, LocalFrame, Position};
use parry2d_f64::math::Vector;

use crate::distance::{east_north, vector};
use crate::error::FenceError;
use crate::outline::{RawPolygon, RawRing, divided};

/// How far a circle's ring may be from the circle, metres.
const CIRCLE_TOLERANCE_M: f64 = 0.01;

/// The error of converting positions through a frame, metres. Circles and corridors are drawn smaller or larger by
/// this.
const ROUND_TRIP_M: f64 = 0.001;

/// How far the round ends and corners of a corridor may be from true ones, as a fraction of its half width; or a
/// centimetre if that is more.
const CORNER_TOLERANCE: f64 = 0.01;

/// Vertices of a corridor's line that are nearer to each other than this are one vertex, metres.
const SAME_M: f64 = 1e-3;

/// A ring around a circle, or for a keep-in zone within it.
pub(super) fn circle(centre: Position, radius_m: f64, keep_in: bool) -> RawPolygon {
    let frame = LocalFrame::new(centre);
    let radius_m = stricter_m(radius_m, keep_in);
    let count = (TAU / step_rad(radius_m, CIRCLE_TOLERANCE_M)).ceil().max(12.0) as u32;
    let radius_m = if keep_in {
        radius_m
    } else {
        circumscribed_m(radius_m, PI / f64::from(count))
    };
    let corner = |index: u32| {
        let (sin, cos) = sin_cos(TAU * f64::from(index % count) / f64::from(count));
        frame.to_position(EastNorth::new(radius_m * cos, radius_m * sin))
    };
    vec![RawRing {
        positions: (0..=count).map(corner).collect(),
        // A circle has one edge.
        numbers: Some(vec![1; count as usize]),
    }]
}

/// The polygons of everything within half a width of a line: one outline for a keep-in zone, and one polygon around
/// each straight piece for a keep-out zone.
pub(super) fn corridor(
    line: &[Position],
    middle: Position,
    half_width_m: f64,
    keep_in: bool,
    label: &str,
) -> Result<Vec<RawPolygon>, FenceError> {
    let frame = LocalFrame::new(middle);
    let mut points = vec![vector(frame.to_local(line[0]))];
    let mut numbers = Vec::new();
    for (ends, number) in line.windows(2).zip(1..) {
        for vertex in divided(&frame, ends[0], ends[1]) {
            let vertex = vector(vertex);
            if (vertex - points[points.len() - 1]).length() > SAME_M {
                points.push(vertex);
                numbers.push(number);
            }
        }
    }
    if points.len() < 2 {
        return Err(FenceError::Form {
            place: label.to_owned(),
            found: "line without length".to_owned(),
            expected: "a LineString of at least two distinct positions",
        });
    }
    let pen = Pen::new(stricter_m(half_width_m, keep_in), keep_in);
    let raw = |ring: Ring| {
        let mut positions: Vec<_> = ring.points.iter().map(|p| frame.to_position(east_north(*p))).collect();
        positions.push(positions[0]);
        vec![RawRing {
            positions,
            numbers: Some(ring.numbers),
        }]
    };
    if keep_in {
        let ring = pen.outline(&points, &numbers).map_err(|vertex| FenceError::TightTurn {
            feature: label.to_owned(),
            vertex,
            half_width_m,
        })?;
        return Ok(vec![raw(ring)]);
    }
    let pieces = points.windows(2).zip(&numbers);
    Ok(pieces
        .map(|(ends, number)| raw(pen.capsule(ends[0], ends[1], *number)))
        .collect())
}

fn stricter_m(length_m: f64, keep_in: bool) -> f64 {
    if keep_in {
        length_m - ROUND_TRIP_M
    } else {
        length_m + ROUND_TRIP_M
    }
}

/// The angle of a chord that is no farther than `tolerance_m` from its arc.
fn step_rad(radius_m: f64, tolerance_m: f64) -> f64 {
    2.0 * acos((1.0 - tolerance_m / radius_m).max(0.8))
}

/// The distance from the middle of the corners of a polygon whose edges touch a circle. Each corner is half a step from
/// the points where its edges touch.
fn circumscribed_m(radius_m: f64, half_step_rad: f64) -> f64 {
    radius_m / sin_cos(half_step_rad).1
}

/// A ring that is being drawn counterclockwise. Each corner has the number of the edge that begins there.
#[derive(Default)]
struct Ring {
    points: Vec<Vector>,
    numbers: Vec<u32>,
}

impl Ring {
    fn push(&mut self, point: Vector, number: u32) {
        self.points.push(point);
        self.numbers.push(number);
    }
}

struct Pen {
    half_width_m: f64,
    step_rad: f64,
    /// Whether the corners of arcs lie outside the true arcs.
    around: bool,
}

impl Pen {
    fn new(half_width_m: f64, keep_in: bool) -> Self {
        let tolerance_m = (CORNER_TOLERANCE * half_width_m).max(CIRCLE_TOLERANCE_M);
        Self {
            half_width_m,
            step_rad: step_rad(half_width_m, tolerance_m),
            around: !keep_in,
        }
    }

    /// Draws an arc counterclockwise around a point, from the direction `from` over the angle `sweep_rad`.
    fn arc(&self, ring: &mut Ring, middle: Vector, from: Vector, sweep_rad: f64, number: u32) {
        let start = from * self.half_width_m;
        let count = (sweep_rad / self.step_rad).ceil().max(1.0) as u32;
        let step_rad = sweep_rad / f64::from(count);
        let turned = |angle_rad: f64, length: f64| {
            let (sin, cos) = sin_cos(angle_rad);
            middle + (start * cos + start.perp() * sin) * length
        };
        ring.push(turned(0.0, 1.0), number);
        if self.around {
            let length = circumscribed_m(1.0, step_rad / 2.0);
            for step in 0..count {
                ring.push(turned(step_rad * (f64::from(step) + 0.5), length), number);
            }
        } else {
            for step in 1..count {
                ring.push(turned(step_rad * f64::from(step), 1.0), number);
            }
        }
        ring.push(turned(sweep_rad, 1.0), number);
    }

    fn capsule(&self, a: Vector, b: Vector, number: u32) -> Ring {
        let right = -(b - a).normalize().perp();
        let mut ring = Ring::default();
        self.arc(&mut ring, b, right, PI, number);
        self.arc(&mut ring, a, -right, PI, number);
        ring
    }

    /// The outline of the whole line if it turns gently enough; otherwise the vertex of the line at which it does not.
    fn outline(&self, points: &[Vector], numbers: &[u32]) -> Result<Ring, usize> {
        let ways: Vec<_> = points.windows(2).map(|ends| (ends[1] - ends[0]).normalize()).collect();
        let turn_rad = |vertex: usize| {
            let (before, after) = (ways[vertex - 1], ways[vertex]);
            atan2(before.perp_dot(after), before.dot(after))
        };
        // The length that the inner side of a turn takes from each of the two pieces that meet there.
        let taken_m = |vertex: usize| {
            if vertex == 0 || vertex == ways.len() {
                return 0.0;
            }
            let (sin, cos) = sin_cos(turn_rad(vertex) / 2.0);
            self.half_width_m * sin.abs() / cos.max(1e-9)
        };
        for (piece, ends) in points.windows(2).enumerate() {
            if taken_m(piece) + taken_m(piece + 1) > (ends[1] - ends[0]).length() {
                let tighter = if taken_m(piece) > taken_m(piece + 1) {
                    piece
                } else {
                    piece + 1
                };
                // The file's vertex from which the next piece begins.
                return Err(numbers[tighter.min(numbers.len() - 1)] as usize);
            }
        }
        let mut ring = Ring::default();
        let last = ways.len() - 1;
        // Draws the right side on the way out, and then the right side of the way back.
        for vertex in 1..=last {
            self.corner(
                &mut ring,
                points[vertex],
                ways[vertex - 1],
                turn_rad(vertex),
                numbers[vertex],
            );
        }
        self.arc(&mut ring, points[last + 1], -ways[last].perp(), PI, numbers[last]);
        for vertex in (1..=last).rev() {
            self.corner(
                &mut ring,
                points[vertex],
                -ways[vertex],
                -turn_rad(vertex),
                numbers[vertex - 1],
            );
        }
        self.arc(&mut ring, points[0], ways[0].perp(), PI, numbers[0]);
        Ok(ring)
    }

    /// Draws the right side of a corner: round if the line turns left, a point if it turns right.
    fn corner(&self, ring: &mut Ring, at: Vector, way: Vector, turn_rad: f64, number: u32) {
        let right = -way.perp();
        if turn_rad > 0.0 {
            self.arc(ring, at, right, turn_rad, number);
        } else {
            let (sin, cos) = sin_cos(turn_rad / 2.0);
            // Moves back along the line by the length that the turn takes.
            ring.push(at + (right + way * (sin / cos)) * self.half_width_m, number);
        }
    }
}
