use std::time::Duration;

use crate::earth::wrap_180;
use crate::moment::Moment;
use crate::time_of_day::TimeOfDay;

use crate::plane::{Plane, Point, length_m};
use crate::wire::Fix;

/// The greatest speed of a vehicle, m/s: twice that of the fastest, in a strong current.
const SPEED_MAX_MPS: f64 = 5.0;
/// A step that exceeds the way at that speed by more than this is a jump under any interpretation, metres.
const JUMP_M: f64 = 50.0;
/// Within this distance to the north or south, a degree has the same length to a thousandth.
const PLANE_DEG: f64 = 0.02;

/// The age of the vehicle's newest navigation, by the time of its solution, and the position that it reports. A new
/// arrival alone does not make navigation fresh.
#[derive(Clone, Debug, Default)]
pub(crate) struct Navigation {
    newest: Option<Newest>,
    /// The fixes of this connection: the newest, one that the runtime may not have heard yet, and one that it certainly
    /// has heard.
    told: Option<Told>,
    on_its_way: Option<Told>,
    /// When bottom lock was last reported on this connection.
    locked: Option<Moment>,
    /// When the solutions' time last went back on this connection.
    went_back: Option<Moment>,
    /// The record has a gap until this time.
    unseen_until: Option<Moment>,
    heard: Option<Told>,
    /// The last fix on any connection, and the plane at a latitude near it, degrees.
    last: Option<(Told, (Plane, f64))>,
    jump: Option<Jump>,
    /// The state before the newest fix, if the solutions' time went back with that fix, which may be damaged.
    before: Option<Box<Self>>,
}

#[derive(Clone, Copy, Debug)]
struct Newest {
    solution: TimeOfDay,
    /// The same, counted on over midnight, nanoseconds.
    solution_ns: i64,
    /// The smallest difference yet between the run's time of a fix and the time of its solution, nanoseconds.
    offset_ns: i64,
}

/// A fix, and when it came.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Told {
    pub(crate) at: Moment,
    pub(crate) fix: Fix,
}

/// A step of the reported position that no vehicle can make.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Jump {
    pub(crate) at: Moment,
    pub(crate) step_m: f64,
    /// How much of the solutions' time has passed since.
    steady: Duration,
}

impl Jump {
    /// How long navigation has been steady since, by the clock that shows more.
    pub(crate) fn steady(&self, now: Moment) -> Duration {
        self.steady.max(now.since(self.at))
    }
}

impl Navigation {
    /// A solution that is older than the newest by more than this comes from another clock, nanoseconds.
    const RESTART_NS: i64 = -50_000_000;
    /// The solutions' time may advance by so much more than the run's time, nanoseconds.
    const AHEAD_NS: i64 = 1_000_000_000;

    /// Forgets what belongs to one connection only.
    pub(crate) fn cut(&mut self) {
        self.newest = None;
        self.told = None;
        self.locked = None;
        self.went_back = None;
        self.unseen_until = None;
        self.on_its_way = None;
        self.heard = None;
        self.before = None;
    }

    /// Forgets everything: a new process has heard nothing.
    pub(crate) fn clear(&mut self) {
        *self = Self::default();
    }

    /// The record has a gap until now. The newest solution may be of this moment, and so may a bottom lock.
    pub(crate) fn forget(&mut self, at: Moment) {
        *self = Self {
            unseen_until: Some(at),
            locked: Some(at),
            ..Self::default()
        };
    }

    /// The vehicle sent a BFNVG. Returns whether its solution time advanced. `sure` is the longest time until the
    /// runtime has certainly heard it.
    pub(crate) fn heard(&mut self, at: Moment, fix: Fix, sure: Duration) -> bool {
        self.pass_over_stray(at, fix.solution);
        let before = self.goes_back_to(fix.solution).then(|| Box::new(self.clone()));
        if !self.advances(at, fix.solution) {
            return false;
        }
        self.before = before;
        let told = Told { at, fix };
        if fix.locked {
            self.locked = Some(at);
        }
        self.step(told);
        self.told = Some(told);
        if let Some(before) = self.on_its_way.take_if(|before| before.at + sure <= at) {
            self.heard = Some(before);
        }
        self.on_its_way.get_or_insert(told);
        true
    }

    /// Whether a solution's time comes from another clock.
    fn goes_back_to(&self, solution: TimeOfDay) -> bool {
        self.newest
            .is_some_and(|newest| solution.nanos_since(newest.solution) < Self::RESTART_NS)
    }

    /// If only the last fix had gone back in time, restores the state before it: a runtime that ignores old solutions
    /// has not used that fix.
    fn pass_over_stray(&mut self, at: Moment, solution: TimeOfDay) {
        let Some(before) = self.before.take() else { return };
        let Some((told, newest)) = before.told.zip(before.newest) else {
            return;
        };
        let passed_ns = nanos(at).saturating_sub(nanos(told.at));
        let solved_ns = solution.nanos_since(newest.solution);
        if solved_ns > 0 && solved_ns <= passed_ns.saturating_add(Self::AHEAD_NS) {
            *self = *before;
        }
    }

