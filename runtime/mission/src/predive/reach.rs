//! Finds keep-in zones that cannot be reached. Each behavior must lie in one polygon, so the vehicle changes from one
//! polygon to another only where they overlap, at a depth that both allow. In each polygon, the margins, the keep-out
//! zones and the water depth must leave room for the vehicle.

use backseat_core::Limits;
use backseat_fence::{Band, Fence, Kind, Shape, Sweep, VerticalExtent, Zone};
use backseat_units::EastNorth;

use super::ALTITUDE_UNKNOWN_M;

/// The most pairs of edges that are compared; zones with more pairs count as overlapping where their boxes do.
const PAIRS_MAX: usize = 20_000_000;
/// The number of positions that are tried along a polygon's edges, and on each side of a grid over it.
const ALONG_EDGES: usize = 4096;
const GRID: u32 = 48;
/// How far inside the margin a position is tried, metres.
const INSIDE_M: [f64; 2] = [0.01, 1.0];

/// A polygon of a keep-in zone: its rings, the outer one first.
struct Part<'a> {
    zone: &'a Zone,
    /// Its number within the zone, from 1.
    number: usize,
    depth: Band,
    altitude_min_m: f64,
    rings: Vec<&'a [EastNorth]>,
    min: EastNorth,
    max: EastNorth,
}

/// Polygons that contain none of the positions and are not connected by overlaps to one that does, and polygons that
/// leave no room for the vehicle.
pub(super) fn unreachable(fence: &Fence, limits: &Limits, places: &[EastNorth]) -> Vec<String> {
    let parts = parts(fence);
    let mut findings: Vec<String> = parts
        .iter()
        .filter_map(|part| part.without_room(fence, limits))
        .collect();
    let mut reached: Vec<bool> = parts
        .iter()
        .map(|part| places.iter().any(|place| part.holds(*place)))
        .collect();
    if !reached.contains(&true) {
        // The start is reported already, and all else would follow from it.
        return findings;
    }
    let mut waiting: Vec<usize> = (0..parts.len()).filter(|part| reached[*part]).collect();
    while let Some(from) = waiting.pop() {
        for to in 0..parts.len() {
            if !reached[to] && parts[from].overlaps(&parts[to]) {
                reached[to] = true;
                waiting.push(to);
            }
        }
    }
    findings.extend(parts.iter().zip(reached).filter(|(_, reached)| !reached).map(|(part, _)| {
        format!(
            "{}: cannot be reached: neither start nor plan enters it, or a zone that overlaps it at a depth that \
             both allow",
            part.name()
        )
    }));
    findings
}

fn parts(fence: &Fence) -> Vec<Part<'_>> {
    let mut parts: Vec<Part<'_>> = Vec::new();
    for zone in fence.zones() {
        let (depth, altitude_min_m) = match zone.kind() {
            Kind::KeepIn {
                depth, altitude_min_m, ..
            } => (depth, altitude_min_m),
            Kind::KeepOut { .. } => continue,
        };
        for ring in zone.rings() {
            match parts.last_mut().filter(|_| ring.hole.is_some()) {
                Some(part) => part.rings.push(ring.points),
                None => {
                    let extreme = |pick: fn(f64, f64) -> f64| {
                        let first = ring.points.first().copied().unwrap_or_default();
                        ring.points.iter().fold(first, |all, point| {
                            EastNorth::new(pick(all.east_m, point.east_m), pick(all.north_m, point.north_m))
                        })
                    };
                    parts.push(Part {
                        zone,
                        number: ring.polygon,
                        depth,
                        altitude_min_m,
                        rings: vec![ring.points],
                        min: extreme(f64::min),
                        max: extreme(f64::max),
                    });
                }
            }
        }
    }
    parts
}

