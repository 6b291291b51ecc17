//! Closed-form distances between what a sweep is made of and the straight edges of a fence.
//!
//! The hot path compares squared distances only. Where the nearest edge is known, [`Probe::contact`] measures it once
//! more by differences of coordinates, which is exact where a leg runs along an axis at a round distance.

use backseat_units::EastNorth;
use parry2d_f64::math::Vector;

use crate::strips::{Strips, WIDTH};
use crate::sweep::Shape;

mod leg;
mod rim;
mod slant;
mod solid;

pub(crate) use leg::LegProbe;
pub(crate) use rim::RimProbe;
pub(crate) use solid::SolidProbe;

pub(crate) use solid::chain_of;
use solid::convex_hull;

/// Nearer than this a contact counts as being at a vertex, metres. Edges of a polygon that do not share a vertex are
/// farther apart, and corners are sharp by at most [`crate::outline::SHARPEST_RAD`]: see `Polygon::is_inside`.
pub(crate) const AT_VERTEX_M: f64 = 1e-6;

/// Shorter legs have no direction that is worth computing with, square metres.
const POINT_LIKE_M2: f64 = 1e-18;

/// Where a shape and an edge are nearest to each other.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Contact {
    /// Zero where they touch.
    pub(crate) distance_m: f64,
    /// The place on the edge.
    pub(crate) at: Vector,
    /// From that place towards the shape, of any length; zero where they touch.
    pub(crate) towards: Vector,
}

/// A shape made ready to be measured against many edges.
pub(crate) trait Probe {
    /// Lower corner of the shape's bounding box.
    fn min(&self) -> Vector;
    /// Upper corner of the shape's bounding box.
    fn max(&self) -> Vector;
    /// A lower bound of the squared distance to whatever lies in a box. The bound need not be good where it is over
    /// `enough_m2`.
    fn box_d2(&self, min: Vector, max: Vector, enough_m2: f64) -> f64;
    /// The squared distance to an edge, zero where they touch.
    fn edge_d2(&self, a: Vector, b: Vector) -> f64;
    /// A lower bound of the squared distance to whatever lies in each of some turned boxes.
    fn strips_d2(&self, strips: &Strips) -> [f64; WIDTH];
    /// The least of the squared distances to consecutive edges, and which edge has it.
    #[inline]
    fn run_d2(&self, vertices: &[EastNorth]) -> (f64, usize) {
        let mut best = (f64::INFINITY, 0);
        for (index, ends) in vertices.windows(2).enumerate() {
            let d2 = self.edge_d2(vector(ends[0]), vector(ends[1]));
            if d2 < best.0 {
                best = (d2, index);
            }
        }
        best
    }
    /// The same for one edge with all that is to know about it.
    fn contact(&self, a: Vector, b: Vector) -> Contact;
    /// Points of the shape from which its worst one is taken: the corners of a hull, eight of a rim.
    fn samples(&self) -> Samples;
}

/// Up to eight points.
pub(crate) type Samples = ([Vector; 8], usize);

pub(crate) fn vector(point: EastNorth) -> Vector {
    Vector::new(point.east_m, point.north_m)
}

pub(crate) fn east_north(v: Vector) -> EastNorth {
    EastNorth::new(v.x, v.y)
}

/// The probe of any shape.
#[expect(
    clippy::large_enum_variant,
    reason = "one lives on the stack for the time of one check"
)]
pub(crate) enum AnyProbe {
    Point(PointProbe),
    Leg(LegProbe),
    Solid(SolidProbe),
    Rim(RimProbe),
}

impl AnyProbe {
    /// The shape's coordinates are finite, and so are their squares.
    pub(crate) fn new(shape: &Shape) -> Self {
        let hull = match shape {
            Shape::Rim { centre, radius_m } => {
                return Self::Rim(RimProbe {
                    centre: vector(*centre),
                    radius_m: *radius_m,
                });
            }
            Shape::Hull(hull) => hull,
        };
        match *hull.points() {
            [a] => Self::Point(PointProbe(vector(a))),
            [a, b] if a == b => Self::Point(PointProbe(vector(a))),
            [a, b] => Self::Leg(LegProbe::new(vector(a), vector(b))),
            ref points => {
                let mut corners = [Vector::ZERO; 4];
                for (corner, point) in corners.iter_mut().zip(points) {
                    *corner = vector(*point);
                }
                let (corners, len) = convex_hull(corners, points.len());
                match len {
                    1 => Self::Point(PointProbe(corners[0])),
                    2 => Self::Leg(LegProbe::new(corners[0], corners[1])),
                    _ => Self::Solid(SolidProbe::new(&corners[..len])),
                }
            }
        }
    }
}

/// The point of the segment that is nearest to `p`.
fn project(p: Vector, a: Vector, b: Vector) -> Vector {
    let e = b - a;
    let e2 = e.length_squared();
    if e2 < POINT_LIKE_M2 {
        return a;
    }
    let t = (p - a).dot(e) / e2;
    if t <= 0.0 {
        a
    } else if t >= 1.0 {
        b
    } else {
        a + e * t
    }
}

/// Squared distance of a point and an edge, which may be a point itself.
pub(crate) fn point_d2(p: Vector, a: Vector, b: Vector) -> f64 {
    let e = b - a;
    let r = p - a;
    // Adding the least number there is keeps the quotient of two zeros from being none, and changes no other.
    let t = (r.dot(e) / (e.length_squared() + f64::MIN_POSITIVE)).clamp(0.0, 1.0);
    (r - e * t).length_squared()
}

/// Squared distance of a point, given from an edge's start, to an edge, where it lies beside the edge; infinite where
/// an end is nearer. A division for those only that need it.
#[inline]
fn beside_d2(p: Vector, e: Vector) -> f64 {
    let (along, length2) = (p.dot(e), e.length_squared());
    if along > 0.0 && along < length2 {
        let area = p.perp_dot(e);
        area * area / length2
    } else {
        f64::INFINITY
    }
}

/// How far two boxes are apart along each axis.
fn gap(min: Vector, max: Vector, other_min: Vector, other_max: Vector) -> Vector {
    (other_min - max).max(min - other_max).max(Vector::ZERO)
}

/// A point.
pub(crate) struct PointProbe(pub(crate) Vector);

impl Probe for PointProbe {
    fn min(&self) -> Vector {
        self.0
    }

    fn max(&self) -> Vector {
        self.0
    }

    #[inline]
    fn box_d2(&self, min: Vector, max: Vector, _: f64) -> f64 {
        gap(self.0, self.0, min, max).length_squared()
    }

    #[inline]
    fn strips_d2(&self, strips: &Strips) -> [f64; WIDTH] {
        let mut bounds = [0.0; WIDTH];
        for (lane, bound) in bounds.iter_mut().enumerate() {
            let off = strips.off(lane, self.0).abs() - strips.half(lane);
            *bound = off.max(Vector::ZERO).length_squared();
        }
        bounds
    }

    #[inline]
    fn edge_d2(&self, a: Vector, b: Vector) -> f64 {
        point_d2(self.0, a, b)
    }

    fn contact(&self, a: Vector, b: Vector) -> Contact {
        let at = project(self.0, a, b);
        Contact {
            distance_m: (self.0 - at).length(),
            at,
            towards: self.0 - at,
        }
    }

    fn samples(&self) -> Samples {
        ([self.0; 8], 1)
    }
}
