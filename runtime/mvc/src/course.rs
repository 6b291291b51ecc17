use core::time::Duration;

use backseat_units::math::{asin, atan, wrap_180};
use backseat_units::{EastNorth, Timestamp};

use crate::hull::Hull;
use crate::plan::Shape;

/// One behavior being flown: which part of its shape comes now, how far it has got, and where to steer.
///
/// Its end condition looks at progress alone (past the end along the line, the angle swept, the time), so that a
/// behavior also ends where a payload's modify has led the vehicle off its line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Course {
    shape: Shape,
    part: Part,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Part {
    /// To where the shape begins, or a waypoint's whole.
    Transit(Line),
    /// A trackline itself.
    Along(Line),
    Around {
        last_bearing_deg: f64,
        swept_deg: f64,
    },
    Hold {
        until: Timestamp,
    },
}

#[derive(Clone, Copy, Debug, PartialEq)]
struct Line {
    from: EastNorth,
    /// Unit vector.
    direction: EastNorth,
    bearing_deg: f64,
    length_m: f64,
}

/// Where a course wants the vehicle to go now.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Steer {
    /// Course over ground, degrees from the frame's north; for a setpoint the heading.
    pub(crate) bearing_deg: f64,
    /// Whether the bearing is a heading that the current may set off.
    pub(crate) is_heading: bool,
    /// Distance from the shape's own line, metres.
    pub(crate) off_line_m: f64,
    pub(crate) done: bool,
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

    /// Metres along the line, and to the right of it.
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
            bearing_deg: self.bearing_deg - atan(right_m / lookahead_m).to_degrees(),
            is_heading: false,
            off_line_m: right_m.abs(),
            done: left_m <= 0.0 || captured,
        }
    }
}

/// How near a waypoint, or the begin of a line or circle, counts as there, metres.
const CAPTURE_M: f64 = 3.0;

impl Course {
    pub(crate) fn begin(shape: Shape, at: EastNorth, now: Timestamp) -> Self {
        let part = match shape {
            Shape::Waypoint { to } => Part::Transit(Line::new(at, to)),
            Shape::Trackline { start, .. } => Part::Transit(Line::new(at, start)),
            Shape::Setpoint { duration, .. } => Part::Hold { until: now + duration },
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

    /// Goes on after a pause, which a setpoint's time does not count.
    pub(crate) fn resume(&mut self, paused: Duration) {
        if let Part::Hold { until } = &mut self.part {
            *until = *until + paused;
        }
    }

    pub(crate) fn steer(&mut self, at: EastNorth, speed_mps: f64, hull: &Hull, now: Timestamp) -> Steer {
        let lookahead_m = (4.0 * speed_mps / hull.yaw_gain_per_s.max(0.1)).clamp(4.0, 40.0);
        if let Part::Transit(line) = self.part {
            let steer = line.steer(at, lookahead_m, CAPTURE_M);
            if !steer.done {
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
                Shape::Waypoint { .. } | Shape::Setpoint { .. } => return steer,
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
                around(&self.shape, at, bearing_deg, *swept_deg, speed_mps, lookahead_m, hull)
            }
            Part::Hold { until } => {
                let bearing_deg = match self.shape {
                    Shape::Setpoint { heading_deg, .. } => heading_deg,
                    Shape::Waypoint { .. } | Shape::Trackline { .. } | Shape::Trackcircle { .. } => 0.0,
                };
                Steer {
                    bearing_deg,
                    is_heading: true,
                    off_line_m: 0.0,
                    done: now >= *until,
                }
            }
        }
    }
}

fn circle_bearing_deg(shape: &Shape, at: EastNorth) -> f64 {
    match shape {
        Shape::Trackcircle { centre, .. } => centre.bearing_deg(at),
        Shape::Waypoint { .. } | Shape::Trackline { .. } | Shape::Setpoint { .. } => 0.0,
    }
}

fn around(
    shape: &Shape,
    at: EastNorth,
    bearing_deg: f64,
    swept_deg: f64,
    speed_mps: f64,
    lookahead_m: f64,
    hull: &Hull,
) -> Steer {
    let Shape::Trackcircle {
        centre,
        radius_m,
        orbits,
        ..
    } = *shape
    else {
        return Steer {
            bearing_deg,
            is_heading: false,
            off_line_m: 0.0,
            done: true,
        };
    };
    let out_m = centre.distance_m(at) - radius_m;
    // The turn lags behind what is asked for: ask for where the tangent will be.
    let lead_deg = (speed_mps / radius_m * (hull.yaw_tau_s + 1.0 / hull.yaw_gain_per_s))
        .to_degrees()
        .min(60.0);
    let inward_deg = 90.0 + atan(out_m / lookahead_m).to_degrees() + lead_deg;
    let side = orbits.signum();
    Steer {
        bearing_deg: bearing_deg + side * inward_deg,
        is_heading: false,
        off_line_m: out_m.abs(),
        done: swept_deg * side >= orbits.abs() * 360.0,
    }
}

/// The heading that makes good a course over ground in a current, degrees from the frame's north.
pub(crate) fn crabbed_deg(bearing_deg: f64, speed_mps: f64, current: (f64, f64)) -> f64 {
    if current == (0.0, 0.0) || speed_mps < 0.1 {
        return bearing_deg;
    }
    let (sin, cos) = backseat_units::math::sin_cos(bearing_deg.to_radians());
    let set_right_mps = current.0 * cos - current.1 * sin;
    bearing_deg - asin((set_right_mps / speed_mps).clamp(-0.9, 0.9)).to_degrees()
}
