//! The data of a fence, the one index of all its zones, and the judgement of a question.
//!
//! The index has two levels, both parry's `Bvh`: one over the polygons of all zones, keep-in and keep-out, and in each
//! polygon one over its edges. A search passes what it has found so far from the first level to the second, so it looks
//! at no edge that is too far away to matter.

use std::sync::Arc;

use backseat_units::LocalFrame;
use parry2d_f64::bounding_volume::Aabb;
use parry2d_f64::math::Vector;
use parry2d_f64::partitioning::{Bvh, BvhBuildStrategy, BvhLeafCost, BvhNode};

use crate::distance::{Probe, east_north};
use crate::polygon::Polygon;
use crate::question::{EDGE_THICKNESS_M, Question};
use crate::verdict::{Breach, Cause, Clearance, EdgeId, EdgeInfo, Rule};
use crate::zone::{Kind, Zone};

/// The data of a fence. Breaches keep it, so that their text can be made when it is needed.
pub(crate) struct Map {
    pub(crate) frame: LocalFrame,
    pub(crate) zones: Vec<Zone>,
    /// All polygons: the zone, and the polygon of the zone.
    parts: Vec<(u32, u32)>,
    /// The tree over the bounding boxes of `parts`, each grown by the zone's margin.
    tree: Bvh,
}

/// How far beyond margin and radius the nearest edge is searched for, metres. Whether a sweep keeps the fence does not
/// depend on more, and far from a long coast, much of which is at about the same distance, the search for the nearest
/// edge takes long.
pub(crate) const CLEARANCE_MAX_M: f64 = 1000.0;

/// A fault that was found, before it becomes a [`Breach`].
#[derive(Clone, Copy)]
struct Fault {
    rule: Rule,
    metres: f64,
    edge: EdgeId,
    at: Vector,
}

impl BvhLeafCost for Clearance {
    fn cost(&self) -> f64 {
        self.metres
    }
}

