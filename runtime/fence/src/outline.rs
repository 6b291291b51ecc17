//! Makes polygons of the plane from the rings of the file, or refuses them.

use backseat_units::{EastNorth, LocalFrame, Position};
use geo::coordinate_position::{CoordPos, coord_pos_relative_to_ring};
use geo::{Coord, LineString};
use parry2d_f64::bounding_volume::BoundingVolume;
use parry2d_f64::math::Vector;

use crate::distance::{ConvexProbe, Probe, vector};
use crate::error::{FenceError, Place};
use crate::load::VERTICES_MAX;
use crate::polygon::{GoodRing, Polygon, bounds};
use crate::question::EDGE_THICKNESS_M;

/// Sharper corners are refused, radians. In them a ring runs back on itself, by mistake or except for the rounding of
/// its coordinates.
const SHARPEST_RAD: f64 = 1e-4;

/// How far a straight piece in the plane may be from the straight line in longitude and latitude, metres.
const SAGITTA_M: f64 = 0.01;

/// A closed ring of positions.
pub(crate) struct RawRing {
    /// The positions as they are in the file, or as they were made from it.
    pub(crate) positions: Vec<Position>,
    /// For each edge, its number in the file; if absent, edges count from 1.
    pub(crate) numbers: Option<Vec<u32>>,
}

/// The outer ring, then the holes.
pub(crate) type RawPolygon = Vec<RawRing>;

/// Makes polygons, and keeps count of their vertices and the box around them.
pub(crate) struct Outliner<'a> {
    frame: &'a LocalFrame,
    vertices: usize,
    min: Vector,
    max: Vector,
}

/// Names a ring of the current polygon: 0 is the outer one.
type Placer<'a> = &'a dyn Fn(usize) -> Place;

impl<'a> Outliner<'a> {
    pub(crate) fn new(frame: &'a LocalFrame) -> Self {
        Self {
            frame,
            vertices: 0,
            min: Vector::splat(f64::INFINITY),
            max: Vector::splat(f64::NEG_INFINITY),
        }
    }

    /// The greater side of the box around all polygons, metres.
    pub(crate) fn across_m(&self) -> f64 {
        (self.max - self.min).max_element()
    }

    /// Makes a polygon, which must be wide enough for the margin.
    pub(crate) fn polygon(
        &mut self,
        raw: &RawPolygon,
        margin_m: f64,
        place: Placer<'_>,
    ) -> Result<Polygon, FenceError> {
        let mut rings = Vec::with_capacity(raw.len());
        for (index, ring) in raw.iter().enumerate() {
            rings.push(self.ring(ring, index > 0, &|| place(index))?);
        }
        let polygon = Polygon::new(rings);
        self.min = self.min.min(polygon.min);
        self.max = self.max.max(polygon.max);
        self.refuse_spikes(&polygon, place)?;
        self.refuse_crossings(&polygon, place)?;
        refuse_stray_holes(&polygon, place)?;
        let surely_fits = 2.0 * margin_m < least_width_m(&polygon);
        if !surely_fits {
            let width_m = width_bound_m(&polygon);
            if 2.0 * margin_m >= width_m {
                return Err(FenceError::NothingReachable {
                    place: place(0),
                    margin_m,
                    width_m,
                });
            }
        }
        Ok(polygon)
    }

    fn ring(&mut self, raw: &RawRing, hole: bool, place: &dyn Fn() -> Place) -> Result<GoodRing, FenceError> {
        let positions = &raw.positions;
        let mut distinct: Vec<_> = positions
            .iter()
            .map(|position| (position.longitude.as_deg(), position.latitude.as_deg()))
            .collect();
        distinct.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
        distinct.dedup();
        if distinct.len() < 3 {
            return Err(FenceError::TooFewVertices {
                place: place(),
                found: distinct.len(),
            });
        }
        if positions.first() != positions.last() {
            return Err(FenceError::OpenRing {
                place: place(),
                last: positions.len(),
            });
        }
        let mut ring = self.project(raw)?;
        if on_one_line(&ring.vertices) {
            return Err(FenceError::ZeroArea { place: place() });
        }
        if (signed_area_m2(&ring.vertices) < 0.0) != hole {
            ring.vertices.reverse();
            ring.numbers.reverse();
        }
        Ok(ring)
    }

