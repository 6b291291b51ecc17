use core::fmt;
use std::sync::Arc;

use backseat_units::{EastNorth, LocalFrame, Utc};
use parry2d_f64::bounding_volume::Aabb;
use parry2d_f64::math::Vector;
use parry2d_f64::partitioning::{Bvh, BvhBuildStrategy, BvhLeafCost, BvhNode};

use crate::distance::{AnyProbe, PointProbe, Probe, east_north, vector};
use crate::error::FenceError;
use crate::polygon::Polygon;
use crate::question::{EDGE_THICKNESS_M, LIMIT_M, Question, unusable, unusable_span, unusable_vertical};
use crate::sweep::{Sweep, VerticalExtent};
use crate::terms::Terms;
use crate::verdict::{Breach, Cause, Clearance, EdgeId, EdgeInfo, Rule};
use crate::window::{Span, Window};
use crate::zone::{Kind, Zone};

/// Where the vehicle may be. Immutable, cheap to clone, shared between threads.
#[derive(Clone)]
pub struct Fence {
    map: Arc<Map>,
}

impl fmt::Debug for Fence {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names = self.zones().map(Zone::name).collect::<Vec<_>>();
        f.debug_struct("Fence")
            .field("frame", self.frame())
            .field("zones", &names)
            .finish()
    }
}

/// What a fence is made of; breaches keep it, so that their text can be made when it is wanted.
pub(crate) struct Map {
    pub(crate) frame: LocalFrame,
    pub(crate) zones: Vec<Zone>,
    /// Zone and polygon.
    inclusions: Vec<(u32, u32)>,
    /// Zone and polygon.
    exclusions: Vec<(u32, u32)>,
    /// Over the exclusions' bounding boxes, each grown by its margin.
    exclusion_tree: Bvh,
}

impl Fence {
    /// Reads a fence; the crate's front page tells its form.
    ///
    /// # Errors
    /// The first fault that is found, with the feature, the ring and the vertex or key, and what was expected.
    pub fn from_geojson(text: &str) -> Result<Self, FenceError> {
        crate::load::geojson(text).map(Self::new)
    }

    /// Reads the `geoFence` of a plan file of QGroundControl: its polygons and circles, named `polygon 1` and so on in
    /// the order of the file. What such a file cannot say, `terms` say.
    ///
    /// # Errors
    /// As [`Fence::from_geojson`].
    pub fn from_plan(text: &str, terms: &Terms) -> Result<Self, FenceError> {
        crate::load::plan(text, terms).map(Self::new)
    }

    /// Reads the placemarks of a KML file (OGC 12-007r2): `Polygon` and `MultiGeometry` of them, `Point` as a circle and
    /// `LineString` as a corridor. The placemark's name is the zone's; its `ExtendedData` bear the other properties, under
    /// the keys of the GeoJSON form, of which `kind` must be there, and a `TimeSpan` is its window. What else is
    /// absent, `terms` say.
    ///
    /// # Errors
    /// As [`Fence::from_geojson`], with the line of the placemark.
    pub fn from_kml(text: &str, terms: &Terms) -> Result<Self, FenceError> {
        crate::load::kml(text, terms).map(Self::new)
    }

    fn new((frame, zones): (LocalFrame, Vec<Zone>)) -> Self {
        Self {
            map: Arc::new(Map::new(frame, zones)),
        }
    }

    /// The plane of all shapes that this fence checks, around the centroid of its inclusion zones.
    #[must_use]
    pub fn frame(&self) -> &LocalFrame {
        &self.map.frame
    }

    /// The zones in the order of the file.
    pub fn zones(&self) -> impl Iterator<Item = &Zone> {
        self.map.zones.iter()
    }

