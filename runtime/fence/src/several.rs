//! Checks several shapes at once: first a shape that contains them all, then one for each half of them, and so on down
//! to single shapes wherever such a check fails.

use backseat_units::EastNorth;
use parry2d_f64::shape::Segment;

use crate::distance::{point_d2, vector};
use crate::fence::{Fence, FenceDuring};
use crate::question::LIMIT_M;
use crate::sweep::{Shape, Sweep, VerticalExtent};
use crate::verdict::{Breach, Clearance};

impl Fence {
    /// As [`Fence::check_passing`] for each of several shapes with one radius. If all of them, or half of them and so
    /// on, lie well inside, one question is enough. The clearance is then that of a shape around them, and theirs may
    /// be greater.
    ///
    /// # Errors
    /// The [`Breach`] of the first shape that breaches the fence.
    ///
    /// # Panics
    /// If there is no shape.
    pub fn check_all(
        &self,
        shapes: &[Shape],
        radius_m: f64,
        vertical: &VerticalExtent,
        depths_m: [f64; 2],
    ) -> Result<Clearance, Breach> {
        each(shapes, radius_m, |sweep| self.check_passing(sweep, vertical, depths_m))
    }
}

impl FenceDuring<'_> {
    /// As [`Fence::check_all`], with the zones that are valid then.
    ///
    /// # Errors
    /// The [`Breach`] of the first shape that breaches the fence.
    ///
    /// # Panics
    /// If there is no shape.
    pub fn check_all(
        &self,
        shapes: &[Shape],
        radius_m: f64,
        vertical: &VerticalExtent,
        depths_m: [f64; 2],
    ) -> Result<Clearance, Breach> {
        each(shapes, radius_m, |sweep| self.check_passing(sweep, vertical, depths_m))
    }
}

fn each(
    shapes: &[Shape],
    radius_m: f64,
    check: impl Fn(&Sweep) -> Result<Clearance, Breach> + Copy,
) -> Result<Clearance, Breach> {
    if let [shape] = shapes {
        return check(&Sweep::new(*shape, radius_m));
    }
    if let Some(around) = around(shapes, radius_m)
        && let Ok(clearance) = check(&around)
    {
        return Ok(clearance);
    }
    let (first, second) = shapes.split_at(shapes.len() / 2);
    let (first, second) = (each(first, radius_m, check)?, each(second, radius_m, check)?);
    Ok(if second.metres < first.metres { second } else { first })
}

/// A leg between two points that are about as far apart as any, with a radius within which all other points lie. It is
/// convex, so it also contains their convex hulls. `None` for a single leg or point, because its own check costs no
/// more, and if the shapes include a rim or a number that is not usable.
fn around(shapes: &[Shape], radius_m: f64) -> Option<Sweep> {
    let points = || {
        shapes.iter().flat_map(|shape| match shape {
            Shape::Convex(convex) => convex.points(),
            Shape::Rim { .. } => &[],
        })
    };
    let convex = shapes.iter().all(|shape| match shape {
        Shape::Convex(_) => true,
        Shape::Rim { .. } => false,
    });
    let usable = |point: &EastNorth| point.east_m.abs() <= LIMIT_M && point.north_m.abs() <= LIMIT_M;
    if !convex || points().count() < 3 || !points().all(usable) {
        return None;
    }
    // The farthest point from any point, and the farthest from that one. They are seldom much nearer to each other than
    // the two that are farthest apart, and each is found in one pass.
    let farthest = |from: EastNorth| {
        let squared_m2 = |point: &EastNorth| (vector(*point) - vector(from)).length_squared();
        points().max_by(|a, b| squared_m2(a).total_cmp(&squared_m2(b)))
    };
    let from = farthest(*points().next()?)?;
    let to = farthest(*from)?;
    let (from, to) = (*from, *to);
    let leg = Segment::new(vector(from), vector(to));
    let off_m2 = points().map(|point| point_d2(vector(*point), &leg));
    // The rounding of the square roots is far below a micrometre.
    let off_m = off_m2.fold(0.0, f64::max).sqrt() + 1e-6;
    Some(Sweep::new(Shape::leg(from, to), radius_m + off_m))
}
