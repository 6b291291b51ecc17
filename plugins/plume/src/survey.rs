use backseat_sdk::State as Fate;
use backseat_sdk::units::EastNorth;
use backseat_sdk::units::math::TAU;
use serde::{Deserialize, Serialize};

use crate::area::Line;

const SECOND_NS: u64 = 1_000_000_000;
/// How many of our inserts may be open: one being flown and two queued.
const OPEN_MAX: usize = 3;
/// How often a leg is requested again after the vehicle has failed it or has not flown it.
const TRIES_MAX: u32 = 3;
/// How often a leg is requested again that was refused for a reason other than its geometry, while little else is open:
/// five minutes' worth.
const REFUSALS_MAX: u32 = 60;
/// The time between two requests for the same leg.
const AGAIN_NS: u64 = 5 * SECOND_NS;
/// A refused line is shortened by this much at both ends, metres; a refused circle to this fraction of its radius.
const SHORTEN_M: f64 = 50.0;
const SHRINK: f64 = 0.75;
/// A line or circle is not made smaller than this, metres.
const LINE_MIN_M: f64 = 80.0;
const RADIUS_MIN_M: f64 = 15.0;
/// A leg that ends after this fraction of the time that it takes counts as flown.
const FLOWN: f64 = 0.5;
/// Farther from its line than this the vehicle is still on its way to it, metres.
const ON_LINE_M: f64 = 25.0;

/// The stages of the survey.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Stage {
    /// The lines of the first map.
    Map,
    /// The cross through the first estimate.
    Cross,
    /// The circle around the second estimate.
    Circle,
    /// Nothing is left to request.
    Done,
}

/// A leg that the vehicle flies by itself.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) enum Leg {
    Line(Line),
    Circle {
        centre: EastNorth,
        radius_m: f64,
        orbits: f64,
        entry_deg: f64,
    },
}

impl Leg {
    fn length_m(&self) -> f64 {
        match self {
            Self::Line(line) => line.length_m(),
            Self::Circle { radius_m, orbits, .. } => TAU * radius_m * orbits,
        }
    }

    fn smaller(&self) -> Option<Self> {
        match *self {
            Self::Line(line) => line.shortened(SHORTEN_M, LINE_MIN_M).map(Self::Line),
            Self::Circle {
                centre,
                radius_m,
                orbits,
                entry_deg,
            } => {
                let radius_m = radius_m * SHRINK;
                (radius_m >= RADIUS_MIN_M).then_some(Self::Circle {
                    centre,
                    radius_m,
                    orbits,
                    entry_deg,
                })
            }
        }
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Standing {
    /// Not requested yet, or to be requested again.
    Waiting { not_before_ns: u64 },
    /// Requested, and without a final state.
    Open { tag: u64, started_ns: Option<u64> },
    /// Flown, or enough of it.
    Flown,
    /// Given up.
    Dropped,
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Task {
    pub(crate) leg: Leg,
    pub(crate) standing: Standing,
    tries: u32,
    refusals: u32,
    /// How far along its line the vehicle has been seen, 0 to 1.
    progress: f64,
}

/// What an outcome means for a task, for the log.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Turn {
    /// Nothing worth a line.
    Quiet,
    /// The vehicle has begun to fly it.
    Began,
    /// It has been flown.
    Flown,
    /// It will be requested again; with the reason.
    Again(String),
    /// It will be requested again in a smaller form; with the reason.
    Smaller(String),
    /// It is given up; with the reason.
    Dropped(String),
}

/// The legs in the order in which they are flown, each with its state.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Survey {
    pub(crate) stage: Stage,
    pub(crate) tasks: Vec<Task>,
    next_tag: u64,
    /// Open tags that belong to no task of this instance.
    strays: Vec<u64>,
}

impl Survey {
    pub(crate) fn new() -> Self {
        Self {
            stage: Stage::Map,
            tasks: Vec::new(),
            next_tag: 1,
            strays: Vec::new(),
        }
    }

