//! The monitor's judgement: whether the operator's fence and limits allow a request, the way to it and what follows it.
//! It is pure: the same question gives the same answer, to core before it sends anything and to plugins that ask.

use std::time::Duration;

use backseat_fence::{Fence, Shape, Span, Sweep, VerticalExtent, Window};
use backseat_units::math::{PI, SQRT_2};
use backseat_units::{Altitude, Depth, EastNorth, Heading, Latitude, Longitude, Position, Speed};

use crate::monitor::limits::Limits;
use crate::mutations::{Check, is_on};
use crate::plugin::{
    ModifyRequest, NavigationSample, PositionRequest, Refusal, TrackcircleRequest, TracklineRequest, VerticalRequest,
};
use crate::refusal::{Figure, Reason};

mod boxes;
mod ends;
mod judge;
mod modify;
mod motion;
mod onto;
mod place;
mod station;
mod surfacing;
#[cfg(test)]
mod tests;
mod time;
mod tracks;

pub(crate) use ends::End;
use ends::{farthest_m, ways};
pub use modify::LeaseReach;
use motion::turn_radius_m;
pub(crate) use onto::{Approach, Track};
pub(crate) use place::Good;
pub(crate) use station::{Aim, Hover, Surroundings, Suspended, aim_at_here};
use surfacing::{Climb, deepest};
pub(crate) use time::{APART_MAX, Clocks};

/// The vehicle keeps a modify for this long after the last BPRMB that it received (SPI 7.12).
pub(crate) const MODIFY_TIMEOUT: Duration = Duration::from_secs(5);

/// A vertical setpoint whose value has been checked.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
pub(crate) enum Vertical {
    Depth(Depth),
    Altitude(Altitude),
}

/// What a modify sets. It always sets all three, so the vehicle inherits none of them.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
pub(crate) struct Setpoint {
    pub(crate) heading: Heading,
    pub(crate) vertical: Vertical,
    pub(crate) speed: Speed,
}

/// How a line or a circle is flown.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
pub(crate) struct Flight {
    pub(crate) vertical: Vertical,
    pub(crate) speed: Speed,
}

/// Where an insert goes.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
pub(crate) enum InsertPath {
    Line {
        start: Position,
        end: Position,
        flight: Flight,
    },
    Circle {
        centre: Position,
        radius_m: f64,
        orbits: f64,
        entry_angle_deg: Option<f64>,
        flight: Flight,
    },
    /// A GPS hit: the vehicle goes to a place at a depth and speed of its own choice, climbs to the surface there, and
    /// drifts until GPS has a fix (SPI 7.7).
    Surface { at: Position },
}

/// An insert whose values have been checked.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
pub(crate) struct Insert {
    pub(crate) path: InsertPath,
    /// Whether it begins at once instead of after the current behavior.
    pub(crate) interrupt: bool,
}

impl Insert {
    /// Whether it is a GPS hit, which nothing can take back (SPI 7.8).
    pub(crate) const fn surfaces(&self) -> bool {
        match self.path {
            InsertPath::Surface { .. } => true,
            InsertPath::Line { .. } | InsertPath::Circle { .. } => false,
        }
    }

    const fn flight(&self) -> Option<Flight> {
        match self.path {
            InsertPath::Line { flight, .. } | InsertPath::Circle { flight, .. } => Some(flight),
            InsertPath::Surface { .. } => None,
        }
    }
}

/// A water depth from bottom lock, and where it was measured.
#[derive(Clone, Copy, Debug, PartialEq)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
pub(crate) struct BottomLock {
    pub(crate) water_depth_m: f64,
    pub(crate) at: EastNorth,
}

