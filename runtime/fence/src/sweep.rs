use backseat_units::EastNorth;

use crate::distance::{chain_of, east_north, vector};

/// Everything within `radius_m` of a shape: all places to which a request may bring the vehicle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sweep {
    /// The shape.
    pub shape: Shape,
    /// How far from the shape the vehicle may be, metres, 0 or more.
    pub radius_m: f64,
}

impl Sweep {
    /// Everything within `radius_m` metres of `shape`.
    #[must_use]
    pub const fn new(shape: Shape, radius_m: f64) -> Self {
        Self { shape, radius_m }
    }
}

/// A shape on the plane of the fence's [`LocalFrame`](backseat_units::LocalFrame).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shape {
    /// The solid convex hull of one to four points: it touches a fence edge that is wholly inside it.
    Convex(ConvexHull),
    /// A circle's line, not its disc: it does not touch a fence edge that is wholly inside the circle.
    Rim {
        /// The circle's centre.
        centre: EastNorth,
        /// The circle's radius, metres, 0 or more.
        radius_m: f64,
    },
}

/// One to four points that stand for their convex hull. Their order does not matter, and points may repeat or lie on
/// one line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ConvexHull {
    points: [EastNorth; 4],
    len: u8,
}

impl ConvexHull {
    /// The points, in the order in which they were given.
    #[must_use]
    pub fn points(&self) -> &[EastNorth] {
        &self.points[..usize::from(self.len)]
    }
}

impl Shape {
    /// One point.
    #[must_use]
    pub const fn point(a: EastNorth) -> Self {
        Self::Convex(ConvexHull {
            points: [a, a, a, a],
            len: 1,
        })
    }

    /// The straight line from one point to another, which may be the same.
    #[must_use]
    pub const fn leg(a: EastNorth, b: EastNorth) -> Self {
        Self::Convex(ConvexHull {
            points: [a, b, b, b],
            len: 2,
        })
    }

    /// A solid triangle.
    #[must_use]
    pub const fn triangle(a: EastNorth, b: EastNorth, c: EastNorth) -> Self {
        Self::Convex(ConvexHull {
            points: [a, b, c, c],
            len: 3,
        })
    }

    /// The solid convex hull of four points.
    #[must_use]
    pub const fn quadrilateral(points: [EastNorth; 4]) -> Self {
        Self::Convex(ConvexHull { points, len: 4 })
    }

    /// Solids that together are exactly the convex hull of any number of points.
    #[must_use]
    pub fn convex_hulls(points: &[EastNorth]) -> Vec<Self> {
        let mut given: Vec<_> = points.iter().map(|point| vector(*point)).collect();
        // Points that are NaN turn in no direction, so then the chain leaves out no point.
        let mut chain = vec![vector(EastNorth::default()); 2 * points.len() + 2];
        let len = chain_of(&mut given, &mut chain);
        let corners: Vec<EastNorth> = chain[..len].iter().map(|corner| east_north(*corner)).collect();
        match corners[..] {
            [] => Vec::new(),
            [a] => vec![Self::point(a)],
            [a, b] => vec![Self::leg(a, b)],
            [a, ref rest @ ..] => {
                // A fan of triangles from one corner, two at a time.
                let quarters = (0..rest.len() - 1).step_by(2);
                let third = |index: usize| rest.get(index + 2).copied().unwrap_or(rest[index + 1]);
                quarters
                    .map(|index| Self::quadrilateral([a, rest[index], rest[index + 1], third(index)]))
                    .collect()
            }
        }
    }

    /// A circle's line.
    #[must_use]
    pub const fn rim(centre: EastNorth, radius_m: f64) -> Self {
        Self::Rim { centre, radius_m }
    }
}

/// The depths and altitudes at which the vehicle may be along a sweep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VerticalExtent {
    /// The shallowest depth, metres below the surface.
    pub depth_min_m: f64,
    /// The deepest depth, metres below the surface; not less than `depth_min_m`.
    pub depth_max_m: f64,
    /// The lowest altitude above the bottom, metres. It must be finite: if the bottom is unknown, the caller gives the
    /// altitude that the vehicle is known to have at least.
    pub altitude_min_m: f64,
}
