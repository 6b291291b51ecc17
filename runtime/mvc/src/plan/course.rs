use core::time::Duration;

use backseat_units::math::{asin, atan, wrap_180};
use backseat_units::{EastNorth, Timestamp};

use crate::estimate::Estimate;
use crate::event::EndReason;
use crate::plan::{GpsTimes, Shape};
use crate::vehicle::performance::Performance;

/// A behavior that is being flown: the part of its shape that is flown now, the progress along it, and where to steer.
///
/// Its end depends only on progress (past the end along the line, the angle swept, the time), so a behavior also ends
/// when a modify has led the vehicle off its line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Course {
    shape: Shape,
    part: Part,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Part {
    /// To where the shape begins; for a waypoint, the whole behavior.
    Transit(Line),
    /// Along a trackline with its lead-in and lead-out.
    Along(Line),
    Around {
        last_bearing_deg: f64,
        swept_deg: f64,
    },
    Stay {
        until: Timestamp,
    },
    /// At the place of a GPS hit.
    Surface {
        since: Timestamp,
        /// Heading of the climb, degrees from the frame's north.
        heading_deg: f64,
        /// Since when the antenna is out of the water; `None` while it is under water.
        up_since: Option<Timestamp>,
    },
    Idle,
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Line {
    from: EastNorth,
    /// Unit vector.
    direction: EastNorth,
    bearing_deg: f64,
    length_m: f64,
}

/// Where the vehicle must go now to follow a course.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Steer {
    pub(crate) way: Way,
    /// Distance from the shape's own line, metres.
    pub(crate) off_line_m: f64,
    /// Why the course ends now; `None` while it goes on.
    pub(crate) end: Option<EndReason>,
}

/// How the vehicle must move.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Way {
    /// A course over ground, degrees from the frame's north.
    Course(f64),
    /// A heading, which the current may turn into another course, degrees from true north.
    Heading(f64),
    /// To the surface on a heading, degrees from the frame's north.
    Climb(f64),
    /// Thruster off.
    Drift,
}

impl Steer {
    const fn on(way: Way) -> Self {
        Self {
            way,
            off_line_m: 0.0,
            end: None,
        }
    }

    fn ending(self, reason: EndReason, when: bool) -> Self {
        Self {
            end: when.then_some(reason),
            ..self
        }
    }
}

impl Line {
    fn new(from: EastNorth, to: EastNorth) -> Self {
        let length_m = from.distance_m(to);
        let direction = if length_m > 0.0 {
            (to - from) * (1.0 / length_m)
        } else {
            EastNorth::new(0.0, 1.0)
        };
        Self {
            from,
            direction,
            bearing_deg: from.bearing_deg(to),
            length_m,
        }
    }

    /// The distance along the line and the distance to the right of it, metres.
    fn progress(&self, at: EastNorth) -> (f64, f64) {
        let from = at - self.from;
        (
            from.east_m * self.direction.east_m + from.north_m * self.direction.north_m,
            from.east_m * self.direction.north_m - from.north_m * self.direction.east_m,
        )
    }

    /// Line-of-sight steering: towards the point `lookahead_m` down the line (Fossen, *Handbook of Marine Craft
    /// Hydrodynamics and Motion Control*, 2011, section 10.3).
    fn steer(&self, at: EastNorth, lookahead_m: f64, capture_m: f64) -> Steer {
        let (along_m, right_m) = self.progress(at);
        let left_m = self.length_m - along_m;
        let captured = capture_m > 0.0 && left_m * left_m + right_m * right_m < capture_m * capture_m;
        Steer {
            way: Way::Course(self.bearing_deg - atan(right_m / lookahead_m).to_degrees()),
            off_line_m: right_m.abs(),
            end: (left_m <= 0.0 || captured).then_some(EndReason::Done),
        }
    }
}

/// Within this distance of a waypoint, or of the begin of a line or circle, the vehicle has reached it, metres.
const CAPTURE_M: f64 = 3.0;
/// Above this depth the antenna is out of the water, metres.
pub(crate) const SURFACED_M: f64 = 0.3;

