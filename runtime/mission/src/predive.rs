//! What can be known before a dive: the front seat's plan against the fence, and the limits against the vehicle's class.
//!
//! The plan is judged as the vehicle will fly it: every leg and rim whole, with the tracking error of the limits, at its
//! depths or altitudes, and at its time. What the backseat adds to it is judged when it is asked for.

use std::time::Duration;

use backseat_core::Limits;
use backseat_fence::{Breach, Clearance, Fence, Kind, Shape, Span, Sweep, VerticalExtent};
use backseat_mvc::{Hull, HullClass, PlannedBehavior, PlannedPath, PlannedVertical};
use backseat_units::{EastNorth, Position, Utc};

mod reach;

/// Nothing shallower is known of the seabed: no altitude is too low.
const ALTITUDE_UNKNOWN_M: f64 = 1e6;

/// A dive as it is planned.
#[derive(Clone, Copy, Debug)]
pub struct Dive<'a> {
    /// Where the vehicle may be.
    pub fence: &'a Fence,
    /// What the operator allows, and how well the vehicle keeps its way.
    pub limits: &'a Limits,
    /// What the front seat does, in order.
    pub plan: &'a [PlannedBehavior],
    /// Where it begins; at the plan's first place where that is not known.
    pub start: Option<Position>,
    /// When it begins.
    pub utc: Utc,
}

/// Where the vehicle is on its way through the plan.
struct Way {
    at: EastNorth,
    /// It may be so far from there, metres.
    spread_m: f64,
    depths_m: Option<[f64; 2]>,
    /// Since the start, seconds, at the earliest and at the latest.
    since_s: [f64; 2],
}

