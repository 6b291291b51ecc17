use backseat_sdk::survey::{FieldMap, Flight, GaussianProcess, InsertQueue, Leg, Line, QueueSettings};
use backseat_sdk::units::EastNorth;
use backseat_sdk::{Briefing, Description, Event, Grant, Plugin, Request, StepInput, Topic, Vertical, log, measures};
use serde::{Deserialize, Serialize};

use crate::config::Config;
use crate::planner::{Planner, Settings};

const SECOND_NS: u64 = 1_000_000_000;
/// The next line is planned when this part of the last one is flown.
const PLAN_FROM: f64 = 0.4;
/// How many plans are looked at in a step.
const LOOKS: u32 = 2;

/// Maps a field where it matters.
#[derive(Debug)]
pub struct Informative {
    config: Config,
    settings: Settings,
    places: Vec<EastNorth>,
    flight: Option<Flight>,
    /// The map with which the next line is planned, while it is.
    map: Option<FieldMap>,
    state: State,
}

/// What a new instance needs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct State {
    queue: InsertQueue,
    process: GaussianProcess,
    planner: Option<Planner>,
    /// The length of all lines that were asked for, and of the ways between them, metres.
    way_m: f64,
    /// Where the last of these lines ends.
    end: Option<EastNorth>,
    done: bool,
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
        let state = State {
            queue: InsertQueue::new(QueueSettings::default()),
            process: settings.process()?,
            planner: None,
            way_m: 0.0,
            end: None,
            done: false,
        };
        Ok(Self {
            places: settings.places(),
            config,
            settings,
            flight: None,
            map: None,
            state,
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
        for event in &input.events {
            if let Event::Ctd(ctd) = event
                && self.settings.area.contains(here, 50.0)
            {
                self.state.process.add(here, ctd.temperature);
            }
        }
        if input.control {
            self.plan(here);
        }
        requests.extend(std::iter::from_fn(|| self.state.queue.ask_one(input, &flight)));
        Ok(requests)
    }

    backseat_sdk::keep!(state);
}

impl Informative {
    /// Adds the next line to the queue, when it is time and one was found.
    fn plan(&mut self, here: EastNorth) {
        if self.state.done {
            self.finish();
            return;
        }
        if self.state.queue.tasks().is_empty() {
            for line in self.first(here) {
                self.push(line);
            }
            return;
        }
        if !self.config.adaptive || self.state.queue.last_progress() < PLAN_FROM {
            return;
        }
        if self.state.way_m >= self.config.way_m {
            self.state.done = true;
            return;
        }
        let from = self.state.end.unwrap_or(here);
        let mut planner = self.state.planner.take().unwrap_or_else(|| Planner::new(from));
        if self.map.is_none() {
            // A fit is a step's work.
            self.map = self.state.process.fit();
            self.state.planner = Some(planner);
            return;
        }
        let Some(map) = &self.map else { return };
        let mut more = true;
        for _ in 0..LOOKS {
            more = more && planner.look(&self.settings, map, &self.places);
        }
        if more {
            self.state.planner = Some(planner);
            return;
        }
        self.map = None;
        match planner.best() {
            Some(line) => self.push(line),
            None => self.state.done = true,
        }
    }

    /// The first line of a survey, or all lines of a lawnmower.
    fn first(&self, here: EastNorth) -> Vec<Line> {
        let area = &self.settings.area;
        if self.config.adaptive {
            // Along the middle: half of the way to each side is then known a little.
            return area.lawnmower(2.0 * area.width_m(), here);
        }
        // As many lines as the way allows: n lines of the length, with the width between the first and the last.
        let length_m = area.length_m();
        let count = ((self.config.way_m - area.width_m()) / length_m).floor().max(1.0);
        area.lawnmower(area.width_m() / count, here)
    }

    fn push(&mut self, line: Line) {
        let state = &mut self.state;
        state.way_m += line.length_m() + state.end.map_or(0.0, |end| end.distance_m(line.start));
        state.end = Some(line.end);
        state.queue.push(Leg::Line(line));
        log::info!(
            "line {} leads to {:.0} {:.0}",
            state.queue.tasks().len(),
            line.end.east_m,
            line.end.north_m
        );
        if !self.config.adaptive && state.way_m >= self.config.way_m - self.settings.area.length_m() {
            state.done = true;
        }
    }

    /// Publishes what is left unknown, when the last line is flown.
    fn finish(&mut self) {
        if !self.state.queue.is_done() || self.map.is_some() {
            return;
        }
        self.map = self.state.process.fit();
        let Some(map) = &self.map else { return };
        let (mut unknown, mut highest) = (0.0, f64::MIN);
        for place in &self.places {
            let estimate = map.at(*place);
            unknown += estimate.deviation * estimate.deviation / self.places.len() as f64;
            highest = highest.max(estimate.mean);
        }
        measures::publish("unknown", unknown.sqrt(), "C");
        measures::publish("highest", highest, "C");
        measures::publish("way", self.state.way_m, "m");
        log::info!(
            "{} lines flown: the map is known to {:.2} C",
            self.state.queue.tasks().len(),
            unknown.sqrt()
        );
    }

