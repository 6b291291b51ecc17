use backseat_sdk::State as Fate;
use backseat_sdk::sonar::coverage::Place;
use serde::{Deserialize, Serialize};

use crate::lines::{Line, Purpose};

const SECOND_NS: u64 = 1_000_000_000;
/// How often a line is requested again after the vehicle has failed it or has not flown it.
const TRIES_MAX: u32 = 3;
/// How often a line is requested again that was refused for a reason other than its geometry: five minutes' worth.
const REFUSALS_MAX: u32 = 60;
/// The time between two requests for the same line.
const AGAIN_NS: u64 = 5 * SECOND_NS;
/// A line that does not fit is shortened by this much at both ends, metres.
const SHORTEN_M: f64 = 25.0;
/// A line that ends after this part of it counts as flown.
const FLOWN: f64 = 0.5;
/// Farther from its line than this the vehicle is still on its way to it, metres.
const ON_LINE_M: f64 = 20.0;

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) enum Standing {
    /// Not requested yet, or to be requested again.
    Waiting { not_before_ns: u64 },
    /// Requested, and without a final state.
    Open { tag: u64, is_flying: bool },
}

#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Task {
    pub(crate) line: Line,
    pub(crate) purpose: Purpose,
    pub(crate) standing: Standing,
    /// Whether what it has seen is known to the planner.
    pub(crate) is_counted: bool,
    /// How far along its line the vehicle has been seen, 0 to 1.
    pub(crate) progress: f64,
    tries: u32,
    refusals: u32,
}

/// What an outcome means.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Turn {
    /// Nothing worth a line.
    Quiet,
    /// The vehicle has begun to fly it.
    Began,
    /// It has been flown.
    Flown(Task),
    /// It will be requested again; with the reason.
    Again(String),
    /// It will be requested again in a shorter form; with the reason.
    Shorter(String),
    /// It is given up; with the reason.
    Dropped(Task, String),
}

/// The lines that the vehicle has or shall get: at most the one that it flies and the next one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(crate) struct Queue {
    tasks: Vec<Task>,
    next_tag: u64,
    /// Open tags that belong to no task of this instance.
    strays: Vec<u64>,
    /// Whether the vehicle is on the line that it flies, and not on the way to it.
    is_on_line: bool,
}

impl Queue {
    pub(crate) const fn new() -> Self {
        Self {
            tasks: Vec::new(),
            next_tag: 1,
            strays: Vec::new(),
            is_on_line: false,
        }
    }

    pub(crate) fn push(&mut self, line: Line, purpose: Purpose) {
        self.tasks.push(Task {
            line,
            purpose,
            standing: Standing::Waiting { not_before_ns: 0 },
            is_counted: false,
            progress: 0.0,
            tries: 0,
            refusals: 0,
        });
    }

    /// A tag that was not used before. [`Queue::use_tag`] uses it.
    pub(crate) const fn free_tag(&self) -> u64 {
        self.next_tag
    }

    /// The free tag was used.
    pub(crate) const fn use_tag(&mut self) {
        self.next_tag += 1;
    }

    /// The line that is being flown, if it is the only one.
    pub(crate) fn last_flying(&mut self) -> Option<&mut Task> {
        match &mut self.tasks[..] {
            [task] if matches!(task.standing, Standing::Open { is_flying: true, .. }) => Some(task),
            _ => None,
        }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.tasks.is_empty() && self.strays.is_empty()
    }

    pub(crate) const fn is_on_line(&self) -> bool {
        self.is_on_line
    }

    /// How many of our inserts the vehicle may have.
    pub(crate) fn open(&self) -> usize {
        self.tags().count() + self.strays.len()
    }

    /// The line to request now, as its place in the queue.
    pub(crate) fn due(&self, now_ns: u64) -> Option<usize> {
        self.tasks.iter().position(|task| match task.standing {
            Standing::Waiting { not_before_ns } => not_before_ns <= now_ns,
            Standing::Open { .. } => false,
        })
    }

    pub(crate) fn task(&self, index: usize) -> &Task {
        &self.tasks[index]
    }

    /// A line was requested under the free tag.
    pub(crate) fn asked(&mut self, index: usize) {
        let tag = self.next_tag;
        self.next_tag += 1;
        self.tasks[index].standing = Standing::Open { tag, is_flying: false };
    }

    /// The line does not fit into the fence, by our own check of it.
    pub(crate) fn misfits(&mut self, index: usize, why: &str, now_ns: u64) -> Turn {
        match self.tasks[index].line.shortened(SHORTEN_M) {
            Some(shorter) => {
                self.tasks[index].line = shorter;
                self.tasks[index].standing = Standing::Waiting { not_before_ns: now_ns };
                Turn::Shorter(why.to_owned())
            }
            None => Turn::Dropped(self.tasks.remove(index), why.to_owned()),
        }
    }

    /// The line is refused for now, by our own check or by the runtime.
    pub(crate) fn refused(&mut self, index: usize, why: &str, now_ns: u64) -> Turn {
        let task = &mut self.tasks[index];
        task.refusals += 1;
        if task.refusals >= REFUSALS_MAX {
            return Turn::Dropped(self.tasks.remove(index), why.to_owned());
        }
        task.wait(now_ns);
        if task.refusals == 1 {
            Turn::Again(why.to_owned())
        } else {
            Turn::Quiet
        }
    }