impl Dive<'_> {
    /// Whatever keeps the plan from being flown inside the fence, a line each, with the place.
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
            findings.push("plan: it leads nowhere, expected a place".to_owned());
            return findings;
        };
        let mut way = Way {
            at: frame.to_local(start),
            spread_m: 0.0,
            depths_m: None,
            since_s: [0.0; 2],
        };
        if let Err(breach) = self.contains(way.at, self.span([0.0; 2])) {
            findings.push(format!("start: {breach}"));
        }
        let mut inside = vec![way.at];
        for behavior in self.plan {
            self.fly(behavior, &mut way, &mut findings);
            inside.push(way.at);
        }
        findings.extend(reach::unreachable(self.fence, &inside));
        findings.extend(self.closed(way.since_s[1]));
        findings
    }

    /// Judges a behavior and goes on to its end.
    fn fly(&self, behavior: &PlannedBehavior, way: &mut Way, findings: &mut Vec<String>) {
        let place = format!("plan element {}", behavior.element);
        let frame = self.fence.frame();
        let strayed_m = self.limits.tracking_error_m;
        let mut legs: Vec<(Shape, f64, f64)> = Vec::new();
        let (from, from_m) = (way.at, way.spread_m);
        let to = |to: EastNorth| (Shape::leg(from, to), strayed_m + from_m, from.distance_m(to));
        let (end, spread_m) = match behavior.path {
            PlannedPath::Nowhere => return,
            PlannedPath::Waypoint { to: waypoint } => {
                let waypoint = frame.to_local(waypoint);
                legs.push(to(waypoint));
                (waypoint, 0.0)
            }
            PlannedPath::Line { start, end } => {
                let (start, end) = (frame.to_local(start), frame.to_local(end));
                legs.push(to(start));
                legs.push((Shape::leg(start, end), strayed_m, start.distance_m(end)));
                (end, 0.0)
            }
            PlannedPath::Circle {
                centre,
                radius_m,
                orbits,
                entry_deg,
            } => {
                let convergence_deg = frame.convergence_deg(centre);
                let centre = frame.to_local(centre);
                let entry_deg =
                    entry_deg.map_or_else(|| centre.bearing_deg(way.at), |entry_deg| entry_deg - convergence_deg);
                legs.push(to(centre.offset(entry_deg, radius_m)));
                let round_m = std::f64::consts::TAU * radius_m * orbits.abs();
                legs.push((Shape::rim(centre, radius_m), strayed_m, round_m));
                (centre.offset(entry_deg + 360.0 * orbits, radius_m), 0.0)
            }
            PlannedPath::Heading { heading_deg, duration } => {
                let heading_deg = heading_deg - frame.convergence_deg(frame.to_position(way.at));
                let end = way.at.offset(heading_deg, behavior.speed_mps * duration.as_secs_f64());
                // Nothing holds it against the current.
                let spread_m = way.spread_m + self.limits.current_max_mps * duration.as_secs_f64();
                legs.push((Shape::leg(way.at, end), strayed_m + spread_m, way.at.distance_m(end)));
                (end, spread_m)
            }
        };
        let depths_m = self.depths_m(behavior.vertical);
        for (shape, radius_m, length_m) in legs {
            let begun_s = way.since_s[0];
            way.since_s = self.later(way.since_s, behavior, length_m + way.spread_m);
            let span = self.span([begun_s, way.since_s[1]]);
            let judged = match depths_m {
                Some(own_m) => {
                    let passed_m = way.depths_m.unwrap_or(own_m);
                    let extent = VerticalExtent {
                        depth_min_m: own_m[0].min(passed_m[0]).max(0.0),
                        depth_max_m: own_m[1].max(passed_m[1]),
                        altitude_min_m: self.altitude_m(behavior.vertical),
                    };
                    self.check(&Sweep::new(shape, radius_m), &extent, span)
                }
                // Nothing tells its depths: where it leads must be inside at least.
                None => self.contains(end, span),
            };
            if let Err(breach) = judged {
                findings.push(format!("{place}: {breach}"));
            }
            way.depths_m = depths_m;
        }
        if depths_m.is_none() {
            findings.push(format!(
                "{place}: an altitude leads to depths that nobody knows, expected water_depth_min_m and water_depth_max_m \
                 in [limits]"
            ));
        }
        if self.fence.changes() && behavior.speed_mps < self.limits.speed_min_mps {
            findings.push(format!(
                "{place}: its speed is {} m/s, expected at least limits.speed_min_mps of {}, by which the times of zones are \
                 counted",
                behavior.speed_mps, self.limits.speed_min_mps
            ));
        }
        (way.at, way.spread_m) = (end, spread_m);
    }

    /// The depths of a setpoint; `None` where they hang on a seabed that no limit tells of.
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

    /// How long a way takes, seconds, at least and at most; the most is infinite where the current may hold the vehicle.
    fn seconds(&self, behavior: &PlannedBehavior, length_m: f64) -> [f64; 2] {
        let current_mps = self.limits.current_max_mps;
        let slowest_mps = behavior.speed_mps - current_mps;
        let most_s = if slowest_mps > 0.0 {
            length_m / slowest_mps
        } else {
            f64::INFINITY
        };
        [length_m / (behavior.speed_mps + current_mps), most_s]
    }

    fn later(&self, since_s: [f64; 2], behavior: &PlannedBehavior, length_m: f64) -> [f64; 2] {
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

    fn check(&self, sweep: &Sweep, extent: &VerticalExtent, span: Option<Span>) -> Result<Clearance, Breach> {
        match span {
            Some(span) => self.fence.during(span).check(sweep, extent),
            None => self.fence.check(sweep, extent),
        }
    }

    fn contains(&self, at: EastNorth, span: Option<Span>) -> Result<Clearance, Breach> {
        match span {
            Some(span) => self.fence.during(span).contains(at),
            None => self.fence.contains(at),
        }
    }

    /// Inclusion zones that hold at no time of the dive.
    fn closed(&self, lasts_s: f64) -> Vec<String> {
        let span = self.span([0.0, lasts_s]);
        let zones = self.fence.zones().filter(|zone| match zone.kind() {
            Kind::Inclusion { .. } => !zone.window().meets(span),
            Kind::Exclusion { .. } => false,
        });
        let told = |zone: &backseat_fence::Zone| {
            let dive = span.map_or_else(|| "at a time that nobody knows".to_owned(), |span| span.to_string());
            format!(
                "inclusion '{}': valid {}, expected some of the dive in it ({dive})",
                zone.name(),
                zone.window()
            )
        };
        zones.map(told).collect()
    }
}

/// What the limits and the fence allow and a hull of the class cannot do.
#[must_use]
pub fn beyond_class(limits: &Limits, fence: &Fence, class: HullClass, hull: &Hull) -> Vec<String> {
    let name = class.name();
    let mut findings = Vec::new();
    let mut over = |key: &str, value: f64, most: f64, unit: &str| {
        if value > most {
            findings.push(format!(
                "limits.{key} is {value}: expected at most the {most} {unit} of a {name} hull"
            ));
        }
    };
    over("speed_max_mps", limits.speed_max_mps, hull.speed_max_mps, "m/s");
    over(
        "turn_rate_dps",
        limits.turn_rate_dps,
        hull.yaw_rate_max_dps,
        "degrees a second",
    );
    if limits.speed_min_mps < hull.speed_min_mps {
        findings.push(format!(
            "limits.speed_min_mps is {}: expected at least the {} m/s at which a {name} hull steers",
            limits.speed_min_mps, hull.speed_min_mps
        ));
    }
    for zone in fence.zones() {
        if let Kind::Inclusion { depth, .. } = zone.kind()
            && depth.max_m > hull.depth_max_m
        {
            findings.push(format!(
                "inclusion '{}': depth_max_m is {}: expected at most the {} m of a {name} hull",
                zone.name(),
                depth.max_m,
                hull.depth_max_m
            ));
        }
    }
    findings
}
