use std::ops::Range;

use backseat_units::math::TAU;
use backseat_units::{EastNorth, LocalFrame};
use serde::{Deserialize, Serialize};

use super::Line;
use crate::{
    Event, Navigation, Request, Restored, Rule, State, StepInput, Trackcircle, Trackline, Vertical, fence, log,
};

const SECOND_NS: u64 = 1_000_000_000;

/// A circle to fly.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Circle {
    /// Its centre.
    pub centre: EastNorth,
    /// Its radius, metres.
    pub radius_m: f64,
    /// How often it is flown, positive clockwise.
    pub orbits: f64,
    /// Where on the circle to begin, degrees from north; `None` leaves it to the vehicle.
    pub entry_deg: Option<f64>,
}

/// A line or a circle that the vehicle flies by itself.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum Leg {
    /// A trackline.
    Line(Line),
    /// A trackcircle.
    Circle(Circle),
}

impl Leg {
    /// Its length, metres, with all orbits of a circle.
    #[must_use]
    pub fn length_m(&self) -> f64 {
        match self {
            Self::Line(line) => line.length_m(),
            Self::Circle(circle) => TAU * circle.radius_m * circle.orbits.abs(),
        }
    }

    /// Its length or its radius, for a person.
    fn size(&self) -> String {
        match self {
            Self::Line(line) => format!("{:.0} m", line.length_m()),
            Self::Circle(circle) => format!("radius {:.0} m", circle.radius_m),
        }
    }

    /// A little smaller, for what may be refused for more than itself, such as the way there.
    fn smaller(&self, settings: &QueueSettings) -> Option<Self> {
        match *self {
            Self::Line(line) => line.shortened(settings.shorten_m, settings.line_min_m).map(Self::Line),
            Self::Circle(circle) => {
                let radius_m = circle.radius_m * settings.shrink;
                (settings.radius_min_m..circle.radius_m)
                    .contains(&radius_m)
                    .then_some(Self::Circle(Circle { radius_m, ..circle }))
            }
        }
    }

    /// The longest part of the line, or the largest circle about the same centre, that `fits` and is smaller than this leg;
    /// `None` if none is large enough.
    fn largest_that(&self, settings: &QueueSettings, mut fits: impl FnMut(&Self) -> bool) -> Option<Self> {
        match *self {
            Self::Line(line) => longest_part(line, settings, |part| fits(&Self::Line(part))).map(Self::Line),
            Self::Circle(_) => {
                let smaller = |circle: &Self| circle.smaller(settings);
                std::iter::successors(smaller(self), smaller)
                    .take(PARTS_MAX)
                    .find(|circle| fits(circle))
            }
        }
    }
}

/// A line is tried in so many parts at most, because each question to the fence costs fuel.
const PARTS_MAX: usize = 24;

fn longest_part(line: Line, settings: &QueueSettings, mut fits: impl FnMut(Line) -> bool) -> Option<Line> {
    let length_m = line.length_m();
    let count = ((length_m / settings.shorten_m) as usize).clamp(1, PARTS_MAX);
    let at = |index: usize| line.at(length_m * index as f64 / count as f64);
    let part = |parts: &Range<usize>| Line {
        start: at(parts.start),
        end: at(parts.end),
    };
    let (mut longest, mut run) = (0..0, 0..0);
    for index in 0..count {
        run.end = index + 1;
        if !fits(part(&(index..run.end))) {
            run.start = run.end;
        } else if run.len() > longest.len() {
            longest = run.clone();
        }
    }
    // Where each part fits, all together may not.
    while longest.len() == count || !longest.is_empty() && !fits(part(&longest)) {
        longest = longest.start + 1..longest.end.saturating_sub(1);
    }
    let longest = (!longest.is_empty()).then(|| part(&longest))?;
    (longest.length_m() >= settings.line_min_m).then_some(longest)
}

/// How legs are flown.
#[derive(Clone, Debug)]
pub struct Flight {
    /// The frame of the legs.
    pub frame: LocalFrame,
    /// Depth or altitude.
    pub vertical: Vertical,
    /// Speed through the water, metres per second.
    pub speed_mps: f64,
}

impl Flight {
    /// The request for a leg.
    #[must_use]
    pub fn request(&self, leg: &Leg, tag: u64, interrupt: bool) -> Request {
        let position = |at: EastNorth| self.frame.to_position(at).into();
        match *leg {
            Leg::Line(Line { start, end }) => Request::Trackline(Trackline {
                tag,
                start: position(start),
                end: position(end),
                vertical: self.vertical,
                speed: self.speed_mps,
                interrupt,
            }),
            Leg::Circle(circle) => Request::Trackcircle(Trackcircle {
                tag,
                centre: position(circle.centre),
                radius: circle.radius_m,
                orbits: circle.orbits,
                vertical: self.vertical,
                speed: self.speed_mps,
                entry_angle: circle.entry_deg,
                interrupt,
            }),
        }
    }
}

