//! An example of DVL triggering: a sonar of the payload and the vehicle's Doppler velocity log (DVL) would disturb each
//! other, so the payload triggers both, each in turn. This plugin agrees with the vehicle when that is allowed.
//!
//! What it shows:
//!
//! - The handshake of SPI 7.4. The plugin asks, waits until the vehicle allows it, and says that it triggers.
//! - All steps of one handshake have the tag of the request that began it. While the plugin triggers, it repeats that
//!   request at least every 5 s; otherwise the runtime gives the DVL back.
//! - The vehicle may take the DVL back at any time. The plugin must answer within 1 s, so it steps five times a second.
//! - Without pulses there are no velocities, and navigation drifts. The plugin watches what the DVL measures, and gives
//!   the DVL back if nothing comes.
//!
//! The pulses themselves are not a matter of SPI: the payload's own electronics make them, on a line to the DVL. Where
//! this plugin changes `pulsing`, yours would switch that line.

use backseat_sdk::{
    Description, DvlTrigger, Event, Grant, Plugin, Request, Sample, State as Fate, StepInput, Topic, log, measures,
};
use serde::{Deserialize, Serialize};

const SECOND_NS: u64 = 1_000_000_000;
const PERIOD_NS: u64 = SECOND_NS / 5;
/// The time from one repetition to the next. The runtime allows 5 s.
const REPEAT_NS: u64 = 2 * SECOND_NS;

/// The plugin's settings, from `[plugin.config]` of the mission.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Config {
    /// How long to trigger in all, seconds.
    pub trigger_s: f64,
    /// If the DVL measures nothing for so long while the plugin triggers, the plugin gives it back, seconds.
    pub silence_max_s: f64,
    /// The pause after a handshake that came to nothing, seconds.
    pub retry_s: f64,
}

/// Triggers the DVL.
#[derive(Debug)]
pub struct DvlTriggering {
    config: Config,
    state: State,
    /// The measurements of the DVL.
    heard: Heard,
}

/// What a new instance needs after a failure.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct State {
    /// The tag of the newest handshake.
    tag: u64,
    phase: Phase,
    /// How long the plugin has triggered in all.
    triggered_ns: u64,
    /// How often the vehicle has taken the DVL back.
    stops: u32,
    /// No new handshake before this time.
    wait_until_ns: u64,
}

/// How far the handshake has come.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
enum Phase {
    /// The DVL triggers itself.
    #[default]
    Internal,
    /// The plugin has asked for the DVL, and may not trigger yet.
    Asked,
    /// The plugin triggers. It repeats its request when `repeat_ns` is over.
    Pulsing {
        /// When the plugin began, after the last time that it was allowed to.
        since_ns: u64,
        /// When the next repetition is due.
        repeat_ns: u64,
    },
}

/// What the DVL has measured while the plugin triggers, or while it does not.
#[derive(Clone, Copy, Debug, Default)]
struct Heard {
    count: u32,
    first_ns: u64,
    last_ns: u64,
}

impl Plugin for DvlTriggering {
    type Config = Config;

    fn describe() -> Description {
        Description {
            name: "dvl-triggering".into(),
            version: env!("CARGO_PKG_VERSION").into(),
            step_period_ns: PERIOD_NS,
            topics: vec![Topic::Dvl],
            grants: vec![Grant::Dvl],
        }
    }

    fn new(config: Config) -> Result<Self, String> {
        for (key, value) in [
            ("trigger_s", config.trigger_s),
            ("silence_max_s", config.silence_max_s),
            ("retry_s", config.retry_s),
        ] {
            if !(1.0..=100_000.0).contains(&value) {
                return Err(format!("{key}: {value}, expected 1 to 100000"));
            }
        }
        Ok(Self {
            config,
            state: State::default(),
            heard: Heard::default(),
        })
    }

    fn step(&mut self, input: &StepInput) -> Result<Vec<Request>, String> {
        let mut requests = Vec::new();
        for event in &input.events {
            if let Event::Sample(Sample::Dvl(dvl)) = event {
                self.measure(input.now_ns.saturating_sub(dvl.age_ns));
            } else if let Event::DvlTrigger(allowed) = event {
                requests.extend(self.obey(*allowed, input.now_ns));
            } else if let Event::Outcome(outcome) = event {
                if outcome.tag == self.state.tag {
                    self.hear(&outcome.state, input.now_ns);
                }
            } else if let Event::Restored(restored) = event {
                // The runtime has ended the handshake when the plugin failed.
                self.state.tag = restored.open.iter().copied().fold(self.state.tag, u64::max);
                self.internal(input.now_ns);
            }
        }
        requests.extend(self.go_on(input));
        Ok(requests)
    }

    backseat_sdk::keep!(state);
}

impl DvlTriggering {
    /// A step of the handshake.
    const fn say(&self, external: bool, triggering: bool) -> Request {
        Request::DvlTrigger(DvlTrigger {
            tag: self.state.tag,
            external,
            triggering,
        })
    }