    /// What an edge of this fence is in the terms of its file; none for an edge that this fence does not have.
    #[must_use]
    pub fn describe_edge(&self, edge: EdgeId) -> Option<EdgeInfo<'_>> {
        let polygon = self
            .map
            .zones
            .get(edge.zone as usize)?
            .polygons
            .get(edge.polygon as usize)?;
        polygon.has_edge(edge.edge).then(|| self.map.describe(edge))
    }

    /// Judges everything that the vehicle may touch.
    ///
    /// # Errors
    /// The [`Breach`]: what does not hold, by how many metres, and where. Where no inclusion zone holds, it is told of
    /// the one whose worst fault is the smallest.
    pub fn check(&self, sweep: &Sweep, vertical: &VerticalExtent) -> Result<Clearance, Breach> {
        self.ask(sweep, vertical, None, false, None)
    }

    /// Whether any zone is valid for a time only, so that the answers depend on when.
    #[must_use]
    pub fn changes(&self) -> bool {
        self.zones().any(|zone| zone.window() != Window::default())
    }

    /// Whether a zone begins or ceases to be valid within a stretch of time, both ends included.
    #[must_use]
    pub fn changes_within(&self, span: Span) -> bool {
        let within = |at: Option<Utc>| at.is_some_and(|at| span.from <= at && at <= span.until);
        self.zones()
            .any(|zone| within(zone.window().from) || within(zone.window().until))
    }

    /// The fence as it is in a stretch of time: [`Fence::check`] and its sisters know no time, and take every zone that
    /// is not always valid at its worst.
    #[must_use]
    pub fn during(&self, span: Span) -> FenceDuring<'_> {
        FenceDuring { fence: self, span }
    }

    /// Judges a place where the vehicle comes up to the surface: as [`Fence::check`], but only inclusion zones with
    /// `surfacing` can hold it, their `depth_min_m` does not count, and exclusion zones count from the surface down to
    /// the extent's deepest, whatever its shallowest is.
    ///
    /// # Errors
    /// The [`Breach`]; [`Rule::Surfacing`] where no zone that allows surfacing holds the sweep.
    pub fn check_surfacing(&self, sweep: &Sweep, vertical: &VerticalExtent) -> Result<Clearance, Breach> {
        self.ask(sweep, vertical, None, true, None)
    }

    /// As [`Fence::check`], of a way on which the vehicle may come to other depths than those of the extent, which are not
    /// the asker's affair: from and to, metres. Exclusion zones count at all of them, inclusion zones by the extent alone.
    ///
    /// # Errors
    /// As [`Fence::check`]; [`Rule::NotFinite`] too where a depth is no number.
    pub fn check_passing(
        &self,
        sweep: &Sweep,
        vertical: &VerticalExtent,
        depths_m: [f64; 2],
    ) -> Result<Clearance, Breach> {
        self.ask(sweep, vertical, Some(depths_m), false, None)
    }

    fn ask(
        &self,
        sweep: &Sweep,
        vertical: &VerticalExtent,
        depths_m: Option<[f64; 2]>,
        surfacing: bool,
        span: Option<Span>,
    ) -> Result<Clearance, Breach> {
        if depths_m.is_some_and(|depths_m| !depths_m.iter().all(|metres| metres.abs() <= LIMIT_M)) {
            return Err(self.map.unusable("depth that may be passed"));
        }
        if let Some(time) = unusable_span(span) {
            return Err(self.map.unusable(time));
        }
        if let Some(number) = unusable(sweep).or_else(|| unusable_vertical(vertical)) {
            return Err(self.map.unusable(number));
        }
        let mut passed = *vertical;
        if surfacing {
            passed.depth_min_m = passed.depth_min_m.min(0.0);
            passed.depth_max_m = passed.depth_max_m.max(0.0);
        }
        let [from_m, to_m] = depths_m.unwrap_or([passed.depth_min_m, passed.depth_max_m]);
        let question = Question {
            radius_m: sweep.radius_m,
            passed_m: [passed.depth_min_m.min(from_m), passed.depth_max_m.max(to_m)],
            vertical: Some(passed),
            surfacing,
            span,
        };
        match AnyProbe::new(&sweep.shape) {
            AnyProbe::Point(probe) => self.map.judge(&probe, question),
            AnyProbe::Leg(probe) => self.map.judge(&probe, question),
            AnyProbe::Solid(probe) => self.map.judge(&probe, question),
            AnyProbe::Rim(probe) => self.map.judge(&probe, question),
        }
    }

    /// Judges a bare position: no radius, no margins, no depth. Exclusion zones count at whatever depth they have.
    ///
    /// # Errors
    /// [`Rule::Inclusion`], [`Rule::Exclusion`] or [`Rule::NotFinite`]; an edge itself is outside of what it bounds.
    pub fn contains(&self, point: EastNorth) -> Result<Clearance, Breach> {
        self.holds(point, None)
    }

    fn holds(&self, point: EastNorth, span: Option<Span>) -> Result<Clearance, Breach> {
        if let Some(time) = unusable_span(span) {
            return Err(self.map.unusable(time));
        }
        if !(point.east_m.abs() <= LIMIT_M && point.north_m.abs() <= LIMIT_M) {
            return Err(self.map.unusable("point"));
        }
        self.map.judge(
            &PointProbe(vector(point)),
            Question {
                radius_m: 0.0,
                vertical: None,
                passed_m: [0.0; 2],
                surfacing: false,
                span,
            },
        )
    }
}