/// What comes before and after a request: where the vehicle may be when the request begins, and where it may go after
/// it.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Route {
    /// Where the vehicle may come from.
    pub(crate) from: Vec<End>,
    /// The vehicle may come from the surface, because a GPS hit may be flown before the request.
    pub(crate) from_surface: bool,
    /// The vehicle may go on to the surface, because a GPS hit may be flown after the request.
    pub(crate) to_surface: bool,
    /// The greatest depth of what may be flown before the request, metres. It counts only if the vehicle is not deeper
    /// now.
    pub(crate) deepest_m: f64,
    /// The greatest speed over ground at which the vehicle was seen to fly its plan in this dive, m/s.
    pub(crate) seen_mps: f64,
    /// Where the vehicle may go after the request: where what may come next begins.
    pub(crate) to: Vec<End>,
    /// The tracks that the vehicle may take up again after the request.
    pub(crate) onto: Vec<Track>,
    /// The tracks that the vehicle may be on now. When a modify lapses, the vehicle returns to one of them.
    pub(crate) legs: Vec<Track>,
    /// The least and the greatest depth of what is flown before and after the request, metres. If `None`, only the
    /// request's own depths count.
    pub(crate) depths_m: Option<[f64; 2]>,
    /// How long everything that may be flown before the request takes at most, seconds. For a modify: how long the
    /// insert that it changes takes at most. Infinite if nobody knows.
    pub(crate) before_s: f64,
}

/// How the vehicle flies a way that belongs to no request.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Passage {
    /// The vehicle's depth now.
    pub(crate) depth: Depth,
    pub(crate) lock: Option<BottomLock>,
    /// A GPS hit is at one end of the way, so the vehicle may be at any depth from the surface down to `depth`.
    pub(crate) surfacing: bool,
    /// The depth from which the vehicle may climb to the surface at that end, metres. It counts only if the vehicle is
    /// not deeper now.
    pub(crate) deepest_m: f64,
    /// As `Route::seen_mps`.
    pub(crate) seen_mps: f64,
    /// As `Route::depths_m`, with the depth now in place of the request's depths.
    pub(crate) depths_m: Option<[f64; 2]>,
    pub(crate) clocks: Clocks,
    /// When the way begins at the latest, seconds from now.
    pub(crate) before_s: f64,
}

/// How a way is flown: how far beside it, how deep, and when.
#[derive(Clone, Copy)]
struct Way {
    cross_track_m: f64,
    extent: VerticalExtent,
    depths_m: [f64; 2],
    when: Option<Span>,
}

impl Route {
    /// Where the vehicle may come from; nothing in a test build without the check of the ways from there.
    fn checked_from(&self) -> impl Iterator<Item = &End> {
        self.from.iter().filter(|_| is_on(Check::InsertWayTo))
    }

    /// The tracks that the vehicle may take up again; none in a test build without the check of the ways there.
    fn checked_onto(&self) -> impl Iterator<Item = &Track> {
        self.onto.iter().filter(|_| is_on(Check::InsertWayOn))
    }

    /// The least and the greatest depth on the ways, metres.
    fn passed_m(&self, extent: &VerticalExtent) -> [f64; 2] {
        self.depths_m.unwrap_or([extent.depth_min_m, extent.depth_max_m])
    }

    /// Every point to which the vehicle may go on.
    fn goes_on_to(&self) -> impl Iterator<Item = EastNorth> {
        let next = self.to.iter().flat_map(|to| to.corners());
        next.chain(self.onto.iter().flat_map(Track::points))
    }

    /// Where the vehicle may go next; nothing in a test build without the check of the ways there.
    fn checked_to(&self) -> impl Iterator<Item = &End> {
        self.to.iter().filter(|_| is_on(Check::InsertWayOn))
    }
}

/// The operator's fence and limits, immutable for the run.
pub struct Envelope {
    fence: Fence,
    limits: Limits,
    /// At least one zone of the fence is not always valid.
    timed: bool,
}

impl Envelope {
    /// Makes an envelope of a fence and of validated limits.
    #[must_use]
    pub fn new(fence: Fence, limits: Limits) -> Self {
        let timed = fence.zones().any(|zone| zone.window() != Window::default());
        Self { fence, limits, timed }
    }

    /// The fence.
    #[must_use]
    pub const fn fence(&self) -> &Fence {
        &self.fence
    }

    /// The limits.
    #[must_use]
    pub const fn limits(&self) -> &Limits {
        &self.limits
    }

    pub(crate) fn admit_modify(&self, request: &ModifyRequest) -> Result<Setpoint, Refusal> {
        if request.duration.is_zero() || request.duration > self.limits.modify_term_max() {
            return Err(Figure::ModifyTerm.not_within(
                request.duration.as_secs_f64(),
                0.0,
                self.limits.modify_term_max_s,
            ));
        }
        Ok(Setpoint {
            heading: heading(request.heading_deg, Figure::Heading)?,
            vertical: vertical(request.vertical)?,
            speed: self.speed(request.speed_mps)?,
        })
    }

