//! Checks that are possible before a dive: the front seat's plan against the fence, and the limits against the
//! vehicle's class.
//!
//! The plan is checked as the vehicle will fly it: every leg and rim whole, widened by the tracking error in the
//! limits, at its depths or altitudes and its time; on the way down from the start; in the turns between behaviors; and
//! from wherever the time limit of an element may end it. Requests of the backseat are checked when they are made.

use std::time::Duration;

use backseat_core::Limits;
use backseat_fence::{Breach, Clearance, Fence, Kind, Shape, Span, Sweep, VerticalExtent};
use backseat_plan::{PlannedBehavior, PlannedPath, PlannedVertical, VehicleClass, VehicleLimits};
use backseat_units::{EastNorth, LocalFrame, Position, Utc};

mod reach;

/// Where no limit gives the seabed's least depth, no altitude counts as too low.
const ALTITUDE_UNKNOWN_M: f64 = 1e6;

/// Positions closer than this are the same, metres; so are directions that differ by less, degrees.
const SAME_PLACE_M: f64 = 0.01;
const SAME_WAY_DEG: f64 = 0.01;

/// A planned dive.
#[derive(Clone, Copy, Debug)]
pub struct Dive<'a> {
    /// The fence.
    pub fence: &'a Fence,
    /// The operator's limits, with how well the vehicle keeps to its path.
    pub limits: &'a Limits,
    /// The front seat's behaviors, in order.
    pub plan: &'a [PlannedBehavior],
    /// Where the dive begins; if unknown, at the plan's first position.
    pub start: Option<Position>,
    /// Its depth at the beginning, metres: 0 at the surface.
    pub start_depth_m: f64,
    /// When the dive begins.
    pub utc: Utc,
}

/// The state of the vehicle at a point of the plan.
struct Way {
    /// The vehicle is within the convex hull of these: a single position, or all where a time limit may have ended an
    /// element.
    places: Vec<EastNorth>,
    /// It may be this far from there, metres.
    spread_m: f64,
    /// Its direction, degrees in the fence's frame, if known.
    bearing_deg: Option<f64>,
    /// Its speed through the water, metres a second.
    speed_mps: f64,
    depths_m: Option<[f64; 2]>,
    /// Time since the start, seconds, at the earliest and at the latest.
    since_s: [f64; 2],
}

/// One swept part of a behavior.
struct Part {
    /// What the vehicle does in this part, if it does not yet fly the behavior itself.
    what: &'static str,
    shapes: Vec<Shape>,
    radius_m: f64,
    /// The length of the part, metres, at least and at most.
    length_m: [f64; 2],
}

const TURN: &str = "turning to it: ";
const WAY: &str = "on the way to it: ";
const WAY_CUT_SHORT: &str = "on the way to it, from a place where a time limit may end the previous element: ";