impl Part<'_> {
    fn name(&self) -> String {
        let several = self.zone.rings().any(|ring| ring.polygon > 1);
        let number = if several {
            format!(" polygon {}", self.number)
        } else {
            String::new()
        };
        format!("keep-in zone '{}'{number}", self.zone.name())
    }

    /// What leaves no room in the polygon, if anything does. This is not checked where zones change with time.
    fn without_room(&self, fence: &Fence, limits: &Limits) -> Option<String> {
        if let Some(deepest_m) = limits.water_depth_max_m
            && self.depth.min_m + self.altitude_min_m > deepest_m
        {
            return Some(format!(
                "{}: depth_min_m {} and altitude_min_m {} need more water than limits.water_depth_max_m of \
                 {deepest_m}, expected room between them",
                self.name(),
                self.depth.min_m,
                self.altitude_min_m
            ));
        }
        let Band { min_m, max_m } = self.depth;
        let free = |at: EastNorth| {
            [f64::midpoint(min_m, max_m), min_m, max_m].into_iter().any(|depth_m| {
                let extent = VerticalExtent {
                    depth_min_m: depth_m,
                    depth_max_m: depth_m,
                    altitude_min_m: ALTITUDE_UNKNOWN_M,
                };
                fence.check(&Sweep::new(Shape::point(at), 0.0), &extent).is_ok()
            })
        };
        let none = !fence.changes() && !self.tried().any(|at| free(at) && self.holds(at));
        none.then(|| {
            format!(
                "{}: its margin of {} m and the keep-out zones leave no room for the vehicle in it",
                self.name(),
                self.zone.margin_m()
            )
        })
    }

    /// Positions in the polygon that are tried: on a grid, and along the edges, where the narrowest room is.
    fn tried(&self) -> impl Iterator<Item = EastNorth> + '_ {
        let edges = self.edges().count().max(1);
        let (every, each) = (edges.div_ceil(ALONG_EDGES), (ALONG_EDGES / edges).clamp(1, 64));
        let along = self.edges().step_by(every).flat_map(move |(a, b)| {
            let (length_m, bearing_deg) = (a.distance_m(b), a.bearing_deg(b));
            (0..each).flat_map(move |index| {
                let on = a.offset(bearing_deg, length_m * (index as f64 + 0.5) / each as f64);
                // The inside is on the left: outer rings run counterclockwise, holes clockwise.
                INSIDE_M.map(|inside_m| on.offset(bearing_deg - 90.0, self.zone.margin_m() + inside_m))
            })
        });
        let size = self.max - self.min;
        let grid = (0..GRID).flat_map(move |row| {
            (0..GRID).map(move |column| {
                let part = |index: u32| (f64::from(index) + 0.5) / f64::from(GRID);
                EastNorth::new(
                    self.min.east_m + size.east_m * part(column),
                    self.min.north_m + size.north_m * part(row),
                )
            })
        });
        grid.chain(along)
    }

    fn edges(&self) -> impl Iterator<Item = (EastNorth, EastNorth)> + '_ {
        self.rings
            .iter()
            .flat_map(|ring| ring.windows(2).map(|ends| (ends[0], ends[1])))
    }

    /// Whether a point is inside, by the number of edges that a ray to the east crosses.
    fn holds(&self, at: EastNorth) -> bool {
        let crossed = self.edges().filter(|(a, b)| {
            let spans = (a.north_m > at.north_m) != (b.north_m > at.north_m);
            let along = (at.north_m - a.north_m) / (b.north_m - a.north_m);
            spans && a.east_m + along * (b.east_m - a.east_m) > at.east_m
        });
        crossed.count() % 2 == 1
    }

    fn overlaps(&self, other: &Self) -> bool {
        let apart = self.max.east_m < other.min.east_m
            || other.max.east_m < self.min.east_m
            || self.max.north_m < other.min.north_m
            || other.max.north_m < self.min.north_m
            || self.depth.max_m < other.depth.min_m
            || other.depth.max_m < self.depth.min_m;
        if apart {
            return false;
        }
        let (ours, theirs) = (self.edges().count(), other.edges().count());
        ours.saturating_mul(theirs) > PAIRS_MAX
            || self.rings[0].iter().any(|corner| other.holds(*corner))
            || other.rings[0].iter().any(|corner| self.holds(*corner))
            || self.edges().any(|edge| other.edges().any(|across| cross(edge, across)))
    }
}

fn cross((a, b): (EastNorth, EastNorth), (c, d): (EastNorth, EastNorth)) -> bool {
    let side = |from: EastNorth, to: EastNorth, point: EastNorth| {
        let (along, aside) = (to - from, point - from);
        along.east_m * aside.north_m - along.north_m * aside.east_m
    };
    side(a, b, c) * side(a, b, d) < 0.0 && side(c, d, a) * side(c, d, b) < 0.0
}