    pub(crate) fn add(&mut self, legs: impl IntoIterator<Item = Leg>) {
        self.tasks.extend(legs.into_iter().map(|leg| Task {
            leg,
            standing: Standing::Waiting { not_before_ns: 0 },
            tries: 0,
            refusals: 0,
            progress: 0.0,
        }));
    }

    /// The next leg to request now, which becomes open under the returned tag. Also returns its index among the tasks.
    pub(crate) fn ask(&mut self, now_ns: u64) -> Option<(usize, u64)> {
        let open = self.open();
        if open >= OPEN_MAX {
            return None;
        }
        let waiting = |task: &Task| match task.standing {
            Standing::Waiting { not_before_ns } => Some(not_before_ns),
            Standing::Open { .. } | Standing::Flown | Standing::Dropped => None,
        };
        let first = self.tasks.iter().position(|task| waiting(task).is_some())?;
        // In their order, unless the first has to wait while nothing is queued, because the vehicle would then leave.
        let index = self
            .tasks
            .iter()
            .position(|task| waiting(task).is_some_and(|not_before_ns| not_before_ns <= now_ns))
            .filter(|index| *index == first || open <= 1)?;
        let tag = self.next_tag;
        self.next_tag += 1;
        self.tasks[index].standing = Standing::Open { tag, started_ns: None };
        Some((index, tag))
    }

    /// How many of our inserts the vehicle may have.
    pub(crate) fn open(&self) -> usize {
        let open = |task: &&Task| matches!(task.standing, Standing::Open { .. });
        self.tasks.iter().filter(open).count() + self.strays.len()
    }

    /// The task that is open under a tag.
    pub(crate) fn task_of(&self, tag: u64) -> Option<usize> {
        self.tasks
            .iter()
            .position(|task| matches!(task.standing, Standing::Open { tag: open, .. } if open == tag))
    }

    /// Takes in the outcome of a request. `control` is whether the backseat has control, `misfits` whether the fence
    /// refuses the request's geometry.
    pub(crate) fn hear(
        &mut self,
        tag: u64,
        fate: &Fate,
        now_ns: u64,
        control: bool,
        speed_mps: f64,
        misfits: impl FnOnce() -> bool,
    ) -> Turn {
        let at_end = !matches!(
            fate,
            Fate::Sent | Fate::Pending | Fate::Accepted | Fate::Started | Fate::Unknown
        );
        if at_end {
            self.strays.retain(|stray| *stray != tag);
        }
        let Some(index) = self.task_of(tag) else {
            return Turn::Quiet;
        };
        let others = self.open() - 1;
        let task = &mut self.tasks[index];
        match fate {
            Fate::Sent | Fate::Pending | Fate::Accepted | Fate::Unknown => Turn::Quiet,
            Fate::Started => {
                task.standing = Standing::Open {
                    tag,
                    started_ns: Some(now_ns),
                };
                Turn::Began
            }
            Fate::Ended(why) => {
                let due_s = task.leg.length_m() / speed_mps;
                let flown_s = match task.standing {
                    Standing::Open {
                        started_ns: Some(started_ns),
                        ..
                    } => now_ns.saturating_sub(started_ns) as f64 / SECOND_NS as f64,
                    Standing::Open { started_ns: None, .. }
                    | Standing::Waiting { .. }
                    | Standing::Flown
                    | Standing::Dropped => 0.0,
                };
                if flown_s >= FLOWN * due_s {
                    task.standing = Standing::Flown;
                    Turn::Flown
                } else {
                    task.fail(&format!("ended too early: {}", why.text), now_ns)
                }
            }
            Fate::Failed(_) => task.fail(fate.reason().unwrap_or_default(), now_ns),
            Fate::TimedOut => task.fail("the vehicle did not answer", now_ns),
            Fate::Cancelled => task.fail("cancelled", now_ns),
            Fate::Rejected(why) if !control => {
                task.wait(now_ns);
                Turn::Again(why.text.clone())
            }
            Fate::Rejected(why) => {
                let first = task.refusals == 0;
                // With others left to fly, the mission's limit on open inserts may be the reason, which passes.
                if first || others <= 1 {
                    task.refusals += 1;
                }
                // A smaller leg is tried now and then anyway, because the fence that a plugin can ask does not know the
                // vehicle's plan.
                let stuck = others <= 1 && task.refusals.is_multiple_of(REFUSALS_MAX / 5);
                if misfits() || stuck {
                    task.shrink(&why.text, now_ns)
                } else if task.refusals < REFUSALS_MAX {
                    task.wait(now_ns);
                    if first {
                        Turn::Again(why.text.clone())
                    } else {
                        Turn::Quiet
                    }
                } else {
                    task.drop(&why.text)
                }
            }
        }
    }

