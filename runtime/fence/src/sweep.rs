use backseat_units::EastNorth;

use crate::distance::{chain_of, east_north, vector};

/// Everything within `radius_m` of a shape: where the vehicle may come while it does what was asked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sweep {
    /// What is swept.
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
    /// The convex hull of one to four points, solid: a fence edge wholly inside it is touched.
    Convex(ConvexHull),
    /// A circle's line, not its disc: a fence edge wholly inside the circle is not touched.
    Rim {
        /// The circle's centre.
        centre: EastNorth,
        /// The circle's radius, metres, 0 or more.
        radius_m: f64,
    },
}

/// One to four points that stand for their convex hull. In any order; points may repeat or lie on one line.
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

    /// The straight way from one point to another, which may be the same.
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

    /// Solids that together are the convex hull of any number of points, and nothing else.
    #[must_use]
    pub fn convex_hulls(points: &[EastNorth]) -> Vec<Self> {
        let mut given: Vec<_> = points.iter().map(|point| vector(*point)).collect();
        // What is no number turns no way, and then nothing is left out.
        let mut chain = vec![vector(EastNorth::default()); 2 * points.len() + 2];
        let len = chain_of(&mut given, &mut chain);
        let corners: Vec<EastNorth> = chain[..len].iter().map(|corner| east_north(*corner)).collect();
        match corners[..] {
            [] => Vec::new(),
            [a] => vec![Self::point(a)],
            [a, b] => vec![Self::leg(a, b)],
            [a, ref rest @ ..] => {
                // A fan from one corner, two triangles at a time.
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

/// What the vehicle may do vertically along a sweep.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VerticalExtent {
    /// The shallowest that it may be, metres below the surface.
    pub depth_min_m: f64,
    /// The deepest that it may be, metres below the surface; not less than `depth_min_m`.
    pub depth_max_m: f64,
    /// The lowest height above the bottom that it may have, metres. Finite: where the bottom is unknown, the caller
    /// says what it is known to be at least.
    pub altitude_min_m: f64,
}