impl Dive<'_> {
    /// Everything that prevents the plan from being flown inside the fence, one line each, with the place.
    #[must_use]
    pub fn findings(&self) -> Vec<String> {
        let mut findings = Vec::new();
        let frame = self.fence.frame();
        let first = self.plan.iter().find_map(|behavior| match behavior.path {
            PlannedPath::Waypoint { to } => Some(to),
            PlannedPath::Line { start, .. } => Some(start),
            PlannedPath::Circle { centre, .. } => Some(centre),
            PlannedPath::Heading { .. } | PlannedPath::Nowhere => None,
        });
        let Some(start) = self.start.or(first) else {
            findings.push("plan: no element has a position, expected at least one".to_owned());
            return findings;
        };
        let start = frame.to_local(start);
        let mut way = Way {
            places: vec![start],
            spread_m: 0.0,
            bearing_deg: None,
            speed_mps: 0.0,
            depths_m: None,
            since_s: [0.0; 2],
        };
        if let Err(breach) = self.contains(start, self.span([0.0; 2])) {
            findings.push(format!("start: {breach}"));
        }
        let mut inside = vec![start];
        for behavior in self.plan {
            self.fly(behavior, &mut way, &mut findings);
            inside.extend(&way.places);
        }
        findings.extend(reach::unreachable(self.fence, self.limits, &inside));
        findings.extend(self.closed(way.since_s[1]));
        findings
    }

    /// Whether the plan has depths over a bottom whose depth no limit gives, so that the fence's altitudes cannot be
    /// checked.
    #[must_use]
    pub fn bottom_is_unknown(&self) -> bool {
        let at_depth = |behavior: &PlannedBehavior| match behavior.vertical {
            PlannedVertical::Depth(_) => behavior.path != PlannedPath::Nowhere,
            PlannedVertical::Altitude(_) => false,
        };
        let over_bottom = self.fence.zones().any(|zone| match zone.kind() {
            Kind::KeepIn { altitude_min_m, .. } => altitude_min_m > 0.0,
            Kind::KeepOut { .. } => false,
        });
        self.limits.water_depth_min_m.is_none() && over_bottom && self.plan.iter().any(at_depth)
    }

    /// Checks one behavior, and moves `way` to its end.
    fn fly(&self, behavior: &PlannedBehavior, way: &mut Way, findings: &mut Vec<String>) {
        let place = format!("plan element {}", behavior.element);
        let frame = self.fence.frame();
        let (begun, begun_s) = (way.places.clone(), way.since_s);
        let mut parts = Vec::new();
        match behavior.path {
            PlannedPath::Nowhere => return,
            PlannedPath::Waypoint { to } => {
                self.lead(behavior, way, vec![frame.to_local(to)], &mut parts);
            }
            PlannedPath::Line { start, end } => {
                self.lead(behavior, way, vec![frame.to_local(start)], &mut parts);
                self.lead(behavior, way, vec![frame.to_local(end)], &mut parts);
            }
            PlannedPath::Circle {
                centre,
                radius_m,
                orbits,
                entry_deg,
            } => {
                let convergence_deg = frame.convergence_deg(centre);
                let centre = frame.to_local(centre);
                let entry_deg = match (entry_deg, &way.places[..]) {
                    (Some(entry_deg), _) => Some(entry_deg - convergence_deg),
                    (None, [from]) => Some(centre.bearing_deg(*from)),
                    // It may begin anywhere on the circle.
                    (None, _) => None,
                };
                let on_rim = |turned_deg: f64| match entry_deg {
                    Some(entry_deg) => vec![centre.offset(entry_deg + turned_deg, radius_m)],
                    None => square(centre, radius_m),
                };
                self.lead(behavior, way, on_rim(0.0), &mut parts);
                parts.push(Part {
                    what: "",
                    shapes: vec![Shape::rim(centre, radius_m)],
                    radius_m: self.limits.tracking_error_m,
                    length_m: [std::f64::consts::TAU * radius_m * orbits.abs(); 2],
                });
                way.places = on_rim(360.0 * orbits);
                way.bearing_deg = None;
            }
            PlannedPath::Heading { heading_deg, duration } => {
                let heading_deg = heading_deg - frame.convergence_deg(frame.to_position(begun[0]));
                let length_m = behavior.speed_mps * duration.as_secs_f64();
                let to = begun.iter().map(|from| from.offset(heading_deg, length_m)).collect();
                // Nothing keeps the vehicle in place against the current.
                let spread_m = way.spread_m + self.limits.current_max_mps * duration.as_secs_f64();
                way.spread_m = spread_m;
                self.lead(behavior, way, to, &mut parts);
                (way.spread_m, way.bearing_deg) = (spread_m, Some(heading_deg));
            }
        }
        if let (Some(leg), PlannedPath::Line { .. } | PlannedPath::Heading { .. }) = (parts.last_mut(), behavior.path) {
            leg.what = "";
        }
        let depths_m = self.depths_m(behavior.vertical);
        for part in parts {
            let part_begun_s = way.since_s[0];
            way.since_s = self.later(way.since_s, behavior, part.length_m);
            let span = self.span([part_begun_s, way.since_s[1]]);
            let judged = match depths_m {
                Some(own_m) => part.shapes.iter().find_map(|shape| {
                    let sweep = Sweep::new(*shape, part.radius_m);
                    self.judge(&sweep, behavior.vertical, own_m, way.depths_m, span).err()
                }),
                // Its depths are unknown, so only its end positions must be inside.
                None => way.places.iter().find_map(|end| self.contains(*end, span).err()),
            };
            if let Some(breach) = judged {
                findings.push(format!("{place}: {}{breach}", part.what));
            }
            // A vehicle that dives more steeply than it moves along the path reaches no other depth.
            let middle_m = |[shallowest_m, deepest_m]: [f64; 2]| f64::midpoint(shallowest_m, deepest_m);
            let before_m = way.depths_m.map_or(self.start_depth_m, middle_m);
            if depths_m.is_none_or(|own_m| part.length_m[0] >= (middle_m(own_m) - before_m).abs()) {
                way.depths_m = depths_m;
            }
        }
        if depths_m.is_none() {
            findings.push(format!(
                "{place}: it keeps an altitude, so its depths are unknown without water_depth_min_m and \
                 water_depth_max_m in [limits]"
            ));
        }
        if self.fence.changes() && behavior.speed_mps < self.limits.speed_min_mps {
            findings.push(format!(
                "{place}: its speed is {} m/s, expected at least limits.speed_min_mps of {}, with which the times for \
                 zones are computed",
                behavior.speed_mps, self.limits.speed_min_mps
            ));
        }
        if let Some(timeout) = behavior.timeout {
            let timeout_s = timeout.as_secs_f64();
            if begun_s[1] + timeout_s < way.since_s[1] {
                way.end_anywhere(behavior, frame, begun);
            }
            way.since_s = [0, 1].map(|end| way.since_s[end].min(begun_s[end] + timeout_s));
        }
    }

    /// Turns towards the next start of the behavior, and goes there.
    fn lead(&self, behavior: &PlannedBehavior, way: &mut Way, to: Vec<EastNorth>, parts: &mut Vec<Part>) {
        let from = core::mem::replace(&mut way.places, to);
        let stays = matches!((&from[..], &way.places[..]), ([from], [to]) if from.distance_m(*to) < SAME_PLACE_M);
        let bearing_deg = if stays {
            way.bearing_deg
        } else {
            one_bearing_deg(&from, &way.places)
        };
        let radius_m = self.limits.tracking_error_m + way.spread_m;
        let turn_m = way.speed_mps.max(behavior.speed_mps) / self.limits.turn_rate_dps.to_radians();
        let turned_deg = match (way.bearing_deg, bearing_deg) {
            (Some(before_deg), Some(after_deg)) => {
                let turned_deg = (after_deg - before_deg).rem_euclid(360.0);
                turned_deg.min(360.0 - turned_deg)
            }
            (None, _) | (_, None) => 180.0,
        };
        // A turn from a standstill needs no room. During its turn the vehicle is no further from the corner than at its
        // end.
        let turn_m = if way.speed_mps > 0.0 && !stays { turn_m } else { 0.0 };
        let room_m = 2.0 * turn_m * backseat_units::math::sin((turned_deg / 2.0).to_radians());
        if room_m > 0.0 {
            parts.push(Part {
                what: TURN,
                shapes: Shape::convex_hulls(&from),
                radius_m: radius_m + room_m,
                length_m: [0.0, turn_m * std::f64::consts::TAU],
            });
        }
        let distances_m = || {
            let pairs = from
                .iter()
                .flat_map(|from| way.places.iter().map(move |to| from.distance_m(*to)));
            pairs.map(|distance_m| distance_m + way.spread_m)
        };
        let both: Vec<EastNorth> = from.iter().chain(&way.places).copied().collect();
        parts.push(Part {
            what: if from.len() == 1 { WAY } else { WAY_CUT_SHORT },
            shapes: Shape::convex_hulls(&both),
            radius_m,
            length_m: [
                if from.len() == 1 {
                    distances_m().fold(f64::INFINITY, f64::min)
                } else {
                    0.0
                },
                distances_m().fold(0.0, f64::max),
            ],
        });
        (way.spread_m, way.bearing_deg, way.speed_mps) = (0.0, bearing_deg, behavior.speed_mps);
    }

    fn judge(
        &self,
        sweep: &Sweep,
        vertical: PlannedVertical,
        own_m: [f64; 2],
        passed_m: Option<[f64; 2]>,
        span: Option<Span>,
    ) -> Result<Clearance, Breach> {
        let [shallowest_m, deepest_m] = passed_m.unwrap_or(own_m);
        // On the way down the vehicle may be shallower than the zones allow, because every dive begins at the surface.
        let start_m = if passed_m.is_none() {
            self.start_depth_m
        } else {
            own_m[0]
        };
        let extent = VerticalExtent {
            depth_min_m: own_m[0].min(shallowest_m).max(0.0),
            depth_max_m: own_m[1].max(deepest_m).max(start_m),
            altitude_min_m: self.altitude_m(vertical),
        };
        let depths_m = [extent.depth_min_m.min(start_m), extent.depth_max_m];
        match span {
            Some(span) => self.fence.during(span).check_passing(sweep, &extent, depths_m),
            None => self.fence.check_passing(sweep, &extent, depths_m),
        }
    }

    /// The depths of a setpoint; `None` if they depend on a seabed whose depth no limit gives.
    fn depths_m(&self, vertical: PlannedVertical) -> Option<[f64; 2]> {
        let error_m = self.limits.vertical_error_m;
        match vertical {
            PlannedVertical::Depth(depth_m) => Some([depth_m - error_m, depth_m + error_m]),
            PlannedVertical::Altitude(altitude_m) => {
                let (shallowest_m, deepest_m) = (self.limits.water_depth_min_m?, self.limits.water_depth_max_m?);
                Some([shallowest_m - altitude_m - error_m, deepest_m - altitude_m + error_m])
            }
        }
    }

    fn altitude_m(&self, vertical: PlannedVertical) -> f64 {
        let error_m = self.limits.vertical_error_m;
        match (vertical, self.limits.water_depth_min_m) {
            (PlannedVertical::Altitude(altitude_m), _) => altitude_m - error_m,
            (PlannedVertical::Depth(depth_m), Some(shallowest_m)) => shallowest_m - depth_m - error_m,
            (PlannedVertical::Depth(_), None) => ALTITUDE_UNKNOWN_M,
        }
    }

    /// How long a path takes, seconds, at least and at most. The most is infinite where the current may stop the
    /// vehicle.
    fn seconds(&self, behavior: &PlannedBehavior, [least_m, most_m]: [f64; 2]) -> [f64; 2] {
        let current_mps = self.limits.current_max_mps;
        let slowest_mps = behavior.speed_mps - current_mps;
        let most_s = if slowest_mps > 0.0 {
            most_m / slowest_mps
        } else {
            f64::INFINITY
        };
        [least_m / (behavior.speed_mps + current_mps), most_s]
    }

    fn later(&self, since_s: [f64; 2], behavior: &PlannedBehavior, length_m: [f64; 2]) -> [f64; 2] {
        let [least_s, most_s] = match behavior.path {
            PlannedPath::Heading { duration, .. } => [duration.as_secs_f64(); 2],
            PlannedPath::Waypoint { .. }
            | PlannedPath::Line { .. }
            | PlannedPath::Circle { .. }
            | PlannedPath::Nowhere => self.seconds(behavior, length_m),
        };
        [since_s[0] + least_s, since_s[1] + most_s]
    }

    fn span(&self, since_s: [f64; 2]) -> Option<Span> {
        let after = |seconds: f64| {
            let since = Duration::try_from_secs_f64(seconds.max(0.0)).ok()?;
            (since < Duration::from_secs(366 * 86_400)).then(|| self.utc + since)
        };
        Some(Span {
            from: after(since_s[0])?,
            until: after(since_s[1])?,
        })
    }

    fn contains(&self, at: EastNorth, span: Option<Span>) -> Result<Clearance, Breach> {
        match span {
            Some(span) => self.fence.during(span).contains(at),
            None => self.fence.contains(at),
        }
    }

    /// Keep-in zones that are valid at no time of the dive.
    fn closed(&self, lasts_s: f64) -> Vec<String> {
        let span = self.span([0.0, lasts_s]);
        let zones = self.fence.zones().filter(|zone| match zone.kind() {
            Kind::KeepIn { .. } => !zone.window().meets(span),
            Kind::KeepOut { .. } => false,
        });
        let told = |zone: &backseat_fence::Zone| {
            let dive = span.map_or_else(|| "at an unknown time".to_owned(), |span| span.to_string());
            format!(
                "keep-in zone '{}': valid {}, expected to overlap the dive ({dive})",
                zone.name(),
                zone.window()
            )
        };
        zones.map(told).collect()
    }
}