    /// The map of all measurements so far, for tests.
    #[must_use]
    pub fn map(&self) -> Option<FieldMap> {
        self.state.process.fit()
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use backseat_sdk::Ctd;
    use backseat_sdk::testing::{Basin, Fault};
    use backseat_sdk::units::math::exp;

    use super::*;

    const CONFIG: &str = r#"{"east_m": 0, "north_m": 300, "length_m": 800, "width_m": 600, "bearing_deg": 90, "scale_m": 90,
        "deviation_c": 0.7, "line_m": 150, "way_m": 4200, "depth_m": 12, "speed_mps": 1.5}"#;

    /// Two warm springs, which the seed places.
    #[derive(Clone, Copy)]
    struct Sea([(EastNorth, f64); 2]);

    impl Sea {
        fn drawn(seed: u64) -> Self {
            let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
            let mut within = |least: f64, most: f64| {
                state ^= state << 13;
                state ^= state >> 7;
                state ^= state << 17;
                least + (most - least) * ((state >> 11) as f64 / (1u64 << 53) as f64)
            };
            Self([0, 1].map(|_| {
                (
                    EastNorth::new(within(-350.0, 350.0), within(50.0, 550.0)),
                    within(1.0, 2.0),
                )
            }))
        }

        fn temperature_c(&self, at: EastNorth) -> f64 {
            let spring = |(centre, warmer_c): &(EastNorth, f64)| {
                let off_m = at.distance_m(*centre);
                warmer_c * exp(-0.5 * (off_m / 90.0) * (off_m / 90.0))
            };
            12.0 + self.0.iter().map(spring).sum::<f64>()
        }
    }

    fn basin(sea: Sea, adaptive: bool) -> Basin<Informative> {
        let config = CONFIG.replace('}', &format!(", \"adaptive\": {adaptive}}}"));
        let mut basin = Basin::<Informative>::new(&config).unwrap();
        basin.senses = Box::new(move |place, _, _| {
            vec![Event::Ctd(Ctd {
                age_ns: 0,
                conductivity: 40_000.0,
                temperature: sea.temperature_c(place),
                pressure: 200.0,
            })]
        });
        basin
    }

    /// The root mean square error of the map where the water is at least half a degree warmer, and the way that was flown.
    fn error_c(seed: u64, adaptive: bool) -> (f64, f64) {
        let sea = Sea::drawn(seed);
        let mut basin = basin(sea, adaptive);
        basin.fly(Duration::from_secs(7200));
        let plugin = &basin.harness.plugin;
        assert!(plugin.state.done && plugin.state.queue.is_done(), "seed {seed}");
        let map = plugin.map().unwrap();
        let (mut squares, mut count) = (0.0, 0.0);
        for east in -39..40 {
            for north in 1..60 {
                let at = EastNorth::new(10.0 * f64::from(east), 10.0 * f64::from(north));
                let truth_c = sea.temperature_c(at);
                if truth_c > 12.5 {
                    squares += (map.mean_at(at) - truth_c).powi(2);
                    count += 1.0;
                }
            }
        }
        ((squares / f64::max(count, 1.0)).sqrt(), plugin.state.way_m)
    }

    #[test]
    fn it_knows_the_warm_water_better_than_a_lawnmower_of_the_same_length() {
        let (mut adaptive, mut plain, mut better) = (0.0, 0.0, 0);
        let seeds = 12;
        for seed in 1..=seeds {
            let ((own_c, own_m), (lawn_c, lawn_m)) = (error_c(seed, true), error_c(seed, false));
            assert!(own_m < lawn_m + 450.0, "seed {seed}: {own_m} m against {lawn_m} m");
            adaptive += own_c / f64::from(seeds as u32);
            plain += lawn_c / f64::from(seeds as u32);
            better += u32::from(own_c < lawn_c);
        }
        assert!(
            adaptive < 0.8 * plain && better >= 8,
            "{adaptive:.3} against {plain:.3} C, better in {better}"
        );
    }

    #[test]
    fn it_ends_whatever_happens() {
        for seed in 0..20 {
            let mut basin = basin(Sea::drawn(seed), true);
            basin.faults = Fault::draw(seed);
            let flight = basin.fly(Duration::from_secs(10_800));
            assert!(flight.failures.is_empty());
            assert!(basin.harness.plugin.state.done, "seed {seed}: {:?}", basin.faults);
        }
    }
}