impl Map {
    pub(crate) fn new(frame: LocalFrame, zones: Vec<Zone>) -> Self {
        let (mut parts, mut boxes) = (Vec::new(), Vec::new());
        for (zone, index) in zones.iter().zip(0..) {
            for (polygon, part) in zone.polygons.iter().zip(0..) {
                let margin = Vector::splat(zone.margin_m.max(EDGE_THICKNESS_M));
                parts.push((index, part));
                boxes.push(Aabb::new(polygon.min - margin, polygon.max + margin));
            }
        }
        Self {
            frame,
            zones,
            parts,
            tree: Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes),
        }
    }

    /// An edge that is known to exist.
    pub(crate) fn describe(&self, edge: EdgeId) -> EdgeInfo<'_> {
        let zone = &self.zones[edge.zone as usize];
        let polygon = &zone.polygons[edge.polygon as usize];
        let (ring, number) = polygon.locate(edge.edge);
        EdgeInfo {
            zone: &zone.name,
            polygon: edge.polygon as usize + 1,
            hole: (ring > 0).then_some(ring),
            number,
            ends: polygon.ends(edge.edge),
        }
    }

    /// The zone and the polygon of a leaf, and a function that makes the identifier of one of its edges.
    fn part(&self, leaf: u32) -> (&Zone, &Polygon, impl Fn(u32) -> EdgeId + use<>) {
        let (zone, polygon) = self.parts[leaf as usize];
        let edge = move |edge| EdgeId { zone, polygon, edge };
        let zone = &self.zones[zone as usize];
        (zone, &zone.polygons[polygon as usize], edge)
    }

    /// Judges a shape. If no edge of a polygon is near the shape, the whole shape is on one side of the polygon, and
    /// one point of the shape shows on which.
    pub(crate) fn judge<P: Probe>(self: &Arc<Self>, probe: &P, question: Question) -> Result<Clearance, Breach> {
        let Some(inside) = self.roomiest_keep_in(probe, question) else {
            return Err(self.outside(probe, question));
        };
        // If keep-in and keep-out zones leave equal room, the clearance names the keep-in zone.
        match self.nearest_keep_out(probe, question, inside.metres) {
            None => Ok(inside),
            Some((_, clearance)) if clearance.metres >= 0.0 => Ok(clearance),
            Some((leaf, _)) => Err(self.breach(self.fault(probe, question, leaf))),
        }
    }

    /// Of the keep-in polygons that contain the sweep, the one that leaves the most room.
    fn roomiest_keep_in<P: Probe>(&self, probe: &P, question: Question) -> Option<Clearance> {
        let (min, max) = probe.bounds();
        // A shape that leaves the bounding box leaves the polygon.
        let around = |node: &BvhNode| min.cmpge(node.mins()).all() && max.cmple(node.maxs()).all();
        let mut roomiest: Option<Clearance> = None;
        for leaf in self.tree.leaves(around) {
            let (zone, polygon, edge_id) = self.part(leaf);
            let holds = question.may_hold(zone) && question.is_open(zone) && question.vertical_fault(zone).is_none();
            if !holds || !polygon.contains(probe.witness()) {
                continue;
            }
            let reach_m = question.reach_m(zone);
            let nearest = polygon.nearest(probe, reach_m + CLEARANCE_MAX_M);
            let found = Clearance {
                metres: nearest.map_or(CLEARANCE_MAX_M, |(_, contact)| contact.distance_m() - reach_m),
                edge: nearest.map(|(edge, _)| edge_id(edge)),
            };
            // Of two equal ones, the first in the file.
            let first = |known: Clearance| (known.metres, found.edge) < (found.metres, known.edge);
            if found.metres >= 0.0 && roomiest.is_none_or(first) {
                roomiest = Some(found);
            }
        }
        roomiest
    }

    /// The keep-out zone that leaves the least room, if that is less than `below_m`; negative if the zone is breached.
    fn nearest_keep_out<P: Probe>(&self, probe: &P, question: Question, below_m: f64) -> Option<(u32, Clearance)> {
        let least_m = |node: &BvhNode, _| {
            let d2 = probe.box_d2(node.mins(), node.maxs(), f64::INFINITY);
            // Within its box, a shape may be far inside a polygon.
            if d2 > 0.0 {
                d2.sqrt() - question.radius_m
            } else {
                f64::MIN
            }
        };
        let room = |leaf, best_m: f64| {
            let (zone, polygon, edge_id) = self.part(leaf);
            if !question.forbids(zone) {
                return None;
            }
            let reach_m = question.reach_m(zone);
            let inside = polygon.contains(probe.witness());
            let (edge, metres) = if inside {
                // A distance of NaN never passes.
                let nearest = polygon.nearest(probe, f64::INFINITY);
                nearest.map_or((0, f64::MIN), |(edge, contact)| (edge, -contact.distance_m() - reach_m))
            } else {
                let (edge, contact) = polygon.nearest(probe, (best_m + reach_m).max(0.0))?;
                (edge, contact.distance_m() - reach_m)
            };
            Some(Clearance {
                metres,
                edge: Some(edge_id(edge)),
            })
        };
        self.tree.find_best(below_m, least_m, room)
    }

    /// The breach of the keep-in zone that comes nearest to containing the sweep.
    #[cold]
    fn outside<P: Probe>(self: &Arc<Self>, probe: &P, question: Question) -> Breach {
        let (mut least, mut closed): (Option<Fault>, Option<Fault>) = (None, None);
        for leaf in 0..self.parts.len() as u32 {
            let (zone, ..) = self.part(leaf);
            if !question.may_hold(zone) {
                continue;
            }
            let mut fault = self.fault(probe, question, leaf);
            if let Some((rule, metres)) = question.vertical_fault(zone)
                && metres > fault.metres
            {
                fault = Fault { rule, metres, ..fault };
            }
            let known = if question.is_open(zone) {
                &mut least
            } else {
                &mut closed
            };
            if known.is_none_or(|known| fault.metres < known.metres) {
                *known = Some(fault);
            }
        }
        if let Some(fault) = closed
            && (fault.metres <= 0.0 || least.is_none())
        {
            return Breach {
                rule: Rule::Closed,
                metres: f64::INFINITY,
                cause: Cause::Closed(fault.edge.zone, question.span),
                ..self.breach(fault)
            };
        }
        match least {
            Some(fault) => self.breach(fault),
            // A fence without keep-in zones is refused when it is read, so this one has none that allows surfacing.
            None => Breach {
                rule: Rule::Surfacing,
                metres: f64::INFINITY,
                edge: None,
                at: None,
                cause: Cause::NoSurfacing,
                map: Arc::clone(self),
            },
        }
    }

    /// How far the sweep is on the wrong side of one polygon's edge, metres; zero or less if it is not.
    #[cold]
    fn fault<P: Probe>(&self, probe: &P, question: Question, leaf: u32) -> Fault {
        let (zone, polygon, edge_id) = self.part(leaf);
        let (rule, sign) = match zone.kind {
            Kind::KeepOut { .. } => (Rule::KeepOut, -1.0),
            Kind::KeepIn { .. } if question.surfacing => (Rule::Surfacing, 1.0),
            Kind::KeepIn { .. } => (Rule::KeepIn, 1.0),
        };
        let (mut edge, mut at, outside_m) = polygon.beside_m(probe);
        let mut wrong_m = sign * outside_m;
        if wrong_m >= 0.0 {
            let (samples, len) = probe.samples();
            for sample in &samples[..len] {
                let (nearest, place, outside_m) = polygon.outside_m(*sample);
                if sign * outside_m > wrong_m {
                    (edge, at, wrong_m) = (nearest, place, sign * outside_m);
                }
            }
        }
        Fault {
            rule,
            metres: question.reach_m(zone) + wrong_m,
            edge: edge_id(edge),
            at,
        }
    }

    fn breach(self: &Arc<Self>, fault: Fault) -> Breach {
        let Fault { rule, metres, edge, at } = fault;
        Breach {
            rule,
            metres,
            edge: Some(edge),
            at: Some(east_north(at)),
            cause: Cause::Zone(edge.zone),
            map: Arc::clone(self),
        }
    }

    #[cold]
    pub(crate) fn unusable(self: &Arc<Self>, number: &'static str) -> Breach {
        Breach {
            rule: Rule::NotFinite,
            metres: f64::INFINITY,
            edge: None,
            at: None,
            cause: Cause::Number(number),
            map: Arc::clone(self),
        }
    }
}