    pub(crate) fn admit_trackline(&self, request: &TracklineRequest) -> Result<Insert, Refusal> {
        let (start, end) = (position(request.start)?, position(request.end)?);
        let frame = self.fence.frame();
        if frame.to_local(start).distance_m(frame.to_local(end)) < 1.0 {
            return Err(Figure::TracklineLength.under(frame.to_local(start).distance_m(frame.to_local(end)), 1.0));
        }
        Ok(Insert {
            path: InsertPath::Line {
                start,
                end,
                flight: Flight {
                    vertical: vertical(request.vertical)?,
                    speed: self.speed(request.speed_mps)?,
                },
            },
            interrupt: request.interrupt,
        })
    }

    pub(crate) fn admit_trackcircle(&self, request: &TrackcircleRequest) -> Result<Insert, Refusal> {
        let speed = self.speed(request.speed_mps)?;
        let least = turn_radius_m(speed.as_mps(), self.limits.turn_rate_dps);
        if !(request.radius_m >= least && request.radius_m <= 10_000.0) {
            return Err(Figure::CircleRadius.not_within(request.radius_m, least, 10_000.0));
        }
        if !(request.orbits.abs() > 0.0 && request.orbits.abs() <= 100.0) {
            return Err(Figure::CircleOrbits.not_within(request.orbits.abs(), 0.0, 100.0));
        }
        let entry_angle_deg = match request.entry_angle_deg {
            Some(deg) => Some(heading(deg, Figure::EntryAngle)?.as_deg()),
            None => None,
        };
        Ok(Insert {
            path: InsertPath::Circle {
                centre: position(request.centre)?,
                radius_m: request.radius_m,
                orbits: request.orbits,
                entry_angle_deg,
                flight: Flight {
                    vertical: vertical(request.vertical)?,
                    speed,
                },
            },
            interrupt: request.interrupt,
        })
    }

    /// Judges an insert by safety requirement 002: the way to it, its lead-in and lead-out, its whole geometry, and the
    /// ways on to what comes after it. Returns the smallest clearance, metres.
    pub(crate) fn judge_insert(
        &self,
        insert: &Insert,
        depth: Depth,
        lock: Option<BottomLock>,
        route: &Route,
        clocks: Clocks,
    ) -> Result<f64, Refusal> {
        let frame = self.fence.frame();
        let speed_mps = insert
            .flight()
            .map_or(self.fastest_mps(route.seen_mps), |flight| flight.speed.as_mps());
        let cross_track_m = self.cross_track_m(speed_mps);
        let (shape, reach_m) = match insert.path {
            InsertPath::Line { start, end, .. } => {
                let (start, end) = self.with_leads(frame.to_local(start), frame.to_local(end));
                (Shape::leg(start, end), start.distance_m(end))
            }
            InsertPath::Circle { centre, radius_m, .. } => {
                (Shape::rim(frame.to_local(centre), radius_m), 2.0 * radius_m)
            }
            InsertPath::Surface { at } => (Shape::point(frame.to_local(at)), self.drift_m()),
        };
        let climb = if insert.surfaces() || route.from_surface {
            self.climb(deepest(depth, route.deepest_m)?)
        } else {
            Climb::default()
        };
        let ends = self.ends(insert);
        let when = clocks.next(route.before_s + self.lasts_s(insert, route) + climb.lasts_s);
        let to_it = route.from.iter().map(|from| farthest_m(*from, ends.0));
        let from_it = route.goes_on_to().map(|to| farthest_m(ends.1, End::At(to)));
        let ways_m = to_it.chain(from_it).fold(0.0, f64::max);
        // The water depths that a bottom lock shows must hold for the ways too.
        let reach_m = reach_m + ways_m + cross_track_m;
        let around = ends.0.middle();
        let Some(flight) = insert.flight() else {
            // The vehicle chooses the depths at which it flies a GPS hit: any depth between the surface and the depth
            // that it comes from.
            let deepest = deepest(depth, route.deepest_m)?;
            let extent = self.extent(Vertical::Depth(deepest), depth, lock, around, reach_m)?;
            return self.judge_surfacing((shape, cross_track_m + climb.along_m), ends, &extent, route, when);
        };
        let extent = self.extent(flight.vertical, depth, lock, around, reach_m)?;
        // The vehicle may fly faster before and after the insert.
        let way = Way {
            cross_track_m: self.cross_track_m(self.fastest_mps(route.seen_mps)),
            extent,
            depths_m: route.passed_m(&extent),
            when,
        };
        // The vehicle may come from the surface. The climb to it may have led it `climb.along_m` metres away.
        let to_it = Way {
            cross_track_m: way.cross_track_m + climb.along_m,
            ..way
        };
        let mut least_m = f64::MAX;
        if is_on(Check::InsertShape) {
            least_m = self.sweep(shape, cross_track_m, &extent, when)?;
        }
        for from in route.checked_from() {
            let judged = self.way_by(route.from_surface, *from, ends.0, &to_it);
            least_m = least_m.min(judged.map_err(Refusal::on_the_way_to)?);
        }
        for to in route.checked_to() {
            let judged = self.way_by(route.to_surface, ends.1, *to, &way);
            least_m = least_m.min(judged.map_err(Refusal::on_the_way_on)?);
        }
        for track in route.checked_onto() {
            let judged = self.way_onto(route.to_surface, ends.1, track, &way);
            least_m = least_m.min(judged.map_err(Refusal::on_the_way_on)?);
        }
        Ok(least_m)
    }

