use backseat_sdk::units::{EastNorth, Position};
use backseat_sdk::{
    Ctd, Description, Event, Grant, Navigation, Outcome, Plugin, Request, Restored, StepInput, Topic, Trackcircle,
    Trackline, Vertical, fence, log, measures,
};
use serde::{Deserialize, Serialize};

use crate::area::{Area, Line};
use crate::config::{Channel, Config};
use crate::locate::{Located, Method, locate};
use crate::samples::Samples;
use crate::survey::{Leg, Stage, Survey, Turn};

const SECOND_NS: u64 = 1_000_000_000;
const PERIOD_NS: u64 = SECOND_NS / 2;
/// Samples from a depth that differs from the commanded one by more than this are not used, metres.
const DEPTH_OFF_M: f64 = 2.0;
/// Samples farther outside the area than this are not used, metres.
const OUTSIDE_M: f64 = 80.0;
/// How much of a stage's last line must be flown before the next stage is decided: late, so that much is measured, but
/// with time for another attempt before the line ends.
const DECIDE_MAP: f64 = 0.6;
const DECIDE_CROSS: f64 = 0.7;
/// The time between two attempts to locate the maximum.
const LOCATE_NS: u64 = 10 * SECOND_NS;

/// Maps a scalar plume and circles its maximum.
#[derive(Debug)]
pub struct Plume {
    config: Config,
    area: Area,
    state: State,
    /// Whether the fence refuses a request for its geometry.
    misfits: fn(&Request) -> bool,
}

/// The state that a new instance needs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct State {
    survey: Survey,
    samples: Samples,
    control: bool,
    /// The next attempt to locate the maximum is not before this time.
    locate_ns: u64,
    shut_down: bool,
}

impl Plugin for Plume {
    type Config = Config;

    fn describe() -> Description {
        Description {
            name: "plume".into(),
            version: env!("CARGO_PKG_VERSION").into(),
            step_period_ns: PERIOD_NS,
            topics: vec![Topic::Ctd],
            grants: vec![Grant::Insert],
        }
    }

    fn new(config: Config) -> Result<Self, String> {
        config.validate().map_err(|error| error.to_string())?;
        let area = config.area.area().map_err(|error| error.to_string())?;
        let state = State {
            survey: Survey::new(),
            samples: Samples::default(),
            control: false,
            locate_ns: 0,
            shut_down: false,
        };
        Ok(Self {
            config,
            area,
            state,
            misfits: |request| fence::check(request).is_err(),
        })
    }

    fn step(&mut self, input: &StepInput) -> Result<Vec<Request>, String> {
        let mut requests = Vec::new();
        let here = input
            .navigation
            .as_ref()
            .and_then(|navigation| self.note_fix(navigation, input.now_ns));
        self.note_control(input.control);
        for event in &input.events {
            match event {
                Event::Outcome(outcome) => self.hear(outcome, input),
                Event::Ctd(ctd) => self.measure(ctd, input.now_ns),
                Event::Restored(restored) => self.note_restored(restored, input.now_ns, &mut requests),
                Event::Shutdown => {
                    log::info!("power goes off soon: making no more requests");
                    self.state.shut_down = true;
                }
                Event::Control(_)
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
                | Event::Sample(_)
                | Event::Sidescan(_)
                | Event::SubBottom(_)
                | Event::Sonar(_) => {}
            }
        }
        let Some(here) = here else { return Ok(requests) };
        if !input.control || self.state.shut_down {
            return Ok(requests);
        }
        self.plan(here, input.now_ns, &mut requests);
        let idle = self.state.survey.open() == 0;
        if let Some((index, tag)) = self.state.survey.ask(input.now_ns) {
            let interrupt = self.config.interrupt && idle;
            requests.push(self.request(&self.state.survey.tasks[index].leg, tag, interrupt));
        }
        Ok(requests)
    }

    fn snapshot(&self) -> Vec<u8> {
        // Serialising numbers into a growing vector cannot fail.
        postcard::to_allocvec(&self.state).unwrap_or_default()
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), String> {
        self.state = postcard::from_bytes(state).map_err(|error| format!("the state does not parse: {error}"))?;
        Ok(())
    }
}

