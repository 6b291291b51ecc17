//! Finds keep-in zones that nobody can reach because a keep-out zone covers them.

use geo::{Area, BooleanOps, Euclidean, Length};
use parry2d_f64::math::Vector;

use crate::outline::geometry;
use crate::polygon::Polygon;
use crate::zone::{Band, Kind, Zone};

/// A remainder of a zone within this distance of its edge counts as nothing, metres. Edges follow the lines of the file
/// to a centimetre, so two edges along one line may be twice that apart.
const SLACK_M: f64 = 0.02;

/// Which polygon of which keep-in zone lies in which keep-out zone, counted from 0.
pub(crate) struct Covered {
    pub(crate) keep_in: usize,
    pub(crate) polygon: usize,
    pub(crate) keep_out: usize,
}

/// The first keep-in polygon that lies wholly inside one keep-out polygon, whose zone counts at all depths and times at
/// which the keep-in zone is valid.
pub(crate) fn find(zones: &[Zone]) -> Option<Covered> {
    for (keep_in, zone) in zones.iter().enumerate() {
        for (keep_out, other) in zones.iter().enumerate() {
            if !always_counts(other, zone) {
                continue;
            }
            for (polygon, part) in zone.polygons.iter().enumerate() {
                if other.polygons.iter().any(|whole| covers(whole, part)) {
                    return Some(Covered {
                        keep_in,
                        polygon,
                        keep_out,
                    });
                }
            }
        }
    }
    None
}

/// Whether a keep-out zone counts at all depths and times of a keep-in zone.
fn always_counts(keep_out: &Zone, keep_in: &Zone) -> bool {
    let depths = match (keep_out.kind, keep_in.kind) {
        (Kind::KeepOut { depth: None }, Kind::KeepIn { .. }) => true,
        (
            Kind::KeepOut {
                depth: Some(Band { min_m, max_m }),
            },
            Kind::KeepIn { depth, .. },
        ) => min_m <= depth.min_m && max_m >= depth.max_m,
        (Kind::KeepIn { .. }, _) | (_, Kind::KeepOut { .. }) => false,
    };
    let (ours, theirs) = (keep_out.window, keep_in.window);
    let from = ours
        .from
        .is_none_or(|from| theirs.from.is_some_and(|other| from <= other));
    let until = ours
        .until
        .is_none_or(|until| theirs.until.is_some_and(|other| until >= other));
    depths && from && until
}

/// Whether one polygon lies in another: nothing is left of it, or only slivers about as thin as the slack.
fn covers(whole: &Polygon, part: &Polygon) -> bool {
    let slack = Vector::splat(SLACK_M);
    let in_box = (part.min + slack).cmpge(whole.min).all() && (part.max - slack).cmple(whole.max).all();
    in_box
        && geometry(part).difference(&geometry(whole)).iter().all(|left| {
            let around_m = Euclidean.length(left.exterior());
            left.unsigned_area() <= SLACK_M / 2.0 * around_m
        })
}
