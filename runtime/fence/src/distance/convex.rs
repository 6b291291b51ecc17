use backseat_units::EastNorth;
use parry2d_f64::math::Vector;
use parry2d_f64::shape::Segment;

use super::{Contact, Probe, Samples, gap, project, vector};

/// The convex hull of one to four points: a point, a leg, or a solid.
pub(crate) struct ConvexProbe {
    /// The corners, counterclockwise.
    corners: [Vector; 4],
    /// For each corner, the outward normal, of length one, of the side that begins there; zero for a side that is too
    /// short to have a direction.
    normals: [Vector; 4],
    len: usize,
    min: Vector,
    max: Vector,
}

impl ConvexProbe {
    /// Makes a probe from at most four points.
    pub(crate) fn new(points: &[EastNorth]) -> Self {
        let mut given = [Vector::ZERO; 4];
        for (corner, point) in given.iter_mut().zip(points) {
            *corner = vector(*point);
        }
        let given = &mut given[..points.len()];
        let mut chain = [Vector::ZERO; 10];
        let mut len = chain_of(given, &mut chain);
        if len > points.len() {
            // The two passes of the chain disagree about a turn, which rounding can decide either way only where all
            // points are on one line to rounding.
            (chain[0], chain[1], len) = (given[0], given[given.len() - 1], 2);
        }
        let mut probe = Self {
            corners: [chain[0], chain[1], chain[2], chain[3]],
            normals: [Vector::ZERO; 4],
            len,
            min: chain[0],
            max: chain[0],
        };
        for index in 0..len {
            let corner = chain[index];
            (probe.min, probe.max) = (probe.min.min(corner), probe.max.max(corner));
            let way = chain[(index + 1) % len] - corner;
            probe.normals[index] = (-way.perp()).normalize_or_zero();
        }
        probe
    }

    pub(crate) fn point(point: Vector) -> Self {
        Self {
            corners: [point; 4],
            normals: [Vector::ZERO; 4],
            len: 1,
            min: point,
            max: point,
        }
    }

    fn corners(&self) -> &[Vector] {
        &self.corners[..self.len]
    }

    /// The sides: none for a point, one for a leg.
    fn sides(&self) -> impl Iterator<Item = Segment> {
        let count = if self.len > 2 { self.len } else { self.len - 1 };
        (0..count).map(|index| Segment::new(self.corners[index], self.corners[(index + 1) % self.len]))
    }

    /// A place where the shape and an edge touch, unless it is at an end of the edge or at a corner of the shape.
    fn touch(&self, edge: &Segment) -> Option<Vector> {
        // An edge that crosses no side has both ends inside, or neither.
        let left = |side: Segment| side.scaled_direction().perp_dot(edge.a - side.a) >= 0.0;
        if self.len > 2 && self.sides().all(left) {
            return Some(edge.a);
        }
        self.sides().find_map(|side| crossing(&side, edge))
    }
}

impl Probe for ConvexProbe {
    fn bounds(&self) -> (Vector, Vector) {
        (self.min, self.max)
    }

    #[inline]
    fn box_d2(&self, min: Vector, max: Vector, enough_m2: f64) -> f64 {
        let mut bound_m2 = gap(self.min, self.max, min, max).length_squared();
        if bound_m2 >= enough_m2 {
            return bound_m2;
        }
        // The distance beyond a side is a better bound for a long slanting leg, about which its bounding box says
        // little.
        let (middle, half) = ((min + max) * 0.5, (max - min) * 0.5);
        for (corner, normal) in self.corners().iter().zip(&self.normals) {
            let beyond_m = (normal.dot(middle - corner) - normal.abs().dot(half)).max(0.0);
            bound_m2 = bound_m2.max(beyond_m * beyond_m);
        }
        bound_m2
    }

    #[inline]
    fn contact(&self, edge: &Segment) -> Contact {
        if let Some(at) = self.touch(edge) {
            return Contact { d2: 0.0, at };
        }
        let mut nearest = Contact {
            d2: f64::INFINITY,
            at: edge.a,
        };
        let mut offer = |at: Vector, on_shape: Vector| {
            let d2 = (on_shape - at).length_squared();
            if d2 < nearest.d2 {
                nearest = Contact { d2, at };
            }
        };
        for corner in self.corners() {
            offer(project(edge, *corner), *corner);
        }
        for side in self.sides() {
            offer(edge.a, project(&side, edge.a));
            offer(edge.b, project(&side, edge.b));
        }
        nearest
    }