    /// Judges the way from one end to another alone, such as what remains when an insert between them is cancelled.
    /// Returns the smallest clearance, metres.
    pub(crate) fn judge_way(&self, (from, to): (End, End), passage: &Passage) -> Result<f64, Refusal> {
        let way = self.passed(passage, to.middle(), farthest_m(from, to))?;
        self.way_by(passage.surfacing, from, to, &way)
    }

    /// As [`Envelope::judge_way`], but onto a track that the vehicle takes up again.
    pub(crate) fn judge_way_onto(&self, (from, onto): (End, &Track), passage: &Passage) -> Result<f64, Refusal> {
        let farthest_m = onto
            .points()
            .map(|to| farthest_m(from, End::At(to)))
            .fold(0.0, f64::max);
        // If the vehicle flies by way of the line, its way is at most sqrt(2) times as long as the straight one.
        let way = self.passed(passage, from.middle(), SQRT_2 * farthest_m)?;
        self.way_onto(passage.surfacing, from, onto, &way)
    }

    /// How the vehicle flies a way of `way_m` metres that lies around a point.
    fn passed(&self, passage: &Passage, around: EastNorth, way_m: f64) -> Result<Way, Refusal> {
        let climb = if passage.surfacing {
            self.climb(deepest(passage.depth, passage.deepest_m)?)
        } else {
            Climb::default()
        };
        let cross_track_m = self.cross_track_m(self.fastest_mps(passage.seen_mps)) + climb.along_m;
        let depth_m = passage.depth.as_m();
        let (shallowest_m, _) = self.water_depths(passage.lock, around, way_m + cross_track_m);
        let extent = VerticalExtent {
            depth_min_m: depth_m,
            depth_max_m: depth_m,
            altitude_min_m: shallowest_m.unwrap_or(0.0) - depth_m,
        };
        Ok(Way {
            cross_track_m,
            extent,
            depths_m: passage.depths_m.unwrap_or([depth_m, depth_m]),
            when: passage
                .clocks
                .next(passage.before_s + climb.lasts_s + way_m / self.slowest_mps()),
        })
    }

    /// Where an insert begins and ends. A line may have leads of any length up to the longest.
    pub(crate) fn ends(&self, insert: &Insert) -> (End, End) {
        let frame = self.fence.frame();
        match insert.path {
            InsertPath::Line { start, end, .. } => {
                let (start, end) = (frame.to_local(start), frame.to_local(end));
                let (led_in, led_out) = self.with_leads(start, end);
                (End::between(led_in, start), End::between(led_out, end))
            }
            InsertPath::Surface { at } => {
                let centre = frame.to_local(at);
                let adrift = End::Anywhere {
                    centre,
                    radius_m: self.drift_m(),
                };
                (End::At(centre), adrift)
            }
            InsertPath::Circle {
                centre,
                radius_m,
                orbits,
                entry_angle_deg,
                ..
            } => {
                let local = frame.to_local(centre);
                match entry_angle_deg {
                    Some(entry_deg) => {
                        let entry_deg = entry_deg - frame.convergence_deg(centre);
                        (
                            End::At(local.offset(entry_deg, radius_m)),
                            End::At(local.offset(entry_deg + 360.0 * orbits, radius_m)),
                        )
                    }
                    None => {
                        let anywhere = End::Anywhere {
                            centre: local,
                            radius_m,
                        };
                        (anywhere, anywhere)
                    }
                }
            }
        }
    }

