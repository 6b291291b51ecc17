use std::collections::VecDeque;

use crate::earth::{Position, wrap_180};
use crate::flaws::{Flaw, What};
use crate::limits::Limits;
use crate::moment::Moment;
use crate::plane::{Plane, Point, Vector, length_m};
use crate::time_of_day::TimeOfDay;
use crate::wire::{Fix, Velocities};

/// No window is longer, seconds.
const WINDOW_S: f64 = 9.5;
/// Each so often, by the solutions' time, the newest sample is held against those before it, seconds.
const JUDGED_EVERY_S: f64 = 0.5;
/// The samples that disagree with a later one are those of so long a stretch, so that no single one is to blame, seconds.
const STRETCH_S: f64 = 0.5;
/// What the wire's decimals and two frames may add, metres.
const SLACK_M: f64 = 0.5;
/// After a gap as long as this a window begins anew, seconds.
const GAP_S: f64 = 2.9;
/// Velocities that were said so long before or after a place are of another one, nanoseconds.
const OF_ONE_TIME_NS: i64 = 500_000_000;
/// GPS is heard no deeper than this, metres: there it may move the solution as it likes.
const SURFACE_M: f64 = 5.0;
/// Solutions that are older than the newest are left out for so long: whoever goes by the newest hears nothing of them.
const OLD_FOR_S: f64 = 100.0;
/// What two moments of hearing may make of a time between them, seconds.
const HEARD_S: f64 = 0.2;

/// What navigation says, held against the truth over windows.
///
/// Place and velocities may both be wrong: an error that they share no payload can see. So what is counted of a window is
/// how much the error of the place has changed within it, less how much of that the told velocities have wrong too. More
/// than the mission's step and its drift for each second of the window must show in place and velocities alone, whatever
/// the truth is compared with: that only makes this find less.
#[derive(Clone, Debug, Default)]
pub(crate) struct Integrity {
    step_m: f64,
    drift_mps: f64,
    velocity_gap_s: f64,
    truth: Option<Position>,
    /// Where the newest fix was told whose velocities have not come.
    incomplete: Option<(Moment, Fix)>,
    /// Since when no fix had velocities.
    without_since: Option<Moment>,
    last: Option<Sample>,
    /// The newest solution, and when it was told.
    newest: Option<(TimeOfDay, Moment)>,
    frame: Option<(Position, Plane)>,
    was_by_gps: bool,
    judged_s: f64,
    window: VecDeque<Sample>,
}

/// A fix with its velocities.
#[derive(Clone, Copy, Debug)]
struct Sample {
    told: Moment,
    solution: TimeOfDay,
    /// By the solutions' time since the window began.
    at_s: f64,
    place_m: Vector,
    truth_m: Vector,
    velocity_mps: Vector,
    /// What the velocities add up to.
    way_m: Vector,
}

impl Integrity {
    pub(crate) fn new(limits: &Limits) -> Self {
        Self {
            step_m: limits.position_step_m,
            drift_mps: limits.position_drift_mps,
            velocity_gap_s: limits.velocity_gap_s,
            ..Self::default()
        }
    }

    /// What came before says nothing of what comes.
    pub(crate) fn cut(&mut self) {
        self.restart();
        self.incomplete = None;
        self.without_since = None;
        self.newest = None;
    }

    fn restart(&mut self) {
        self.window.clear();
        self.last = None;
        self.frame = None;
    }

    /// Where the vehicle truly is.
    pub(crate) fn truth(&mut self, position: Position) {
        self.truth = Some(position);
    }

    /// Whether there are windows.
    pub(crate) fn has_window(&self) -> bool {
        !self.window.is_empty()
    }

    /// Whether there is navigation.
    pub(crate) const fn has_navigation(&self) -> bool {
        self.newest.is_some()
    }

