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
        // The chain ends with the first corner again: at most five entries.
        let mut chain = [Vector::ZERO; 6];
        let len = chain_of(&mut given[..points.len()], &mut chain);
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
/// returns how many there are. `chain` needs room for two entries more than there are points, if the points are
/// numbers.
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