impl Way {
    /// A time limit may end the behavior anywhere between its beginning and its end.
    fn end_anywhere(&mut self, behavior: &PlannedBehavior, frame: &LocalFrame, begun: Vec<EastNorth>) {
        match behavior.path {
            PlannedPath::Line { start, .. } => self.places.push(frame.to_local(start)),
            PlannedPath::Circle { centre, radius_m, .. } => {
                self.places.extend(square(frame.to_local(centre), radius_m));
            }
            PlannedPath::Waypoint { .. } | PlannedPath::Heading { .. } | PlannedPath::Nowhere => {}
        }
        self.places.extend(begun);
        // The direction stays the same if all positions lie on one line.
        let [end, before @ ..] = &self.places[..] else { return };
        self.bearing_deg = one_bearing_deg(before, &[*end]);
    }
}

/// The direction in which all of them lead, degrees, if they share one.
fn one_bearing_deg(from: &[EastNorth], to: &[EastNorth]) -> Option<f64> {
    let pairs = from.iter().flat_map(|from| to.iter().map(move |to| (*from, *to)));
    let mut bearings = pairs
        .filter(|(from, to)| from != to)
        .map(|(from, to)| from.bearing_deg(to));
    let first_deg = bearings.next()?;
    bearings
        .all(|bearing_deg| (bearing_deg - first_deg).abs() < SAME_WAY_DEG)
        .then_some(first_deg)
}