/// A fence in a stretch of time ([`Fence::during`]).
#[derive(Clone, Copy, Debug)]
pub struct FenceDuring<'a> {
    fence: &'a Fence,
    span: Span,
}

impl FenceDuring<'_> {
    /// As [`Fence::check`], with the zones that are valid then.
    ///
    /// # Errors
    /// The [`Breach`]; [`Rule::Closed`] where the zone that would hold is not valid throughout.
    pub fn check(&self, sweep: &Sweep, vertical: &VerticalExtent) -> Result<Clearance, Breach> {
        self.fence.ask(sweep, vertical, None, false, Some(self.span))
    }

    /// As [`Fence::check_passing`], with the zones that are valid then.
    ///
    /// # Errors
    /// As [`Fence::check_passing`]; [`Rule::Closed`] where the zone that would hold is not valid throughout.
    pub fn check_passing(
        &self,
        sweep: &Sweep,
        vertical: &VerticalExtent,
        depths_m: [f64; 2],
    ) -> Result<Clearance, Breach> {
        self.fence.ask(sweep, vertical, Some(depths_m), false, Some(self.span))
    }

    /// As [`Fence::check_surfacing`], with the zones that are valid then.
    ///
    /// # Errors
    /// The [`Breach`]; [`Rule::Closed`] where the zone that would hold is not valid throughout.
    pub fn check_surfacing(&self, sweep: &Sweep, vertical: &VerticalExtent) -> Result<Clearance, Breach> {
        self.fence.ask(sweep, vertical, None, true, Some(self.span))
    }

    /// As [`Fence::contains`], with the zones that are valid then.
    ///
    /// # Errors
    /// The [`Breach`]; [`Rule::Closed`] where the zone that would hold is not valid throughout.
    pub fn contains(&self, point: EastNorth) -> Result<Clearance, Breach> {
        self.fence.holds(point, Some(self.span))
    }
}

/// A fault that was found, before it becomes a [`Breach`].
#[derive(Clone, Copy)]
struct Fault {
    rule: Rule,
    metres: f64,
    edge: EdgeId,
    at: Vector,
}

/// What an exclusion leaves of the clearance, and its edge that does so.
#[derive(Clone, Copy)]
struct Room {
    metres: f64,
    edge: u32,
}

impl BvhLeafCost for Room {
    fn cost(&self) -> f64 {
        self.metres
    }
}

