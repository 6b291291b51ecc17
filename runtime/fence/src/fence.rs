use core::fmt;
use std::sync::Arc;

use backseat_units::{EastNorth, LocalFrame, Position, Utc};

use crate::distance::{AnyProbe, ConvexProbe, vector};
use crate::error::FenceError;
use crate::map::Map;
use crate::question::{LIMIT_M, Question, unusable, unusable_span, unusable_vertical};
use crate::sweep::{Sweep, VerticalExtent};
use crate::terms::{Form, Terms};
use crate::verdict::{Breach, Clearance, EdgeId, EdgeInfo};
use crate::window::{Span, Window};
use crate::zone::Zone;

/// The area in which the vehicle may be. Immutable, cheap to clone, shared between threads.
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
    /// Reads a fence from the text of a file of this form. `origin` is where the plane of its shapes has its zero point;
    /// without it, that is the centroid of the keep-in zones.
    ///
    /// # Errors
    /// The first fault, with the feature, the ring and the vertex or key, and what was expected; or an origin that is so
    /// far away that one plane does not hold both.
    pub fn read(text: &str, form: Form<'_>, origin: Option<Position>) -> Result<Self, FenceError> {
        let (frame, zones) = crate::load::read(text, form, origin)?;
        Ok(Self {
            map: Arc::new(Map::new(frame, zones)),
        })
    }

    /// Reads a fence from GeoJSON, as [`Fence::read`] without an origin. The crate's documentation describes the form of
    /// the file.
    ///
    /// # Errors
    /// As [`Fence::read`].
    pub fn from_geojson(text: &str) -> Result<Self, FenceError> {
        Self::read(text, Form::GeoJson, None)
    }

    /// Reads the `geoFence` of a plan file of QGroundControl: its polygons and circles, named `polygon 1` and so on in
    /// the order of the file. `terms` give the values that such a file cannot have.
    ///
    /// # Errors
    /// As [`Fence::read`].
    pub fn from_plan(text: &str, terms: &Terms) -> Result<Self, FenceError> {
        Self::read(text, Form::Plan(terms), None)
    }

    /// Reads the placemarks of a KML file (OGC 12-007r2): `Polygon` and `MultiGeometry` of polygons, `Point` as a
    /// circle and `LineString` as a corridor. The placemark's name is the zone's name. Its `ExtendedData` have the
    /// other properties, with the keys of the GeoJSON form; `kind` is required. Its `TimeSpan` is the zone's window.
    /// `terms` give the other values that are absent.
    ///
    /// # Errors
    /// As [`Fence::read`], with the line of the placemark.
    pub fn from_kml(text: &str, terms: &Terms) -> Result<Self, FenceError> {
        Self::read(text, Form::Kml(terms), None)
    }

    /// The plane of all shapes that this fence checks. Its origin is the one with which the fence was read, or else the
    /// centroid of the keep-in zones.
    #[must_use]
    pub fn frame(&self) -> &LocalFrame {
        &self.map.frame
    }

    /// The zones in the order of the file.
    pub fn zones(&self) -> impl Iterator<Item = &Zone> {
        self.map.zones.iter()
    }

    /// Describes an edge in the terms of the fence's file; `None` if this fence does not have the edge.
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
    /// The [`Breach`]: the broken rule, by how many metres, and where. If no keep-in zone contains the sweep, the
    /// breach describes the zone whose worst fault is the smallest.
    pub fn check(&self, sweep: &Sweep, vertical: &VerticalExtent) -> Result<Clearance, Breach> {
        self.ask(sweep, vertical, None, false, None)
    }

    /// Whether any zone is valid for a limited time, so that the answers depend on the time.
    #[must_use]
    pub fn changes(&self) -> bool {
        self.zones().any(|zone| zone.window() != Window::default())
    }

    /// Whether a zone begins or stops being valid within a span of time, both ends included.
    #[must_use]
    pub fn changes_within(&self, span: Span) -> bool {
        let within = |at: Option<Utc>| at.is_some_and(|at| span.from <= at && at <= span.until);
        self.zones()
            .any(|zone| within(zone.window().from) || within(zone.window().until))
    }

    /// The fence during a span of time. [`Fence::check`] and the similar methods do not know the time, and assume the
    /// worst for every zone that is not always valid.
    #[must_use]
    pub fn during(&self, span: Span) -> FenceDuring<'_> {
        FenceDuring { fence: self, span }
    }

    /// Judges a place where the vehicle surfaces. This is like [`Fence::check`] with three differences: only keep-in
    /// zones with `surfacing` can contain the place, their `depth_min_m` does not count, and keep-out zones count from
    /// the surface down to the extent's deepest depth, whatever its shallowest is.
    ///
    /// # Errors
    /// The [`Breach`]; [`Rule::Surfacing`] if no zone that allows surfacing contains the sweep.
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

    /// As [`Fence::check`], for a way on which the vehicle may also reach depths outside the extent, for which the
    /// caller does not answer. Keep-out zones count at all of `depths_m` (from and to, metres) and of the extent, and
    /// keep-in zones are judged by the extent alone.
    ///
    /// # Errors
    /// As [`Fence::check`]; also [`Rule::NotFinite`] if a depth is not a usable number.
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
            return Err(self.map.unusable("depth that the vehicle may pass"));
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

    /// Judges a bare position, without radius, margins and depth. Keep-out zones count at whatever depth they have.
    ///
    /// # Errors
    /// [`Rule::KeepIn`], [`Rule::KeepOut`] or [`Rule::NotFinite`]. An edge itself is outside the zone that it bounds.
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

/// A fence during a span of time ([`Fence::during`]).
#[derive(Clone, Copy, Debug)]
pub struct FenceDuring<'a> {
    fence: &'a Fence,
    span: Span,
}

impl FenceDuring<'_> {
    /// As [`Fence::check`], with the zones that are valid then.
    ///
    /// # Errors
    /// The [`Breach`]; [`Rule::Closed`] if the zone that would contain the sweep is not valid throughout.
    pub fn check(&self, sweep: &Sweep, vertical: &VerticalExtent) -> Result<Clearance, Breach> {
        self.fence.ask(sweep, vertical, None, false, Some(self.span))
    }

    /// As [`Fence::check_passing`], with the zones that are valid then.
    ///
    /// # Errors
    /// As [`Fence::check_passing`]; [`Rule::Closed`] if the zone that would contain the sweep is not valid throughout.
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
    /// The [`Breach`]; [`Rule::Closed`] if the zone that would contain the sweep is not valid throughout.
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
    /// The [`Breach`]; [`Rule::Closed`] if the zone that would contain the point is not valid throughout.
    pub fn contains(&self, point: EastNorth) -> Result<Clearance, Breach> {
        self.fence.holds(point, Some(self.span))
    }
}

#[cfg(test)]
mod tests;
