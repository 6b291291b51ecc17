use backseat_sdk::sonar::coverage::{CoverageMap, MapState, NoiseFloor, PingStack, Place, Strip};
use backseat_sdk::units::{EastNorth, LocalFrame, Position};
use backseat_sdk::{
    Description, Event, Grant, Navigation, Outcome, Plugin, Refusal, Request, Restored, Rule, SonarEvent, SonarPing,
    SonarSet, SonarSetting, StepInput, Topic, Trackline, Vertical, fence, kept, log, measures,
};
use serde::{Deserialize, Serialize};

use crate::config::{Config, Ground};
use crate::dial::Dial;
use crate::lines::{End, Line, Lines};
use crate::observer::{Observer, Pose};
use crate::queue::{Queue, Task, Turn};

const SECOND_NS: u64 = 1_000_000_000;
const PERIOD_NS: u64 = SECOND_NS;
/// The next line is decided this far before the end of the current one, metres: late, so that much was seen, but with
/// time for another attempt before the vehicle turns.
const DECIDE_M: f64 = 45.0;
/// On a short line, the part of it that is left at that moment.
const DECIDE_PART: f64 = 0.4;
/// The range of the sonar is changed if the wanted one differs by more than this part.
const RANGE_STEP: f64 = 0.1;
/// Listening to the noise takes no longer than this.
const LISTEN_NS: u64 = 30 * SECOND_NS;
/// Pings that were under way when the sonar fell silent.
const ON_THE_WAY: u32 = 2;
/// A setting that the sonar refuses so often is given up.
const FAILURES_MAX: u32 = 5;

/// Surveys an area by sidescan, line by line.
#[derive(Debug)]
pub struct Coverage {
    config: Config,
    frame: LocalFrame,
    map: CoverageMap,
    state: State,
    /// Why the fence refuses a request.
    refusal: fn(&Request) -> Option<Refusal>,
}

/// The state that a new instance needs, beside the map.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct State {
    lines: Lines,
    queue: Queue,
    observer: Observer,
    range: Dial,
    power: Dial,
    listening: Listening,
    noise: Option<NoiseFloor>,
    control: bool,
    /// The way since the first line began, metres, and where it was measured last.
    way_m: Option<f64>,
    last_at: Option<EastNorth>,
    place: Option<Place>,
    flown: u32,
    shut_down: bool,
    is_done: bool,
}

/// Listening to the noise.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
enum Listening {
    /// Not begun: the sonar has shown nothing yet. Since when the plugin has control.
    Waiting { control_ns: Option<u64> },
    /// Power 0 is requested or set; since when, and what was heard.
    Silent {
        from_ns: u64,
        skipped: u32,
        stack: PingStack,
    },
    /// Over.
    Done,
}

impl Plugin for Coverage {
    type Config = Config;

    fn describe() -> Description {
        Description {
            name: "coverage".into(),
            version: env!("CARGO_PKG_VERSION").into(),
            step_period_ns: PERIOD_NS,
            topics: vec![Topic::Sidescan, Topic::Sonar],
            grants: vec![Grant::Insert],
        }
    }

    fn new(config: Config) -> Result<Self, String> {
        let Ground { frame, map, lines_deg } = config.ground().map_err(|error| error.to_string())?;
        log::info!(
            "{:.0} m2 to survey with lines along {lines_deg:.0} degrees",
            map.size_m2()
        );
        let listening = if config.noise.is_some() {
            Listening::Waiting { control_ns: None }
        } else {
            Listening::Done
        };
        let state = State {
            lines: Lines::new(&config, &map),
            queue: Queue::new(),
            observer: Observer::new(config.turn_max_dps),
            range: Dial::default(),
            power: Dial::default(),
            listening,
            noise: None,
            control: false,
            way_m: None,
            last_at: None,
            place: None,
            flown: 0,
            shut_down: false,
            is_done: false,
        };
        Ok(Self {
            config,
            frame,
            map,
            state,
            refusal: |request| fence::check(request).err(),
        })
    }

