//! One polygon with its holes and an index of its edges, which finds the nearest edge and whether a point is inside.

use core::fmt;

use backseat_units::EastNorth;
use parry2d_f64::bounding_volume::{Aabb, BoundingVolume};
use parry2d_f64::math::Vector;
use parry2d_f64::partitioning::{Bvh, BvhBuildStrategy, BvhNode};
use parry2d_f64::shape::Segment;

use crate::distance::{Contact, ConvexProbe, Probe, vector};

/// A ring that has been checked.
#[derive(Clone, Debug)]
pub(crate) struct GoodRing {
    /// Counterclockwise for an outer ring, clockwise for a hole; the first vertex is repeated as the last.
    pub(crate) vertices: Vec<EastNorth>,
    /// For each edge, its number in the file.
    pub(crate) numbers: Vec<u32>,
}

/// A polygon with its holes. Its inside is on the left of every edge.
#[derive(Clone)]
pub(crate) struct Polygon {
    /// All closed rings, one after the other. Edge `i` runs from vertex `i` to `i + 1`.
    vertices: Vec<EastNorth>,
    /// For each vertex, the number of the edge that begins there.
    numbers: Vec<u32>,
    /// Where each ring begins, and where the last one ends.
    starts: Vec<u32>,
    /// The tree over the edges' bounding boxes.
    tree: Bvh,
    pub(crate) min: Vector,
    pub(crate) max: Vector,
}

impl fmt::Debug for Polygon {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let lengths = self.rings().map(<[EastNorth]>::len).collect::<Vec<_>>();
        f.debug_struct("Polygon")
            .field("ring_lengths", &lengths)
            .finish_non_exhaustive()
    }
}

impl Polygon {
    /// The outer ring, then the holes.
    pub(crate) fn new(rings: Vec<GoodRing>) -> Self {
        let (mut vertices, mut numbers, mut starts) = (Vec::new(), Vec::new(), vec![0]);
        for ring in rings {
            vertices.extend(ring.vertices);
            numbers.extend(ring.numbers);
            // The closing vertex begins no edge.
            numbers.push(0);
            starts.push(vertices.len() as u32);
        }
        let (min, max) = bounds(&vertices);
        let mut polygon = Self {
            vertices,
            numbers,
            starts,
            tree: Bvh::new(),
            min,
            max,
        };
        let boxes = polygon.ring_edges().flat_map(|(first, last)| first..=last);
        let boxes = boxes.map(|edge| (edge as usize, polygon.segment(edge).local_aabb()));
        polygon.tree = Bvh::from_iter(BvhBuildStrategy::Binned, boxes);
        polygon
    }

    /// The closed rings, the outer one first.
    pub(crate) fn rings(&self) -> impl Iterator<Item = &[EastNorth]> {
        self.starts
            .windows(2)
            .map(|ends| &self.vertices[ends[0] as usize..ends[1] as usize])
    }

    /// The ring of an edge (0 is the outer one) and the edge's number in the file.
    pub(crate) fn locate(&self, edge: u32) -> (usize, usize) {
        (self.ring_of(edge), self.numbers[edge as usize] as usize)
    }

    /// The file's number for a ring's vertex. `vertex` is counted along the ring as it is stored here.
    pub(crate) fn vertex_number(&self, ring: usize, vertex: usize) -> usize {
        // A ring begins with the file's first vertex in both directions. At each other vertex, the numbers of the two
        // edges that meet differ by one, and the higher is the vertex's number.
        let edge = self.ends_of(ring).0 + vertex as u32;
        if vertex == 0 {
            1
        } else {
            self.numbers[edge as usize].max(self.numbers[edge as usize - 1]) as usize
        }
    }

    /// The first and the last edge of each ring.
    pub(crate) fn ring_edges(&self) -> impl Iterator<Item = (u32, u32)> {
        (0..self.starts.len() - 1).map(|ring| self.ends_of(ring))
    }

    /// The edges whose bounding boxes share a point with a box.
    pub(crate) fn edges_in(&self, around: Aabb) -> impl Iterator<Item = u32> {
        self.tree.leaves(move |node: &BvhNode| node.aabb().intersects(&around))
    }

