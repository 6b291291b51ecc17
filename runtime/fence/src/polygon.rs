//! One polygon with its holes, indexed: the nearest edge, and from it the side.

use core::fmt;

use backseat_units::EastNorth;
use parry2d_f64::bounding_volume::Aabb;
use parry2d_f64::math::Vector;
use parry2d_f64::partitioning::{Bvh, BvhBuildStrategy, BvhLeafCost, BvhNode};

use crate::distance::{AT_VERTEX_M, Contact, PointProbe, Probe, point_d2, vector};

/// Edges to a leaf of the tree. Consecutive edges lie beside each other in the plane and in memory.
const RUN: usize = 8;

/// A ring that has been found good.
#[derive(Clone, Debug)]
pub(crate) struct GoodRing {
    /// Counterclockwise for an outer ring, clockwise for a hole; the first vertex again as the last.
    pub(crate) vertices: Vec<EastNorth>,
    /// For each edge the number that it has in the file.
    pub(crate) numbers: Vec<u32>,
}

/// A polygon with its holes. Its inside is left of every edge.
#[derive(Clone)]
pub(crate) struct Polygon {
    /// All rings, closed, one after the other. Edge `i` runs from vertex `i` to `i + 1`.
    vertices: Vec<EastNorth>,
    /// Of the edge that begins at the vertex.
    numbers: Vec<u32>,
    /// Where each ring begins, and where the last one ends.
    starts: Vec<u32>,
    /// The leaves.
    runs: Vec<Run>,
    tree: Bvh,
    pub(crate) min: Vector,
    pub(crate) max: Vector,
}

/// Consecutive edges of one ring.
#[derive(Clone, Copy, Debug)]
struct Run {
    first: u32,
    count: u32,
    /// All the edges are within this of the straight line from the first vertex to the last. A smooth line is much
    /// nearer to its chord than to its bounding box, so that most runs are passed over without a look at their edges:
    /// the idea of strip trees (Ballard, CACM 24(5), 1981).
    sagitta_m: f64,
}

/// The nearest edge, and how near.
#[derive(Clone, Copy)]
struct Nearest {
    d2: f64,
    edge: u32,
}