impl Plume {
    /// The maximum according to all measurements so far, and its position.
    #[must_use]
    pub fn maximum(&self) -> Option<(Located, Position)> {
        let found = locate(self.state.samples.bins(), &self.area, self.config.line_spacing_m)?;
        Some((found, self.area.frame().to_position(found.centre)))
    }

    /// Replaces the fence by `misfits`, because tests on the host have no fence.
    #[must_use]
    pub fn with_fence(mut self, misfits: fn(&Request) -> bool) -> Self {
        self.misfits = misfits;
        self
    }

    /// Notes the vehicle's position at the time of its navigation. Returns it in the area's frame.
    fn note_fix(&mut self, navigation: &Navigation, now_ns: u64) -> Option<EastNorth> {
        let at = self
            .area
            .frame()
            .to_local(Position::try_from(navigation.position).ok()?);
        let velocity = EastNorth::new(navigation.velocity_east, navigation.velocity_north);
        let at_ns = now_ns.saturating_sub(navigation.age_ns);
        self.state.samples.fix(at_ns, at, navigation.depth, velocity);
        self.state.survey.fly(at, velocity);
        Some(at)
    }

    fn measure(&mut self, ctd: &Ctd, now_ns: u64) {
        let at_ns = now_ns.saturating_sub(ctd.age_ns);
        let Some((at, depth_m)) = self.state.samples.place(at_ns) else {
            return;
        };
        if (depth_m - self.config.depth_m).abs() > DEPTH_OFF_M || !self.area.contains(at, OUTSIDE_M) {
            return;
        }
        let value = match self.config.channel {
            Channel::Temperature => ctd.temperature,
            Channel::Conductivity => ctd.conductivity,
        };
        self.state.samples.sample(at_ns, at, value);
    }

    fn note_control(&mut self, control: bool) {
        if control == self.state.control {
            return;
        }
        self.state.control = control;
        if control {
            log::info!("control: {} legs are planned", self.state.survey.tasks.len());
        } else {
            log::info!(
                "control lost: making no requests; the vehicle has {} legs",
                self.state.survey.open()
            );
        }
    }

    fn hear(&mut self, outcome: &Outcome, input: &StepInput) {
        let Some(index) = self.state.survey.task_of(outcome.tag) else {
            let _ = self.state.survey.hear(
                outcome.tag,
                &outcome.state,
                input.now_ns,
                input.control,
                self.config.speed_mps,
                || false,
            );
            return;
        };
        let request = self.request(&self.state.survey.tasks[index].leg, outcome.tag, false);
        let misfits = self.misfits;
        let turn = self.state.survey.hear(
            outcome.tag,
            &outcome.state,
            input.now_ns,
            input.control,
            self.config.speed_mps,
            || misfits(&request),
        );
        let (number, of) = (index + 1, self.state.survey.tasks.len());
        match turn {
            Turn::Quiet => {}
            Turn::Began => log::info!("leg {number} of {of} begun"),
            Turn::Flown => log::info!("leg {number} of {of} flown"),
            Turn::Again(why) => log::warn!("leg {number} of {of} will be requested again: {why}"),
            Turn::Smaller(why) => log::warn!("leg {number} of {of} made smaller: {why}"),
            Turn::Dropped(why) => log::warn!("leg {number} of {of} given up: {why}"),
        }
    }

    fn note_restored(&mut self, restored: &Restored, now_ns: u64, requests: &mut Vec<Request>) {
        log::warn!(
            "a new instance: {} steps were lost, {} requests are open",
            restored.lost_steps,
            restored.open.len()
        );
        self.state.survey.restored(&restored.open, now_ns);
        requests.extend(self.state.survey.strays().iter().map(|tag| Request::Cancel(*tag)));
    }