/// The corners of the square around a circle.
fn square(centre: EastNorth, radius_m: f64) -> Vec<EastNorth> {
    let corner = |bearing_deg| centre.offset(bearing_deg, radius_m * std::f64::consts::SQRT_2);
    vec![corner(45.0), corner(135.0), corner(225.0), corner(315.0)]
}

/// Everything that the limits and the fence allow but a vehicle of this class, with the limits `able`, cannot do.
#[must_use]
pub fn beyond_class(limits: &Limits, fence: &Fence, class: VehicleClass, able: &VehicleLimits) -> Vec<String> {
    let name = class.name();
    let mut findings = Vec::new();
    let mut over = |key: &str, value: f64, most: f64, unit: &str| {
        if value > most {
            findings.push(format!(
                "limits.{key} is {value}: expected at most the {most} {unit} of a {name} vehicle"
            ));
        }
    };
    over("speed_max_mps", limits.speed_max_mps, able.speed_max_mps, "m/s");
    over(
        "turn_rate_dps",
        limits.turn_rate_dps,
        able.yaw_rate_max_dps,
        "degrees a second",
    );
    if limits.speed_min_mps < able.speed_min_mps {
        findings.push(format!(
            "limits.speed_min_mps is {}: expected at least the {} m/s at which a {name} vehicle steers",
            limits.speed_min_mps, able.speed_min_mps
        ));
    }
    for zone in fence.zones() {
        if let Kind::KeepIn { depth, .. } = zone.kind()
            && depth.max_m > able.depth_max_m
        {
            findings.push(format!(
                "keep-in zone '{}': depth_max_m is {}: expected at most the {} m of a {name} vehicle",
                zone.name(),
                depth.max_m,
                able.depth_max_m
            ));
        }
    }
    findings
}