    /// The vehicle tells its place. A flaw where it has told it without velocities for too long.
    pub(crate) fn fix(&mut self, at: Moment, fix: Fix) -> Option<Flaw> {
        if let Some((newest, told)) = self.newest
            && fix.solution.nanos_since(newest) <= 0
        {
            if at.since(told).as_secs_f64() < OLD_FOR_S {
                return None;
            }
            self.restart();
        }
        self.newest = Some((fix.solution, at));
        if self.incomplete.is_none() {
            self.without_since = Some(at);
        }
        self.incomplete = Some((at, fix));
        let for_s = at.since(self.without_since?).as_secs_f64();
        (for_s > self.velocity_gap_s + HEARD_S).then_some(Flaw {
            since: at,
            told: at,
            what: What::NoVelocity { for_s },
        })
    }

    /// The vehicle tells its velocities. A flaw where they and its place cannot both be true.
    pub(crate) fn velocities(&mut self, told: &Velocities) -> Option<Flaw> {
        let (at, fix) = self.incomplete?;
        if told.created.nanos_since(fix.created).abs() > OF_ONE_TIME_NS {
            return None;
        }
        self.incomplete = None;
        self.without_since = None;
        let by_gps = fix.by_gps && fix.depth_m <= SURFACE_M;
        if core::mem::replace(&mut self.was_by_gps, by_gps) || by_gps {
            self.restart();
        }
        let elapsed_s = self
            .last
            .map_or(0.0, |last| fix.solution.nanos_since(last.solution) as f64 / 1e9);
        if !(0.0..=GAP_S).contains(&elapsed_s) {
            self.restart();
        }
        let truth = self.truth?;
        let (origin, plane) = *self.frame.get_or_insert_with(|| {
            let y = truth.latitude_deg;
            (truth, Plane::at(Point { x: 0.0, y }))
        });
        let place_m = |position: Position| {
            plane.vector(Point {
                x: wrap_180(position.longitude_deg - origin.longitude_deg),
                y: position.latitude_deg,
            })
        };
        let velocity_mps = [told.east_mps, told.north_mps];
        let mut sample = Sample {
            told: at,
            solution: fix.solution,
            at_s: 0.0,
            place_m: place_m(fix.position),
            truth_m: place_m(truth),
            velocity_mps,
            way_m: [0.0; 2],
        };
        if let Some(last) = &self.last {
            sample.at_s = last.at_s + elapsed_s;
            for axis in [0, 1] {
                let mean_mps = (last.velocity_mps[axis] + velocity_mps[axis]) / 2.0;
                sample.way_m[axis] = last.way_m[axis] + mean_mps * elapsed_s;
            }
        } else {
            self.judged_s = 0.0;
        }
        self.last = Some(sample);
        while self
            .window
            .front()
            .is_some_and(|first| sample.at_s - first.at_s > WINDOW_S)
        {
            self.window.pop_front();
        }
        let mut flaw = None;
        if sample.at_s - self.judged_s >= JUDGED_EVERY_S {
            self.judged_s = sample.at_s;
            flaw = self.disagreement(&sample);
        }
        self.window.push_back(sample);
        flaw
    }

    /// The latest stretch of the window that disagrees with the newest sample.
    fn disagreement(&self, newest: &Sample) -> Option<Flaw> {
        let mut stretch_ends_s = None;
        for before in self.window.iter().rev() {
            let span_s = newest.at_s - before.at_s;
            let moved = |of: fn(&Sample) -> Vector| {
                let (now, then) = (of(newest), of(before));
                let (truth_now, truth_then) = (newest.truth_m, before.truth_m);
                length_m([0, 1].map(|axis| (now[axis] - then[axis]) - (truth_now[axis] - truth_then[axis])))
            };
            let off_m = moved(|sample| sample.place_m);
            let allowed_m = self.step_m + self.drift_mps * span_s + SLACK_M;
            // Most never come to the second length.
            if off_m <= allowed_m || off_m <= allowed_m + moved(|sample| sample.way_m) {
                stretch_ends_s = None;
                continue;
            }
            let ends_s = *stretch_ends_s.get_or_insert(before.at_s);
            if ends_s - before.at_s >= STRETCH_S {
                return Some(Flaw {
                    since: before.told,
                    told: newest.told,
                    what: What::Untrue { off_m, span_s },
                });
            }
        }
        None
    }
}