impl BvhLeafCost for Nearest {
    #[inline]
    fn cost(&self) -> f64 {
        self.d2
    }
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
        let mut polygon = Self {
            vertices: Vec::new(),
            numbers: Vec::new(),
            starts: vec![0],
            runs: Vec::new(),
            tree: Bvh::new(),
            min: Vector::splat(f64::MAX),
            max: Vector::splat(f64::MIN),
        };
        let mut boxes = Vec::new();
        for ring in rings {
            let first = polygon.vertices.len();
            let edges = ring.vertices.len() - 1;
            polygon.vertices.extend(ring.vertices);
            polygon.numbers.extend(ring.numbers);
            // The closing vertex begins no edge.
            polygon.numbers.push(0);
            polygon.starts.push(polygon.vertices.len() as u32);
            for start in (first..first + edges).step_by(RUN) {
                let count = RUN.min(first + edges - start);
                let (mut min, mut max) = (Vector::splat(f64::MAX), Vector::splat(f64::MIN));
                for vertex in &polygon.vertices[start..=start + count] {
                    min = min.min(vector(*vertex));
                    max = max.max(vector(*vertex));
                }
                polygon.runs.push(Run {
                    first: start as u32,
                    count: count as u32,
                    sagitta_m: sagitta_m(&polygon.vertices[start..=start + count]),
                });
                boxes.push(Aabb::new(min, max));
                polygon.min = polygon.min.min(min);
                polygon.max = polygon.max.max(max);
            }
        }
        polygon.tree = Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes);
        polygon
    }

    /// The rings, closed, the outer one first.
    pub(crate) fn rings(&self) -> impl Iterator<Item = &[EastNorth]> {
        self.starts
            .windows(2)
            .map(|ends| &self.vertices[ends[0] as usize..ends[1] as usize])
    }

    /// The ring of an edge (0 is the outer one) and the edge's number in the file.
    pub(crate) fn locate(&self, edge: u32) -> (usize, usize) {
        (self.ring_of(edge), self.numbers[edge as usize] as usize)
    }

    /// The number in the file of a ring's vertex, which is counted along the ring as it is kept here.
    pub(crate) fn vertex_number(&self, ring: usize, vertex: usize) -> usize {
        // A ring begins with the file's first vertex either way round; at the others the numbers of the two edges that
        // meet differ by one, and the higher is that of the vertex.
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

    /// The tree over the runs of edges.
    pub(crate) fn tree(&self) -> &Bvh {
        &self.tree
    }

    /// The edges of a run.
    pub(crate) fn run_edges(&self, run: u32) -> impl Iterator<Item = u32> + use<> {
        let Run { first, count, .. } = self.runs[run as usize];
        first..first + count
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

    /// The edge nearest to a shape, where one is nearer than the square root of `below_m2`.
    pub(crate) fn nearest<P: Probe>(&self, probe: &P, below_m2: f64) -> Option<(u32, Contact)> {
        let (_, nearest) = self.tree.find_best(
            below_m2,
            |node: &BvhNode, best_m2| probe.box_d2(node.mins(), node.maxs(), best_m2),
            |run, best_m2| {
                let Run {
                    first,
                    count,
                    sagitta_m,
                } = self.runs[run as usize];
                let vertices = &self.vertices[first as usize..=(first + count) as usize];
                let reach_m = best_m2.sqrt() + sagitta_m;
                let (from, to) = (vector(vertices[0]), vector(vertices[count as usize]));
                if probe.chord_d2(from, to) > reach_m * reach_m {
                    return None;
                }
                let (d2, index) = probe.run_d2(vertices);
                Some(Nearest {
                    d2,
                    edge: first + index as u32,
                })
            },
        )?;
        let [a, b] = self.ends(nearest.edge);
        Some((nearest.edge, probe.contact(vector(a), vector(b))))
    }

    /// Whether a shape whose nearest edge this is, and which does not touch it, lies inside the polygon.
    ///
    /// No edge comes between the shape and the contact, so the shape lies on the side on which it leaves the edge: left
    /// is inside. Where the contact is a vertex, or as near to one that the neighbouring edge could as well have been
    /// found, one edge's side is not enough (the point beyond a sharp corner lies left of one of the two edges):
    /// there the direction must lie in the corner's inner angle, left of both edges where the ring turns left, left of
    /// either where it turns right. Baerentzen and Aanaes's pseudonormal (IEEE TVCG 11(3), 2005) decides the same in
    /// three dimensions, where there is no such plain angle.
    ///
    /// It is right for distances of a micrometre and more: edges that share no vertex are farther apart than that, and
    /// sharper corners than [`crate::outline::SHARPEST_RAD`], whose two edges could be mistaken for each other farther
    /// than [`AT_VERTEX_M`] from the corner, have been refused.
    pub(crate) fn is_inside(&self, edge: u32, contact: &Contact) -> bool {
        let [a, b] = self.ends(edge);
        let near = |vertex: EastNorth| (vector(vertex) - contact.at).length_squared() <= AT_VERTEX_M * AT_VERTEX_M;
        let ring = self.ring_of(edge);
        let (first, last) = self.ends_of(ring);
        let (incoming, outgoing) = if near(a) {
            (if edge == first { last } else { edge - 1 }, edge)
        } else if near(b) {
            (edge, if edge == last { first } else { edge + 1 })
        } else {
            return (vector(b) - vector(a)).perp_dot(contact.towards) > 0.0;
        };
        let direction = |edge: u32| {
            let [a, b] = self.ends(edge);
            vector(b) - vector(a)
        };
        let (incoming, outgoing) = (direction(incoming), direction(outgoing));
        let left_of_incoming = incoming.perp_dot(contact.towards) > 0.0;
        let left_of_outgoing = outgoing.perp_dot(contact.towards) > 0.0;
        if incoming.perp_dot(outgoing) > 0.0 {
            left_of_incoming && left_of_outgoing
        } else {
            left_of_incoming || left_of_outgoing
        }
    }

    /// The nearest edge to a point, where on it, and the distance: positive outside, negative inside.
    pub(crate) fn outside_m(&self, point: Vector) -> (u32, Vector, f64) {
        let Some((edge, contact)) = self.nearest(&PointProbe(point), f64::INFINITY) else {
            // Only a distance that is no number finds no edge, and what cannot be measured is far outside.
            return (0, vector(self.vertices[0]), f64::INFINITY);
        };
        let inside = self.is_inside(edge, &contact);
        (
            edge,
            contact.at,
            if inside {
                -contact.distance_m
            } else {
                contact.distance_m
            },
        )
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

/// An upper bound of how far the edges are from the straight line between the two ends: the vertices' greatest
/// distance from it, which is the edges' too because the distance to a straight line is convex, and a little for
/// rounding.
fn sagitta_m(vertices: &[EastNorth]) -> f64 {
    let (from, to) = (vector(vertices[0]), vector(vertices[vertices.len() - 1]));
    let distance2 = |vertex: &EastNorth| point_d2(vector(*vertex), from, to);
    vertices.iter().map(distance2).fold(0.0, f64::max).sqrt() + 1e-9
}