impl Map {
    pub(crate) fn new(frame: LocalFrame, zones: Vec<Zone>) -> Self {
        let (mut inclusions, mut exclusions, mut boxes) = (Vec::new(), Vec::new(), Vec::new());
        for (zone, index) in zones.iter().zip(0..) {
            for (polygon, part) in zone.polygons.iter().zip(0..) {
                match zone.kind {
                    Kind::Inclusion { .. } => inclusions.push((index, part)),
                    Kind::Exclusion { .. } => {
                        exclusions.push((index, part));
                        let margin = Vector::splat(zone.margin_m.max(EDGE_THICKNESS_M));
                        boxes.push(Aabb::new(polygon.min - margin, polygon.max + margin));
                    }
                }
            }
        }
        let exclusion_tree = Bvh::from_leaves(BvhBuildStrategy::Binned, &boxes);
        Self {
            frame,
            zones,
            inclusions,
            exclusions,
            exclusion_tree,
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

    fn part(&self, (zone, polygon): (u32, u32)) -> (&Zone, &Polygon) {
        let zone = &self.zones[zone as usize];
        (zone, &zone.polygons[polygon as usize])
    }

    fn judge<P: Probe>(self: &Arc<Self>, probe: &P, question: Question) -> Result<Clearance, Breach> {
        let mut best: Option<Clearance> = None;
        for &part in &self.inclusions {
            let (zone, polygon) = self.part(part);
            // What leaves the bounding box leaves the polygon, and most zones are told apart by that alone.
            let in_box = probe.min().cmpge(polygon.min).all() && probe.max().cmple(polygon.max).all();
            if !in_box || !question.may_hold(zone) || !question.is_open(zone) || question.vertical_fault(zone).is_some()
            {
                continue;
            }
            let Some((edge, contact)) = polygon.nearest(probe, f64::INFINITY) else {
                continue;
            };
            let reach_m = question.reach_m(zone);
            let spare_m = contact.distance_m - reach_m;
            if contact.distance_m >= reach_m
                && best.is_none_or(|best| spare_m > best.metres)
                && polygon.is_inside(edge, &contact)
            {
                best = Some(Clearance {
                    metres: spare_m,
                    edge: EdgeId {
                        zone: part.0,
                        polygon: part.1,
                        edge,
                    },
                });
            }
        }
        let Some(inside) = best else {
            return Err(self.outside(probe, question));
        };
        let Some((exclusion, room)) = self.nearest_exclusion(probe, question, inside.metres) else {
            return Ok(inside);
        };
        let part = self.exclusions[exclusion as usize];
        if room.metres < 0.0 {
            return Err(self.breach(self.exclusion_fault(probe, question, part)));
        }
        Ok(Clearance {
            metres: room.metres,
            edge: EdgeId {
                zone: part.0,
                polygon: part.1,
                edge: room.edge,
            },
        })
    }

    /// The exclusion that leaves the least room, where that is less than `below_m`; negative where it is breached.
    fn nearest_exclusion<P: Probe>(&self, probe: &P, question: Question, below_m: f64) -> Option<(u32, Room)> {
        if self.exclusions.is_empty() {
            return None;
        }
        self.exclusion_tree.find_best(
            // Equal room on both sides is told of the inclusion.
            below_m,
            |node: &BvhNode, _| {
                let d2 = probe.box_d2(node.mins(), node.maxs(), f64::INFINITY);
                if d2 > 0.0 {
                    d2.sqrt() - question.radius_m
                } else {
                    f64::MIN
                }
            },
            |index, best_m| {
                let (zone, polygon) = self.part(self.exclusions[index as usize]);
                if !question.meets(zone) {
                    return None;
                }
                let reach_m = question.reach_m(zone);
                // Around a shape beside the bounding box only edges near enough to matter are looked for; one within
                // it may lie far inside, with its nearest edge far away.
                let beside = probe.box_d2(polygon.min, polygon.max, f64::INFINITY) > 0.0;
                let room_m = best_m + reach_m;
                let below_m2 = if beside { room_m * room_m } else { f64::INFINITY };
                let nearest = polygon.nearest(probe, below_m2);
                let (edge, metres) = match nearest {
                    Some((edge, contact)) if beside || !polygon.is_inside(edge, &contact) => {
                        let spare_m = contact.distance_m - reach_m;
                        (
                            edge,
                            if contact.distance_m >= reach_m {
                                spare_m.max(0.0)
                            } else {
                                spare_m
                            },
                        )
                    }
                    Some((edge, contact)) => (edge, -reach_m - contact.distance_m),
                    None if beside => return None,
                    // A distance that is no number never passes.
                    None => (0, f64::MIN),
                };
                Some(Room { metres, edge })
            },
        )
    }

    #[cold]
    fn outside<P: Probe>(self: &Arc<Self>, probe: &P, question: Question) -> Breach {
        let (mut least, mut closed): (Option<Fault>, Option<Fault>) = (None, None);
        for &part in &self.inclusions {
            let (zone, _) = self.part(part);
            if !question.may_hold(zone) {
                continue;
            }
            let mut fault = self.inclusion_fault(probe, question, part);
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
            // A fence without inclusion zones is refused at load; it has none that allows surfacing.
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

    /// How far the sweep is from holding in one polygon; metres may be zero or less where it holds.
    fn inclusion_fault<P: Probe>(&self, probe: &P, question: Question, part: (u32, u32)) -> Fault {
        let (zone, polygon) = self.part(part);
        let reach_m = question.reach_m(zone);
        let mut worst = (0, polygon.min, f64::INFINITY);
        if let Some((edge, contact)) = polygon.nearest(probe, f64::INFINITY) {
            let inside = contact.distance_m > 0.0 && polygon.is_inside(edge, &contact);
            worst = (
                edge,
                contact.at,
                if inside {
                    -contact.distance_m
                } else {
                    contact.distance_m
                },
            );
            if !inside {
                let (samples, len) = probe.samples();
                for &sample in &samples[..len] {
                    let outside = polygon.outside_m(sample);
                    if outside.2 > worst.2 {
                        worst = outside;
                    }
                }
            }
        }
        let (edge, at, outside_m) = worst;
        let edge = EdgeId {
            zone: part.0,
            polygon: part.1,
            edge,
        };
        Fault {
            rule: if question.surfacing {
                Rule::Surfacing
            } else {
                Rule::Inclusion
            },
            metres: reach_m + outside_m,
            edge,
            at,
        }
    }

    #[cold]
    fn exclusion_fault<P: Probe>(&self, probe: &P, question: Question, part: (u32, u32)) -> Fault {
        let (zone, polygon) = self.part(part);
        let reach_m = question.reach_m(zone);
        let mut deepest = (0, polygon.min, f64::INFINITY);
        if let Some((edge, contact)) = polygon.nearest(probe, f64::INFINITY) {
            let inside = contact.distance_m > 0.0 && polygon.is_inside(edge, &contact);
            deepest = (
                edge,
                contact.at,
                if inside {
                    contact.distance_m
                } else {
                    -contact.distance_m
                },
            );
            if contact.distance_m == 0.0 || inside {
                let (samples, len) = probe.samples();
                for &sample in &samples[..len] {
                    let (edge, at, outside_m) = polygon.outside_m(sample);
                    if -outside_m > deepest.2 {
                        deepest = (edge, at, -outside_m);
                    }
                }
            }
        }
        let (edge, at, inside_m) = deepest;
        let edge = EdgeId {
            zone: part.0,
            polygon: part.1,
            edge,
        };
        Fault {
            rule: Rule::Exclusion,
            metres: reach_m + inside_m,
            edge,
            at,
        }
    }

    fn breach(self: &Arc<Self>, fault: Fault) -> Breach {
        let Fault { rule, metres, edge, at } = fault;
        let cause = Cause::Zone(edge.zone);
        Breach {
            rule,
            metres,
            edge: Some(edge),
            at: Some(east_north(at)),
            cause,
            map: Arc::clone(self),
        }
    }

    #[cold]
    fn unusable(self: &Arc<Self>, number: &'static str) -> Breach {
        let (rule, cause) = (Rule::NotFinite, Cause::Number(number));
        Breach {
            rule,
            metres: f64::INFINITY,
            edge: None,
            at: None,
            cause,
            map: Arc::clone(self),
        }
    }
}

#[cfg(test)]
mod tests;