    fn step(&mut self, input: &StepInput) -> Result<Vec<Request>, String> {
        let mut requests = Vec::new();
        let pose = input
            .navigation
            .as_ref()
            .and_then(|navigation| self.note_fix(navigation, input.now_ns));
        self.note_control(input.control);
        for event in &input.events {
            match event {
                Event::Outcome(outcome) => self.hear(outcome, input),
                Event::Sidescan(ping) => self.hear_ping(ping, input.now_ns),
                Event::Sonar(SonarEvent::Swath(swath)) => {
                    if swath.sensor == self.config.sensor
                        && !self.is_silent()
                        && let Some(pose) = pose
                        && let Some(strip) =
                            self.state
                                .observer
                                .swath(swath, input.now_ns, pose, &self.config.quality())
                    {
                        self.mark(&strip);
                    }
                }
                Event::Restored(restored) => self.note_restored(restored, input.now_ns, &mut requests),
                Event::Shutdown => {
                    log::info!("power goes off soon: making no more requests");
                    self.state.shut_down = true;
                }
                // On a new connection the sonar may have its settings of the mission.
                Event::Sonar(SonarEvent::Ready(true)) => {
                    self.state.range.forget();
                    self.state.power.forget();
                }
                Event::Sonar(
                    SonarEvent::Ready(false)
                    | SonarEvent::Logging(_)
                    | SonarEvent::Health(_)
                    | SonarEvent::Alarm(_)
                    | SonarEvent::ActiveAlarms(_)
                    | SonarEvent::ControllerShutdown,
                )
                | Event::SubBottom(_)
                | Event::Control(_)
                | Event::Ctd(_)
                | Event::MissionCommand(_)
                | Event::BehaviorBegan(_)
                | Event::BehaviorEnded(_)
                | Event::Timer(_)
                | Event::LoggingBegan(_)
                | Event::LoggingEnded(_)
                | Event::TopsideMessage(_)
                | Event::DvlTrigger(_)
                | Event::Window(_)
                | Event::Packet(_)
                | Event::Plan(_)
                | Event::Sample(_) => {}
            }
        }
        if self.state.shut_down {
            return Ok(requests);
        }
        self.listen(input.now_ns, input.control);
        self.set_sonar(input.now_ns, &mut requests);
        if input.control && pose.is_some() && !self.state.is_done {
            self.plan(&mut requests);
            self.ask(input.now_ns, &mut requests);
        }
        Ok(requests)
    }

    fn snapshot(&self) -> Vec<u8> {
        kept::write(&(&self.state, self.map.state()))
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), String> {
        let (state, map): (State, MapState) = kept::read(state)?;
        self.map.set_state(&map).map_err(|error| error.to_string())?;
        self.state = state;
        Ok(())
    }
}

impl Coverage {
    /// The part of the area that it has seen so far, 0 to 1.
    #[must_use]
    pub fn part(&self) -> f64 {
        self.map.part(self.config.times)
    }

    /// Replaces the fence by `refusal`, which says why it refuses a request, because tests on the host have no fence.
    #[must_use]
    pub fn with_fence(mut self, refusal: fn(&Request) -> Option<Refusal>) -> Self {
        self.refusal = refusal;
        self
    }

    /// Notes where the vehicle is, and its way. Returns its pose in the area's frame.
    fn note_fix(&mut self, navigation: &Navigation, now_ns: u64) -> Option<Pose> {
        let position = Position::try_from(navigation.position).ok()?;
        let at = self.frame.to_local(position);
        let axes = *self.map.axes();
        let place = axes.place(at);
        let velocity = EastNorth::new(navigation.velocity_east, navigation.velocity_north);
        let along_mps = axes.place(at + velocity).along_m - place.along_m;
        self.state.queue.fly(place, along_mps);
        self.state.place = Some(place);
        let last = self.state.last_at.replace(at);
        if let (Some(way_m), Some(last)) = (&mut self.state.way_m, last) {
            *way_m += last.distance_m(at);
        }
        Some(Pose {
            at_ns: now_ns.saturating_sub(navigation.age_ns),
            at,
            bearing_deg: navigation.heading - self.frame.convergence_deg(position),
        })
    }

