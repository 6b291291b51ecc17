use parry2d_f64::math::Vector;
use parry2d_f64::shape::Segment;

use super::{Contact, Probe, Samples, gap, project};

/// A circle's line.
pub(crate) struct RimProbe {
    pub(super) centre: Vector,
    pub(super) radius_m: f64,
}

impl RimProbe {
    /// The squared distance from the rim to something that has points at every distance from `near_m` to `far_m` from
    /// the centre.
    #[inline]
    fn d2(&self, near_m: f64, far_m: f64) -> f64 {
        let distance_m = (near_m - self.radius_m).max(self.radius_m - far_m).max(0.0);
        distance_m * distance_m
    }
}

impl Probe for RimProbe {
    fn bounds(&self) -> (Vector, Vector) {
        let radius = Vector::splat(self.radius_m);
        (self.centre - radius, self.centre + radius)
    }

    #[inline]
    fn box_d2(&self, min: Vector, max: Vector, _: f64) -> f64 {
        let near = gap(self.centre, self.centre, min, max);
        let far = (max - self.centre).max(self.centre - min);
        self.d2(near.length(), far.length())
    }

    #[inline]
    fn contact(&self, edge: &Segment) -> Contact {
        let near = project(edge, self.centre);
        let far = if edge.a.distance_squared(self.centre) >= edge.b.distance_squared(self.centre) {
            edge.a
        } else {
            edge.b
        };
        let (near_m, far_m) = (near.distance(self.centre), far.distance(self.centre));
        Contact {
            d2: self.d2(near_m, far_m),
            // An edge within the circle is nearest at its far end.
            at: if far_m < self.radius_m { far } else { near },
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
