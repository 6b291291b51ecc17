use std::time::Duration;

use crate::earth::wrap_180;
use crate::moment::Moment;
use crate::time_of_day::TimeOfDay;

use crate::plane::{Plane, Point, length_m};
use crate::wire::Fix;

/// How far the vehicle may go in a second at most, metres: twice what the fastest of them do, in a strong current.
const SPEED_MAX_MPS: f64 = 5.0;
/// A step that is longer than the way at that speed by this is a jump on any reading, metres.
const JUMP_M: f64 = 50.0;
/// A degree has the same length this far to the north or south, to a thousandth.
const PLANE_DEG: f64 = 0.02;

/// How old the vehicle's newest navigation is, by the time of its solution, and where it says that the vehicle is.
/// Arrival alone makes nothing fresh.
#[derive(Clone, Debug, Default)]
pub(crate) struct Navigation {
    newest: Option<Newest>,
    /// What was said on this connection: the newest, one that is on its way to be heard for sure, one that has been.
    told: Option<Told>,
    on_its_way: Option<Told>,
    /// When bottom lock was last told on this connection.
    locked: Option<Moment>,
    /// When the solutions' time last went back on this connection.
    went_back: Option<Moment>,
    /// What was said before this is not known.
    unseen_until: Option<Moment>,
    heard: Option<Told>,
    /// The last that was heard on any connection, and the plane at a latitude that was near, degrees.
    last: Option<(Told, (Plane, f64))>,
    jump: Option<Jump>,
    /// All this before the solutions' time went back with the newest, which may be a damaged one.
    before: Option<Box<Self>>,
}

#[derive(Clone, Copy, Debug)]
struct Newest {
    solution: TimeOfDay,
    /// The same, going on over midnight, nanoseconds.
    solution_ns: i64,
    /// The smallest difference seen between the run's time at the write and the solution's, nanoseconds.
    offset_ns: i64,
}

/// A fix, and when it was said.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Told {
    pub(crate) at: Moment,
    pub(crate) fix: Fix,
}

/// A step that no vehicle can have made.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Jump {
    pub(crate) at: Moment,
    pub(crate) step_m: f64,
    /// How much solution time has passed since.
    steady: Duration,
}

impl Jump {
    /// How long navigation has been steady since, by the clock that says more.
    pub(crate) fn steady(&self, now: Moment) -> Duration {
        self.steady.max(now.since(self.at))
    }
}

impl Navigation {
    /// A solution that goes back further than this is another clock, nanoseconds.
    const RESTART_NS: i64 = -50_000_000;
    /// By so much more than the run's time the solutions' may go on, nanoseconds.
    const AHEAD_NS: i64 = 1_000_000_000;

    /// Forgets what holds for one connection only.
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

    /// Forgets all: a new process has heard nothing.
    pub(crate) fn clear(&mut self) {
        *self = Self::default();
    }

    /// What was said until now is not known: the newest solution may be of this moment, and so may a bottom lock.
    pub(crate) fn forget(&mut self, at: Moment) {
        *self = Self {
            unseen_until: Some(at),
            locked: Some(at),
            ..Self::default()
        };
    }

    /// The vehicle wrote a BFNVG. Whether its solution time advanced. `sure` is how long it takes at most to be heard.
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

    /// Whether a solution's time is another clock's.
    fn goes_back_to(&self, solution: TimeOfDay) -> bool {
        self.newest
            .is_some_and(|newest| solution.nanos_since(newest.solution) < Self::RESTART_NS)
    }

    /// Where the last was the only one whose time had gone back, whoever takes what is old for nothing has not heard it.
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

    /// Looks for a jump since what was heard before, on whatever connection.
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

    /// How old the newest solution is; `None` where there was none on this connection.
    pub(crate) fn age(&self, now: Moment) -> Option<Duration> {
        let Some(newest) = self.newest else {
            return self.unseen_until.map(|until| now.since(until));
        };
        let solved_ns = newest.solution_ns.saturating_add(newest.offset_ns);
        let age_ns = nanos(now).saturating_sub(solved_ns);
        Some(Duration::from_nanos(u64::try_from(age_ns).unwrap_or(0)))
    }

    /// The newest that the runtime has heard for sure.
    pub(crate) fn heard_for_sure(&self, now: Moment, sure: Duration) -> Option<Told> {
        let heard = |told: &Told| told.at + sure <= now;
        self.told.filter(heard).or(self.on_its_way.filter(heard)).or(self.heard)
    }

    /// The newest that was told on this connection.
    pub(crate) const fn newest(&self) -> Option<Told> {
        self.told
    }

    /// When bottom lock was last told on this connection.
    pub(crate) const fn locked(&self) -> Option<Moment> {
        self.locked
    }

    /// When the solutions' time last went back: whoever takes what comes then for old hears of no jump in it, and has no
    /// navigation before long.
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
        // Written 2 s after it was solved.
        assert!(navigation.advances(ms(4000), tod(950)));
        assert_eq!(age(&navigation, 4000), 2000);
        // Another clock.
        assert!(navigation.advances(ms(4100), tod(40_000_000)));
        assert!(navigation.advances(ms(4200), tod(10_000_000)));
        assert_eq!(age(&navigation, 4200), 0);
    }
}
