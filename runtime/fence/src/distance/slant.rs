use parry2d_f64::math::Vector;

use super::POINT_LIKE_M2;
use crate::strips::Strips;

/// A box around a shape along a direction of its own: the bounding box along the axes says little about a long
/// slanting leg.
#[derive(Clone, Copy)]
pub(super) struct Slant {
    along: Vector,
    /// Its components without their signs.
    shares: Vector,
    /// In its own coordinates, and on the plane.
    middle: Vector,
    centre: Vector,
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
        let middle = (min + max) * 0.5;
        Self {
            along,
            shares: along.abs(),
            middle,
            centre: along * middle.x + along.perp() * middle.y,
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

    /// The squared distance to a turned box by the four directions of the two boxes.
    #[inline]
    pub(super) fn strip_d2(&self, strips: &Strips, lane: usize) -> f64 {
        let (off, half) = (strips.off(lane, self.centre), strips.half(lane));
        let turn = strips.turn(lane, self.along);
        let (cos, sin) = (turn.x.abs(), turn.y.abs());
        let reach = Vector::new(
            cos * self.half.x + sin * self.half.y,
            sin * self.half.x + cos * self.half.y,
        );
        let theirs = (off.abs() - half - reach).max(Vector::ZERO);
        let own = Vector::new(turn.dot(off), turn.perp_dot(off));
        let reach = Vector::new(cos * half.x + sin * half.y, sin * half.x + cos * half.y);
        let ours = (own.abs() - self.half - reach).max(Vector::ZERO);
        theirs.length_squared().max(ours.length_squared())
    }

    /// How far a turned box is to the right of the line through the middle.
    #[inline]
    pub(super) fn beyond_m(&self, strips: &Strips, lane: usize) -> f64 {
        let (off, half) = (strips.off(lane, self.centre), strips.half(lane));
        let turn = strips.turn(lane, self.along);
        (turn.perp_dot(off) - turn.y.abs() * half.x - turn.x.abs() * half.y).max(0.0)
    }
}
