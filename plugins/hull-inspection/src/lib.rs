//! An example of station keeping: a hovering vehicle goes from place to place along a ship's hull, and stays at each of
//! them for some seconds, with its light on.
//!
//! What it shows:
//!
//! - Station keeping is a lease: it lasts as long as the plugin renews its request. A renewal has the tag of the
//!   request, and each place has a tag of its own.
//! - Places count along the hull, across it and away from it, as BFRNV counts them (`input.relative`). SPI does not say
//!   whether the second of these counts up or down. The plugin compares it with the depth.
//! - The mission has boxes that the vehicle may not leave or enter. The plugin leaves out a place that the runtime
//!   refuses because of them, and waits after every other refusal.
//! - At the end the plugin gives the vehicle back, and the front seat's mission goes on.

mod places;

use backseat_sdk::{
    Description, EndKind, Event, Grant, HullPosition, Light, Plugin, Relative, Request, Rule, State as Fate, Station,
    StationTarget, StepInput, Topic, log, measures,
};
use serde::{Deserialize, Serialize};

pub use places::{Place, places};

const SECOND_NS: u64 = 1_000_000_000;
const PERIOD_NS: u64 = SECOND_NS / 2;
/// How long one request lasts, and after what time the plugin renews it.
const STANDS_NS: u64 = 15 * SECOND_NS;
const RENEW_NS: u64 = 5 * SECOND_NS;
/// The pause after a refusal that may pass.
const AGAIN_NS: u64 = 2 * SECOND_NS;
/// Above this depth the sign of the vertical position says nothing, metres.
const SIGN_DEPTH_M: f64 = 0.5;
/// The light's number.
const LIGHT: i32 = 1;

/// The plugin's settings, from `[plugin.config]` of the mission.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Config {
    /// The first and the last place along the hull, metres.
    pub horizontal_m: [f64; 2],
    /// The shallowest and the deepest place, metres below the surface.
    pub depth_m: [f64; 2],
    /// The number of places along the hull, 2 to 100.
    pub columns: u32,
    /// The number of places across the hull, 1 to 100.
    pub rows: u32,
    /// The distance from the hull, metres.
    pub distance_m: f64,
    /// The speed from place to place, metres per second.
    pub speed_mps: f64,
    /// The vehicle is at a place if it is this near, metres.
    pub within_m: f64,
    /// How long to stay at each place, seconds.
    pub stay_s: f64,
    /// The longest time for the way to a place, seconds. Then the place is left out.
    pub way_max_s: f64,
}

/// Inspects a hull.
#[derive(Debug)]
pub struct HullInspection {
    config: Config,
    places: Vec<Place>,
    state: State,
}

/// What a new instance needs after a failure.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct State {
    tag: u64,
    /// The place to go to: its index.
    at: usize,
    /// The request for this place, if one is open.
    asked: Option<Asked>,
    /// Since when the vehicle has been at the place.
    there_since_ns: Option<u64>,
    /// Whether the vertical position counts upwards; unknown until the vehicle is deep enough.
    upwards: Option<bool>,
    inspected: u32,
    left_out: u32,
    /// The greatest distance from a place at the end of a stay, metres.
    off_max_m: f64,
    /// No request before this time.
    wait_until_ns: u64,
    lit: bool,
    over: bool,
}

/// The open request.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
struct Asked {
    tag: u64,
    since_ns: u64,
    renew_ns: u64,
}

impl Plugin for HullInspection {
    type Config = Config;

    fn describe() -> Description {
        Description {
            name: "hull-inspection".into(),
            version: env!("CARGO_PKG_VERSION").into(),
            step_period_ns: PERIOD_NS,
            topics: vec![Topic::RelativeNavigation],
            grants: vec![Grant::Station, Grant::Devices],
        }
    }

    fn new(config: Config) -> Result<Self, String> {
        let [shallow_m, deep_m] = config.depth_m;
        for (key, ok, expected) in [
            ("columns", (2..=100).contains(&config.columns), "2 to 100"),
            ("rows", (1..=100).contains(&config.rows), "1 to 100"),
            (
                "horizontal_m",
                config.horizontal_m.iter().all(|metres| metres.abs() <= 1000.0),
                "within 1000 m",
            ),
            (
                "depth_m",
                0.0 <= shallow_m && shallow_m <= deep_m && deep_m <= 100.0,
                "[shallow, deep]",
            ),
            ("distance_m", (0.5..=100.0).contains(&config.distance_m), "0.5 to 100"),
            ("speed_mps", (0.05..=2.0).contains(&config.speed_mps), "0.05 to 2"),
            ("within_m", (0.05..=10.0).contains(&config.within_m), "0.05 to 10"),
            ("stay_s", (0.0..=3600.0).contains(&config.stay_s), "0 to 3600"),
            ("way_max_s", (1.0..=3600.0).contains(&config.way_max_s), "1 to 3600"),
        ] {
            if !ok {
                return Err(format!("{key}: expected {expected}"));
            }
        }
        Ok(Self {
            places: places(&config),
            config,
            state: State::default(),
        })
    }

