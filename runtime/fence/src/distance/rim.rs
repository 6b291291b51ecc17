use parry2d_f64::math::Vector;

use super::{Contact, Probe, Samples, gap, point_d2, project};
use crate::strips::{Strips, WIDTH};

/// A circle's line.
pub(crate) struct RimProbe {
    pub(super) centre: Vector,
    pub(super) radius_m: f64,
}

impl RimProbe {
    /// How far the rim is from something whose points are `near` to `far` from the centre, all of them in between.
    #[inline]
    fn distance_m(&self, near_m2: f64, far_m2: f64) -> f64 {
        let r2 = self.radius_m * self.radius_m;
        if near_m2 > r2 {
            near_m2.sqrt() - self.radius_m
        } else if far_m2 < r2 {
            self.radius_m - far_m2.sqrt()
        } else {
            0.0
        }
    }
}

impl Probe for RimProbe {
    fn min(&self) -> Vector {
        self.centre - Vector::splat(self.radius_m)
    }

    fn max(&self) -> Vector {
        self.centre + Vector::splat(self.radius_m)
    }

    #[inline]
    fn box_d2(&self, min: Vector, max: Vector, _: f64) -> f64 {
        let near = gap(self.centre, self.centre, min, max);
        let far = (max - self.centre).max(self.centre - min);
        let distance_m = self.distance_m(near.length_squared(), far.length_squared());
        distance_m * distance_m
    }

    #[inline]
    fn strips_d2(&self, strips: &Strips) -> [f64; WIDTH] {
        let mut bounds = [0.0; WIDTH];
        for (lane, bound) in bounds.iter_mut().enumerate() {
            let (off, half) = (strips.off(lane, self.centre).abs(), strips.half(lane));
            let near = (off - half).max(Vector::ZERO);
            let distance_m = self.distance_m(near.length_squared(), (off + half).length_squared());
            *bound = distance_m * distance_m;
        }
        bounds
    }

    #[inline]
    fn edge_d2(&self, a: Vector, b: Vector) -> f64 {
        let far_m2 = (a - self.centre)
            .length_squared()
            .max((b - self.centre).length_squared());
        let distance_m = self.distance_m(point_d2(self.centre, a, b), far_m2);
        distance_m * distance_m
    }

    fn contact(&self, a: Vector, b: Vector) -> Contact {
        let near = project(self.centre, a, b);
        let far = if (a - self.centre).length_squared() >= (b - self.centre).length_squared() {
            a
        } else {
            b
        };
        let (near_m, far_m) = ((near - self.centre).length(), (far - self.centre).length());
        if near_m > self.radius_m {
            Contact {
                distance_m: near_m - self.radius_m,
                at: near,
                towards: self.centre - near,
            }
        } else if far_m < self.radius_m {
            // An edge within the circle: from its far end outward. One that is no longer than a rounding error at
            // the very centre has every direction alike.
            let outward = if far_m > 0.0 { far - self.centre } else { b - a };
            Contact {
                distance_m: self.radius_m - far_m,
                at: far,
                towards: outward,
            }
        } else {
            Contact {
                distance_m: 0.0,
                at: near,
                towards: Vector::ZERO,
            }
        }
    }

    fn samples(&self) -> Samples {
        let (r, d) = (self.radius_m, self.radius_m * core::f64::consts::FRAC_1_SQRT_2);
        let offsets = [
            (r, 0.0),
            (d, d),
            (0.0, r),
            (-d, d),
            (-r, 0.0),
            (-d, -d),
            (0.0, -r),
            (d, -d),
        ];
        (offsets.map(|(x, y)| self.centre + Vector::new(x, y)), 8)
    }
}