    /// Adds the legs of the next stage when they are due.
    fn plan(&mut self, here: EastNorth, now_ns: u64, requests: &mut Vec<Request>) {
        let survey = &mut self.state.survey;
        match survey.stage {
            Stage::Map if survey.tasks.is_empty() => {
                let lines = self.area.lawnmower(self.config.line_spacing_m, here);
                log::info!(
                    "mapping {:.0} x {:.0} m with {} lines",
                    self.area.length_m(),
                    self.area.width_m(),
                    lines.len()
                );
                survey.add(lines.into_iter().map(Leg::Line));
            }
            Stage::Map if survey.last_progress() >= DECIDE_MAP => {
                let Some(found) = self.find(now_ns, requests) else {
                    return;
                };
                let cross = self.area.cross(found.centre, self.config.cross_m, self.last_end(here));
                self.state.survey.add(cross.map(Leg::Line));
                self.state.survey.stage = Stage::Cross;
            }
            Stage::Cross if survey.last_progress() >= DECIDE_CROSS => {
                let Some(found) = self.find(now_ns, requests) else {
                    return;
                };
                let circle = Leg::Circle {
                    centre: found.centre,
                    radius_m: self.config.circle_radius_m,
                    orbits: self.config.orbits,
                    entry_deg: found.centre.bearing_deg(self.last_end(here)),
                };
                requests.push(Request::Message(self.report(&found)));
                self.state.survey.add([circle]);
                self.state.survey.stage = Stage::Circle;
            }
            Stage::Circle if survey.at_end() => {
                survey.stage = Stage::Done;
                let text = if survey.last_flown() {
                    "plume: circle flown, done"
                } else {
                    "plume: no circle was flown"
                };
                log::info!("{text}");
                requests.push(Request::Message(text.to_owned()));
            }
            Stage::Map | Stage::Cross | Stage::Circle | Stage::Done => {}
        }
    }

    /// The maximum now. Ends the survey if there is none and nothing is left to measure.
    fn find(&mut self, now_ns: u64, requests: &mut Vec<Request>) -> Option<Located> {
        let at_end = self.state.survey.at_end();
        if now_ns < self.state.locate_ns && !at_end {
            return None;
        }
        self.state.locate_ns = now_ns + LOCATE_NS;
        let found = locate(self.state.samples.bins(), &self.area, self.config.line_spacing_m);
        match found {
            Some(found) => {
                log::info!("{}", self.report(&found));
                measures::publish("maximum", found.amplitude, self.config.channel.unit());
                measures::publish("maximum_east", found.centre.east_m, "m");
                measures::publish("maximum_north", found.centre.north_m, "m");
            }
            None if at_end => {
                self.state.survey.stage = Stage::Done;
                let text = format!(
                    "plume: no clear maximum in {} bins of samples, done",
                    self.state.samples.bins().len()
                );
                log::warn!("{text}");
                requests.push(Request::Message(text));
            }
            None => {}
        }
        found
    }

    fn report(&self, found: &Located) -> String {
        let position = self.area.frame().to_position(found.centre);
        let how = match found.method {
            Method::Fit => "fit",
            Method::Centroid => "centroid",
        };
        let (narrow_m, wide_m) = found.sigmas_m.unwrap_or((0.0, 0.0));
        format!(
            "plume: maximum {:.3} {} over background at {:.6} {:.6}, radius {:.0} x {:.0} m, noise {:.3}, by {how} of {} bins",
            found.amplitude,
            self.config.channel.unit(),
            position.latitude.as_deg(),
            position.longitude.as_deg(),
            narrow_m,
            wide_m,
            found.noise,
            self.state.samples.bins().len()
        )
    }

    /// Where the last line ends; `here` if there is none.
    fn last_end(&self, here: EastNorth) -> EastNorth {
        match self.state.survey.tasks.last().map(|task| task.leg) {
            Some(Leg::Line(Line { end, .. })) => end,
            Some(Leg::Circle { .. }) | None => here,
        }
    }

    fn request(&self, leg: &Leg, tag: u64, interrupt: bool) -> Request {
        let position = |at: EastNorth| self.area.frame().to_position(at).into();
        let vertical = Vertical::Depth(self.config.depth_m);
        let speed = self.config.speed_mps;
        match *leg {
            Leg::Line(Line { start, end }) => Request::Trackline(Trackline {
                tag,
                start: position(start),
                end: position(end),
                vertical,
                speed,
                interrupt,
            }),
            Leg::Circle {
                centre,
                radius_m,
                orbits,
                entry_deg,
            } => Request::Trackcircle(Trackcircle {
                tag,
                centre: position(centre),
                radius: radius_m,
                orbits,
                vertical,
                speed,
                entry_angle: Some(entry_deg),
                interrupt,
            }),
        }
    }
}
