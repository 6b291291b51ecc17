//! A plugin for tests that keeps to the interface but makes requests all the time: those of a curious researcher's
//! plugin, many of them at the edge of what is allowed.
//!
//! All random numbers come from the configuration's seed. Some leases steer towards the fence until the monitor ends
//! them. Some inserts reach as far as the fence allows, or farther. Others are short and close, so that the vehicle has
//! something to fly. The plugin also makes requests that are bound to fail: without control, outside of windows, too
//! often.

use backseat_sdk::{Description, Event, Plugin, Request, StepInput, Topic, fence};
use serde::{Deserialize, Serialize};

mod asking;
mod config;
mod errands;
mod inserts;
mod random;
mod station;
mod steering;

pub use config::{Config, ConfigError, Kind};

use asking::{Asking, Fix};
use errands::Errands;
use inserts::Inserts;
use random::Random;
use station::Keeping;
use steering::Steering;

const PERIOD_NS: u64 = 500_000_000;
/// The fraction of steps without control, or without a known position, in which it makes requests at full boldness.
const BLIND_SHARE: f64 = 0.15;

/// Makes requests at the edge of what is allowed.
#[derive(Debug)]
pub struct Prober {
    config: Config,
    state: State,
    /// Whether the fence allows a request, as far as a plugin can ask.
    fits: fn(&Request) -> bool,
}

/// The state that a new instance needs.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct State {
    random: Random,
    tag: u64,
    fix: Option<Fix>,
    control: bool,
    shut_down: bool,
    steering: Steering,
    station: Keeping,
    inserts: Inserts,
    errands: Errands,
}

impl Plugin for Prober {
    type Config = Config;

    fn describe() -> Description {
        Description {
            name: "prober".into(),
            version: env!("CARGO_PKG_VERSION").into(),
            step_period_ns: PERIOD_NS,
            topics: vec![Topic::Acoustic, Topic::RelativeNavigation],
            grants: vec![],
        }
    }

    fn new(config: Config) -> Result<Self, String> {
        config.validate().map_err(|error| error.to_string())?;
        let state = State {
            random: Random::new(config.seed),
            tag: 0,
            fix: None,
            control: false,
            shut_down: false,
            steering: Steering::default(),
            station: Keeping::default(),
            inserts: Inserts::default(),
            errands: Errands::default(),
        };
        Ok(Self {
            config,
            state,
            fits: |request| fence::check(request).is_ok(),
        })
    }

    fn step(&mut self, input: &StepInput) -> Result<Vec<Request>, String> {
        let mut requests = Vec::new();
        let state = &mut self.state;
        if let Some(navigation) = &input.navigation {
            state.fix = Some(Fix::of(navigation, input));
        }
        // Without any known position there is nothing to request.
        let Some(fix) = state.fix else { return Ok(requests) };
        let mut asking = Asking {
            config: &self.config,
            random: &mut state.random,
            tag: &mut state.tag,
            fix,
            now_ns: input.now_ns,
            // The fence answers with this step's navigation.
            fits: if input.navigation.is_some() {
                self.fits
            } else {
                |_| false
            },
            requests: &mut requests,
        };
        for event in &input.events {
            match event {
                Event::Outcome(outcome) => {
                    let (tag, fate) = (outcome.tag, &outcome.state);
                    state.steering.hear(tag, fate, &mut asking);
                    state.station.hear(tag, fate, &mut asking);
                    state.inserts.hear(tag, fate, &mut asking);
                    state.errands.hear(tag, fate);
                }
                Event::DvlTrigger(allowed) => state.errands.hear_dvl(*allowed, &mut asking),
                Event::Window(window) => state.errands.hear_window(window.until_ns, input.now_ns),
                Event::Restored(restored) => {
                    state.steering.restart();
                    state.station.restart();
                    state.inserts.restart(&restored.open);
                    state.errands.restart();
                }
                Event::Shutdown => state.shut_down = true,
                Event::Control(_)
                | Event::Ctd(_)
                | Event::MissionCommand(_)
                | Event::BehaviorBegan(_)
                | Event::BehaviorEnded(_)
                | Event::Timer(_)
                | Event::LoggingBegan(_)
                | Event::LoggingEnded(_)
                | Event::TopsideMessage(_)
                | Event::Packet(_)
                | Event::Plan(_)
                | Event::Sample(_)
                | Event::Sidescan(_)
                | Event::SubBottom(_)
                | Event::Sonar(_) => {}
            }
        }
        if input.control && !state.control {
            state.inserts.hurry(&mut asking);
        }
        state.control = input.control;
        let blind = state.shut_down || !input.control || input.navigation.is_none();
        if !blind || asking.dares(BLIND_SHARE) {
            let (flying, settled) = (state.inserts.is_flying(), state.inserts.is_accepted());
            state.steering.step(flying, settled, &mut asking);
            state.station.step(&mut asking);
            state.inserts.step(&mut asking);
            state.errands.step(&state.inserts, &mut asking);
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

backseat_sdk::export!(Prober);

#[cfg(test)]
mod tests;
