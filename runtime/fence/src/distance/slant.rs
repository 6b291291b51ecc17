use parry2d_f64::math::Vector;

use super::POINT_LIKE_M2;

/// A box around a shape along a direction of its own: the bounding box along the axes says little about a long
/// slanting leg.
#[derive(Clone, Copy)]
pub(super) struct Slant {
    along: Vector,
    /// Its components without their signs.
    shares: Vector,
    middle: Vector,
    half: Vector,
}

impl Slant {
    pub(super) fn new(points: &[Vector], direction: Vector) -> Self {
        let length = direction.length();
        let along = if length * length < POINT_LIKE_M2 {
            Vector::new(1.0, 0.0)
        } else {
            direction / length
        };
        let (mut min, mut max) = (Vector::splat(f64::MAX), Vector::splat(f64::MIN));
        for &point in points {
            let turned = Vector::new(along.dot(point), along.perp_dot(point));
            min = min.min(turned);
            max = max.max(turned);
        }
        Self {
            along,
            shares: along.abs(),
            middle: (min + max) * 0.5,
            half: (max - min) * 0.5,
        }
    }

    pub(super) fn box_d2(&self, min: Vector, max: Vector) -> f64 {
        let (middle, half) = ((min + max) * 0.5, (max - min) * 0.5);
        let turned = Vector::new(self.along.dot(middle), self.along.perp_dot(middle));
        let reach = Vector::new(self.shares.dot(half), self.shares.y * half.x + self.shares.x * half.y);
        ((turned - self.middle).abs() - self.half - reach)
            .max(Vector::ZERO)
            .length_squared()
    }
}