    fn note_control(&mut self, control: bool) {
        if control != self.state.control {
            self.state.control = control;
            let open = self.state.queue.open();
            log::info!(
                "{}: {open} lines are open",
                if control { "control" } else { "control lost" }
            );
        }
    }

    /// Whether the sonar may be without transmission now. One that answers no request for its power, but pings, counts as
    /// transmitting after some attempts.
    fn is_silent(&self) -> bool {
        let power = &self.state.power;
        matches!(self.state.listening, Listening::Silent { .. })
            || power.accepted() == Some(0.0)
            || (power.is_unsure() && power.failures() < FAILURES_MAX)
    }

    fn hear_ping(&mut self, ping: &SonarPing, now_ns: u64) {
        if ping.sensor != self.config.sensor {
            return;
        }
        if self.is_silent() {
            if let Listening::Silent { skipped, stack, .. } = &mut self.state.listening
                && self.state.power.accepted() == Some(0.0)
            {
                *skipped += 1;
                if *skipped > ON_THE_WAY {
                    stack.add(ping);
                }
            }
            self.state.observer.interrupt();
            return;
        }
        let quality = self.config.quality();
        let noise = self.state.noise.as_ref();
        if let Some(strip) = self.state.observer.ping(ping, now_ns, &self.frame, &quality, noise) {
            self.mark(&strip);
        }
    }

    fn mark(&mut self, strip: &Strip) {
        let on_line = self.state.queue.is_on_line();
        self.state.observer.mark(strip, &mut self.map, on_line);
    }

    /// Listens to the noise before the first line.
    fn listen(&mut self, now_ns: u64, control: bool) {
        let Some(noise) = self.config.noise else { return };
        let power = &mut self.state.power;
        match &mut self.state.listening {
            // Pings show that the sonar is there.
            Listening::Waiting { .. } if self.state.observer.has_looked() => {
                power.want(0.0);
                self.state.listening = Listening::Silent {
                    from_ns: now_ns,
                    skipped: 0,
                    stack: PingStack::default(),
                };
            }
            Listening::Silent { from_ns, stack, .. } => {
                let is_full = stack.pings() >= noise.pings;
                if is_full || now_ns.saturating_sub(*from_ns) > LISTEN_NS {
                    if is_full {
                        log::info!("the noise is known from {} pings", stack.pings());
                        self.state.noise = NoiseFloor::of(stack);
                    } else {
                        log::warn!("the noise is not known: {} pings without transmission", stack.pings());
                    }
                    power.want(noise.power_percent);
                    self.state.listening = Listening::Done;
                }
            }
            Listening::Waiting { control_ns } if control => {
                let from_ns = *control_ns.get_or_insert(now_ns);
                if now_ns.saturating_sub(from_ns) > LISTEN_NS {
                    log::warn!("the noise is not known: no pings");
                    self.state.listening = Listening::Done;
                }
            }
            Listening::Waiting { .. } | Listening::Done => {}
        }
    }

    /// Requests the settings of the sonar that are wanted.
    fn set_sonar(&mut self, now_ns: u64, requests: &mut Vec<Request>) {
        let state = &mut self.state;
        // The power must come back, so it is never given up. The range stays as it is if the sonar refuses it.
        if state.range.failures() >= FAILURES_MAX {
            state.range.give_up();
        }
        let tag = state.queue.free_tag();
        let setting = match state.power.ask(tag, now_ns) {
            Some(percent) => SonarSetting::Power(percent),
            None => match state.range.ask(tag, now_ns) {
                Some(range_m) => SonarSetting::Range(range_m),
                None => return,
            },
        };
        state.queue.use_tag();
        requests.push(Request::SonarSet(SonarSet {
            tag,
            sensor: self.config.sensor,
            setting,
        }));
    }