    /// Compares what a new instance believes to be open with what is open.
    ///
    /// Open tags without a task here were requested after the snapshot, in the order of the tasks.
    pub(crate) fn restored(&mut self, open: &[u64], now_ns: u64) {
        for task in &mut self.tasks {
            if let Standing::Open { tag, started_ns } = task.standing
                && !open.contains(&tag)
            {
                // Its end was missed. What had begun counts as flown; anything else is requested again.
                if started_ns.is_some() {
                    task.standing = Standing::Flown;
                } else {
                    task.wait(now_ns);
                }
            }
        }
        let mut unknown: Vec<u64> = open
            .iter()
            .copied()
            .filter(|tag| self.task_of(*tag).is_none())
            .collect();
        unknown.sort_unstable();
        for tag in unknown {
            self.next_tag = self.next_tag.max(tag + 1);
            let waiting = |task: &&mut Task| matches!(task.standing, Standing::Waiting { .. });
            match self.tasks.iter_mut().find(waiting) {
                Some(task) => {
                    // Its beginning may have been missed: then its end comes within its time.
                    task.standing = Standing::Open {
                        tag,
                        started_ns: Some(now_ns),
                    };
                }
                None => self.strays.push(tag),
            }
        }
        // Tags that were used and have ended since the snapshot must not be used again.
        self.next_tag += 100;
    }

    /// Open tags that belong to no task of this instance.
    pub(crate) fn strays(&self) -> &[u64] {
        &self.strays
    }

    /// Notes the vehicle's position on the line that it is flying.
    pub(crate) fn fly(&mut self, at: EastNorth, velocity: EastNorth) {
        for task in &mut self.tasks {
            let (
                Standing::Open {
                    started_ns: Some(_), ..
                },
                Leg::Line(line),
            ) = (task.standing, task.leg)
            else {
                continue;
            };
            let (along, off_m) = line.progress(at);
            let way = line.end - line.start;
            let forward = way.east_m * velocity.east_m + way.north_m * velocity.north_m;
            // On the way to its start the vehicle moves in another direction, or is away from the line.
            if off_m < ON_LINE_M && forward > 0.3 * line.length_m() {
                task.progress = task.progress.max(along.clamp(0.0, 1.0));
            }
        }
    }

    /// The progress of the last leg: 0 while there are others before it, 1 when all have ended.
    pub(crate) fn last_progress(&self) -> f64 {
        let mut live = self
            .tasks
            .iter()
            .filter(|task| !matches!(task.standing, Standing::Flown | Standing::Dropped));
        match (live.next(), live.next()) {
            (None, _) => 1.0,
            (Some(task), None) => task.progress,
            (Some(_), Some(_)) => 0.0,
        }
    }

    /// Whether every leg has ended.
    pub(crate) fn at_end(&self) -> bool {
        self.tasks
            .iter()
            .all(|task| matches!(task.standing, Standing::Flown | Standing::Dropped))
    }

    /// Whether the vehicle has flown the last leg.
    pub(crate) fn last_flown(&self) -> bool {
        self.tasks.last().is_some_and(|task| task.standing == Standing::Flown)
    }
}

impl Task {
    fn wait(&mut self, now_ns: u64) {
        self.progress = 0.0;
        self.standing = Standing::Waiting {
            not_before_ns: now_ns + AGAIN_NS,
        };
    }

    fn fail(&mut self, why: &str, now_ns: u64) -> Turn {
        self.tries += 1;
        if self.tries >= TRIES_MAX {
            return self.drop(why);
        }
        self.wait(now_ns);
        Turn::Again(why.to_owned())
    }

