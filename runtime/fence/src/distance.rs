//! Measures the shape of a sweep against one straight edge, and bounds its distance to a box of many edges from below.
//!
//! The distances come from parry's projection onto a segment: two segments that do not cross are nearest to each other
//! at an end of one of them, and four signs show whether they cross. parry's query for two segments solves for both
//! places at once, which loses half of the digits if the segments are almost parallel: for two that cross at a small
//! angle it reports a distance of up to a sixth of a millimetre.

use backseat_units::EastNorth;
use parry2d_f64::math::Vector;
use parry2d_f64::query::PointQuery;
use parry2d_f64::shape::Segment;

use crate::sweep::Shape;

mod convex;
mod rim;

pub(crate) use convex::{ConvexProbe, chain_of};
pub(crate) use rim::RimProbe;

/// Where a shape and an edge are nearest to each other.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Contact {
    /// The squared distance, zero if they touch.
    pub(crate) d2: f64,
    /// The place on the edge.
    pub(crate) at: Vector,
}

impl Contact {
    /// The distance, zero if they touch.
    pub(crate) fn distance_m(&self) -> f64 {
        self.d2.sqrt()
    }
}

/// A shape that is prepared for being measured against many edges.
pub(crate) trait Probe {
    /// The lower and upper corner of the shape's bounding box.
    fn bounds(&self) -> (Vector, Vector);
    /// A lower bound of the squared distance to everything in a box. A bound over `enough_m2` need not be tight.
    fn box_d2(&self, min: Vector, max: Vector, enough_m2: f64) -> f64;
    /// Where the shape and an edge are nearest to each other.
    fn contact(&self, edge: &Segment) -> Contact;
    /// The points of the shape from which its worst one is taken: the corners of a convex hull, or eight points of a
    /// rim.
    fn samples(&self) -> Samples;
    /// A point of the shape.
    fn witness(&self) -> Vector {
        self.samples().0[0]
    }
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
pub(crate) enum AnyProbe {
    Convex(ConvexProbe),
    Rim(RimProbe),
}

impl AnyProbe {
    /// Makes a probe. The shape's coordinates must be finite, and so must their squares.
    pub(crate) fn new(shape: &Shape) -> Self {
        match shape {
            Shape::Convex(convex) => Self::Convex(ConvexProbe::new(convex.points())),
            Shape::Rim { centre, radius_m } => Self::Rim(RimProbe {
                centre: vector(*centre),
                radius_m: *radius_m,
            }),
        }
    }
}

/// The place on a segment that is nearest to a point.
fn project(segment: &Segment, point: Vector) -> Vector {
    segment.project_local_point(point, true).point
}

/// The squared distance between a point and a segment, which may be a point itself.
pub(crate) fn point_d2(point: Vector, segment: &Segment) -> f64 {
    (point - project(segment, point)).length_squared()
}

/// How far apart two boxes are along each axis.
fn gap(min: Vector, max: Vector, other_min: Vector, other_max: Vector) -> Vector {
    (other_min - max).max(min - other_max).max(Vector::ZERO)
}
