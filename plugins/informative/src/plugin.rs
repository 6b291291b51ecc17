use backseat_sdk::survey::{FieldMap, Flight, Leg};
use backseat_sdk::units::EastNorth;
use backseat_sdk::{Briefing, Description, Event, Grant, Plugin, Request, StepInput, Topic, Vertical, log};

use crate::config::Config;
use crate::planner::{Progress, Search};
use crate::report::{self, Peak};
use crate::settings::Settings;
use crate::survey::Survey;

const SECOND_NS: u64 = 1_000_000_000;
/// The next line is looked for when the vehicle reaches the end of the last one in so many seconds.
const AHEAD_S: f64 = 70.0;
/// Lines are planned while more way than this is left, metres.
const LEFT_MIN_M: f64 = 80.0;

/// Searches an area for warm water and maps it.
#[derive(Debug)]
pub struct Informative {
    config: Config,
    settings: Settings,
    places: Vec<EastNorth>,
    flight: Option<Flight>,
    /// The search for the next line, while there is one.
    search: Option<Search>,
    /// The search for the warmest place, while there is one.
    peak: Option<Peak>,
    /// The map, while it is published.
    map: Option<FieldMap>,
    state: Survey,
}

impl Plugin for Informative {
    type Config = Config;

    fn describe() -> Description {
        Description {
            name: "informative".into(),
            version: env!("CARGO_PKG_VERSION").into(),
            step_period_ns: SECOND_NS,
            topics: vec![Topic::Ctd],
            grants: vec![Grant::Insert],
        }
    }

    fn new(config: Config) -> Result<Self, String> {
        let settings = config.settings().map_err(|error| error.to_string())?;
        Ok(Self {
            places: settings.places(),
            state: Survey::new(&settings)?,
            config,
            settings,
            flight: None,
            search: None,
            peak: None,
            map: None,
        })
    }

    fn brief(&mut self, briefing: &Briefing) -> Result<(), String> {
        self.flight = Some(Flight {
            frame: briefing.frame()?,
            vertical: Vertical::Depth(self.config.depth_m),
            speed_mps: self.config.speed_mps,
        });
        Ok(())
    }

    fn step(&mut self, input: &StepInput) -> Result<Vec<Request>, String> {
        let Some(flight) = self.flight.clone() else {
            return Ok(vec![]);
        };
        let mut requests = self.state.queue.hear_all(input, &flight);
        let Some(navigation) = &input.navigation else {
            return Ok(requests);
        };
        let here = navigation.local();
        let measured = input.events.iter().filter_map(|event| {
            if let Event::Ctd(ctd) = event {
                Some(ctd.temperature)
            } else {
                None
            }
        });
        self.state.measure(&self.settings, here, measured);
        if input.control {
            self.plan(here);
        }
        if self.state.is_over() && (self.state.marked || !input.control) {
            self.deliver();
        }
        requests.extend(std::iter::from_fn(|| self.state.queue.ask_one(input, &flight)));
        Ok(requests)
    }

    backseat_sdk::keep!(state);
}

impl Informative {
    /// Adds the next line to the queue, or at the end the circle, when it is time.
    fn plan(&mut self, here: EastNorth) {
        if self.state.queue.tasks().is_empty() {
            self.state.begin(self.settings.first_lines(here));
            self.state.done = !self.settings.adaptive;
            return;
        }
        if !self.state.begin_later() || self.state.ahead_m(here) > AHEAD_S * self.config.speed_mps {
            return;
        }
        if self.state.done {
            self.mark();
        } else if let Some(search) = &mut self.search {
            if let Progress::Done(line) = search.work(&self.settings, &self.places) {
                self.search = None;
                match line {
                    Some(line) => {
                        log::info!("a line to {:.0} {:.0}", line.end.east_m, line.end.north_m);
                        self.state.push(line);
                    }
                    None => self.state.done = true,
                }
            }
        } else {
            let left_m = self.state.left_m(&self.settings, here);
            if left_m < LEFT_MIN_M || self.state.is_hopeless() {
                self.state.done = true;
                return;
            }
            let from = self.state.end().unwrap_or(here);
            let ahead = self.state.ahead(&self.settings, here);
            let map = self.state.process.fit();
            self.search = map.map(|map| Search::new(map, from, left_m, ahead));
        }
    }

    /// Adds a circle around the warmest place, while the last line is flown.
    fn mark(&mut self) {
        if self.state.marked {
            return;
        }
        let Some(peak) = &mut self.peak else {
            // A fit is a step's work.
            self.peak = self.state.process.fit().map(Peak::new);
            return;
        };
        let Some(found) = peak.work(&self.settings, &self.places) else {
            return;
        };
        self.peak = None;
        log::info!(
            "{:.2} C at {:.0} {:.0}",
            found.mean_c,
            found.at.east_m,
            found.at.north_m
        );
        found.publish();
        self.state.queue.push(Leg::Circle(found.circle()));
        self.state.marked = true;
    }

    /// Publishes the map, some places a step.
    fn deliver(&mut self) {
        if self.map.is_none() {
            self.state.close();
            self.map = self.state.process.fit();
        } else if let Some(map) = &self.map {
            report::publish(&self.settings, &mut self.state, map, &self.places);
        }
    }

    /// What the survey has come to, for tests.
    #[must_use]
    pub const fn survey(&self) -> &Survey {
        &self.state
    }
}