    fn ends_of(&self, ring: usize) -> (u32, u32) {
        (self.starts[ring], self.starts[ring + 1] - 2)
    }

    /// Whether an edge of this index exists.
    pub(crate) fn has_edge(&self, edge: u32) -> bool {
        // A closing vertex begins no edge.
        (edge as usize) + 1 < self.vertices.len() && !self.starts.contains(&(edge + 1))
    }

    /// The ends of an edge.
    pub(crate) fn ends(&self, edge: u32) -> [EastNorth; 2] {
        [self.vertices[edge as usize], self.vertices[edge as usize + 1]]
    }

    /// An edge as parry's segment.
    pub(crate) fn segment(&self, edge: u32) -> Segment {
        let [a, b] = self.ends(edge).map(vector);
        Segment::new(a, b)
    }

    /// The nearest edge to a shape, if one is nearer than `below_m`.
    pub(crate) fn nearest<P: Probe>(&self, probe: &P, below_m: f64) -> Option<(u32, Contact)> {
        let nearest = self.tree.find_best(
            below_m * below_m,
            |node: &BvhNode, least_m2| probe.box_d2(node.mins(), node.maxs(), least_m2),
            |edge, _| {
                let contact = probe.contact(&self.segment(edge));
                Some((contact.d2, contact))
            },
        );
        nearest.map(|(edge, (_, contact))| (self.first_at(edge, contact.at), contact))
    }

    /// The first of the edges that meet at a point of an edge, so that the order of the index does not decide which one
    /// is named.
    fn first_at(&self, edge: u32, point: Vector) -> u32 {
        let (first, last) = self.ends_of(self.ring_of(edge));
        let [a, b] = self.ends(edge).map(vector);
        match edge {
            _ if point == a && edge > first => edge - 1,
            _ if point == b && edge == last => first,
            _ => edge,
        }
    }

    /// Whether a point that is on no edge lies inside: a ray from it towards the east crosses an odd number of edges.
    pub(crate) fn contains(&self, point: Vector) -> bool {
        let on_ray = |node: &BvhNode| {
            let (min, max) = (node.mins(), node.maxs());
            min.y <= point.y && point.y <= max.y && point.x <= max.x
        };
        let crossed = |edge: &u32| {
            let edge = self.segment(*edge);
            let upward = edge.b.y > point.y;
            // An edge includes its lower end and not its upper one, so that a ray through a vertex crosses one of the
            // two edges.
            let left = edge.scaled_direction().perp_dot(point - edge.a) > 0.0;
            (edge.a.y > point.y) != upward && left == upward
        };
        self.tree.leaves(on_ray).filter(crossed).count() % 2 == 1
    }

    /// The nearest edge to a point, the place on it, and the distance: positive outside, negative inside.
    pub(crate) fn outside_m(&self, point: Vector) -> (u32, Vector, f64) {
        self.beside_m(&ConvexProbe::point(point))
    }

    /// The nearest edge to a shape, the place on it, and the distance: positive if the shape is outside, negative if it
    /// is inside, zero if they touch.
    pub(crate) fn beside_m<P: Probe>(&self, probe: &P) -> (u32, Vector, f64) {
        let Some((edge, contact)) = self.nearest(probe, f64::INFINITY) else {
            // Only a distance of NaN finds no edge. A shape that cannot be measured counts as far outside.
            return (0, vector(self.vertices[0]), f64::INFINITY);
        };
        let distance_m = contact.distance_m();
        let inside = distance_m > 0.0 && self.contains(probe.witness());
        (edge, contact.at, if inside { -distance_m } else { distance_m })
    }

    fn ring_of(&self, edge: u32) -> usize {
        // Almost always there is one ring.
        if edge < self.starts[1] {
            0
        } else {
            self.starts.partition_point(|start| *start <= edge) - 1
        }
    }
}

/// The corners of the box around points.
pub(crate) fn bounds(points: &[EastNorth]) -> (Vector, Vector) {
    points.iter().fold(
        (Vector::splat(f64::INFINITY), Vector::splat(f64::NEG_INFINITY)),
        |(min, max), point| (min.min(vector(*point)), max.max(vector(*point))),
    )
}