    /// Takes in the outcome of a request. `control` is whether the backseat has control, `misfits` whether the fence
    /// refuses the request's geometry.
    pub(crate) fn hear(
        &mut self,
        tag: u64,
        fate: &Fate,
        now_ns: u64,
        control: bool,
        misfits: impl FnOnce() -> bool,
    ) -> Turn {
        let is_open = matches!(
            fate,
            Fate::Sent | Fate::Pending | Fate::Accepted | Fate::Started | Fate::Unknown
        );
        if !is_open {
            self.strays.retain(|stray| *stray != tag);
        }
        let Some(index) = self.index_of(tag) else {
            return Turn::Quiet;
        };
        let others = self.open() - 1;
        let task = &mut self.tasks[index];
        match fate {
            Fate::Sent | Fate::Pending | Fate::Accepted | Fate::Unknown => Turn::Quiet,
            Fate::Started => {
                task.standing = Standing::Open { tag, is_flying: true };
                Turn::Began
            }
            Fate::Ended(_) if task.progress >= FLOWN => Turn::Flown(self.tasks.remove(index)),
            Fate::Ended(why) => self.fail(index, &format!("ended too early: {}", why.text), now_ns),
            Fate::Failed(_) => self.fail(index, fate.reason().unwrap_or("failed"), now_ns),
            Fate::TimedOut => self.fail(index, "the vehicle did not answer", now_ns),
            Fate::Cancelled => self.fail(index, "cancelled", now_ns),
            Fate::Rejected(why) if !control => {
                task.wait(now_ns);
                Turn::Again(why.text.clone())
            }
            Fate::Rejected(why) => {
                // The fence that a plugin can ask does not know the way to the line and back to the vehicle's plan. If
                // nothing else is open, a shorter line is tried now and then.
                let stuck = others == 0 && (task.refusals + 1).is_multiple_of(REFUSALS_MAX / 5);
                if misfits() || stuck {
                    self.misfits(index, &why.text, now_ns)
                } else {
                    self.refused(index, &why.text, now_ns)
                }
            }
        }
    }

    /// Compares what a new instance believes to be open with what is open. Returns the lines whose end was missed.
    ///
    /// Open tags without a task here were requested after the snapshot.
    pub(crate) fn restored(&mut self, open: &[u64], own: impl Fn(u64) -> bool, now_ns: u64) -> Vec<Task> {
        let mut ended = Vec::new();
        self.tasks.retain_mut(|task| {
            let Standing::Open { tag, is_flying } = task.standing else {
                return true;
            };
            if open.contains(&tag) {
                return true;
            }
            if is_flying {
                ended.push(*task);
                return false;
            }
            task.wait(now_ns);
            true
        });
        let known: Vec<u64> = self.tags().collect();
        for tag in open.iter().copied().filter(|tag| !known.contains(tag) && !own(*tag)) {
            match self
                .tasks
                .iter_mut()
                .find(|task| matches!(task.standing, Standing::Waiting { .. }))
            {
                // Its begin may have been missed.
                Some(task) => task.standing = Standing::Open { tag, is_flying: true },
                None => self.strays.push(tag),
            }
        }
        // Tags that were used and have ended since the snapshot must not be used again.
        self.next_tag += 100;
        self.is_on_line = false;
        ended
    }

    /// Open tags that belong to no task of this instance.
    pub(crate) fn strays(&self) -> &[u64] {
        &self.strays
    }

    /// Notes the vehicle's place, and its velocity along the axes, on the line that it flies.
    pub(crate) fn fly(&mut self, at: Place, along_mps: f64) {
        self.is_on_line = false;
        for task in &mut self.tasks {
            if !matches!(task.standing, Standing::Open { is_flying: true, .. }) {
                continue;
            }
            let (along, off_m) = task.line.progress(at);
            let forward_mps = if task.line.to.along_m >= task.line.from.along_m {
                along_mps
            } else {
                -along_mps
            };
            // On the way to its start the vehicle moves in another direction, or is away from the line.
            if off_m < ON_LINE_M && forward_mps > 0.3 {
                task.progress = task.progress.max(along.clamp(0.0, 1.0));
                self.is_on_line = (0.0..=1.0).contains(&along);
            }
        }
    }

    /// The place of the task that is open under a tag.
    pub(crate) fn index_of(&self, tag: u64) -> Option<usize> {
        self.tasks
            .iter()
            .position(|task| matches!(task.standing, Standing::Open { tag: open, .. } if open == tag))
    }

    fn tags(&self) -> impl Iterator<Item = u64> {
        self.tasks.iter().filter_map(|task| match task.standing {
            Standing::Open { tag, .. } => Some(tag),
            Standing::Waiting { .. } => None,
        })
    }

    fn fail(&mut self, index: usize, why: &str, now_ns: u64) -> Turn {
        let task = &mut self.tasks[index];
        task.tries += 1;
        if task.tries >= TRIES_MAX {
            return Turn::Dropped(self.tasks.remove(index), why.to_owned());
        }
        task.wait(now_ns);
        Turn::Again(why.to_owned())
    }
}

impl Task {
    fn wait(&mut self, now_ns: u64) {
        self.progress = 0.0;
        self.standing = Standing::Waiting {
            not_before_ns: now_ns + AGAIN_NS,
        };
    }
}