    /// How long an insert takes at most, including the transit from `from`, seconds.
    pub(crate) fn duration_s(&self, insert: &Insert, from: &[End]) -> f64 {
        let limits = &self.limits;
        let length_m = self.length_m(insert);
        let (speed_mps, at_surface_s) = match insert.flight() {
            Some(flight) => (flight.speed.as_mps(), 0.0),
            None => (limits.speed_min_mps, limits.gps_hit_duration_max_s),
        };
        let transit_m = from
            .iter()
            .map(|from| farthest_m(*from, self.ends(insert).0))
            .fold(0.0, f64::max);
        let turns_s = 2.0 * self.turn_away_s();
        (length_m + transit_m) / (speed_mps - limits.current_max_mps) + turns_s + at_surface_s
    }

    /// As [`Envelope::duration_s`], and including the way on to what may come next. The vehicle flies that way no
    /// slower than `speed_min_mps`, the least speed that plugins may ask for.
    pub(crate) fn lasts_s(&self, insert: &Insert, route: &Route) -> f64 {
        let end = self.ends(insert).1;
        let straight_m = route.to.iter().map(|to| farthest_m(end, *to)).fold(0.0, f64::max);
        // If the vehicle flies by way of the line, its way is at most sqrt(2) times as long as the straight one.
        let points = route.onto.iter().flat_map(Track::points);
        let onto_m = SQRT_2 * points.map(|to| farthest_m(end, End::At(to))).fold(0.0, f64::max);
        self.duration_s(insert, &route.from) + straight_m.max(onto_m) / self.slowest_mps()
    }

    /// The length of an insert itself, metres: of a line with its longest leads, and of all orbits of a circle.
    fn length_m(&self, insert: &Insert) -> f64 {
        let frame = self.fence.frame();
        match insert.path {
            InsertPath::Line { start, end, .. } => {
                frame.to_local(start).distance_m(frame.to_local(end)) + 2.0 * self.limits.lead_max_m
            }
            InsertPath::Circle { radius_m, orbits, .. } => 2.0 * PI * radius_m * orbits.abs(),
            InsertPath::Surface { .. } => 0.0,
        }
    }

    fn way(&self, from: End, to: End, way: &Way) -> Result<f64, Refusal> {
        self.least(ways(from, to), way.cross_track_m, |sweep| self.sweep_way(sweep, way))
    }

    /// The smallest clearance of several shapes, each widened by `radius_m`, metres.
    fn least(
        &self,
        shapes: Vec<Shape>,
        radius_m: f64,
        judge: impl Fn(&Sweep) -> Result<f64, Refusal>,
    ) -> Result<f64, Refusal> {
        let mut least_m = f64::MAX;
        for shape in shapes {
            least_m = least_m.min(judge(&Sweep { shape, radius_m })?);
        }
        Ok(least_m)
    }

    fn sweep_way(&self, sweep: &Sweep, way: &Way) -> Result<f64, Refusal> {
        match self.check_passing(sweep, &way.extent, (way.depths_m, way.when)) {
            Ok(clearance) => Ok(clearance.metres),
            Err(breach) => Err(breach.into()),
        }
    }

    fn sweep(&self, shape: Shape, radius_m: f64, extent: &VerticalExtent, when: Option<Span>) -> Result<f64, Refusal> {
        match self.check(&Sweep { shape, radius_m }, extent, when) {
            Ok(clearance) => Ok(clearance.metres),
            Err(breach) => Err(breach.into()),
        }
    }

    fn with_leads(&self, start: EastNorth, end: EastNorth) -> (EastNorth, EastNorth) {
        let length_m = start.distance_m(end).max(1e-3);
        let lead = (end - start) * (self.limits.lead_max_m / length_m);
        (start - lead, end + lead)
    }

    fn speed(&self, mps: f64) -> Result<Speed, Refusal> {
        let allowed = self.limits.speed_min_mps..=self.limits.speed_max_mps;
        match Speed::from_mps(mps) {
            Ok(speed) if allowed.contains(&mps) || !is_on(Check::SpeedLimits) => Ok(speed),
            _ => Err(Figure::Speed.not_within(mps, *allowed.start(), *allowed.end())),
        }
    }