impl Course {
    pub(crate) fn begin(shape: Shape, at: EastNorth, now: Timestamp) -> Self {
        let part = match shape {
            Shape::Waypoint { to } => Part::Transit(Line::new(at, to)),
            Shape::Trackline { start, .. } => Part::Transit(Line::new(at, start)),
            Shape::GpsHit { at: place, .. } => Part::Transit(Line::new(at, place)),
            Shape::Setpoint { duration, .. } => Part::Stay { until: now + duration },
            Shape::Command => Part::Stay { until: now },
            Shape::Idle => Part::Idle,
            Shape::Trackcircle {
                centre,
                radius_m,
                entry_deg,
                ..
            } => {
                let entry = centre.offset(entry_deg.unwrap_or_else(|| centre.bearing_deg(at)), radius_m);
                Part::Transit(Line::new(at, entry))
            }
        };
        Self { shape, part }
    }

    pub(crate) const fn shape(&self) -> &Shape {
        &self.shape
    }

    /// Goes on after a pause. The pause does not count for the times of a setpoint and of a GPS hit.
    pub(crate) fn resume(&mut self, paused: Duration) {
        match &mut self.part {
            Part::Stay { until } => *until = *until + paused,
            Part::Surface { since, up_since, .. } => {
                *since = *since + paused;
                *up_since = None;
            }
            Part::Transit(_) | Part::Along(_) | Part::Around { .. } | Part::Idle => {}
        }
    }

    /// Whether the vehicle is on a trackline, including its lead-in and lead-out, or on a trackcircle.
    pub(crate) const fn is_on_leg(&self) -> bool {
        matches!(self.part, Part::Along(_) | Part::Around { .. })
    }

    pub(crate) fn steer(
        &mut self,
        estimate: &Estimate,
        speed_mps: f64,
        performance: &Performance,
        now: Timestamp,
    ) -> Steer {
        let at = estimate.at;
        let lookahead_m = (4.0 * speed_mps / performance.yaw_gain_per_s.max(0.1)).clamp(4.0, 40.0);
        if let Part::Transit(line) = self.part {
            let steer = line.steer(at, lookahead_m, CAPTURE_M);
            if steer.end.is_none() {
                return steer;
            }
            match self.shape {
                Shape::Trackline { start, end } => self.part = Part::Along(Line::new(start, end)),
                Shape::Trackcircle { centre, .. } => {
                    self.part = Part::Around {
                        last_bearing_deg: centre.bearing_deg(at),
                        swept_deg: 0.0,
                    };
                }
                Shape::GpsHit { .. } => {
                    self.part = Part::Surface {
                        since: now,
                        heading_deg: estimate.heading_deg,
                        up_since: None,
                    };
                }
                Shape::Waypoint { .. } | Shape::Setpoint { .. } | Shape::Command | Shape::Idle => return steer,
            }
        }
        match &mut self.part {
            Part::Transit(line) => line.steer(at, lookahead_m, CAPTURE_M),
            Part::Along(line) => line.steer(at, lookahead_m, 0.0),
            Part::Around {
                last_bearing_deg,
                swept_deg,
            } => {
                let bearing_deg = circle_bearing_deg(&self.shape, at);
                *swept_deg += wrap_180(bearing_deg - *last_bearing_deg);
                *last_bearing_deg = bearing_deg;
                around(
                    &self.shape,
                    at,
                    bearing_deg,
                    *swept_deg,
                    speed_mps,
                    lookahead_m,
                    performance,
                )
            }
            Part::Stay { until } => {
                let heading_deg = match self.shape {
                    Shape::Setpoint { heading_deg, .. } => heading_deg,
                    Shape::Waypoint { .. }
                    | Shape::Trackline { .. }
                    | Shape::Trackcircle { .. }
                    | Shape::GpsHit { .. }
                    | Shape::Command
                    | Shape::Idle => 0.0,
                };
                Steer::on(Way::Heading(heading_deg)).ending(EndReason::Done, now >= *until)
            }
            Part::Surface {
                since,
                heading_deg,
                up_since,
            } => {
                if estimate.depth_m < SURFACED_M {
                    up_since.get_or_insert(now);
                } else {
                    *up_since = None;
                }
                surface(&self.shape, estimate, *since, *heading_deg, *up_since, now)
            }
            Part::Idle => Steer::on(Way::Drift),
        }
    }
}