    fn hear(&mut self, outcome: &Outcome, input: &StepInput) {
        let Outcome { tag, state } = outcome;
        for (name, dial) in [("range", &mut self.state.range), ("power", &mut self.state.power)] {
            if let Some(value) = dial.hear(*tag, state) {
                log::warn!(
                    "the sonar's {name} of {value} is not set: {}",
                    state.reason().unwrap_or("no answer")
                );
            }
        }
        let fits = self
            .state
            .queue
            .index_of(*tag)
            .map(|index| self.request(&self.state.queue.task(index).line, *tag, false));
        let refusal = self.refusal;
        let misfits = || fits.is_some_and(|request| refusal(&request).is_some_and(|refusal| is_geometry(&refusal)));
        let turn = self.state.queue.hear(*tag, state, input.now_ns, input.control, misfits);
        self.take(turn);
    }

    fn take(&mut self, turn: Turn) {
        let number = self.state.flown + 1;
        match turn {
            Turn::Quiet => {}
            Turn::Began => {
                log::info!("line {number} begun");
                self.map.begin_line();
                self.state.observer.reach = Default::default();
                self.state.way_m.get_or_insert(0.0);
            }
            Turn::Flown(task) => {
                self.count(&task);
                self.state.flown += 1;
                self.map.begin_line();
                let seen_percent = 100.0 * self.part();
                log::info!("line {number} flown: {seen_percent:.1} % seen");
                measures::publish("seen", seen_percent, "%");
            }
            Turn::Again(why) => log::warn!("line {number} will be requested again: {why}"),
            Turn::Shorter(why) => log::warn!("line {number} made shorter: {why}"),
            Turn::Dropped(task, why) => {
                log::warn!("line {number} given up: {why}");
                self.state.lines.given_up(&task.line, task.purpose);
            }
        }
    }

    /// Tells the planner what a line has seen, once.
    fn count(&mut self, task: &Task) {
        if !task.is_counted {
            let (state, config) = (&mut self.state, &self.config);
            state
                .lines
                .flown(&task.line, task.purpose, &state.observer.reach, config);
        }
    }

    fn note_restored(&mut self, restored: &Restored, now_ns: u64, requests: &mut Vec<Request>) {
        let Restored { lost_steps, open } = restored;
        log::warn!(
            "a new instance: {lost_steps} steps were lost, {} requests are open",
            open.len()
        );
        self.state.range.restored(open);
        self.state.power.restored(open);
        let (range, power) = (self.state.range.clone(), self.state.power.clone());
        let own = |tag| range.owns(tag) || power.owns(tag);
        for task in self.state.queue.restored(open, own, now_ns) {
            self.take(Turn::Flown(task));
        }
        requests.extend(self.state.queue.strays().iter().map(|tag| Request::Cancel(*tag)));
    }

    /// Decides on the next line when it is due.
    fn plan(&mut self, requests: &mut Vec<Request>) {
        let Some(place) = self.state.place else { return };
        if self.state.listening != Listening::Done {
            return;
        }
        let flying = if self.state.queue.is_empty() {
            None
        } else {
            let Some(task) = self.state.queue.last_flying() else {
                return;
            };
            let length_m = task.line.length_m();
            if (1.0 - task.progress) * length_m > DECIDE_M.min(DECIDE_PART * length_m) {
                return;
            }
            let line = *task;
            task.is_counted = true;
            Some(line)
        };
        let next = match flying {
            Some(task) => {
                self.count(&task);
                self.want_range();
                let map = self.state.lines.foreseen(&self.map, &task.line, place);
                self.state.lines.next(&map, task.line.to, &self.config)
            }
            None => {
                self.want_range();
                self.state.lines.next(&self.map, place, &self.config)
            }
        };
        let way_m = self.state.way_m.unwrap_or(0.0);
        match next {
            Ok((line, _)) if way_m + line.length_m() > self.config.way_max_m => {
                self.end("the way is long enough", requests)
            }
            Ok((line, purpose)) => {
                self.state.queue.push(line, purpose);
            }
            // The present line may still see what is missing.
            Err(End::Enough | End::NoGapWorth) if flying.is_some_and(|task| task.progress < 0.9) => {}
            Err(End::Enough) => self.end("enough was seen", requests),
            Err(End::NoGapWorth) => self.end("no gap is worth its way", requests),
            Err(End::FillLines) => self.end("all lines for gaps are used", requests),
            Err(End::Blind) => self.end("the sonar shows nothing", requests),
            Err(End::Lines) => self.end("too many lines", requests),
        }
    }

