use backseat_sdk::units::EastNorth;
use backseat_sdk::units::math::sin_cos;
use backseat_sdk::{
    Description, Event, Grant, Modify, Plugin, Request, State as Fate, StepInput, Topic, Vertical, log, measures,
};
use serde::{Deserialize, Serialize};

use crate::config::Config;
use crate::tracker::{Settings, Tracker};

const SECOND_NS: u64 = 1_000_000_000;
/// A request lasts longer than the time between two, so that one late step ends nothing.
const LASTS_NS: u64 = 5 * SECOND_NS;

/// Zigzags over a front by modify requests.
#[derive(Debug)]
pub struct FrontPlugin {
    config: Config,
    settings: Settings,
    state: State,
}

/// What a new instance needs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct State {
    tracker: Tracker,
    /// Where the vehicle began to steer.
    begun: Option<EastNorth>,
    tag: u64,
    samples: u32,
    in_front: u32,
}

impl Plugin for FrontPlugin {
    type Config = Config;

    fn describe() -> Description {
        Description {
            name: "front".into(),
            version: env!("CARGO_PKG_VERSION").into(),
            step_period_ns: SECOND_NS,
            topics: vec![Topic::Ctd],
            grants: vec![Grant::Modify],
        }
    }

    fn new(config: Config) -> Result<Self, String> {
        let settings = config.settings().map_err(|error| error.to_string())?;
        Ok(Self {
            config,
            settings,
            state: State::default(),
        })
    }

    fn step(&mut self, input: &StepInput) -> Result<Vec<Request>, String> {
        for event in &input.events {
            if let Event::Outcome(outcome) = event
                && let Fate::Rejected(_) | Fate::Failed(_) = &outcome.state
                && let Some(why) = outcome.state.reason()
            {
                log::warn!("request {}: {why}", outcome.tag);
            }
        }
        let Some(navigation) = input.navigation.as_ref().filter(|_| input.control) else {
            return Ok(vec![]);
        };
        let across_m = self.across_m(navigation.local());
        for event in &input.events {
            if let Event::Ctd(ctd) = event {
                self.measure(across_m, ctd.temperature);
            }
        }
        if self.state.tracker.turn(&self.settings, across_m) {
            log::info!(
                "turned {across_m:.0} m across, {} crossings",
                self.state.tracker.crossings()
            );
        }
        self.state.tag += 1;
        Ok(vec![Request::Modify(Modify {
            tag: self.state.tag,
            heading: self.state.tracker.heading_deg(&self.settings),
            vertical: Vertical::Depth(self.config.depth_m),
            speed: self.config.speed_mps,
            duration_ns: LASTS_NS,
        })])
    }

    backseat_sdk::keep!(state);
}

impl FrontPlugin {
    /// How far to starboard of where it began the vehicle is, seen along the front, metres.
    fn across_m(&mut self, at: EastNorth) -> f64 {
        let from = at - *self.state.begun.get_or_insert(at);
        let (sin, cos) = sin_cos(self.settings.along_deg.to_radians());
        from.east_m * cos - from.north_m * sin
    }

    fn measure(&mut self, across_m: f64, temperature_c: f64) {
        let state = &mut self.state;
        let before = state.tracker.crossings();
        state.tracker.measure(&self.settings, across_m, temperature_c);
        if state.tracker.crossings() > before {
            measures::publish("crossings", f64::from(state.tracker.crossings()), "");
            measures::publish("front_across", across_m, "m");
        }
        let Some([coldest_c, warmest_c]) = self.config.front_c else {
            return;
        };
        state.samples += 1;
        state.in_front += u32::from((coldest_c..=warmest_c).contains(&temperature_c));
        let share = 100.0 * f64::from(state.in_front) / f64::from(state.samples);
        measures::publish("in_front", share, "%");
    }
}

#[cfg(test)]
mod tests {
    use std::time::Duration;

    use backseat_sdk::testing::{Basin, Fault};
    use backseat_sdk::units::math::tanh;
    use backseat_sdk::{Ctd, Event};
    use proptest::prelude::*;

    use super::*;

    const CONFIG: &str = r#"{"along_deg": 90, "cross_deg": 60, "beyond_m": 80, "search_m": 400, "contrast_min_c": 0.5,
        "depth_m": 12, "speed_mps": 1.5, "front_c": [12.5, 13.5]}"#;

    /// A basin with a front to the east and west that moves to the north.
    fn basin(north_m: f64, speed_mps: f64) -> Basin<FrontPlugin> {
        let mut basin = Basin::new(CONFIG).unwrap();
        basin.senses = Box::new(move |place, _, seconds| {
            let off_m = place.north_m - (north_m + speed_mps * seconds);
            vec![Event::Ctd(Ctd {
                age_ns: 0,
                conductivity: 40_000.0,
                temperature: 13.0 - tanh(off_m / 40.0),
                pressure: 120.0,
            })]
        });
        basin
    }

    #[test]
    fn it_is_in_the_front_for_a_good_part_of_its_way() {
        let mut basin = basin(-150.0, 0.05);
        basin.fly(Duration::from_secs(1800));
        let share = *basin.harness.measures("in_front").last().unwrap();
        assert!(share > 20.0, "{share} %");
        assert!(*basin.harness.measures("crossings").last().unwrap() >= 8.0);
        assert!((basin.depth_m - 12.0).abs() < 0.1);
    }

    proptest! {
        #![proptest_config(ProptestConfig::with_cases(40))]

        #[test]
        fn it_finds_the_front_again_whatever_happens(seed: u64) {
            let mut basin = basin(100.0, 0.02);
            basin.faults = Fault::draw(seed);
            let flight = basin.fly(Duration::from_secs(7200));
            prop_assert!(flight.failures.is_empty());
            let crossed = *basin.harness.measures("crossings").last().unwrap();
            prop_assert!(crossed >= 15.0, "{crossed}: {:?}", basin.faults);
        }
    }
}
