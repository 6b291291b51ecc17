//! The start of a new plugin: holds a heading, a depth and a speed for as long as the backseat has control.
//!
//! Copy this folder, rename the crate, and change what `step` does. `cargo test` runs the tests below on the host;
//! the build for the vehicle is `cargo xtask plugins`.

use backseat_sdk::{Description, Event, Modify, Plugin, Request, State, StepInput, Vertical, log};
use serde::Deserialize;

/// The plugin's table in the mission file. Keys carry their units. `deny_unknown_fields` makes a misspelt key an error.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Config {
    /// True heading, degrees.
    pub heading_deg: f64,
    /// Metres below the surface.
    pub depth_m: f64,
    /// Metres per second through the water.
    pub speed_mps: f64,
}

/// Holds a heading.
#[derive(Debug)]
pub struct HoldHeading {
    config: Config,
    /// The newest request's tag: each request has its own, and its outcomes carry it.
    tag: u64,
}

/// How often the plugin is stepped.
const PERIOD_NS: u64 = 1_000_000_000;
/// How long a request stands. Longer than the period, so that one late step does not let it lapse.
const STANDS_NS: u64 = 3 * PERIOD_NS;

impl Plugin for HoldHeading {
    type Config = Config;

    fn describe() -> Description {
        Description {
            name: "template".into(),
            version: env!("CARGO_PKG_VERSION").into(),
            step_period_ns: PERIOD_NS,
            // Outcomes, control, timers, restored and shutdown come unasked; CTD samples and others are topics.
            topics: vec![],
        }
    }

    fn new(config: Config) -> Result<Self, String> {
        // Say here, before the dive, what makes no sense.
        if !(0.0..360.0).contains(&config.heading_deg) {
            return Err(format!("heading_deg: {} is not within 0 to 360", config.heading_deg));
        }
        Ok(Self { config, tag: 0 })
    }

    fn step(&mut self, input: &StepInput) -> Result<Vec<Request>, String> {
        for event in &input.events {
            // The runtime says why it refused a request. That is no failure of the plugin: it may ask again.
            if let Event::Outcome(outcome) = event
                && let State::Rejected(_) | State::Failed(_) = &outcome.state
                && let Some(why) = outcome.state.reason()
            {
                log::warn!("request {}: {why}", outcome.tag);
            }
        }
        // Requests are rejected without control, so do not ask.
        if !input.control {
            return Ok(vec![]);
        }
        self.tag += 1;
        Ok(vec![Request::Modify(Modify {
            tag: self.tag,
            heading: self.config.heading_deg,
            vertical: Vertical::Depth(self.config.depth_m),
            speed: self.config.speed_mps,
            duration_ns: STANDS_NS,
        })])
    }

    // What a new instance needs after a failure. Here: not to use a tag twice.
    fn snapshot(&self) -> Vec<u8> {
        self.tag.to_le_bytes().to_vec()
    }

    fn restore(&mut self, state: &[u8]) -> Result<(), String> {
        let bytes = state
            .try_into()
            .map_err(|_| format!("a state of {} bytes, expected 8", state.len()))?;
        self.tag = u64::from_le_bytes(bytes);
        Ok(())
    }
}

backseat_sdk::export!(HoldHeading);

#[cfg(test)]
mod tests {
    use super::*;

    fn plugin() -> HoldHeading {
        HoldHeading::new(Config {
            heading_deg: 90.0,
            depth_m: 10.0,
            speed_mps: 1.5,
        })
        .unwrap()
    }

    #[test]
    fn asks_only_while_it_has_control() {
        let mut plugin = plugin();
        assert_eq!(plugin.step(&StepInput::default()).unwrap(), []);
        let with_control = StepInput {
            control: true,
            ..StepInput::default()
        };
        let requests = plugin.step(&with_control).unwrap();
        assert!(
            matches!(&requests[..], [Request::Modify(modify)] if modify.heading == 90.0),
            "{requests:?}"
        );
    }

    #[test]
    fn a_new_instance_goes_on_with_new_tags() {
        let mut first = plugin();
        first
            .step(&StepInput {
                control: true,
                ..StepInput::default()
            })
            .unwrap();
        let mut second = plugin();
        second.restore(&first.snapshot()).unwrap();
        assert_eq!(second.tag, 1);
        assert!(second.restore(&[1, 2]).is_err());
    }

    #[test]
    fn a_heading_that_makes_no_sense_is_refused() {
        assert!(
            HoldHeading::new(Config {
                heading_deg: 400.0,
                depth_m: 10.0,
                speed_mps: 1.5
            })
            .is_err()
        );
    }
}
