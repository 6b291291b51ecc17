//! The start of a new plugin. It keeps a heading, a depth and a speed while the backseat has control.
//!
//! Change `step`. `cargo test` runs the tests below on this computer, without the runtime.

use backseat_sdk::{Description, Event, Grant, Modify, Plugin, Request, State, StepInput, Vertical, log};
use serde::Deserialize;

/// The plugin's settings, read from `[plugin.config]` in the mission file. Each key names its unit.
/// `deny_unknown_fields` makes a misspelt key an error.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Config {
    /// True heading, degrees.
    pub heading_deg: f64,
    /// Depth below the surface, metres.
    pub depth_m: f64,
    /// Speed through the water, metres per second.
    pub speed_mps: f64,
}

/// Keeps a heading.
#[derive(Debug)]
pub struct HoldHeading {
    config: Config,
    /// The tag of the newest request. Each request has its own tag, and its outcomes carry the same one.
    tag: u64,
}

/// The time from one step to the next.
const PERIOD_NS: u64 = 1_000_000_000;
/// How long a request lasts. This is longer than the period, so that the request does not lapse if one step is late.
const STANDS_NS: u64 = 3 * PERIOD_NS;

impl Plugin for HoldHeading {
    type Config = Config;

    fn describe() -> Description {
        Description {
            name: env!("CARGO_PKG_NAME").into(),
            version: env!("CARGO_PKG_VERSION").into(),
            step_period_ns: PERIOD_NS,
            // Every plugin receives outcomes, control, timers, restored and shutdown. List a topic here to receive
            // more, for example `Topic::Ctd`.
            topics: vec![],
            // A mission that does not give these grants is refused.
            grants: vec![Grant::Modify],
        }
    }

    fn new(config: Config) -> Result<Self, String> {
        // Refuse invalid settings here: then the mission does not start.
        if !(0.0..360.0).contains(&config.heading_deg) {
            return Err(format!("heading_deg: {} is not within 0 to 360", config.heading_deg));
        }
        Ok(Self { config, tag: 0 })
    }

    fn step(&mut self, input: &StepInput) -> Result<Vec<Request>, String> {
        for event in &input.events {
            // A refused request is not a failure of the plugin. The outcome gives the reason, and the plugin may try
            // again.
            if let Event::Outcome(outcome) = event
                && let State::Rejected(_) | State::Failed(_) = &outcome.state
                && let Some(why) = outcome.state.reason()
            {
                log::warn!("request {}: {why}", outcome.tag);
            }
            // The instance that failed made at most one request a step after its snapshot. Use none of their tags again.
            if let Event::Restored(restored) = event {
                self.tag += restored.lost_steps;
            }
        }
        // Without control the runtime rejects every request, so make none.
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

    // What a new instance needs after a failure: here the last tag. It may be a struct that derives serde's Serialize and
    // Deserialize.
    backseat_sdk::keep!(tag);
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
    fn it_makes_requests_only_with_control() {
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
    fn a_new_instance_continues_with_new_tags() {
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
        let restored = backseat_sdk::Restored {
            lost_steps: 3,
            open: vec![],
        };
        second
            .step(&StepInput {
                events: vec![Event::Restored(restored)],
                ..StepInput::default()
            })
            .unwrap();
        assert_eq!(second.tag, 4);
        assert!(second.restore(&[1, 2]).is_err());
    }

    #[test]
    fn an_invalid_heading_is_refused() {
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