    fn advances(&mut self, at: Moment, solution: TimeOfDay) -> bool {
        let at_ns = nanos(at);
        let Some(newest) = &mut self.newest else {
            let solution_ns = nanos_of(solution);
            self.newest = Some(Newest {
                solution,
                solution_ns,
                offset_ns: at_ns - solution_ns,
            });
            return true;
        };
        let step_ns = solution.nanos_since(newest.solution);
        if step_ns < Self::RESTART_NS {
            self.newest = None;
            self.went_back = Some(at);
            return self.advances(at, solution);
        }
        if step_ns <= 0 {
            return false;
        }
        newest.solution = solution;
        newest.solution_ns = newest.solution_ns.saturating_add(step_ns);
        newest.offset_ns = newest.offset_ns.min(at_ns.saturating_sub(newest.solution_ns));
        true
    }

    /// Looks for a jump since the last fix, on whatever connection that came.
    fn step(&mut self, told: Told) {
        let plane_at = |fix: &Fix| {
            let y = fix.position.latitude_deg;
            (Plane::at(Point { x: 0.0, y }), y)
        };
        let Some((last, (plane, latitude_deg))) = &mut self.last else {
            self.last = Some((told, plane_at(&told.fix)));
            return;
        };
        let step_m = length_m(plane.vector(Point {
            x: wrap_180(told.fix.position.longitude_deg - last.fix.position.longitude_deg),
            y: *latitude_deg + told.fix.position.latitude_deg - last.fix.position.latitude_deg,
        }));
        let solved_ns = told.fix.solution.nanos_since(last.fix.solution);
        let solved = Duration::from_nanos(u64::try_from(solved_ns).unwrap_or(0));
        let passed = solved.max(told.at.since(last.at));
        if step_m > SPEED_MAX_MPS * passed.as_secs_f64() + JUMP_M {
            self.jump = Some(Jump {
                at: told.at,
                step_m,
                steady: Duration::ZERO,
            });
        } else if let Some(jump) = &mut self.jump {
            jump.steady += solved;
        }
        *last = told;
        if (told.fix.position.latitude_deg - *latitude_deg).abs() > PLANE_DEG {
            (*plane, *latitude_deg) = plane_at(&told.fix);
        }
    }

    /// The age of the newest solution; `None` if there was none on this connection.
    pub(crate) fn age(&self, now: Moment) -> Option<Duration> {
        let Some(newest) = self.newest else {
            return self.unseen_until.map(|until| now.since(until));
        };
        let solved_ns = newest.solution_ns.saturating_add(newest.offset_ns);
        let age_ns = nanos(now).saturating_sub(solved_ns);
        Some(Duration::from_nanos(u64::try_from(age_ns).unwrap_or(0)))
    }

    /// The newest fix that the runtime has certainly heard.
    pub(crate) fn heard_for_sure(&self, now: Moment, sure: Duration) -> Option<Told> {
        let heard = |told: &Told| told.at + sure <= now;
        self.told.filter(heard).or(self.on_its_way.filter(heard)).or(self.heard)
    }

    /// The newest fix of this connection.
    pub(crate) const fn newest(&self) -> Option<Told> {
        self.told
    }

    /// When bottom lock was last reported on this connection.
    pub(crate) const fn locked(&self) -> Option<Moment> {
        self.locked
    }

    /// When the solutions' time last went back. A runtime that takes later solutions for old sees no jump in them, and
    /// soon has no navigation.
    pub(crate) const fn went_back(&self) -> Option<Moment> {
        self.went_back
    }

    /// The last jump.
    pub(crate) const fn jump(&self) -> Option<Jump> {
        self.jump
    }
}

fn nanos(at: Moment) -> i64 {
    i64::try_from(at.as_nanos()).unwrap_or(i64::MAX)
}

fn nanos_of(time: TimeOfDay) -> i64 {
    i64::try_from(time.as_nanos()).unwrap_or(i64::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_an_advancing_solution_is_fresh_and_a_late_one_is_old() {
        let tod = crate::time_of_day::from_millis;
        let ms = |millis: u64| Moment::from_nanos(millis * 1_000_000);
        let age = |navigation: &Navigation, at| navigation.age(ms(at)).unwrap().as_millis();
        let mut navigation = Navigation::default();
        assert_eq!(navigation.age(ms(0)), None);
        assert!(navigation.advances(ms(1000), tod(86_399_950)));
        assert!(navigation.advances(ms(1100), tod(86_400_050 % 86_400_000)));
        assert_eq!(age(&navigation, 1150), 50);
        assert!(!navigation.advances(ms(3000), tod(50)));
        assert_eq!(age(&navigation, 3000), 1900);
        // Written 2 s after the solution was computed.
        assert!(navigation.advances(ms(4000), tod(950)));
        assert_eq!(age(&navigation, 4000), 2000);
        // Another clock.
        assert!(navigation.advances(ms(4100), tod(40_000_000)));
        assert!(navigation.advances(ms(4200), tod(10_000_000)));
        assert_eq!(age(&navigation, 4200), 0);
    }
}
