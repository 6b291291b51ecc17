use backseat_units::EastNorth;
use parry2d_f64::math::Vector;

use super::leg::LegProbe;
use super::slant::Slant;
use super::{Contact, Probe, Samples, beside_d2, gap, vector};
use crate::strips::{Strips, WIDTH};

/// A solid triangle or quadrilateral.
pub(crate) struct SolidProbe {
    /// The sides, counterclockwise.
    sides: [LegProbe; 4],
    len: usize,
    min: Vector,
    max: Vector,
    slant: Slant,
}

impl SolidProbe {
    /// Three or four corners of a convex hull, counterclockwise.
    pub(super) fn new(corners: &[Vector]) -> Self {
        let len = corners.len();
        let side = |index: usize| LegProbe::new(corners[index], corners[(index + 1) % len]);
        let sides = [side(0), side(1), side(2), side(if len > 3 { 3 } else { 0 })];
        let (mut min, mut max) = (corners[0], corners[0]);
        let mut longest = Vector::ZERO;
        for (&corner, side) in corners.iter().zip(&sides) {
            min = min.min(corner);
            max = max.max(corner);
            if side.way.length_squared() > longest.length_squared() {
                longest = side.way;
            }
        }
        Self {
            sides,
            len,
            min,
            max,
            slant: Slant::new(corners, longest),
        }
    }

    fn sides(&self) -> &[LegProbe] {
        &self.sides[..self.len]
    }

    #[inline]
    fn covers(&self, point: Vector) -> bool {
        self.sides()
            .iter()
            .all(|side| side.way.perp_dot(point - side.from) >= 0.0)
    }
}

impl Probe for SolidProbe {
    fn min(&self) -> Vector {
        self.min
    }

    fn max(&self) -> Vector {
        self.max
    }

    #[inline]
    fn box_d2(&self, min: Vector, max: Vector, enough_m2: f64) -> f64 {
        let upright = gap(self.min, self.max, min, max).length_squared();
        if upright >= enough_m2 {
            return upright;
        }
        let bound = upright.max(self.slant.box_d2(min, max));
        if bound == 0.0 || bound >= enough_m2 {
            return bound;
        }
        // The box is outside, so that the nearest place of the hull is on a side. The boxes around the hull leave
        // much air at a triangle's corners, and those around its sides none.
        let sides = self.sides().iter().map(|side| side.box_d2(min, max, enough_m2));
        bound.max(sides.fold(f64::INFINITY, f64::min))
    }

    #[inline]
    fn strips_d2(&self, strips: &Strips) -> [f64; WIDTH] {
        let mut bounds = [0.0; WIDTH];
        for (lane, bound) in bounds.iter_mut().enumerate() {
            let (mut min, mut max) = (Vector::splat(f64::INFINITY), Vector::splat(f64::NEG_INFINITY));
            for side in &self.sides {
                let off = strips.off(lane, side.from);
                (min, max) = (min.min(off), max.max(off));
            }
            let half = strips.half(lane);
            *bound = (min - half).max(-half - max).max(Vector::ZERO).length_squared();
        }
        for side in self.sides() {
            for (lane, bound) in bounds.iter_mut().enumerate() {
                let beyond_m = side.slant.beyond_m(strips, lane);
                *bound = bound.max(beyond_m * beyond_m);
            }
        }
        bounds
    }

    #[inline]
    fn edge_d2(&self, a: Vector, b: Vector) -> f64 {
        // An edge that crosses no side is inside with both its ends, or not at all.
        if self.covers(a) {
            return 0.0;
        }
        self.sides()
            .iter()
            .fold(f64::INFINITY, |best, side| best.min(side.edge_d2(a, b)))
    }

    #[inline]
    fn run_d2(&self, vertices: &[EastNorth]) -> (f64, usize) {
        let mut best = (f64::INFINITY, 0);
        let mut a = vector(vertices[0]);
        let mut areas_a = [0.0; 4];
        for (index, vertex) in std::iter::once(&vertices[0]).chain(vertices).enumerate().skip(1) {
            // The first vertex comes as an edge of no length, which sets out the areas; its index is the first edge's.
            let b = vector(*vertex);
            let e = b - a;
            let mut areas_b = [0.0; 4];
            let (mut d2, mut covered) = (f64::INFINITY, true);
            for ((side, area_b), area_a) in self.sides().iter().zip(&mut areas_b).zip(&areas_a) {
                let (r, s) = (a - side.from, b - side.from);
                *area_b = side.way.perp_dot(s);
                covered &= *area_b >= 0.0;
                d2 = d2.min(side.vertex_d2(s)).min(beside_d2(-r, e));
                let parts = index > 1 && (*area_a < 0.0) != (*area_b < 0.0);
                if parts && (r.perp_dot(e) < 0.0) != (e.perp_dot(side.to - a) < 0.0) {
                    return (0.0, index - 2);
                }
            }
            let edge = index.saturating_sub(2);
            if covered {
                return (0.0, edge);
            }
            if d2 < best.0 {
                best = (d2, edge);
            }
            (a, areas_a) = (b, areas_b);
        }
        best
    }

    fn contact(&self, a: Vector, b: Vector) -> Contact {
        if self.covers(a) {
            return Contact {
                distance_m: 0.0,
                at: a,
                towards: Vector::ZERO,
            };
        }
        let mut best = self.sides[0].contact(a, b);
        for side in &self.sides()[1..] {
            let contact = side.contact(a, b);
            if contact.distance_m < best.distance_m {
                best = contact;
            }
        }
        best
    }

    fn samples(&self) -> Samples {
        let mut points = [self.sides[0].from; 8];
        for (point, side) in points.iter_mut().zip(self.sides()) {
            *point = side.from;
        }
        (points, self.len)
    }
}

/// The corners of the convex hull of the first `len` points, counterclockwise.
pub(super) fn convex_hull(mut points: [Vector; 4], len: usize) -> ([Vector; 4], usize) {
    // The first corner is met again at the end: at most five entries.
    let mut chain = [Vector::ZERO; 6];
    let distinct = chain_of(&mut points[..len], &mut chain);
    let mut corners = [Vector::ZERO; 4];
    corners[..distinct].copy_from_slice(&chain[..distinct]);
    (corners, distinct)
}

/// Andrew's monotone chain: how many of the entries that the chain then begins with are the corners of the convex hull,
/// counterclockwise. It has room for two more than there are points, where those are numbers.
pub(crate) fn chain_of(points: &mut [Vector], chain: &mut [Vector]) -> usize {
    points.sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let mut count = 0;
    let mut push = |point: Vector, floor: usize, count: &mut usize| {
        while *count >= floor + 2 && (chain[*count - 1] - chain[*count - 2]).perp_dot(point - chain[*count - 1]) <= 0.0
        {
            *count -= 1;
        }
        if *count == 0 || chain[*count - 1] != point {
            chain[*count] = point;
            *count += 1;
        }
    };
    for &point in points.iter() {
        push(point, 0, &mut count);
    }
    let lower = count.saturating_sub(1);
    for &point in points.iter().rev() {
        push(point, lower, &mut count);
    }
    if count > 1 { count - 1 } else { count }
}
