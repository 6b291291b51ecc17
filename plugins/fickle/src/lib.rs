//! A version of the template that does not last, for tests: it takes over the template's state, steers as it does, and
//! goes wrong in its fifth step. Heading east or north it panics; otherwise it asks for a line around the globe.

use backseat_sdk::{Description, Grant, Modify, Plugin, Position, Request, StepInput, Trackline, Vertical};
use serde::Deserialize;

/// The template's settings.
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

/// Keeps a heading, for a while.
#[derive(Debug)]
pub struct Fickle {
    config: Config,
    tag: u64,
    /// Steps of this instance.
    steps: u32,
}

/// In which step it goes wrong.
const WRONG: u32 = 5;
const PERIOD_NS: u64 = 1_000_000_000;

impl Plugin for Fickle {
    type Config = Config;

    fn describe() -> Description {
        Description {
            name: "template".into(),
            version: "0.2.0".into(),
            step_period_ns: PERIOD_NS,
            topics: vec![],
            grants: vec![Grant::Modify],
        }
    }

    fn new(config: Config) -> Result<Self, String> {
        Ok(Self {
            config,
            tag: 0,
            steps: 0,
        })
    }

    fn step(&mut self, input: &StepInput) -> Result<Vec<Request>, String> {
        self.steps += 1;
        let Config {
            heading_deg,
            depth_m,
            speed_mps,
        } = self.config;
        if self.steps == WRONG && heading_deg <= 90.0 {
            panic!("fickle does not last");
        }
        if !input.control {
            return Ok(vec![]);
        }
        self.tag += 1;
        let place = |longitude| Position {
            latitude: 0.0,
            longitude,
        };
        Ok(vec![if self.steps == WRONG {
            Request::Trackline(Trackline {
                tag: self.tag,
                start: place(-90.0),
                end: place(90.0),
                vertical: Vertical::Depth(depth_m),
                speed: speed_mps,
                interrupt: false,
            })
        } else {
            Request::Modify(Modify {
                tag: self.tag,
                heading: heading_deg,
                vertical: Vertical::Depth(depth_m),
                speed: speed_mps,
                duration_ns: 3 * PERIOD_NS,
            })
        }])
    }

    backseat_sdk::keep!(tag);
}

backseat_sdk::export!(Fickle);

#[cfg(test)]
mod tests {
    use super::*;

    fn asked(heading_deg: f64) -> Vec<Vec<Request>> {
        let config = Config {
            heading_deg,
            depth_m: 10.0,
            speed_mps: 1.5,
        };
        let mut plugin = Fickle::new(config).unwrap();
        let input = StepInput {
            control: true,
            ..StepInput::default()
        };
        (0..WRONG).map(|_| plugin.step(&input).unwrap()).collect()
    }

    #[test]
    fn it_asks_for_too_much_in_its_fifth_step() {
        let asked = asked(180.0);
        let good = |asked: &[Request]| matches!(asked, [Request::Modify(_)]);
        assert!(asked[..4].iter().all(|asked| good(asked)));
        assert!(matches!(asked[4][..], [Request::Trackline(_)]));
    }

    #[test]
    #[should_panic(expected = "does not last")]
    fn it_panics_in_its_fifth_step() {
        let _never = asked(90.0);
    }
}