/// At the place of a GPS hit: the vehicle climbs in a straight line, then drifts until the fix. If the payload brings
/// it up (manual mode, SPI 7.7), it goes to and fro over the place until then.
fn surface(
    shape: &Shape,
    estimate: &Estimate,
    since: Timestamp,
    heading_deg: f64,
    up_since: Option<Timestamp>,
    now: Timestamp,
) -> Steer {
    let Shape::GpsHit { at, climbs, times } = *shape else {
        return Steer::on(Way::Drift).ending(EndReason::Done, true);
    };
    let GpsTimes { fix, within } = times;
    let way = match up_since {
        Some(_) => Way::Drift,
        None if climbs => Way::Climb(heading_deg),
        None => Way::Course(estimate.at.bearing_deg(at)),
    };
    let fixed = up_since.is_some_and(|up| now >= up + fix);
    let end = if fixed {
        Some(EndReason::Done)
    } else {
        (now >= since + within).then_some(EndReason::TimedOut)
    };
    Steer { end, ..Steer::on(way) }
}

fn circle_bearing_deg(shape: &Shape, at: EastNorth) -> f64 {
    match shape {
        Shape::Trackcircle { centre, .. } => centre.bearing_deg(at),
        Shape::Waypoint { .. }
        | Shape::Trackline { .. }
        | Shape::Setpoint { .. }
        | Shape::GpsHit { .. }
        | Shape::Command
        | Shape::Idle => 0.0,
    }
}

fn around(
    shape: &Shape,
    at: EastNorth,
    bearing_deg: f64,
    swept_deg: f64,
    speed_mps: f64,
    lookahead_m: f64,
    performance: &Performance,
) -> Steer {
    let Shape::Trackcircle {
        centre,
        radius_m,
        orbits,
        ..
    } = *shape
    else {
        return Steer::on(Way::Course(bearing_deg)).ending(EndReason::Done, true);
    };
    let out_m = centre.distance_m(at) - radius_m;
    // The turn lags behind the demand: ask for the direction that the tangent will have by then.
    let lead_deg = (speed_mps / radius_m * (performance.yaw_tau_s + 1.0 / performance.yaw_gain_per_s))
        .to_degrees()
        .min(60.0);
    let inward_deg = 90.0 + atan(out_m / lookahead_m).to_degrees() + lead_deg;
    let side = orbits.signum();
    let wanted_deg = orbits.abs() * 360.0;
    // On a circle as narrow as its own turning circle, a vehicle can go around in the wrong direction for ever. The
    // circle then ends after one to two laps in that direction, at the same place.
    let wrong_deg = (orbits.abs() + 1.0).ceil() * 360.0 - wanted_deg;
    let done = swept_deg * side >= wanted_deg || -swept_deg * side >= wrong_deg;
    Steer {
        way: Way::Course(bearing_deg + side * inward_deg),
        off_line_m: out_m.abs(),
        end: done.then_some(EndReason::Done),
    }
}

/// The heading with which the vehicle keeps a course over ground in a current, degrees from the frame's north.
pub(crate) fn crabbed_deg(bearing_deg: f64, speed_mps: f64, current: (f64, f64)) -> f64 {
    if current == (0.0, 0.0) || speed_mps < 0.1 {
        return bearing_deg;
    }
    let (sin, cos) = backseat_units::math::sin_cos(bearing_deg.to_radians());
    let set_right_mps = current.0 * cos - current.1 * sin;
    bearing_deg - asin((set_right_mps / speed_mps).clamp(-0.9, 0.9)).to_degrees()
}
