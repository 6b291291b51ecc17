//! The judgement of what brings the vehicle to the surface: GPS hits, and the ways to and from them (SPI 7.7).

use backseat_fence::{Shape, Span, Sweep, VerticalExtent};
use backseat_units::Depth;
use backseat_units::math::sin_cos;

use super::{BottomLock, End, Envelope, Insert, InsertPath, Route, Track, Way, position, ways};
use crate::mutations::{Check, is_on};
use crate::plugin::{GpsHitRequest, Refusal};
use crate::refusal::Figure;

/// A way up to the surface.
#[derive(Clone, Copy, Default)]
pub(super) struct Climb {
    /// How far it may lead over ground, metres, in any direction.
    pub(super) along_m: f64,
    /// How long it takes, seconds.
    pub(super) lasts_s: f64,
}

/// The greater of the depth where the vehicle is and the depth where it may be by then.
pub(super) fn deepest(now: Depth, then_m: f64) -> Result<Depth, Refusal> {
    Depth::from_m(now.as_m().max(then_m).max(0.0)).map_err(Figure::Depth.out_of_range())
}

impl Envelope {
    /// The longest way up from a depth: at the shallowest angle that the limits allow, at the least speed of a request,
    /// and with the strongest current.
    pub(super) fn climb(&self, from: Depth) -> Climb {
        let limits = &self.limits;
        let (sine, cosine) = sin_cos(limits.climb_angle_min_deg.to_radians());
        let length_m = from.as_m().max(0.0) / sine;
        let lasts_s = length_m / limits.speed_min_mps;
        Climb {
            along_m: length_m * cosine + limits.current_max_mps * lasts_s,
            lasts_s,
        }
    }

    pub(crate) fn admit_gps_hit(&self, request: &GpsHitRequest) -> Result<Insert, Refusal> {
        Ok(Insert {
            path: InsertPath::Surface {
                at: position(request.position)?,
            },
            // BPRGP has no interrupt code (SPI 7.7): it runs after the current behavior.
            interrupt: false,
        })
    }

    /// Judges a GPS hit by safety requirement 002: its place, widened by the climb and by the drift of the whole wait,
    /// must be in a zone that allows surfacing, and the ways to it and on from it must be inside the fence. Returns the
    /// smallest clearance, metres.
    pub(super) fn judge_surfacing(
        &self,
        (place, cross_track_m): (Shape, f64),
        ends: (End, End),
        extent: &VerticalExtent,
        route: &Route,
        when: Option<Span>,
    ) -> Result<f64, Refusal> {
        let adrift = Sweep {
            shape: place,
            radius_m: cross_track_m + self.drift_m(),
        };
        let mut least_m = match self.check_surfacing(&adrift, extent, when) {
            Ok(clearance) => clearance.metres,
            Err(breach) if is_on(Check::Surfacing) => return Err(breach.into()),
            Err(_) => f64::MAX,
        };
        let way = Way {
            cross_track_m,
            extent: *extent,
            depths_m: route.passed_m(extent),
            when,
        };
        for from in route.checked_from() {
            least_m = least_m.min(self.way_by(true, *from, ends.0, &way)?);
        }
        for to in route.checked_to() {
            least_m = least_m.min(self.way_by(true, ends.1, *to, &way)?);
        }
        for track in route.checked_onto() {
            least_m = least_m.min(self.way_onto(true, ends.1, track, &way)?);
        }
        Ok(least_m)
    }

    /// How far the current can carry a vehicle that waits at the surface for GPS, metres.
    pub(super) fn drift_m(&self) -> f64 {
        self.limits.current_max_mps * self.limits.gps_hit_duration_max_s
    }

    /// The least and the greatest depth at which an insert is flown, metres; `None` if they cannot be known. A GPS hit
    /// leads from the depth now to the surface.
    pub(crate) fn depths_m(&self, insert: &Insert, depth: Depth, lock: Option<BottomLock>) -> Option<[f64; 2]> {
        let (InsertPath::Line { flight, .. } | InsertPath::Circle { flight, .. }) = insert.path else {
            return Some([depth.as_m().min(0.0), depth.as_m()]);
        };
        let around = self.ends(insert).0.middle();
        let extent = self.extent(flight.vertical, depth, lock, around, self.length_m(insert));
        extent.ok().map(|extent| [extent.depth_min_m, extent.depth_max_m])
    }

    /// The greatest depth to which an insert leads, metres; the depth now for a GPS hit, and `None` if the depth at the
    /// set altitude cannot be known.
    pub(crate) fn deepest_m(&self, insert: &Insert, depth: Depth, lock: Option<BottomLock>) -> Option<f64> {
        let vertical = match insert.path {
            InsertPath::Line { flight, .. } | InsertPath::Circle { flight, .. } => flight.vertical,
            InsertPath::Surface { .. } => return Some(depth.as_m()),
        };
        let around = self.ends(insert).0.middle();
        let extent = self.extent(vertical, depth, lock, around, self.length_m(insert));
        extent.ok().map(|extent| extent.depth_max_m)
    }

    /// As [`Envelope::way_by`], but from an end onto a track that the vehicle takes up again.
    pub(super) fn way_onto(&self, any_depth: bool, from: End, track: &Track, way: &Way) -> Result<f64, Refusal> {
        let radius_m = way.cross_track_m + track.within_m();
        self.least(track.onto(&from.corners()), radius_m, |sweep| {
            if any_depth {
                self.of_any_depth(sweep, way)
            } else {
                self.sweep_way(sweep, way)
            }
        })
    }

    /// Judges a way that is flown within the extent, or, with `any_depth`, a way on which the vehicle may be at any
    /// depth down to the deepest of the extent.
    pub(super) fn way_by(&self, any_depth: bool, from: End, to: End, way: &Way) -> Result<f64, Refusal> {
        if any_depth {
            self.way_of_any_depth(from, to, way)
        } else {
            self.way(from, to, way)
        }
    }

    /// The fence must allow all of these depths, because the zone's depths include them or because the vehicle may
    /// surface on the whole way.
    fn way_of_any_depth(&self, from: End, to: End, way: &Way) -> Result<f64, Refusal> {
        self.least(ways(from, to), way.cross_track_m, |sweep| self.of_any_depth(sweep, way))
    }

    fn of_any_depth(&self, sweep: &Sweep, way: &Way) -> Result<f64, Refusal> {
        let from_surface = VerticalExtent {
            depth_min_m: way.extent.depth_min_m.min(0.0),
            ..way.extent
        };
        let passing = (way.depths_m, way.when);
        let checked = self.check_passing(sweep, &from_surface, passing).or_else(|breach| {
            self.check_surfacing_passing(sweep, &way.extent, passing)
                .map_err(|_| breach)
        });
        match checked {
            Ok(clearance) => Ok(clearance.metres),
            Err(breach) => Err(breach.into()),
        }
    }
}