    fn samples(&self) -> Samples {
        let mut points = [self.corners[0]; 8];
        points[..self.len].copy_from_slice(self.corners());
        (points, self.len)
    }
}

/// Where two segments cross. Some segments that only touch are left out; they touch at an end of one of them.
fn crossing(a: &Segment, b: &Segment) -> Option<Vector> {
    let (along_a, along_b) = (a.scaled_direction(), b.scaled_direction());
    // Compares the signs of four areas: the ends of each segment must lie on different sides of the other. A zero
    // counts as left. If a zero leads to a crossing, the segments do touch.
    let parts = |along: Vector, from: Vector, other: &Segment| {
        (along.perp_dot(other.a - from) < 0.0) != (along.perp_dot(other.b - from) < 0.0)
    };
    if !parts(along_a, a.a, b) || !parts(along_b, b.a, a) {
        return None;
    }
    let area = along_b.perp_dot(along_a);
    // Parallel segments touch at an end.
    (area != 0.0).then(|| b.a + along_b * ((a.a - b.a).perp_dot(along_a) / area).clamp(0.0, 1.0))
}

/// Andrew's monotone chain. Writes the corners of the convex hull, counterclockwise, to the beginning of `chain`, and
/// returns how many there are. `chain` needs room for two entries more than twice the points: where points are on one
/// line to rounding, or are not numbers, the two passes may disagree about turns, and a corner may be there twice.
pub(crate) fn chain_of(points: &mut [Vector], chain: &mut [Vector]) -> usize {
    points.sort_unstable_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let mut count = 0;
    let mut push = |point: Vector, floor: usize, count: &mut usize| {
        while *count >= floor + 2 && (chain[*count - 1] - chain[*count - 2]).perp_dot(point - chain[*count - 1]) <= 0.0
        {
            *count -= 1;
        }
        if *count == 0 || chain[*count - 1] != point {
            chain[*count] = point;
            *count += 1;
        }
    };
    for &point in points.iter() {
        push(point, 0, &mut count);
    }
    let lower = count.saturating_sub(1);
    for &point in points.iter().rev() {
        push(point, lower, &mut count);
    }
    if count > 1 { count - 1 } else { count }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// On one line to rounding, two of them near each other: the second pass of the chain keeps a point that the first
    /// one has as a corner. The hunt's seed 2043944 found such a way onto a trackline.
    #[test]
    fn points_on_one_line_to_rounding_make_a_probe_that_holds_them_all() {
        let lines: [[(f64, f64); 4]; 3] = [
            [
                (71.358_153_347_992_36, 26.014_790_480_696),
                (-1.668_883_722_381_021, 0.042_170_165_689_374_34),
                (-1.668_601_373_309_397_4, 0.042_270_585_280_508_73),
                (287.664_314_055_928_4, 102.945_719_205_768_38),
            ],
            [
                (-11.870_669_375_294_192, -32.803_025_897_479_17),
                (1_057.922_467_629_955_5, -387.086_087_599_822_4),
                (-11.872_658_548_311_48, -32.802_367_143_667_4),
                (3_871.771_005_422_642_7, -1_318.947_435_978_394_9),
            ],
            [
                (-0.470_747_883_373_104_1, 0.037_588_716_562_404_95),
                (-1_610.793_865_246_422, -865.434_401_504_292_3),
                (-3_116.723_063_275_262, -1_674.799_631_436_514),
                (-0.472_185_679_655_836_97, 0.036_815_969_529_879_75),
            ],
        ];
        let mut disagreed = 0;
        for line in lines {
            let points = line.map(|(east_m, north_m)| EastNorth::new(east_m, north_m));
            disagreed += usize::from(chain_of(&mut points.map(vector), &mut [Vector::ZERO; 10]) > 4);
            let probe = ConvexProbe::new(&points);
            for point in points {
                let at = vector(point);
                let d2 = probe.contact(&Segment::new(at, at)).d2;
                assert!(d2 < 1e-16, "{point:?}: {d2:e}");
            }
        }
        assert!(disagreed >= 2, "{disagreed}");
    }
}
