//! What a sweep is made of, measured against one straight edge, and bounded from below against a box of many.
//!
//! The distances are those of parry's projection onto a segment: two segments that do not cross are nearest to each other
//! at an end of one of them, and whether they cross is told by four signs. parry's query for two segments solves for
//! both places at once, which loses half of the digits where they are almost parallel: of two that cross at a small
//! angle it says that they are up to a sixth of a millimetre apart.

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
    /// The squared distance, zero where they touch.
    pub(crate) d2: f64,
    /// The place on the edge.
    pub(crate) at: Vector,
}

impl Contact {
    /// Zero where they touch.
    pub(crate) fn distance_m(&self) -> f64 {
        self.d2.sqrt()
    }
}

/// A shape made ready to be measured against many edges.
pub(crate) trait Probe {
    /// Lower and upper corner of the shape's bounding box.
    fn bounds(&self) -> (Vector, Vector);
    /// A lower bound of the squared distance to whatever lies in a box. The bound need not be good where it is over
    /// `enough_m2`.
    fn box_d2(&self, min: Vector, max: Vector, enough_m2: f64) -> f64;
    /// Where the shape and an edge are nearest to each other.
    fn contact(&self, edge: &Segment) -> Contact;
    /// Points of the shape from which its worst one is taken: the corners of a convex hull, eight of a rim.
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
    /// The shape's coordinates are finite, and so are their squares.
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

/// Squared distance of a point and a segment, which may be a point itself.
pub(crate) fn point_d2(point: Vector, segment: &Segment) -> f64 {
    (point - project(segment, point)).length_squared()
}

/// How far two boxes are apart along each axis.
fn gap(min: Vector, max: Vector, other_min: Vector, other_max: Vector) -> Vector {
    (other_min - max).max(min - other_max).max(Vector::ZERO)
}
