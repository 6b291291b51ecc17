//! Asks for another heading in each step, for benchmarks of how soon the runtime reacts to navigation.
//!
//! A step comes with the first navigation after its period. The benchmark's navigation comes a little more seldom, so that each
//! message of it brings one step.

use backseat_sdk::{Description, Grant, Modify, Plugin, Request, StepInput, Vertical};
use serde::Deserialize;

/// The plugin's settings.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Config {
    /// True heading about which it turns, degrees.
    pub heading_deg: f64,
    /// Depth below the surface, metres.
    pub depth_m: f64,
    /// Speed through the water, metres per second.
    pub speed_mps: f64,
}

/// Turns by a tenth of a degree to one side and to the other.
#[derive(Debug)]
pub struct Restless {
    config: Config,
    tag: u64,
}

impl Plugin for Restless {
    type Config = Config;

    fn describe() -> Description {
        Description {
            name: "restless".into(),
            version: env!("CARGO_PKG_VERSION").into(),
            step_period_ns: 250_000_000,
            topics: vec![],
            grants: vec![Grant::Modify],
        }
    }

    fn new(config: Config) -> Result<Self, String> {
        Ok(Self { config, tag: 0 })
    }

    fn step(&mut self, input: &StepInput) -> Result<Vec<Request>, String> {
        if !input.control {
            return Ok(vec![]);
        }
        self.tag += 1;
        let side = if self.tag.is_multiple_of(2) { 0.1 } else { -0.1 };
        Ok(vec![Request::Modify(Modify {
            tag: self.tag,
            heading: self.config.heading_deg + side,
            vertical: Vertical::Depth(self.config.depth_m),
            speed: self.config.speed_mps,
            duration_ns: 3_000_000_000,
        })])
    }

    backseat_sdk::keep!(tag);
}

backseat_sdk::export!(Restless);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_step_asks_for_another_heading() {
        let mut plugin = Restless::new(Config {
            heading_deg: 90.0,
            depth_m: 10.0,
            speed_mps: 1.5,
        })
        .unwrap();
        let input = StepInput {
            control: true,
            ..StepInput::default()
        };
        let mut heading = || match plugin.step(&input).unwrap()[..] {
            [Request::Modify(modify)] => modify.heading,
            _ => panic!("one modify"),
        };
        assert!((heading() - heading()).abs() > 0.1);
    }
}
