//! One polygon with its holes, indexed: the nearest edge, and from it the side.

use core::fmt;

use backseat_units::EastNorth;
use parry2d_f64::math::Vector;

use crate::distance::{AT_VERTEX_M, Contact, PointProbe, Probe, vector};
use crate::strips::StripTree;

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
    tree: StripTree,
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
        let tree = StripTree::new(&vertices, in_order(&vertices, &starts));
        Self {
            vertices,
            numbers,
            starts,
            tree,
            min,
            max,
        }
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

    /// The edges that may be nearer to a shape than the square root of `below_m2`, and others.
    pub(crate) fn edges_near<P: Probe>(&self, probe: &P, below_m2: f64, mut visit: impl FnMut(u32)) {
        let bound = |strips: &_| probe.strips_d2(strips);
        self.tree.search(below_m2, bound, |run, below_m2| {
            run.edges().for_each(&mut visit);
            below_m2
        });
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
        let mut nearest = None;
        let bound = |strips: &_| probe.strips_d2(strips);
        self.tree.search(below_m2, bound, |run, least_m2| {
            let (d2, index) = probe.run_d2(run.vertices(&self.vertices));
            if d2 < least_m2 {
                nearest = Some(run.first_edge() + index as u32);
            }
            least_m2.min(d2)
        });
        let edge = nearest?;
        let [a, b] = self.ends(edge);
        Some((edge, probe.contact(vector(a), vector(b))))
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

/// The corners of the box around points.
pub(crate) fn bounds(points: &[EastNorth]) -> (Vector, Vector) {
    points.iter().fold(
        (Vector::splat(f64::INFINITY), Vector::splat(f64::NEG_INFINITY)),
        |(min, max), point| (min.min(vector(*point)), max.max(vector(*point))),
    )
}

/// The first edge of each ring and how many it has, neighbours after each other: by the middles of their boxes along
/// a curve of Z shape (Morton, IBM 1966).
fn in_order(vertices: &[EastNorth], starts: &[u32]) -> impl Iterator<Item = (u32, u32)> {
    let (min, max) = bounds(vertices);
    let across = (max - min).max(Vector::splat(f64::MIN_POSITIVE));
    let mut rings: Vec<_> = starts
        .windows(2)
        .map(|ends| {
            let (low, high) = bounds(&vertices[ends[0] as usize..ends[1] as usize]);
            let share = ((low + high) * 0.5 - min) / across * 65_535.0;
            let place = spread(share.x as u16) | spread(share.y as u16) << 1;
            (place, ends[0], ends[1] - ends[0] - 1)
        })
        .collect();
    rings.sort_unstable();
    rings.into_iter().map(|(_, first, edges)| (first, edges))
}

/// The bits of a number, a zero before each.
fn spread(number: u16) -> u32 {
    (0..16).fold(0, |bits, bit| bits | (u32::from(number) >> bit & 1) << (2 * bit))
}