    fn shrink(&mut self, why: &str, now_ns: u64) -> Turn {
        let Some(smaller) = self.leg.smaller() else {
            return self.drop(why);
        };
        self.leg = smaller;
        self.wait(now_ns);
        // A different request, so it need not wait.
        self.standing = Standing::Waiting { not_before_ns: now_ns };
        Turn::Smaller(why.to_owned())
    }

    fn drop(&mut self, why: &str) -> Turn {
        self.standing = Standing::Dropped;
        Turn::Dropped(why.to_owned())
    }
}

#[cfg(test)]
mod tests {
    use backseat_sdk::{EndKind, Ended, Refusal, Rule};

    use super::*;

    fn line(index: u32) -> Leg {
        let north_m = 50.0 * f64::from(index);
        Leg::Line(Line {
            start: EastNorth::new(0.0, north_m),
            end: EastNorth::new(300.0, north_m),
        })
    }

    fn survey(count: u32) -> Survey {
        let mut survey = Survey::new();
        survey.add((0..count).map(line));
        survey
    }

    fn hear(survey: &mut Survey, tag: u64, fate: &Fate, now_s: u64) -> Turn {
        survey.hear(tag, fate, now_s * SECOND_NS, true, 1.5, || false)
    }

    #[test]
    fn two_legs_are_queued_and_none_is_requested_twice() {
        let mut survey = survey(5);
        let asked: Vec<_> = std::iter::from_fn(|| survey.ask(0)).collect();
        assert_eq!(asked, [(0, 1), (1, 2), (2, 3)]);
        assert_eq!(hear(&mut survey, 1, &Fate::Started, 0), Turn::Began);
        assert_eq!(
            hear(&mut survey, 1, &Fate::Ended(Ended::new(EndKind::Done, "flown")), 200),
            Turn::Flown
        );
        assert_eq!(survey.ask(SECOND_NS), Some((3, 4)));
        assert_eq!(survey.ask(SECOND_NS), None);
    }

    #[test]
    fn a_line_that_ended_too_early_is_flown_again() {
        let mut survey = survey(1);
        survey.ask(0);
        hear(&mut survey, 1, &Fate::Started, 0);
        let turn = hear(
            &mut survey,
            1,
            &Fate::Ended(Ended::new(EndKind::Behavior, "interrupted")),
            20,
        );
        assert!(matches!(turn, Turn::Again(_)), "{turn:?}");
        assert_eq!(
            survey.ask(21 * SECOND_NS),
            None,
            "the leg is not requested again at once"
        );
        assert_eq!(survey.ask(26 * SECOND_NS), Some((0, 2)));
    }

    #[test]
    fn a_reached_cap_uses_up_no_attempts_of_a_leg() {
        let mut survey = survey(4);
        for _ in 0..3 {
            survey.ask(0);
        }
        for attempt in 0..200 {
            let now_s = 10 * attempt;
            let tag = survey.next_tag - 1;
            hear(
                &mut survey,
                tag,
                &Fate::Rejected(Refusal::new(Rule::Cap, "over the cap")),
                now_s,
            );
            assert_eq!(survey.ask((now_s + 6) * SECOND_NS), Some((2, tag + 1)));
        }
        assert_eq!(survey.tasks[2].leg, line(2), "the leg is not made smaller");
    }

    #[test]
    fn a_new_instance_continues_with_what_is_open() {
        let mut survey = survey(5);
        for _ in 0..3 {
            survey.ask(0);
        }
        hear(&mut survey, 1, &Fate::Started, 0);
        // The first has ended unseen, a fourth has been requested, and a tag is open that no task has.
        survey.restored(&[2, 3, 4], SECOND_NS);
        assert_eq!(survey.tasks[0].standing, Standing::Flown);
        assert_eq!(survey.task_of(4), Some(3));
        assert_eq!(survey.ask(SECOND_NS), None);
        survey.restored(&[2, 3, 4, 5, 6], SECOND_NS);
        assert_eq!((survey.task_of(5), survey.strays()), (Some(4), &[6][..]));
        hear(&mut survey, 6, &Fate::Cancelled, 2);
        assert!(survey.strays().is_empty());
    }
}
