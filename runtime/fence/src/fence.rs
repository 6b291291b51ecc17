use core::fmt;
use std::sync::Arc;

use backseat_units::{EastNorth, LocalFrame, Utc};

use crate::distance::{AnyProbe, ConvexProbe, vector};
use crate::error::FenceError;
use crate::map::Map;
use crate::question::{LIMIT_M, Question, unusable, unusable_span, unusable_vertical};
use crate::sweep::{Sweep, VerticalExtent};
use crate::terms::Terms;
use crate::verdict::{Breach, Clearance, EdgeId, EdgeInfo};
use crate::window::{Span, Window};
use crate::zone::Zone;

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

    /// The plane of all shapes that this fence checks, around the centroid of its keep-in zones.
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
    /// The [`Breach`]: what does not hold, by how many metres, and where. Where no keep-in zone holds, it is told of
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

    /// Judges a place where the vehicle comes up to the surface: as [`Fence::check`], but only keep-in zones with
    /// `surfacing` can hold it, their `depth_min_m` does not count, and keep-out zones count from the surface down to
    /// the extent's deepest, whatever its shallowest is.
    ///
    /// # Errors
    /// The [`Breach`]; [`Rule::Surfacing`] where no zone that allows surfacing holds the sweep.
    pub fn check_surfacing(&self, sweep: &Sweep, vertical: &VerticalExtent) -> Result<Clearance, Breach> {
        self.ask(sweep, vertical, None, true, None)
    }

    /// As [`Fence::check_surfacing`], of a path on which the vehicle may also be at other depths: from and to, metres.
    /// Keep-out zones count at all of them.
    ///
    /// # Errors
    /// As [`Fence::check_surfacing`]; also [`Rule::NotFinite`] if a depth is not finite.
    pub fn check_surfacing_passing(
        &self,
        sweep: &Sweep,
        vertical: &VerticalExtent,
        depths_m: [f64; 2],
    ) -> Result<Clearance, Breach> {
        self.ask(sweep, vertical, Some(depths_m), true, None)
    }

    /// As [`Fence::check`], of a way on which the vehicle may come to other depths than those of the extent, which are not
    /// the asker's affair: from and to, metres. Keep-out zones count at all of them, keep-in zones by the extent alone.
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
            AnyProbe::Convex(probe) => self.map.judge(&probe, question),
            AnyProbe::Rim(probe) => self.map.judge(&probe, question),
        }
    }

    /// Judges a bare position: no radius, no margins, no depth. Keep-out zones count at whatever depth they have.
    ///
    /// # Errors
    /// [`Rule::KeepIn`], [`Rule::KeepOut`] or [`Rule::NotFinite`]; an edge itself is outside of what it bounds.
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
            &ConvexProbe::point(vector(point)),
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

    /// As [`Fence::check_surfacing_passing`], with the zones that are valid then.
    ///
    /// # Errors
    /// As [`Fence::check_surfacing_passing`]; [`Rule::Closed`] if the zone that would hold is not valid throughout.
    pub fn check_surfacing_passing(
        &self,
        sweep: &Sweep,
        vertical: &VerticalExtent,
        depths_m: [f64; 2],
    ) -> Result<Clearance, Breach> {
        self.fence.ask(sweep, vertical, Some(depths_m), true, Some(self.span))
    }

    /// As [`Fence::contains`], with the zones that are valid then.
    ///
    /// # Errors
    /// The [`Breach`]; [`Rule::Closed`] where the zone that would hold is not valid throughout.
    pub fn contains(&self, point: EastNorth) -> Result<Clearance, Breach> {
        self.fence.holds(point, Some(self.span))
    }
}

#[cfg(test)]
mod tests;