    /// Projects a ring onto the plane, divides its long edges, and leaves out repeated vertices.
    fn project(&mut self, raw: &RawRing) -> Result<GoodRing, FenceError> {
        let mut ring = GoodRing {
            vertices: vec![self.frame.to_local(raw.positions[0])],
            numbers: Vec::new(),
        };
        for (ends, count) in raw.positions.windows(2).zip(1..) {
            let number = raw
                .numbers
                .as_ref()
                .map_or(count, |numbers| numbers[count as usize - 1]);
            let pieces = divided(self.frame, ends[0], ends[1]);
            self.vertices += pieces.len();
            if self.vertices > VERTICES_MAX {
                return Err(FenceError::TooManyVertices {
                    found: self.vertices,
                    limit: VERTICES_MAX,
                });
            }
            for vertex in pieces {
                let last = ring.vertices[ring.vertices.len() - 1];
                if last.distance_m(vertex) > EDGE_THICKNESS_M {
                    ring.vertices.push(vertex);
                    ring.numbers.push(number);
                }
            }
        }
        // The last vertex is the first one again. Repetitions of it before the end are removed.
        let first = ring.vertices[0];
        while ring.vertices.len() > 1 && ring.vertices[ring.vertices.len() - 1].distance_m(first) <= EDGE_THICKNESS_M {
            ring.vertices.pop();
        }
        ring.vertices.push(first);
        ring.numbers.truncate(ring.vertices.len() - 1);
        Ok(ring)
    }

    fn refuse_spikes(&self, polygon: &Polygon, place: Placer<'_>) -> Result<(), FenceError> {
        for (index, ring) in polygon.rings().enumerate() {
            let edges = ring.len() - 1;
            for vertex in 0..edges {
                let before = ring[if vertex == 0 { edges - 1 } else { vertex - 1 }];
                let incoming = vector(ring[vertex]) - vector(before);
                let outgoing = vector(ring[vertex + 1]) - vector(ring[vertex]);
                let sine = incoming.perp_dot(outgoing).abs() / (incoming.length() * outgoing.length());
                if incoming.dot(outgoing) < 0.0 && sine < SHARPEST_RAD {
                    let (latitude, longitude) = self.degrees(vector(ring[vertex]));
                    let vertex = polygon.vertex_number(index, vertex);
                    return Err(FenceError::Spike {
                        place: place(index),
                        vertex,
                        latitude,
                        longitude,
                    });
                }
            }
        }
        Ok(())
    }

    fn refuse_crossings(&self, polygon: &Polygon, place: Placer<'_>) -> Result<(), FenceError> {
        let Some((first, second, at)) = polygon.crossing() else {
            return Ok(());
        };
        let (latitude, longitude) = self.degrees(at);
        let ((ring, edge), (other, other_edge)) = (polygon.locate(first), polygon.locate(second));
        // In a ring that was reversed, the edge with the higher number comes first.
        let swap = ring == other && edge > other_edge;
        let (edge, other_edge) = if swap { (other_edge, edge) } else { (edge, other_edge) };
        let other = if ring == other {
            String::new()
        } else {
            format!("{} ", place(other).ring())
        };
        Err(FenceError::Crossing {
            place: place(ring),
            edge,
            other,
            other_edge,
            latitude,
            longitude,
        })
    }

    fn degrees(&self, point: Vector) -> (f64, f64) {
        let position = self.frame.to_position(EastNorth::new(point.x, point.y));
        (position.latitude.as_deg(), position.longitude.as_deg())
    }
}

impl Polygon {
    /// Two edges that cross, or come within an edge's thickness of each other without sharing a vertex, and the place.
    pub(crate) fn crossing(&self) -> Option<(u32, u32, Vector)> {
        for (first, last) in self.ring_edges() {
            for edge in first..=last {
                let probe = ConvexProbe::new(&self.ends(edge));
                let near = self.segment(edge).local_aabb().loosened(EDGE_THICKNESS_M);
                let touches = |other: &u32| {
                    let neighbours = *other <= edge + 1 || (edge == first && *other == last);
                    !neighbours && probe.contact(&self.segment(*other)).distance_m() <= EDGE_THICKNESS_M
                };
                if let Some(other) = self.edges_in(near).filter(touches).min() {
                    return Some((edge, other, probe.contact(&self.segment(other)).at));
                }
            }
        }
        None
    }
}

/// The vertices, after the first, of an edge that follows the straight line of longitude and latitude.
pub(crate) fn divided(
    frame: &LocalFrame,
    a: Position,
    b: Position,
) -> impl ExactSizeIterator<Item = EastNorth> + use<'_> {
    let (from, to) = (frame.to_local(a), frame.to_local(b));
    let middle = frame.to_local(between(a, b, 0.5));
    let sagitta_m = middle.distance_m((from + to) * 0.5);
    // Each half has a quarter of the sagitta.
    let pieces = (sagitta_m / SAGITTA_M).sqrt().ceil().max(1.0) as u32;
    (0..pieces).map(move |piece| {
        if piece + 1 == pieces {
            to
        } else {
            frame.to_local(between(a, b, f64::from(piece + 1) / f64::from(pieces)))
        }
    })
}

