use backseat_units::EastNorth;
use parry2d_f64::math::Vector;

use super::slant::Slant;
use super::{Contact, POINT_LIKE_M2, Probe, Samples, beside_d2, gap, project, vector};
use crate::strips::{Strips, WIDTH};

/// A leg between two unlike points.
#[derive(Clone, Copy)]
pub(crate) struct LegProbe {
    pub(super) from: Vector,
    pub(super) to: Vector,
    pub(super) way: Vector,
    min: Vector,
    max: Vector,
    /// One over the squared length; zero for a leg too short to divide by.
    inverse_m2: f64,
    pub(super) slant: Slant,
}

impl LegProbe {
    pub(crate) fn new(from: Vector, to: Vector) -> Self {
        let way = to - from;
        let length2 = way.length_squared();
        let inverse_m2 = if length2 < POINT_LIKE_M2 { 0.0 } else { 1.0 / length2 };
        Self {
            from,
            to,
            way,
            min: from.min(to),
            max: from.max(to),
            inverse_m2,
            slant: Slant::new(&[from, to], way),
        }
    }

    /// Squared distance from the leg to a point, given from the leg's start.
    #[inline]
    pub(super) fn vertex_d2(&self, r: Vector) -> f64 {
        let t = (r.dot(self.way) * self.inverse_m2).clamp(0.0, 1.0);
        (r - self.way * t).length_squared()
    }
}

impl Probe for LegProbe {
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
            upright
        } else {
            upright.max(self.slant.box_d2(min, max))
        }
    }

    #[inline]
    fn strips_d2(&self, strips: &Strips) -> [f64; WIDTH] {
        let mut bounds = [0.0; WIDTH];
        for (lane, bound) in bounds.iter_mut().enumerate() {
            *bound = self.slant.strip_d2(strips, lane);
        }
        bounds
    }

    #[inline]
    fn edge_d2(&self, a: Vector, b: Vector) -> f64 {
        let (e, r, s) = (b - a, a - self.from, b - self.from);
        let p = self.to - a;
        // The signs of four areas: the edge's ends lie on either side of the leg, and the leg's of the edge. A zero
        // counts as left: where that says that they cross, they do touch.
        let leg_parts_edge = (self.way.perp_dot(r) < 0.0) != (self.way.perp_dot(s) < 0.0);
        if leg_parts_edge && (r.perp_dot(e) < 0.0) != (e.perp_dot(p) < 0.0) {
            return 0.0;
        }
        let inverse = 1.0 / (e.length_squared() + f64::MIN_POSITIVE);
        let t_from = (-r.dot(e) * inverse).clamp(0.0, 1.0);
        let t_to = (p.dot(e) * inverse).clamp(0.0, 1.0);
        let from_d2 = (r + e * t_from).length_squared();
        let to_d2 = (p - e * t_to).length_squared();
        self.vertex_d2(r).min(self.vertex_d2(s)).min(from_d2).min(to_d2)
    }

    #[inline]
    fn run_d2(&self, vertices: &[EastNorth]) -> (f64, usize) {
        let mut r = vector(vertices[0]) - self.from;
        let mut area_r = self.way.perp_dot(r);
        let mut best = (self.vertex_d2(r), 0);
        for (index, vertex) in vertices[1..].iter().enumerate() {
            let s = vector(*vertex) - self.from;
            let area_s = self.way.perp_dot(s);
            let (e, p) = (s - r, self.way - r);
            if (area_r < 0.0) != (area_s < 0.0) && (r.perp_dot(e) < 0.0) != (e.perp_dot(p) < 0.0) {
                return (0.0, index);
            }
            let d2 = self.vertex_d2(s).min(beside_d2(-r, e)).min(beside_d2(p, e));
            if d2 < best.0 {
                best = (d2, index);
            }
            (r, area_r) = (s, area_s);
        }
        best
    }

    fn contact(&self, a: Vector, b: Vector) -> Contact {
        let mut best = Contact {
            distance_m: f64::INFINITY,
            at: a,
            towards: Vector::ZERO,
        };
        let mut least_m2 = f64::INFINITY;
        let mut offer = |on_leg: Vector, at: Vector| {
            let towards = on_leg - at;
            let d2 = towards.length_squared();
            if d2 < least_m2 {
                least_m2 = d2;
                (best.at, best.towards) = (at, towards);
            }
        };
        offer(self.from, project(self.from, a, b));
        offer(self.to, project(self.to, a, b));
        offer(project(a, self.from, self.to), a);
        offer(project(b, self.from, self.to), b);
        if self.edge_d2(a, b) == 0.0 {
            let e = b - a;
            let area = e.perp_dot(self.way);
            // Parallel ones touch at an end, which the offers have found.
            if area != 0.0 {
                best.at = a + e * ((self.from - a).perp_dot(self.way) / area).clamp(0.0, 1.0);
            }
            best.towards = Vector::ZERO;
        }
        best.distance_m = best.towards.length();
        best
    }

    fn samples(&self) -> Samples {
        let mut points = [self.from; 8];
        points[1] = self.to;
        (points, 2)
    }
}
