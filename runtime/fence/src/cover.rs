//! Inclusion zones that nobody can reach, as an exclusion zone covers them.

use parry2d_f64::math::Vector;

use crate::distance::{LegProbe, vector};
use crate::polygon::Polygon;
use crate::zone::{Band, Kind, Zone};

/// What is left of a zone within so much of its edge is nothing, metres: edges follow the lines of the file to a
/// centimetre, so that two along one line may lie twice that apart.
const SLACK_M: f64 = 0.02;

/// Which polygon lies in which exclusion zone, counted from 0.
pub(crate) struct Covered {
    pub(crate) inclusion: usize,
    pub(crate) polygon: usize,
    pub(crate) exclusion: usize,
}

/// The first inclusion polygon that lies wholly inside one exclusion polygon, whose zone counts wherever and whenever
/// the inclusion holds.
pub(crate) fn find(zones: &[Zone]) -> Option<Covered> {
    for (inclusion, zone) in zones.iter().enumerate() {
        for (exclusion, other) in zones.iter().enumerate() {
            if !always_counts(other, zone) {
                continue;
            }
            for (polygon, part) in zone.polygons.iter().enumerate() {
                if other.polygons.iter().any(|whole| covers(whole, part)) {
                    return Some(Covered {
                        inclusion,
                        polygon,
                        exclusion,
                    });
                }
            }
        }
    }
    None
}

/// Whether an exclusion zone counts at all depths and times of an inclusion zone.
fn always_counts(exclusion: &Zone, inclusion: &Zone) -> bool {
    let depths = match (exclusion.kind, inclusion.kind) {
        (Kind::Exclusion { depth: None }, Kind::Inclusion { .. }) => true,
        (
            Kind::Exclusion {
                depth: Some(Band { min_m, max_m }),
            },
            Kind::Inclusion { depth, .. },
        ) => min_m <= depth.min_m && max_m >= depth.max_m,
        (Kind::Inclusion { .. }, _) | (_, Kind::Exclusion { .. }) => false,
    };
    let (ours, theirs) = (exclusion.window, inclusion.window);
    let from = ours
        .from
        .is_none_or(|from| theirs.from.is_some_and(|other| from <= other));
    let until = ours
        .until
        .is_none_or(|until| theirs.until.is_some_and(|other| until >= other));
    depths && from && until
}

/// Whether one polygon lies in another: its corners do, none of its edges crosses one of the other's, and no corner of
/// the other lies inside it. Edges that lie upon each other cross nowhere. All but for the slack.
fn covers(whole: &Polygon, part: &Polygon) -> bool {
    let slack = Vector::splat(SLACK_M);
    if !(part.min + slack).cmpge(whole.min).all() || !(part.max - slack).cmple(whole.max).all() {
        return false;
    }
    let Some(outer) = part.rings().next() else {
        return false;
    };
    outer.windows(2).all(|ends| {
        let (a, b) = (vector(ends[0]), vector(ends[1]));
        whole.outside_m(a).2 <= SLACK_M && whole.outside_m((a + b) * 0.5).2 <= SLACK_M && !crosses(whole, a, b)
    }) && whole
        .rings()
        .flatten()
        .all(|corner| part.outside_m(vector(*corner)).2 >= -SLACK_M)
}

/// Whether a straight way leads from one side of an edge to the other, by more than the slack on both.
fn crosses(whole: &Polygon, a: Vector, b: Vector) -> bool {
    let mut found = false;
    whole.edges_near(&LegProbe::new(a, b), f64::MIN_POSITIVE, |edge| {
        let [c, d] = whole.ends(edge).map(vector);
        let apart = |line: Vector, from: Vector, p: Vector, q: Vector| {
            let (p, q) = (line.perp_dot(p - from), line.perp_dot(q - from));
            let thick = SLACK_M * line.length();
            (p > thick && q < -thick) || (p < -thick && q > thick)
        };
        found |= apart(b - a, a, c, d) && apart(d - c, c, a, b);
    });
    found
}