    /// The depths and the least altitude that a setpoint may lead to within `reach_m` of a point.
    fn extent(
        &self,
        vertical: Vertical,
        depth: Depth,
        lock: Option<BottomLock>,
        around: EastNorth,
        reach_m: f64,
    ) -> Result<VerticalExtent, Refusal> {
        let error_m = self.limits.vertical_error_m;
        let (shallowest_m, deepest_m) = self.water_depths(lock, around, reach_m);
        let shallowest_m = shallowest_m.unwrap_or(0.0);
        let now_m = depth.as_m();
        Ok(match vertical {
            Vertical::Depth(set) => VerticalExtent {
                depth_min_m: now_m.min(set.as_m() - error_m).max(0.0),
                depth_max_m: now_m.max(set.as_m() + error_m),
                altitude_min_m: shallowest_m - set.as_m() - error_m,
            },
            Vertical::Altitude(set) => {
                let unknown_m = (!is_on(Check::BottomKnown)).then_some(now_m);
                let Some(deepest_m) = deepest_m.or(unknown_m) else {
                    return Err(Reason::WaterDepthUnknown.into());
                };
                VerticalExtent {
                    depth_min_m: now_m.min(shallowest_m - set.as_m() - error_m).max(0.0),
                    depth_max_m: now_m.max(deepest_m - set.as_m() + error_m),
                    altitude_min_m: set.as_m() - error_m,
                }
            }
        })
    }
}

impl Envelope {
    /// The least and the greatest water depth within `reach_m` of a point, metres, where they are known.
    fn water_depths(&self, lock: Option<BottomLock>, around: EastNorth, reach_m: f64) -> (Option<f64>, Option<f64>) {
        let limits = &self.limits;
        let by_lock = lock.map(|lock| {
            let change_m = limits.seabed_slope_max * (lock.at.distance_m(around) + reach_m);
            (lock.water_depth_m - change_m, lock.water_depth_m + change_m)
        });
        let shallowest_m = match (by_lock, limits.water_depth_min_m) {
            (Some((lock_m, _)), Some(known_m)) => Some(lock_m.max(known_m)),
            (Some((lock_m, _)), None) => Some(lock_m),
            (None, known_m) => known_m,
        };
        let deepest_m = match (by_lock, limits.water_depth_max_m) {
            (Some((_, lock_m)), Some(known_m)) => Some(lock_m.min(known_m)),
            (Some((_, lock_m)), None) => Some(lock_m),
            (None, known_m) => known_m,
        };
        (shallowest_m, deepest_m)
    }
}

/// The water depth under a sample with bottom lock.
pub(crate) fn bottom_lock(navigation: &NavigationSample) -> Option<BottomLock> {
    let altitude = navigation.altitude?;
    Some(BottomLock {
        water_depth_m: navigation.depth.as_m() + altitude.as_m(),
        at: navigation.local,
    })
}

fn vertical(request: VerticalRequest) -> Result<Vertical, Refusal> {
    match request {
        VerticalRequest::DepthM(m) if m < 0.0 => Err(Figure::Depth.under(m, 0.0)),
        VerticalRequest::DepthM(m) => {
            let depth = Depth::from_m(m).map_err(|error| Figure::Depth.not_within(m, 0.0, error.max))?;
            Ok(Vertical::Depth(depth))
        }
        VerticalRequest::AltitudeM(m) => Ok(Vertical::Altitude(
            Altitude::from_m(m).map_err(Figure::Altitude.out_of_range())?,
        )),
    }
}

/// A full turn in each direction is room enough. What is beyond it was not meant as a heading, so it is refused.
fn heading(deg: f64, figure: Figure) -> Result<Heading, Refusal> {
    if !(-360.0..=360.0).contains(&deg) {
        return Err(figure.not_within(deg, -360.0, 360.0));
    }
    Heading::from_deg(deg).map_err(figure.out_of_range())
}

fn position(request: PositionRequest) -> Result<Position, Refusal> {
    Ok(Position {
        latitude: Latitude::from_deg(request.latitude_deg).map_err(Figure::Latitude.out_of_range())?,
        longitude: Longitude::from_deg(request.longitude_deg).map_err(Figure::Longitude.out_of_range())?,
    })
}