/// The position at a fraction of the straight line in longitude and latitude.
fn between(a: Position, b: Position, fraction: f64) -> Position {
    let mix = |a: f64, b: f64| a + (b - a) * fraction;
    let latitude = mix(a.latitude.as_deg(), b.latitude.as_deg());
    let longitude = mix(a.longitude.as_deg(), b.longitude.as_deg());
    Position::from_deg(latitude, longitude).unwrap_or(a)
}

/// Whether a closed ring has no width.
fn on_one_line(vertices: &[EastNorth]) -> bool {
    let first = vertices[0];
    let farthest = vertices.iter().fold(first, |farthest, vertex| {
        if vertex.distance_m(first) > farthest.distance_m(first) {
            *vertex
        } else {
            farthest
        }
    });
    let line = vector(farthest) - vector(first);
    let length = line.length();
    vertices
        .iter()
        .all(|vertex| line.perp_dot(vector(*vertex) - vector(first)).abs() <= EDGE_THICKNESS_M * length)
}

/// The area of a closed ring, positive if it runs counterclockwise.
fn signed_area_m2(vertices: &[EastNorth]) -> f64 {
    let first = vector(vertices[0]);
    vertices
        .windows(2)
        .map(|ends| (vector(ends[0]) - first).perp_dot(vector(ends[1]) - first))
        .sum::<f64>()
        / 2.0
}

/// Refuses holes that are outside the outer ring or inside another hole. No two rings touch, so one vertex decides.
fn refuse_stray_holes(polygon: &Polygon, place: Placer<'_>) -> Result<(), FenceError> {
    let rings: Vec<_> = polygon.rings().map(|ring| (line(ring), bounds(ring))).collect();
    let encloses = |ring: &LineString, vertex: Coord| coord_pos_relative_to_ring(vertex, ring) == CoordPos::Inside;
    for (index, (ring, _)) in rings.iter().enumerate().skip(1) {
        let vertex = ring.0[0];
        if !encloses(&rings[0].0, vertex) {
            return Err(FenceError::HoleOutside { place: place(index) });
        }
        for (outer, (other, (min, max))) in rings.iter().enumerate().skip(1) {
            let in_box = min.x <= vertex.x && vertex.x <= max.x && min.y <= vertex.y && vertex.y <= max.y;
            if outer != index && in_box && encloses(other, vertex) {
                return Err(FenceError::HoleInHole {
                    place: place(index),
                    outer,
                });
            }
        }
    }
    Ok(())
}

/// A polygon in geo's type.
pub(crate) fn geometry(polygon: &Polygon) -> geo::Polygon {
    let mut rings = polygon.rings().map(line);
    let outer = rings.next().unwrap_or_else(LineString::empty);
    geo::Polygon::new(outer, rings.collect())
}

fn line(ring: &[EastNorth]) -> LineString {
    ring.iter().map(|point| (point.east_m, point.north_m)).collect()
}

/// A lower bound of the width in every direction, and so of [`width_bound_m`]: a shape's area is at most its width
/// times its length.
fn least_width_m(polygon: &Polygon) -> f64 {
    area_m2(polygon) / (polygon.max - polygon.min).length()
}

fn area_m2(polygon: &Polygon) -> f64 {
    polygon.rings().map(signed_area_m2).sum()
}

/// An upper bound of the diameter of the widest circle inside: the smaller of the least width in some directions and
/// the diameter of the circle with the same area. It is cheap rather than exact: it finds a margin that was typed in
/// the wrong unit.
fn width_bound_m(polygon: &Polygon) -> f64 {
    let round_m = 2.0 * (area_m2(polygon).max(0.0) / core::f64::consts::PI).sqrt();
    let outer = polygon.rings().next().unwrap_or_default();
    let mut narrowest = (f64::INFINITY, 90.0);
    // All directions in steps of 10 degrees, then finer and finer steps about the best one: a long strip is wide even a
    // little off its own direction.
    for step_deg in [10.0, 2.0, 0.4, 0.08, 0.016] {
        let middle_deg = narrowest.1;
        for step in -9..=9 {
            let direction_deg: f64 = middle_deg + f64::from(step) * step_deg;
            let width_m = width_m(outer, direction_deg);
            if width_m < narrowest.0 {
                narrowest = (width_m, direction_deg);
            }
        }
    }
    round_m.min(narrowest.0)
}

/// The width of a ring in a direction.
fn width_m(ring: &[EastNorth], direction_deg: f64) -> f64 {
    let (sin, cos) = backseat_units::math::sin_cos(direction_deg.to_radians());
    let (min, max) = ring
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(min, max), point| {
            let at = cos * point.east_m + sin * point.north_m;
            (at.min(min), at.max(max))
        });
    max - min
}