    fn step(&mut self, input: &StepInput) -> Result<Vec<Request>, String> {
        for event in &input.events {
            if let Event::Outcome(outcome) = event {
                self.hear(outcome.tag, &outcome.state, input.now_ns);
            } else if let Event::Restored(restored) = event {
                // The lease ended when the plugin failed.
                self.state.tag = restored.open.iter().copied().fold(self.state.tag, u64::max);
                self.end_request(input.now_ns);
            }
        }
        // Without control, and without a fresh position beside the hull, the runtime rejects every request.
        let (true, Some(relative)) = (input.control, &input.relative) else {
            return Ok(vec![]);
        };
        let mut requests = Vec::new();
        if !self.state.over {
            self.look(relative, input.now_ns);
            requests.extend(self.go(relative, input.now_ns));
        }
        if self.state.over && self.state.asked.take().is_some() {
            log::info!(
                "{} places inspected, {} left out: giving the vehicle back",
                self.state.inspected,
                self.state.left_out
            );
            requests.push(Request::EndStation);
        }
        requests.extend(self.switch_light());
        Ok(requests)
    }

    backseat_sdk::keep!(state);
}

impl HullInspection {
    fn next_tag(&mut self) -> u64 {
        self.state.tag += 1;
        self.state.tag
    }

    /// Notes whether the vehicle is at its place, and takes the next place when it has been there for long enough or
    /// does not get there.
    fn look(&mut self, relative: &Relative, now_ns: u64) {
        let Some((place, asked)) = self.places.get(self.state.at).zip(self.state.asked) else {
            return;
        };
        let off_m = place.distance_from(relative);
        if off_m > self.config.within_m {
            self.state.there_since_ns = None;
            if now_ns >= asked.since_ns + nanoseconds(self.config.way_max_s) {
                log::warn!("place {}: still {off_m:.1} m away", self.state.at + 1);
                self.leave_out(now_ns);
            }
            return;
        }
        let since_ns = *self.state.there_since_ns.get_or_insert(now_ns);
        if now_ns >= since_ns + nanoseconds(self.config.stay_s) {
            self.state.inspected += 1;
            self.state.off_max_m = self.state.off_max_m.max(off_m);
            measures::publish("inspected", f64::from(self.state.inspected), "");
            measures::publish("off_max", self.state.off_max_m, "m");
            self.next_place();
        }
    }

    /// The request for the present place, when it is due.
    fn go(&mut self, relative: &Relative, now_ns: u64) -> Option<Request> {
        let place = *self.places.get(self.state.at)?;
        if self.state.upwards.is_none() && relative.depth > SIGN_DEPTH_M {
            self.state.upwards = Some(relative.vertical < 0.0);
        }
        let upwards = self.state.upwards?;
        if now_ns < self.state.wait_until_ns {
            return None;
        }
        let since_ns = match self.state.asked {
            Some(asked) if now_ns < asked.renew_ns => return None,
            Some(asked) => asked.since_ns,
            None => {
                self.next_tag();
                now_ns
            }
        };
        self.state.asked = Some(Asked {
            tag: self.state.tag,
            since_ns,
            renew_ns: now_ns + RENEW_NS,
        });
        Some(Request::Station(Station {
            tag: self.state.tag,
            target: StationTarget::Hull(HullPosition {
                horizontal: place.horizontal_m,
                vertical: if upwards { -place.depth_m } else { place.depth_m },
                distance: place.distance_m,
            }),
            speed: Some(self.config.speed_mps),
            duration_ns: STANDS_NS,
        }))
    }

    /// Takes in what has become of a request.
    fn hear(&mut self, tag: u64, fate: &Fate, now_ns: u64) {
        if self.state.asked.is_none_or(|asked| asked.tag != tag) {
            return;
        }
        match fate {
            Fate::Sent | Fate::Pending | Fate::Accepted | Fate::Started | Fate::Unknown => {}
            Fate::Rejected(refusal) => {
                if let Rule::Station | Rule::Limit | Rule::Altitude = refusal.rule {
                    log::warn!("place {} is left out: {}", self.state.at + 1, refusal.text);
                    self.leave_out(now_ns);
                } else if refusal.rule == Rule::Cap {
                    log::warn!("no more station keeping: {}", refusal.text);
                    self.state.over = true;
                } else {
                    log::warn!("refused, waiting: {}", refusal.text);
                    self.end_request(now_ns);
                }
            }
            // The request is over, and so is the station keeping: the vehicle has taken up its mission. Ask again.
            Fate::Ended(ended) if ended.kind == EndKind::Replaced => {}
            Fate::Ended(_) | Fate::Failed(_) | Fate::TimedOut | Fate::Cancelled => {
                log::warn!("station keeping is over: {}", fate.reason().unwrap_or("no answer"));
                self.end_request(now_ns);
            }
        }
    }

    fn end_request(&mut self, now_ns: u64) {
        self.state.asked = None;
        self.state.there_since_ns = None;
        self.state.wait_until_ns = now_ns + AGAIN_NS;
    }

    fn leave_out(&mut self, now_ns: u64) {
        self.state.left_out += 1;
        measures::publish("left_out", f64::from(self.state.left_out), "");
        self.next_place();
        // A refused request leaves the one before it as it was; the next place replaces both.
        self.state.wait_until_ns = now_ns;
    }

    fn next_place(&mut self) {
        self.state.at += 1;
        self.state.there_since_ns = None;
        if self.state.at < self.places.len() {
            self.state.asked = None;
        } else {
            self.state.over = true;
        }
    }

    /// Switches the light on while the plugin inspects.
    fn switch_light(&mut self) -> Option<Request> {
        let on = !self.state.over && self.state.there_since_ns.is_some();
        if on == self.state.lit {
            return None;
        }
        self.state.lit = on;
        Some(Request::Light(Light {
            tag: self.next_tag(),
            light: LIGHT,
            on,
        }))
    }
}

fn nanoseconds(seconds: f64) -> u64 {
    (seconds * SECOND_NS as f64) as u64
}

backseat_sdk::export!(HullInspection);

#[cfg(test)]
mod tests;
