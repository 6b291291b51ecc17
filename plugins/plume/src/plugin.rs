use backseat_sdk::survey::{Circle, Flight, InsertQueue, Leg, Line, QueueSettings};
use backseat_sdk::units::{EastNorth, Position};
use backseat_sdk::{
    Ctd, Description, Event, Grant, Navigation, Plugin, Request, StepInput, Topic, Vertical, log, measures,
};
use serde::{Deserialize, Serialize};

use crate::area::Area;
use crate::config::{Channel, Config};
use crate::locate::{Located, Method, locate};
use crate::samples::Samples;
use crate::survey::Stage;

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
    flight: Flight,
    state: State,
}

/// The state that a new instance needs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct State {
    stage: Stage,
    queue: InsertQueue,
    samples: Samples,
    control: bool,
    /// The next attempt to locate the maximum is not before this time.
    locate_ns: u64,
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
            stage: Stage::Map,
            queue: InsertQueue::new(QueueSettings {
                interrupt: config.interrupt,
                ..QueueSettings::default()
            }),
            samples: Samples::default(),
            control: false,
            locate_ns: 0,
        };
        let flight = Flight {
            frame: *area.frame(),
            vertical: Vertical::Depth(config.depth_m),
            speed_mps: config.speed_mps,
        };
        Ok(Self {
            config,
            area,
            flight,
            state,
        })
    }

    fn step(&mut self, input: &StepInput) -> Result<Vec<Request>, String> {
        let here = input
            .navigation
            .as_ref()
            .and_then(|navigation| self.note_fix(navigation, input.now_ns));
        self.note_control(input.control);
        for event in &input.events {
            if let Event::Ctd(ctd) = event {
                self.measure(ctd, input.now_ns);
            } else if let Event::Restored(restored) = event {
                log::warn!(
                    "a new instance: {} steps were lost, {} requests are open",
                    restored.lost_steps,
                    restored.open.len()
                );
            } else if matches!(event, Event::Shutdown) {
                log::info!("power goes off soon: making no more requests");
            }
        }
        // The stage is decided by what the queue has heard in this step.
        let mut requests = self.state.queue.hear_all(input, &self.flight);
        let Some(here) = here else { return Ok(requests) };
        if input.control && !self.state.queue.is_shut_down() {
            self.plan(here, input.now_ns, &mut requests);
            requests.extend(self.state.queue.ask_one(input, &self.flight));
        }
        Ok(requests)
    }

    backseat_sdk::keep!(state);
}

impl Plume {
    /// The maximum according to all measurements so far, and its position.
    #[must_use]
    pub fn maximum(&self) -> Option<(Located, Position)> {
        let found = locate(self.state.samples.bins(), &self.area, self.config.line_spacing_m)?;
        Some((found, self.area.frame().to_position(found.centre)))
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
        Some(at)
    }

    fn measure(&mut self, ctd: &Ctd, now_ns: u64) {
        let at_ns = now_ns.saturating_sub(ctd.age_ns);
        let Some((at, depth_m)) = self.state.samples.place(at_ns) else {
            return;
        };
        if (depth_m - self.config.depth_m).abs() > DEPTH_OFF_M || !self.area.rectangle().contains(at, OUTSIDE_M) {
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
            log::info!("control: {} legs are planned", self.state.queue.tasks().len());
        } else {
            log::info!(
                "control lost: making no requests; the vehicle has {} legs",
                self.state.queue.open()
            );
        }
    }

    /// Adds the legs of the next stage when they are due.
    fn plan(&mut self, here: EastNorth, now_ns: u64, requests: &mut Vec<Request>) {
        let State { stage, queue, .. } = &mut self.state;
        match *stage {
            Stage::Map if queue.tasks().is_empty() => {
                let lines = self.area.lawnmower(self.config.line_spacing_m, here);
                log::info!(
                    "mapping {:.0} x {:.0} m with {} lines",
                    self.area.rectangle().length_m(),
                    self.area.rectangle().width_m(),
                    lines.len()
                );
                queue.extend(lines.into_iter().map(Leg::Line));
            }
            Stage::Map if self.config.adaptive && queue.last_progress() >= DECIDE_MAP => {
                let Some(found) = self.find(now_ns, requests) else {
                    return;
                };
                let rectangle = self.area.rectangle();
                let cross = rectangle.cross(found.centre, self.config.cross_m, self.last_end(here));
                self.state.queue.extend(cross.map(Leg::Line));
                self.state.stage = Stage::Cross;
            }
            Stage::Map if !self.config.adaptive && queue.last_progress() >= DECIDE_CROSS => {
                self.circle(here, now_ns, requests);
            }
            Stage::Cross if queue.last_progress() >= DECIDE_CROSS => self.circle(here, now_ns, requests),
            Stage::Circle if queue.is_done() => {
                *stage = Stage::Done;
                let text = if queue.last_flown() {
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

    /// Adds the circle around the maximum, if there is one.
    fn circle(&mut self, here: EastNorth, now_ns: u64, requests: &mut Vec<Request>) {
        let Some(found) = self.find(now_ns, requests) else {
            return;
        };
        let circle = Leg::Circle(Circle {
            centre: found.centre,
            radius_m: self.config.circle_radius_m,
            orbits: self.config.orbits,
            entry_deg: Some(found.centre.bearing_deg(self.last_end(here))),
        });
        requests.push(Request::Message(self.report(&found)));
        self.state.queue.push(circle);
        self.state.stage = Stage::Circle;
    }

    /// The maximum now. Ends the survey if there is none and nothing is left to measure.
    fn find(&mut self, now_ns: u64, requests: &mut Vec<Request>) -> Option<Located> {
        let at_end = self.state.queue.is_done();
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
                self.state.stage = Stage::Done;
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
        match self.state.queue.tasks().last().map(|task| task.leg) {
            Some(Leg::Line(Line { end, .. })) => end,
            Some(Leg::Circle(_)) | None => here,
        }
    }
}