    /// The vehicle allows the payload to trigger, or takes the DVL back.
    fn obey(&mut self, allowed: bool, now_ns: u64) -> Option<Request> {
        match (allowed, self.state.phase) {
            (true, Phase::Asked) => {
                log::info!("triggering");
                self.tell();
                self.state.phase = Phase::Pulsing {
                    since_ns: now_ns,
                    repeat_ns: now_ns + REPEAT_NS,
                };
                Some(self.say(true, true))
            }
            // The runtime ends a request that nobody answers, so an event without a request of ours needs no answer.
            (true, Phase::Internal | Phase::Pulsing { .. }) | (false, Phase::Internal) => None,
            (false, Phase::Asked | Phase::Pulsing { .. }) => {
                log::info!("stopped by the vehicle");
                self.state.stops += 1;
                measures::publish("stops", f64::from(self.state.stops), "");
                self.stop_pulses(now_ns);
                self.state.phase = Phase::Asked;
                // The plugin has stopped, and would like to go on when the vehicle allows it.
                Some(self.say(true, false))
            }
        }
    }

    /// What is due without an event: a new handshake, the next repetition, or the end.
    fn go_on(&mut self, input: &StepInput) -> Option<Request> {
        let now_ns = input.now_ns;
        match self.state.phase {
            Phase::Internal => {
                let left = self.state.triggered_ns < nanoseconds(self.config.trigger_s);
                if !input.control || !left || now_ns < self.state.wait_until_ns {
                    return None;
                }
                self.state.tag += 1;
                self.state.phase = Phase::Asked;
                Some(self.say(true, false))
            }
            Phase::Asked => None,
            Phase::Pulsing { since_ns, repeat_ns } => {
                let silent_ns = now_ns.saturating_sub(self.heard.last_ns.max(since_ns));
                let done = self.state.triggered_ns + (now_ns - since_ns) >= nanoseconds(self.config.trigger_s);
                if silent_ns >= nanoseconds(self.config.silence_max_s) {
                    log::warn!("the DVL measures nothing: giving it back");
                } else if done {
                    log::info!("done");
                } else if now_ns < repeat_ns {
                    return None;
                } else {
                    self.state.phase = Phase::Pulsing {
                        since_ns,
                        repeat_ns: now_ns + REPEAT_NS,
                    };
                    return Some(self.say(true, true));
                }
                let end = self.say(false, false);
                self.internal(now_ns);
                Some(end)
            }
        }
    }

    /// Takes in what has become of the handshake.
    fn hear(&mut self, fate: &Fate, now_ns: u64) {
        match fate {
            Fate::Sent | Fate::Pending | Fate::Accepted | Fate::Started | Fate::Unknown => {}
            // The handshake is over: control or the link is lost, the vehicle has not allowed it within 300 s, or the
            // plugin has ended it. In every case the DVL triggers itself.
            Fate::Rejected(_) | Fate::Failed(_) | Fate::TimedOut | Fate::Ended(_) | Fate::Cancelled => {
                log::info!("the handshake is over: {}", fate.reason().unwrap_or("no answer"));
                self.internal(now_ns);
            }
        }
    }

    /// The DVL triggers itself again.
    fn internal(&mut self, now_ns: u64) {
        self.stop_pulses(now_ns);
        self.state.phase = Phase::Internal;
        self.state.wait_until_ns = now_ns + nanoseconds(self.config.retry_s);
    }

    fn stop_pulses(&mut self, now_ns: u64) {
        if let Phase::Pulsing { since_ns, .. } = self.state.phase {
            self.state.triggered_ns += now_ns.saturating_sub(since_ns);
            measures::publish("triggered", self.state.triggered_ns as f64 / SECOND_NS as f64, "s");
            self.tell();
        }
    }

    fn measure(&mut self, at_ns: u64) {
        if self.heard.count == 0 {
            self.heard.first_ns = at_ns;
        }
        self.heard.count += 1;
        self.heard.last_ns = at_ns;
    }

    /// Publishes how often the DVL measured in the phase that ends now.
    fn tell(&mut self) {
        let Heard {
            count,
            first_ns,
            last_ns,
        } = std::mem::take(&mut self.heard);
        if count > 1 && last_ns > first_ns {
            let rate_hz = f64::from(count - 1) * SECOND_NS as f64 / (last_ns - first_ns) as f64;
            let name = match self.state.phase {
                Phase::Pulsing { .. } => "rate_triggered",
                Phase::Internal | Phase::Asked => "rate_internal",
            };
            measures::publish(name, rate_hz, "Hz");
        }
    }
}

fn nanoseconds(seconds: f64) -> u64 {
    (seconds * SECOND_NS as f64) as u64
}

backseat_sdk::export!(DvlTriggering);

#[cfg(test)]
mod tests;