    /// Wants the range that fits the altitude of the last line.
    fn want_range(&mut self) {
        let Some(range) = self.config.range else { return };
        let Some(altitude_m) = self
            .state
            .lines
            .altitude_m(&self.config)
            .or(self.state.observer.altitude_m)
        else {
            return;
        };
        // Steps of 5 m, so that small changes of altitude change nothing.
        let wanted_m = ((range.per_altitude * altitude_m / 5.0).round() * 5.0).clamp(range.min_m, range.max_m);
        let present_m = self.state.range.wanted().unwrap_or(self.config.range_m);
        if (wanted_m - present_m).abs() > RANGE_STEP * present_m {
            log::info!("range {wanted_m:.0} m for an altitude of {altitude_m:.0} m");
            self.state.range.want(wanted_m);
            self.state.lines.expect_range(wanted_m, altitude_m, &self.config);
        }
    }

    fn end(&mut self, why: &str, requests: &mut Vec<Request>) {
        self.state.is_done = true;
        let text = format!(
            "coverage: {:.1} % seen by {} lines and {:.1} km; {why}; done",
            100.0 * self.part(),
            self.state.flown + u32::from(!self.state.queue.is_empty()),
            self.state.way_m.unwrap_or(0.0) / 1000.0
        );
        log::info!("{text}");
        requests.push(Request::Message(text));
    }

    /// Requests the next line, if the fence allows it.
    fn ask(&mut self, now_ns: u64, requests: &mut Vec<Request>) {
        let Some(index) = self.state.queue.due(now_ns) else {
            return;
        };
        let line = self.state.queue.task(index).line;
        let interrupt = self.config.interrupt && self.state.queue.open() == 0;
        let tag = self.state.queue.free_tag();
        let request = self.request(&line, tag, interrupt);
        let turn = match (self.refusal)(&request) {
            None => {
                self.state.queue.asked(index);
                requests.push(request);
                return;
            }
            Some(refusal) if is_geometry(&refusal) => self.state.queue.misfits(index, &refusal.text, now_ns),
            Some(refusal) => self.state.queue.refused(index, &refusal.text, now_ns),
        };
        self.take(turn);
    }

    fn request(&self, line: &Line, tag: u64, interrupt: bool) -> Request {
        let position = |place: Place| self.frame.to_position(self.map.axes().local(place)).into();
        let vertical = match (self.config.depth_m, self.config.altitude_m) {
            (Some(depth_m), _) => Vertical::Depth(depth_m),
            (None, altitude_m) => Vertical::Altitude(altitude_m.unwrap_or(self.config.first_altitude_m)),
        };
        Request::Trackline(Trackline {
            tag,
            start: position(line.from),
            end: position(line.to),
            vertical,
            speed: self.config.speed_mps,
            interrupt,
        })
    }
}

/// Whether a refusal is for where the line lies, so that another line may pass.
const fn is_geometry(refusal: &Refusal) -> bool {
    matches!(
        refusal.rule,
        Rule::KeepIn | Rule::KeepOut | Rule::Depth | Rule::Altitude
    )
}