/// When a queue asks, asks again and gives up.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct QueueSettings {
    /// How many legs may be open at the vehicle: the one that it flies, and those behind it.
    pub open_max: usize,
    /// How often a leg is requested that the vehicle fails or does not fly.
    pub tries_max: u32,
    /// How often a leg is requested again that was refused for a reason which may pass, while little else is open.
    pub refusals_max: u32,
    /// The time between two requests for the same leg.
    pub again_ns: u64,
    /// A line that does not fit into the fence is cut to the longest part that fits, in steps of about this length, metres. If
    /// only the way to it or back does not fit, it is shortened by this much at both ends.
    pub shorten_m: f64,
    /// A line is not made shorter than this, metres.
    pub line_min_m: f64,
    /// A circle that does not fit is made smaller by this factor, until it does.
    pub shrink: f64,
    /// A circle is not made smaller than this radius, metres.
    pub radius_min_m: f64,
    /// A line that ends after this part of it, or a circle that ends after this part of the time that it takes, counts as
    /// flown, 0 to 1.
    pub flown: f64,
    /// Farther from its line than this the vehicle is still on its way to it, metres.
    pub on_line_m: f64,
    /// Whether the first leg interrupts the current behavior when nothing of the queue is open. Needs the grant
    /// `interrupt`.
    pub interrupt: bool,
}

impl Default for QueueSettings {
    /// One leg that is flown and two behind it; three tries, five seconds apart; five minutes of refusals.
    fn default() -> Self {
        Self {
            open_max: 3,
            tries_max: 3,
            refusals_max: 60,
            again_ns: 5 * SECOND_NS,
            shorten_m: 50.0,
            line_min_m: 80.0,
            shrink: 0.75,
            radius_min_m: 15.0,
            flown: 0.5,
            on_line_m: 25.0,
            interrupt: false,
        }
    }
}

/// What has become of a leg.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Standing {
    /// Not requested yet, or to be requested again.
    Waiting {
        /// Not before this time.
        not_before_ns: u64,
    },
    /// Requested, and without a final state.
    Open {
        /// The tag of its request.
        tag: u64,
        /// When the vehicle began to fly it.
        started_ns: Option<u64>,
    },
    /// Flown, or enough of it.
    Flown,
    /// Given up.
    Dropped,
}

/// A leg in the queue.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Task {
    /// The leg, as it was made smaller if it was.
    pub leg: Leg,
    /// What has become of it.
    pub standing: Standing,
    /// How far along its line the vehicle has been seen, 0 to 1.
    pub progress: f64,
    tries: u32,
    refusals: u32,
}

/// What an outcome means for a leg.
#[derive(Clone, Debug, PartialEq)]
pub enum Turn {
    /// Nothing worth a line.
    Quiet,
    /// The vehicle has begun to fly it.
    Began,
    /// It has been flown.
    Flown,
    /// It will be requested again; with the reason.
    Again(String),
    /// It will be requested again in a smaller form.
    Smaller {
        /// Its size before and now, for a person.
        sizes: String,
        /// The reason.
        why: String,
    },
    /// It is given up; with the reason.
    Dropped(String),
}

/// Legs that are flown in their order, with retries.
///
/// The vehicle flies inserts by itself, one after the other, and returns to its own plan when none is left. So the queue
/// keeps some legs at the vehicle before the current one ends. It asks again for what was refused, was not answered or
/// ended too early, makes smaller what does not fit into the fence, and gives up what cannot be flown.
///
/// Call [`InsertQueue::step`] in each step, and return its requests. The queue uses the tags from 1 upwards; give
/// other requests of the plugin tags from [`InsertQueue::OTHER_TAGS`] upwards. After a restart no tag is used twice, if the
/// queue is a part of the state that the plugin keeps.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct InsertQueue {
    settings: QueueSettings,
    tasks: Vec<Task>,
    next_tag: u64,
    /// Open tags that belong to no task of this instance.
    strays: Vec<u64>,
    /// The power goes off soon.
    shut_down: bool,
}

impl Default for InsertQueue {
    fn default() -> Self {
        Self::new(QueueSettings::default())
    }
}

impl InsertQueue {
    /// From here on, tags are free for the plugin's other requests.
    pub const OTHER_TAGS: u64 = 1 << 40;

