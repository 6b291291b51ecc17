use backseat_sdk::survey::{GaussianProcess, InsertQueue, Leg, Line, QueueSettings, Standing, Task};
use backseat_sdk::units::EastNorth;
use serde::{Deserialize, Serialize};

use crate::samples::Samples;
use crate::settings::Settings;

/// One line that is flown and one behind it.
const OPEN_MAX: usize = 2;
/// The most points of a line that is flown.
const AHEAD_MAX: u32 = 8;
/// When so many lines were given up, the survey ends.
const DROPPED_MAX: usize = 8;

/// A survey as far as it has come: what a new instance needs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Survey {
    /// The lines, and at the end the circle.
    pub queue: InsertQueue,
    /// What was measured.
    pub process: GaussianProcess,
    /// Lines that are added when the vehicle has begun to fly the first one. (If it were refused, because the vehicle has not
    /// reported its plan yet, the queue would ask for the ones behind it first.)
    pub later: Vec<Line>,
    /// Whether no line comes any more.
    pub done: bool,
    /// Whether the circle around the warmest place was added.
    pub marked: bool,
    /// How many places of the map were published.
    pub published: usize,
    /// How much of the published map is warm, square metres.
    pub warm_m2: f64,
    /// The sum of its variances there, square degrees times square metres.
    pub warm_variance: f64,
    samples: Samples,
    last: Option<EastNorth>,
    /// The way since the vehicle came onto the first line, metres.
    flown_m: f64,
}

impl Survey {
    /// A survey that has not begun.
    ///
    /// # Errors
    /// One line, if the field's kernel cannot be used.
    pub fn new(settings: &Settings) -> Result<Self, String> {
        Ok(Self {
            queue: InsertQueue::new(QueueSettings {
                open_max: OPEN_MAX,
                ..QueueSettings::default()
            }),
            process: settings.process()?,
            later: Vec::new(),
            done: false,
            marked: false,
            published: 0,
            warm_m2: 0.0,
            warm_variance: 0.0,
            samples: Samples::default(),
            last: None,
            flown_m: 0.0,
        })
    }

    /// The lines with what has become of them, in their order.
    fn lines(&self) -> impl Iterator<Item = (&Task, Line)> {
        self.queue.tasks().iter().filter_map(|task| match task.leg {
            Leg::Line(line) => Some((task, line)),
            Leg::Circle(_) => None,
        })
    }

    /// Whether the vehicle has come onto its first line, and has not left its last one.
    #[must_use]
    pub fn is_running(&self) -> bool {
        let begun = self.lines().any(|(task, _)| task.progress > 0.0);
        begun && !self.is_over()
    }

    /// Whether the last line was flown or given up, and none comes any more.
    #[must_use]
    pub fn is_over(&self) -> bool {
        self.done && self.later.is_empty() && self.lines().all(|(task, _)| has_ended(task))
    }

    /// Takes in where the vehicle is, and then what it measures there.
    pub fn measure(&mut self, settings: &Settings, at: EastNorth, values: impl Iterator<Item = f64>) {
        if !self.is_running() {
            return;
        }
        self.flown_m += self.last.map_or(0.0, |last| last.distance_m(at));
        self.last = Some(at);
        for value in values {
            if let Some((place, mean)) = self.samples.add(settings.apart_m(), at, value) {
                self.process.add(place, mean);
            }
        }
    }

    /// Adds what was measured last to the map, when the survey is over.
    pub fn close(&mut self) {
        if let Some((place, mean)) = self.samples.take() {
            self.process.add(place, mean);
        }
    }

    /// Adds a line.
    pub fn push(&mut self, line: Line) {
        self.queue.push(Leg::Line(line));
    }

    /// Adds the first of some lines, and the others when that one is begun.
    pub fn begin(&mut self, lines: Vec<Line>) {
        let mut lines = lines.into_iter();
        lines.by_ref().take(1).for_each(|line| self.push(line));
        self.later = lines.collect();
    }

    /// Adds the lines that wait for the first one to begin, if it has. Returns whether none waits.
    pub fn begin_later(&mut self) -> bool {
        let begun = |task: &Task| {
            let flying = matches!(
                task.standing,
                Standing::Open {
                    started_ns: Some(_),
                    ..
                }
            );
            flying || has_ended(task)
        };
        if self.queue.tasks().first().is_some_and(begun) {
            let later = std::mem::take(&mut self.later);
            self.queue.extend(later.into_iter().map(Leg::Line));
        }
        self.later.is_empty()
    }

    /// Where the last line ends.
    #[must_use]
    pub fn end(&self) -> Option<EastNorth> {
        self.lines().last().map(|(_, line)| line.end)
    }

    /// How far it is from here to the end of the last line, metres.
    #[must_use]
    pub fn ahead_m(&self, here: EastNorth) -> f64 {
        let (mut from, mut ahead_m) = (here, 0.0);
        for (task, line) in self.lines().filter(|(task, _)| !has_ended(task)) {
            ahead_m += if task.progress > 0.0 {
                from.distance_m(line.end)
            } else {
                from.distance_m(line.start) + line.length_m()
            };
            from = line.end;
        }
        ahead_m
    }

    /// The way since the vehicle came onto the first line, metres.
    #[must_use]
    pub const fn flown_m(&self) -> f64 {
        self.flown_m
    }

    /// How much of the way is not flown or planned yet, metres.
    #[must_use]
    pub fn left_m(&self, settings: &Settings, here: EastNorth) -> f64 {
        settings.way_m - self.flown_m - self.ahead_m(here)
    }

    /// Whether so many lines were given up that something must be wrong.
    #[must_use]
    pub fn is_hopeless(&self) -> bool {
        let dropped = |(task, _): &(&Task, Line)| task.standing == Standing::Dropped;
        self.lines().filter(dropped).count() >= DROPPED_MAX
    }

    /// The places that will be measured on the way to the end of the last line.
    #[must_use]
    pub fn ahead(&self, settings: &Settings, here: EastNorth) -> Vec<EastNorth> {
        let (mut from, mut ahead) = (here, Vec::new());
        for (_, line) in self.lines().filter(|(task, _)| !has_ended(task)) {
            let rest = Line {
                start: from,
                end: line.end,
            };
            ahead.extend(settings.along(&rest, AHEAD_MAX));
            from = line.end;
        }
        ahead
    }
}

fn has_ended(task: &Task) -> bool {
    matches!(task.standing, Standing::Flown | Standing::Dropped)
}
