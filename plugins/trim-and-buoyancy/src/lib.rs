//! An example of trim, buoyancy and silence: the vehicle's plan has a stop, and the plugin uses it to make the vehicle
//! weightless and level, and then to listen while nothing on board makes a sound.
//!
//! What it shows:
//!
//! - The vehicle does these three things only while its propeller stands still. The plugin knows that from the
//!   thruster's speed (BFRVL), and not from the plan.
//! - Buoyancy comes first, because the water that it moves disturbs the trim. Each adjustment takes as long as it
//!   takes, up to 20 minutes; the outcome says when it is over, and the samples say how far it has come.
//! - A silence is acknowledged twice and ends by itself after 5 minutes. The plugin ends it when it has heard enough.
//! - A step that fails is tried again, and is left out after the last try: the others may still be worth having.

use backseat_sdk::{
    Description, EndKind, Event, Grant, Plugin, Request, Sample, Silent, State as Fate, StepInput, Topic, log, measures,
};
use serde::{Deserialize, Serialize};

const SECOND_NS: u64 = 1_000_000_000;
/// The propeller stands still if it has turned slower than this for so long. (A reading has some noise.)
const STILL_RPM: f64 = 20.0;
const STILL_NS: u64 = 3 * SECOND_NS;

/// The plugin's settings, from `[plugin.config]` of the mission.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Config {
    /// How long to listen in silence, seconds, 1 to 300.
    pub listen_s: f64,
    /// How often each step is tried, 1 to 10.
    pub tries: u32,
    /// The pause before another try, seconds, 1 to 600.
    pub retry_s: f64,
}

/// Adjusts buoyancy and trim, and listens.
#[derive(Debug)]
pub struct TrimAndBuoyancy {
    config: Config,
    state: State,
}

/// The steps of a stop, in their order.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
enum Step {
    Buoyancy,
    Trim,
    Silence,
    /// Everything is done.
    Over,
}

/// What the plugin waits for in the present step.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
enum Waits {
    /// For a still propeller, for control, and for this time; then it makes the step's request.
    ToAsk {
        /// Not before.
        from_ns: u64,
    },
    /// For the outcome of the step's request.
    ForOutcome,
    /// Until it has listened for long enough.
    ToListen {
        /// When that is.
        until_ns: u64,
    },
    /// For the end of the silence, which it has asked for.
    ForNormal,
}

/// What a new instance needs after a failure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct State {
    tag: u64,
    step: Step,
    waits: Waits,
    /// How often the present step has been tried.
    tried: u32,
    /// Since when the propeller has stood still.
    still_since_ns: Option<u64>,
    /// When the silence began.
    silent_since_ns: u64,
}

impl Plugin for TrimAndBuoyancy {
    type Config = Config;

    fn describe() -> Description {
        Description {
            name: "trim-and-buoyancy".into(),
            version: env!("CARGO_PKG_VERSION").into(),
            step_period_ns: SECOND_NS,
            topics: vec![Topic::VehicleSpeed, Topic::Trim, Topic::Buoyancy],
            grants: vec![Grant::Buoyancy, Grant::Trim, Grant::Silent],
        }
    }

    fn new(config: Config) -> Result<Self, String> {
        for (key, ok, expected) in [
            ("listen_s", (1.0..=300.0).contains(&config.listen_s), "1 to 300"),
            ("tries", (1..=10).contains(&config.tries), "1 to 10"),
            ("retry_s", (1.0..=600.0).contains(&config.retry_s), "1 to 600"),
        ] {
            if !ok {
                return Err(format!("{key}: expected {expected}"));
            }
        }
        let state = State {
            tag: 0,
            step: Step::Buoyancy,
            waits: Waits::ToAsk { from_ns: 0 },
            tried: 0,
            still_since_ns: None,
            silent_since_ns: 0,
        };
        Ok(Self { config, state })
    }

    fn step(&mut self, input: &StepInput) -> Result<Vec<Request>, String> {
        for event in &input.events {
            if let Event::Sample(sample) = event {
                self.measure(sample, input.now_ns);
            } else if let Event::Outcome(outcome) = event {
                self.hear(outcome.tag, &outcome.state, input.now_ns);
            } else if let Event::Restored(restored) = event {
                let newest = restored.open.iter().copied().max();
                let open = newest.is_some_and(|tag| tag >= self.state.tag);
                self.state.tag = self.state.tag.max(newest.unwrap_or_default());
                if !open && self.state.waits == Waits::ForOutcome {
                    self.fail("its outcome came while the plugin was not running", input.now_ns);
                }
            }
        }
        Ok(self.ask(input).into_iter().collect())
    }

    backseat_sdk::keep!(state);
}

impl TrimAndBuoyancy {
    fn measure(&mut self, sample: &Sample, now_ns: u64) {
        if let Sample::VehicleSpeed(speed) = sample {
            let still = speed.thruster_rpm.abs() < STILL_RPM;
            self.state.still_since_ns = still.then(|| self.state.still_since_ns.unwrap_or(now_ns));
        } else if let Sample::Buoyancy(buoyancy) = sample {
            measures::publish("buoyancy", buoyancy.buoyancy, "N");
        } else if let Sample::Trim(trim) = sample {
            measures::publish("pitch", trim.pitch, "deg");
            measures::publish("roll", trim.roll, "deg");
        }
    }