    /// An empty queue.
    #[must_use]
    pub const fn new(settings: QueueSettings) -> Self {
        Self {
            settings,
            tasks: Vec::new(),
            next_tag: 1,
            strays: Vec::new(),
            shut_down: false,
        }
    }

    /// Adds a leg to the end.
    pub fn push(&mut self, leg: Leg) {
        self.tasks.push(Task {
            leg,
            standing: Standing::Waiting { not_before_ns: 0 },
            progress: 0.0,
            tries: 0,
            refusals: 0,
        });
    }

    /// Adds legs to the end.
    pub fn extend(&mut self, legs: impl IntoIterator<Item = Leg>) {
        legs.into_iter().for_each(|leg| self.push(leg));
    }

    /// Takes in what has happened, and returns what to ask for now: nothing without control, and nothing after
    /// [`Event::Shutdown`]. Writes to the log what becomes of each leg.
    #[must_use]
    pub fn step(&mut self, input: &StepInput, flight: &Flight) -> Vec<Request> {
        let mut requests = self.hear_all(input, flight);
        requests.extend(std::iter::from_fn(|| self.ask_one(input, flight)));
        requests
    }

    /// The first half of [`InsertQueue::step`]: takes in what has happened. Returns cancels, for what is open and belongs to
    /// no leg. A plugin that adds legs because of what has happened does so between the two halves.
    #[must_use]
    pub fn hear_all(&mut self, input: &StepInput, flight: &Flight) -> Vec<Request> {
        let mut cancels = Vec::new();
        if let Some(navigation) = &input.navigation {
            self.follow(navigation, flight);
        }
        for event in &input.events {
            if let Event::Outcome(outcome) = event {
                let index = self.task_of(outcome.tag);
                let fits = |leg: &Leg| !refused_by_fence(&flight.request(leg, outcome.tag, false));
                let turn = self.hear(outcome.tag, &outcome.state, input, flight.speed_mps, fits);
                if let Some(index) = index {
                    self.log(index, &turn);
                }
            } else if let Event::Restored(restored) = event {
                self.restored(restored, input.now_ns);
                cancels.extend(self.strays.iter().map(|tag| Request::Cancel(*tag)));
            } else if matches!(event, Event::Shutdown) {
                self.shut_down = true;
            }
        }
        cancels
    }

    /// The second half of [`InsertQueue::step`], one leg at a time: the request for the next leg, if one is due.
    pub fn ask_one(&mut self, input: &StepInput, flight: &Flight) -> Option<Request> {
        if !input.control || self.shut_down {
            return None;
        }
        let interrupt = self.settings.interrupt && self.open() == 0;
        let (index, tag) = self.ask(input.now_ns)?;
        Some(flight.request(&self.tasks[index].leg, tag, interrupt))
    }

    /// Whether the power goes off soon: then nothing is asked for any more.
    #[must_use]
    pub const fn is_shut_down(&self) -> bool {
        self.shut_down
    }

    fn follow(&mut self, navigation: &Navigation, flight: &Flight) {
        if let Ok(position) = backseat_units::Position::try_from(navigation.position) {
            let velocity = EastNorth::new(navigation.velocity_east, navigation.velocity_north);
            self.fly(flight.frame.to_local(position), velocity);
        }
    }

    fn log(&self, index: usize, turn: &Turn) {
        let (number, of) = (index + 1, self.tasks.len());
        match turn {
            Turn::Quiet => {}
            Turn::Began => log::info!("leg {number} of {of} begun"),
            Turn::Flown => log::info!("leg {number} of {of} flown"),
            Turn::Again(why) => log::warn!("leg {number} of {of} will be requested again: {why}"),
            Turn::Smaller { sizes, why } => log::warn!("leg {number} of {of} made smaller, {sizes}: {why}"),
            Turn::Dropped(why) => log::warn!("leg {number} of {of} given up: {why}"),
        }
    }

    /// The legs in their order, each with what has become of it.
    #[must_use]
    pub fn tasks(&self) -> &[Task] {
        &self.tasks
    }

