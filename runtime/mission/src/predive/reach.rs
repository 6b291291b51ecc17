//! Inclusion zones that nobody can come to: what is flown must lie in one polygon, so that the vehicle changes from one
//! to another only where they overlap.

use backseat_fence::{Fence, Kind, Zone};
use backseat_units::EastNorth;

/// Pairs of edges that are looked at; zones with more are taken to overlap where their boxes do.
const PAIRS_MAX: usize = 20_000_000;

/// A polygon of an inclusion zone: its rings, the outer one first.
struct Part<'a> {
    zone: &'a Zone,
    rings: Vec<&'a [EastNorth]>,
    min: EastNorth,
    max: EastNorth,
}

/// The zones of which no polygon holds one of the places, or overlaps one that does, however many others between.
pub(super) fn unreachable(fence: &Fence, places: &[EastNorth]) -> Vec<String> {
    let parts = parts(fence);
    let mut reached: Vec<bool> = parts
        .iter()
        .map(|part| places.iter().any(|place| part.holds(*place)))
        .collect();
    if !reached.contains(&true) {
        // The start is told of already, and all else follows from it.
        return Vec::new();
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
    let mut findings = Vec::new();
    for zone in fence.zones() {
        let of_it = || {
            parts
                .iter()
                .zip(&reached)
                .filter(|(part, _)| core::ptr::eq(part.zone, zone))
        };
        if of_it().next().is_some() && of_it().all(|(_, reached)| !reached) {
            findings.push(format!(
                "inclusion '{}': neither start nor plan comes into it, nor into a zone that overlaps it, expected one that \
                 can be reached",
                zone.name()
            ));
        }
    }
    findings
}

fn parts(fence: &Fence) -> Vec<Part<'_>> {
    let mut parts: Vec<Part<'_>> = Vec::new();
    for zone in fence.zones() {
        match zone.kind() {
            Kind::Inclusion { .. } => {}
            Kind::Exclusion { .. } => continue,
        }
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
    fn edges(&self) -> impl Iterator<Item = (EastNorth, EastNorth)> + '_ {
        self.rings
            .iter()
            .flat_map(|ring| ring.windows(2).map(|ends| (ends[0], ends[1])))
    }

    /// By the number of edges that a ray to the east crosses.
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
            || other.max.north_m < self.min.north_m;
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