    /// The request that is due now.
    fn ask(&mut self, input: &StepInput) -> Option<Request> {
        if !input.control {
            return None;
        }
        match self.state.waits {
            Waits::ToAsk { from_ns } => {
                let still = self
                    .state
                    .still_since_ns
                    .is_some_and(|since_ns| input.now_ns >= since_ns + STILL_NS);
                if !still || input.now_ns < from_ns {
                    return None;
                }
                let tag = self.state.tag + 1;
                let request = match self.state.step {
                    Step::Buoyancy => Request::Buoyancy(tag),
                    Step::Trim => Request::Trim(tag),
                    Step::Silence => Request::Silent(Silent { tag, silent: true }),
                    Step::Over => return None,
                };
                self.state.tag = tag;
                self.state.tried += 1;
                self.state.waits = Waits::ForOutcome;
                log::info!("{:?}, try {}", self.state.step, self.state.tried);
                Some(request)
            }
            Waits::ToListen { until_ns } if input.now_ns >= until_ns => {
                self.state.tag += 1;
                self.state.waits = Waits::ForNormal;
                Some(Request::Silent(Silent {
                    tag: self.state.tag,
                    silent: false,
                }))
            }
            Waits::ToListen { .. } | Waits::ForOutcome | Waits::ForNormal => None,
        }
    }

    /// Takes in what has become of a request.
    fn hear(&mut self, tag: u64, fate: &Fate, now_ns: u64) {
        if self.state.step == Step::Silence {
            return self.hear_silence(tag, fate, now_ns);
        }
        if tag != self.state.tag {
            return;
        }
        match fate {
            Fate::Sent | Fate::Pending | Fate::Accepted | Fate::Started | Fate::Unknown => {}
            Fate::Ended(ended) if ended.kind == EndKind::Done => self.next(now_ns),
            Fate::Ended(_) | Fate::Failed(_) | Fate::Rejected(_) | Fate::TimedOut | Fate::Cancelled => {
                self.fail(fate.reason().unwrap_or("no answer"), now_ns);
            }
        }
    }

    /// A silence has a request that begins it, which lasts as long as the silence, and one that ends it.
    fn hear_silence(&mut self, tag: u64, fate: &Fate, now_ns: u64) {
        match (self.state.waits, fate) {
            (Waits::ForOutcome, Fate::Started) if tag == self.state.tag => {
                log::info!("silent: listening for {} s", self.config.listen_s);
                self.state.silent_since_ns = now_ns;
                let until_ns = now_ns + (self.config.listen_s * SECOND_NS as f64) as u64;
                self.state.waits = Waits::ToListen { until_ns };
            }
            (Waits::ForOutcome, Fate::Ended(_) | Fate::Failed(_) | Fate::Rejected(_) | Fate::TimedOut)
                if tag == self.state.tag =>
            {
                self.fail(fate.reason().unwrap_or("no answer"), now_ns);
            }
            // The silence is over, because the plugin has ended it or because its time was over.
            (Waits::ToListen { .. } | Waits::ForNormal, Fate::Ended(ended)) => {
                let silent_s = (now_ns - self.state.silent_since_ns) as f64 / SECOND_NS as f64;
                log::info!("heard {silent_s:.0} s of silence: {}", ended.text);
                measures::publish("silent", silent_s, "s");
                self.next(now_ns);
            }
            (Waits::ForNormal, Fate::Failed(_) | Fate::Rejected(_) | Fate::TimedOut) if tag == self.state.tag => {
                log::warn!("the silence lasts on: {}", fate.reason().unwrap_or("no answer"));
                let until_ns = now_ns + (self.config.retry_s * SECOND_NS as f64) as u64;
                self.state.waits = Waits::ToListen { until_ns };
            }
            (Waits::ToAsk { .. } | Waits::ForOutcome | Waits::ToListen { .. } | Waits::ForNormal, _) => {}
        }
    }

    /// The present step is done, or given up.
    fn next(&mut self, now_ns: u64) {
        self.state.step = match self.state.step {
            Step::Buoyancy => Step::Trim,
            Step::Trim => Step::Silence,
            Step::Silence | Step::Over => Step::Over,
        };
        self.state.tried = 0;
        self.state.waits = Waits::ToAsk { from_ns: now_ns };
    }

    fn fail(&mut self, why: &str, now_ns: u64) {
        log::warn!("{:?} failed: {why}", self.state.step);
        if self.state.tried >= self.config.tries {
            self.next(now_ns);
        } else {
            let from_ns = now_ns + (self.config.retry_s * SECOND_NS as f64) as u64;
            self.state.waits = Waits::ToAsk { from_ns };
        }
    }
}

backseat_sdk::export!(TrimAndBuoyancy);

#[cfg(test)]
mod tests;