    /// The next leg to request now, which becomes open under the returned tag; also its index among the tasks. A part of
    /// [`InsertQueue::step`].
    pub fn ask(&mut self, now_ns: u64) -> Option<(usize, u64)> {
        let open = self.open();
        if open >= self.settings.open_max {
            return None;
        }
        let waiting = |task: &Task| match task.standing {
            Standing::Waiting { not_before_ns } => Some(not_before_ns),
            Standing::Open { .. } | Standing::Flown | Standing::Dropped => None,
        };
        let first = self.tasks.iter().position(|task| waiting(task).is_some())?;
        // In their order, unless the first has to wait while nothing is queued, because the vehicle would then leave. Before the
        // first leg is flown it cannot leave: what refuses that leg, such as a plan that is not known yet, refuses all.
        let begun = |task: &Task| {
            let flying = matches!(
                task.standing,
                Standing::Open {
                    started_ns: Some(_),
                    ..
                }
            );
            flying || matches!(task.standing, Standing::Flown | Standing::Dropped)
        };
        let may_skip = open <= 1 && self.tasks.iter().any(begun);
        let index = self
            .tasks
            .iter()
            .position(|task| waiting(task).is_some_and(|not_before_ns| not_before_ns <= now_ns))
            .filter(|index| *index == first || may_skip)?;
        let tag = self.next_tag;
        self.next_tag += 1;
        self.tasks[index].standing = Standing::Open { tag, started_ns: None };
        Some((index, tag))
    }

    /// How many of our inserts the vehicle may have.
    #[must_use]
    pub fn open(&self) -> usize {
        let open = |task: &&Task| matches!(task.standing, Standing::Open { .. });
        self.tasks.iter().filter(open).count() + self.strays.len()
    }

    /// The task that is open under a tag.
    #[must_use]
    pub fn task_of(&self, tag: u64) -> Option<usize> {
        self.tasks
            .iter()
            .position(|task| matches!(task.standing, Standing::Open { tag: open, .. } if open == tag))
    }

