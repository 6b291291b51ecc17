use std::collections::VecDeque;

use crate::earth::{Position, wrap_180};
use crate::flaws::{Flaw, What};
use crate::limits::Limits;
use crate::moment::Moment;
use crate::plane::{Plane, Point, Vector, length_m};
use crate::time_of_day::TimeOfDay;
use crate::wire::{Fix, Velocities};

/// The longest window, seconds.
const WINDOW_S: f64 = 9.5;
/// How often the newest sample is compared with those before it, seconds of the solutions' time.
const JUDGED_EVERY_S: f64 = 0.5;
/// All samples of a stretch this long must disagree with the later one, so that no single sample is to blame, seconds.
const STRETCH_S: f64 = 0.5;
/// How much the decimals of the sentences and two frames can add, metres.
const SLACK_M: f64 = 0.5;
/// After a longer gap a new window starts, seconds.
const GAP_S: f64 = 2.9;
/// Velocities whose timestamp differs by more from that of a position belong to another position, nanoseconds.
const OF_ONE_TIME_NS: i64 = 500_000_000;
/// The vehicle receives no GPS deeper than this, metres. Above it, GPS can move the solution by any distance.
const SURFACE_M: f64 = 5.0;
/// Solutions older than the newest are ignored for so long, seconds: a runtime that uses the newest solution ignores
/// them too.
const OLD_FOR_S: f64 = 100.0;
/// How much the times of hearing two sentences can change the time between them, seconds.
const HEARD_S: f64 = 0.2;

/// Compares the reported navigation with the truth, over windows.
///
/// Position and velocities can both be wrong, and no payload can see an error that they share. So for each window this
/// computes how much the error of the position has changed, less how much of that change the reported velocities have
/// too. If the result is more than the mission's step plus its drift for each second of the window, position and
/// velocities alone must show the contradiction, whatever they are compared with. The comparison with the truth can
/// only find fewer errors.
#[derive(Clone, Debug, Default)]
pub(crate) struct Integrity {
    step_m: f64,
    drift_mps: f64,
    velocity_gap_s: f64,
    truth: Option<Position>,
    /// The newest fix whose velocities have not come, and when it came.
    incomplete: Option<(Moment, Fix)>,
    /// The time since which no fix had velocities.
    without_since: Option<Moment>,
    last: Option<Sample>,
    /// The newest solution, and when it came.
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
    /// Seconds of the solutions' time since the window began.
    at_s: f64,
    place_m: Vector,
    truth_m: Vector,
    velocity_mps: Vector,
    /// The integral of the velocities since the window began.
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

    /// Forgets everything: earlier navigation cannot be compared with what comes next.
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

    /// Whether there is a window.
    pub(crate) fn has_window(&self) -> bool {
        !self.window.is_empty()
    }

    /// Whether there is navigation.
    pub(crate) const fn has_navigation(&self) -> bool {
        self.newest.is_some()
    }

    /// The vehicle reports its position. Returns a flaw if it has reported positions without velocities for too long.
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

    /// The vehicle reports its velocities. Returns a flaw if they and its positions cannot both be true.
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
            // The second length is seldom needed.
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