    /// Takes in the outcome of a request; a part of [`InsertQueue::step`]. `speed_mps` is the speed at which legs are
    /// flown, `fits` whether the fence lets a leg pass.
    pub fn hear(
        &mut self,
        tag: u64,
        state: &State,
        input: &StepInput,
        speed_mps: f64,
        mut fits: impl FnMut(&Leg) -> bool,
    ) -> Turn {
        let is_final = !matches!(
            state,
            State::Sent | State::Pending | State::Accepted | State::Started | State::Unknown
        );
        if is_final {
            self.strays.retain(|stray| *stray != tag);
        }
        let Some(index) = self.task_of(tag) else {
            return Turn::Quiet;
        };
        let others = self.open() - 1;
        let (settings, now_ns) = (&self.settings, input.now_ns);
        let task = &mut self.tasks[index];
        match state {
            State::Sent | State::Pending | State::Accepted | State::Unknown => Turn::Quiet,
            State::Started => {
                task.standing = Standing::Open {
                    tag,
                    started_ns: Some(now_ns),
                };
                Turn::Began
            }
            State::Ended(why) => {
                if task.flown(now_ns, speed_mps) >= settings.flown {
                    task.standing = Standing::Flown;
                    Turn::Flown
                } else {
                    task.fail(settings, &format!("ended too early: {}", why.text), now_ns)
                }
            }
            State::Failed(_) => task.fail(settings, state.reason().unwrap_or_default(), now_ns),
            State::TimedOut => task.fail(settings, "the vehicle did not answer", now_ns),
            State::Cancelled => task.fail(settings, "cancelled", now_ns),
            State::Rejected(why) if !input.control => {
                task.wait(settings, now_ns);
                Turn::Again(why.text.clone())
            }
            State::Rejected(why) => {
                let first = task.refusals == 0;
                // With others left to fly, the mission's limit on open inserts may be the reason, which passes.
                if first || others <= 1 {
                    task.refusals += 1;
                }
                // A smaller leg is tried now and then anyway, because the fence that a plugin can ask does not know the way
                // there from the vehicle's plan and back.
                let stuck = is_geometry(why.rule)
                    && others <= 1
                    && task.refusals.is_multiple_of((settings.refusals_max / 5).max(1));
                if !fits(&task.leg) {
                    let part = task.leg.largest_that(settings, fits);
                    task.replace(part, &why.text, now_ns)
                } else if stuck {
                    task.replace(task.leg.smaller(settings), &why.text, now_ns)
                } else if task.refusals < settings.refusals_max {
                    task.wait(settings, now_ns);
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

    /// Compares what a new instance believes to be open with what is open; a part of [`InsertQueue::step`].
    ///
    /// Open tags without a task here were requested after the snapshot, in the order of the tasks.
    pub fn restored(&mut self, restored: &Restored, now_ns: u64) {
        for task in &mut self.tasks {
            let Standing::Open { tag, started_ns } = task.standing else {
                continue;
            };
            if restored.open.contains(&tag) {
                // Its beginning may have been missed: then its end comes within its time.
                if started_ns.is_none() && restored.lost_steps > 0 {
                    let started_ns = Some(now_ns);
                    task.standing = Standing::Open { tag, started_ns };
                }
            } else if started_ns.is_some() {
                // Its end was missed. What had begun counts as flown; anything else is requested again.
                task.standing = Standing::Flown;
            } else {
                task.wait(&self.settings, now_ns);
            }
        }
        let ours = |tag: &u64| *tag < Self::OTHER_TAGS && self.task_of(*tag).is_none();
        let mut unknown: Vec<u64> = restored.open.iter().copied().filter(ours).collect();
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

    /// Open tags that belong to no task of this instance; [`InsertQueue::step`] cancels them.
    #[must_use]
    pub fn strays(&self) -> &[u64] {
        &self.strays
    }

    /// Notes the vehicle's position and velocity on the line that it is flying; a part of [`InsertQueue::step`].
    pub fn fly(&mut self, at: EastNorth, velocity: EastNorth) {
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
            if off_m < self.settings.on_line_m && forward > 0.3 * line.length_m() {
                task.progress = task.progress.max(along.clamp(0.0, 1.0));
            }
        }
    }

    /// The progress of the last leg: 0 while there are others before it, 1 when all have ended.
    #[must_use]
    pub fn last_progress(&self) -> f64 {
        let ended = |task: &&Task| !matches!(task.standing, Standing::Flown | Standing::Dropped);
        let mut live = self.tasks.iter().filter(ended);
        match (live.next(), live.next()) {
            (None, _) => 1.0,
            (Some(task), None) => task.progress,
            (Some(_), Some(_)) => 0.0,
        }
    }

    /// Whether every leg was flown or given up.
    #[must_use]
    pub fn is_done(&self) -> bool {
        let mut tasks = self.tasks.iter();
        tasks.all(|task| matches!(task.standing, Standing::Flown | Standing::Dropped))
    }

    /// Whether the vehicle has flown the last leg.
    #[must_use]
    pub fn last_flown(&self) -> bool {
        self.tasks.last().is_some_and(|task| task.standing == Standing::Flown)
    }
}

impl Task {
    /// Which part of the leg was flown, 0 to 1 and more: of a line as far as the vehicle was seen on it, of a circle by
    /// the time.
    fn flown(&self, now_ns: u64, speed_mps: f64) -> f64 {
        match (self.leg, self.standing) {
            (Leg::Line(_), _) => self.progress,
            (
                Leg::Circle(_),
                Standing::Open {
                    started_ns: Some(started_ns),
                    ..
                },
            ) => {
                let flown_s = now_ns.saturating_sub(started_ns) as f64 / SECOND_NS as f64;
                flown_s * speed_mps / self.leg.length_m()
            }
            (
                Leg::Circle(_),
                Standing::Open { started_ns: None, .. }
                | Standing::Waiting { .. }
                | Standing::Flown
                | Standing::Dropped,
            ) => 0.0,
        }
    }

    fn wait(&mut self, settings: &QueueSettings, now_ns: u64) {
        self.progress = 0.0;
        self.standing = Standing::Waiting {
            not_before_ns: now_ns + settings.again_ns,
        };
    }

    fn fail(&mut self, settings: &QueueSettings, why: &str, now_ns: u64) -> Turn {
        self.tries += 1;
        if self.tries >= settings.tries_max {
            return self.drop(why);
        }
        self.wait(settings, now_ns);
        Turn::Again(why.to_owned())
    }

    fn replace(&mut self, smaller: Option<Leg>, why: &str, now_ns: u64) -> Turn {
        let Some(smaller) = smaller else {
            return self.drop(why);
        };
        let sizes = format!("{} to {}", self.leg.size(), smaller.size());
        self.leg = smaller;
        self.progress = 0.0;
        // A different request, so it need not wait.
        self.standing = Standing::Waiting { not_before_ns: now_ns };
        Turn::Smaller {
            sizes,
            why: why.to_owned(),
        }
    }

    fn drop(&mut self, why: &str) -> Turn {
        self.standing = Standing::Dropped;
        Turn::Dropped(why.to_owned())
    }
}

/// Whether the fence refuses a request for its geometry, and not because nothing is known about where the vehicle is.
fn refused_by_fence(request: &Request) -> bool {
    fence::check(request).is_err_and(|refusal| is_geometry(refusal.rule))
}

/// Whether a smaller leg may pass this rule.
const fn is_geometry(rule: Rule) -> bool {
    matches!(
        rule,
        Rule::KeepIn
            | Rule::KeepOut
            | Rule::Depth
            | Rule::Altitude
            | Rule::Surfacing
            | Rule::Time
            | Rule::Station
            | Rule::Limit
    )
}

#[cfg(test)]
mod tests;
