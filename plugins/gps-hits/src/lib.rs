//! An example of GPS hits: under water the position drifts, so the plugin brings the vehicle up for a fix before the
//! position is too far off.
//!
//! What it shows:
//!
//! - A GPS hit is an insert. The vehicle flies it after its present leg, and nothing cancels it. So the plugin asks
//!   once, and waits for the outcome.
//! - The runtime allows a GPS hit only in a zone of the fence with `surfacing = true`. The plugin asks the fence first
//!   (`fence::check`), and takes the nearest of its places that the fence allows.
//! - A request can end in every way that [`Fate`] names, and each has its reaction here.
//! - A GPS hit can end without a fix. Only `navigation.gps` says that there was one.

use backseat_sdk::{
    Description, EndKind, Event, GpsHit, Grant, Navigation, Plugin, Position, Request, Rule, State as Fate, StepInput,
    fence, log, measures, units,
};
use serde::{Deserialize, Serialize};

const SECOND_NS: u64 = 1_000_000_000;
const HOUR_S: f64 = 3600.0;

/// The plugin's settings, from `[plugin.config]` of the mission.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Config {
    /// Where the vehicle may come up: latitude and longitude of each place, degrees.
    pub places: Vec<[f64; 2]>,
    /// How far the vehicle's position drifts in an hour: the standard deviation of a random walk, metres.
    pub drift_m_per_sqrt_h: f64,
    /// The greatest drift that the survey can stand, metres.
    pub drift_max_m: f64,
    /// How long to wait after a request that came to nothing, seconds.
    pub retry_s: f64,
}

/// Brings the vehicle up for GPS fixes.
#[derive(Debug)]
pub struct GpsHits {
    config: Config,
    state: State,
    /// Whether the fence allows a request. Unit tests replace it, because there is no fence on the host.
    allowed: fn(&Request) -> bool,
}

/// What a new instance needs after a failure.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct State {
    /// The tag of the newest request.
    tag: u64,
    /// A request is on its way, waits, or is flown.
    open: bool,
    /// When the position was last that of GPS; before the first fix, when the plugin first saw a position.
    fixed_ns: Option<u64>,
    /// The number of fixes under way, without the one before the dive.
    fixes: u32,
    /// No request before this time.
    wait_until_ns: u64,
    /// The mission allows no more GPS hits.
    used_up: bool,
    /// Where the vehicle believed to be when it was last without GPS, metres east and north in the mission's frame.
    reckoned_m: Option<(f64, f64)>,
}

impl Plugin for GpsHits {
    type Config = Config;

    fn describe() -> Description {
        Description {
            name: "gps-hits".into(),
            version: env!("CARGO_PKG_VERSION").into(),
            step_period_ns: SECOND_NS,
            topics: vec![],
            grants: vec![Grant::Surface],
        }
    }

    fn new(config: Config) -> Result<Self, String> {
        if config.places.is_empty() {
            return Err("places: expected at least one [latitude, longitude]".to_owned());
        }
        for [latitude, longitude] in &config.places {
            units::Position::from_deg(*latitude, *longitude).map_err(|error| format!("places: {error}"))?;
        }
        for (key, value) in [
            ("drift_m_per_sqrt_h", config.drift_m_per_sqrt_h),
            ("drift_max_m", config.drift_max_m),
            ("retry_s", config.retry_s),
        ] {
            if !(value.is_finite() && value > 0.0) {
                return Err(format!("{key}: {value}, expected more than 0"));
            }
        }
        Ok(Self {
            config,
            state: State::default(),
            allowed: |request| match fence::check(request) {
                Ok(_clearance_m) => true,
                Err(refusal) => {
                    log::debug!("not there: {}", refusal.text);
                    false
                }
            },
        })
    }

    fn step(&mut self, input: &StepInput) -> Result<Vec<Request>, String> {
        for event in &input.events {
            if let Event::Outcome(outcome) = event {
                if outcome.tag == self.state.tag {
                    self.hear(&outcome.state, input.now_ns);
                }
            } else if let Event::Restored(restored) = event {
                // The snapshot may be older than the newest request.
                self.state.tag = restored.open.iter().copied().fold(self.state.tag + 1, u64::max);
                self.state.open = !restored.open.is_empty();
            }
        }
        let Some(navigation) = &input.navigation else {
            return Ok(vec![]);
        };
        let drift_m = self.note(navigation, input.now_ns);
        let due = drift_m > self.config.drift_max_m && input.now_ns >= self.state.wait_until_ns;
        if !due || !input.control || self.state.open || self.state.used_up {
            return Ok(vec![]);
        }
        Ok(self.ask(navigation, drift_m, input.now_ns).into_iter().collect())
    }

    backseat_sdk::keep!(state);
}

impl GpsHits {
    /// Takes in the position, and returns how far it may have drifted, metres.
    fn note(&mut self, navigation: &Navigation, now_ns: u64) -> f64 {
        let at_m = (navigation.east, navigation.north);
        if navigation.gps {
            if let Some(reckoned_m) = self.state.reckoned_m.take() {
                self.state.fixes += 1;
                let moved_m = (at_m.0 - reckoned_m.0).hypot(at_m.1 - reckoned_m.1);
                log::info!("fix {}: the position moved by {moved_m:.1} m", self.state.fixes);
                measures::publish("fixes", f64::from(self.state.fixes), "");
                measures::publish("moved", moved_m, "m");
            }
            self.state.fixed_ns = Some(now_ns);
            return 0.0;
        }
        self.state.reckoned_m = Some(at_m);
        let since_ns = now_ns.saturating_sub(*self.state.fixed_ns.get_or_insert(now_ns));
        let hours = since_ns as f64 / SECOND_NS as f64 / HOUR_S;
        let drift_m = self.config.drift_m_per_sqrt_h * hours.sqrt();
        measures::publish("drift", drift_m, "m");
        drift_m
    }

    /// A GPS hit at the nearest place that the fence allows.
    fn ask(&mut self, navigation: &Navigation, drift_m: f64, now_ns: u64) -> Option<Request> {
        let mut places: Vec<(f64, Position)> = self
            .config
            .places
            .iter()
            .map(|[latitude, longitude]| {
                let (latitude, longitude) = (*latitude, *longitude);
                let place = Position { latitude, longitude };
                (distance_m(&navigation.position, &place), place)
            })
            .collect();
        places.sort_by(|one, other| one.0.total_cmp(&other.0));
        for (distance_m, position) in places {
            let request = Request::GpsHit(GpsHit {
                tag: self.state.tag + 1,
                position,
            });
            if (self.allowed)(&request) {
                self.state.tag += 1;
                self.state.open = true;
                log::info!("may have drifted by {drift_m:.0} m: asking for a fix {distance_m:.0} m from here");
                return Some(request);
            }
        }
        log::warn!("no place from which the vehicle may come up now");
        self.wait(now_ns);
        None
    }

    /// Takes in what has become of the newest request.
    fn hear(&mut self, fate: &Fate, now_ns: u64) {
        match fate {
            Fate::Sent | Fate::Pending => {}
            Fate::Accepted => log::info!("the vehicle will surface after this leg"),
            Fate::Started => log::info!("on the way to the place where it surfaces"),
            // It is unknown whether the vehicle will surface. A later state will tell; until then a second request
            // could make it surface twice.
            Fate::Unknown => log::warn!("the vehicle may surface or not"),
            Fate::Ended(ended) => {
                self.state.open = false;
                let fixed = self
                    .state
                    .fixed_ns
                    .is_some_and(|fixed_ns| now_ns - fixed_ns < 60 * SECOND_NS);
                if ended.kind != EndKind::Done || !fixed {
                    log::warn!("no fix: {}", ended.text);
                    self.wait(now_ns);
                }
            }
            Fate::Rejected(refusal) => {
                self.state.open = false;
                // A cap does not go away by waiting.
                self.state.used_up = refusal.rule == Rule::Cap;
                log::warn!("refused: {}", refusal.text);
                self.wait(now_ns);
            }
            Fate::Failed(_) | Fate::TimedOut | Fate::Cancelled => {
                self.state.open = false;
                log::warn!("not flown: {}", fate.reason().unwrap_or("no answer"));
                self.wait(now_ns);
            }
        }
    }

    fn wait(&mut self, now_ns: u64) {
        self.state.wait_until_ns = now_ns + (self.config.retry_s * SECOND_NS as f64) as u64;
    }
}

/// The distance between two places, metres; infinite if one of them is no place.
fn distance_m(from: &Position, to: &Position) -> f64 {
    match (units::Position::try_from(*from), units::Position::try_from(*to)) {
        (Ok(from), Ok(to)) => {
            let there = units::LocalFrame::new(from).to_local(to);
            there.distance_m(units::EastNorth::new(0.0, 0.0))
        }
        (Err(_), _) | (_, Err(_)) => f64::INFINITY,
    }
}

backseat_sdk::export!(GpsHits);

#[cfg(test)]
mod tests {
    use backseat_sdk::{Ended, Outcome, Refusal};

    use super::*;

    const FAR: [f64; 2] = [42.36, -70.70];
    const NEAR: [f64; 2] = [42.351, -70.70];

    fn plugin() -> GpsHits {
        let config = Config {
            places: vec![FAR, NEAR],
            drift_m_per_sqrt_h: 60.0,
            drift_max_m: 20.0,
            retry_s: 60.0,
        };
        GpsHits {
            allowed: |_| true,
            ..GpsHits::new(config).unwrap()
        }
    }

    fn input(seconds: u64, gps: bool) -> StepInput {
        StepInput {
            now_ns: seconds * SECOND_NS,
            control: true,
            navigation: Some(Navigation {
                position: Position {
                    latitude: 42.35,
                    longitude: -70.70,
                },
                east: if gps { 12.0 } else { 0.0 },
                gps,
                ..Navigation::default()
            }),
            ..StepInput::default()
        }
    }

    fn with(seconds: u64, gps: bool, state: Fate) -> StepInput {
        let outcome = Event::Outcome(Outcome { tag: 1, state });
        StepInput {
            events: vec![outcome],
            ..input(seconds, gps)
        }
    }

    /// 20 m at 60 m per root hour is after 400 s.
    #[test]
    fn it_asks_once_when_the_drift_is_too_great_and_at_the_nearest_place() {
        let mut plugin = plugin();
        assert_eq!(plugin.step(&input(0, true)).unwrap(), []);
        assert_eq!(plugin.step(&input(390, false)).unwrap(), []);
        let asked = plugin.step(&input(410, false)).unwrap();
        assert!(
            matches!(&asked[..], [Request::GpsHit(hit)] if hit.position.latitude == NEAR[0]),
            "{asked:?}"
        );
        assert_eq!(plugin.step(&input(411, false)).unwrap(), []);
    }

    #[test]
    fn it_takes_another_place_or_waits_where_the_fence_refuses() {
        let mut plugin = plugin();
        plugin.allowed = |request| matches!(request, Request::GpsHit(hit) if hit.position.latitude == FAR[0]);
        plugin.step(&input(0, true)).unwrap();
        let asked = plugin.step(&input(410, false)).unwrap();
        assert!(
            matches!(&asked[..], [Request::GpsHit(hit)] if hit.position.latitude == FAR[0]),
            "{asked:?}"
        );
        let mut plugin = self::plugin();
        plugin.allowed = |_| false;
        plugin.step(&input(0, true)).unwrap();
        assert_eq!(plugin.step(&input(410, false)).unwrap(), []);
        plugin.allowed = |_| true;
        assert_eq!(plugin.step(&input(460, false)).unwrap(), []);
        assert_eq!(plugin.step(&input(471, false)).unwrap().len(), 1);
    }

    #[test]
    fn a_fix_ends_the_drift_and_an_end_without_one_is_tried_again() {
        let done = || Fate::Ended(Ended::new(EndKind::Done, "flown"));
        let mut plugin = plugin();
        plugin.step(&input(0, true)).unwrap();
        plugin.step(&input(410, false)).unwrap();
        plugin.step(&input(500, true)).unwrap();
        assert_eq!(plugin.step(&with(530, true, done())).unwrap(), []);
        assert_eq!((plugin.state.fixes, plugin.state.open), (1, false));
        assert_eq!(plugin.step(&input(900, false)).unwrap(), []);

        let mut plugin = self::plugin();
        plugin.step(&input(0, true)).unwrap();
        plugin.step(&input(410, false)).unwrap();
        assert_eq!(plugin.step(&with(500, false, done())).unwrap(), []);
        assert_eq!(plugin.step(&input(561, false)).unwrap().len(), 1);
    }

    #[test]
    fn it_stops_when_the_mission_allows_no_more() {
        let mut plugin = plugin();
        plugin.step(&input(0, true)).unwrap();
        plugin.step(&input(410, false)).unwrap();
        let refused = Fate::Rejected(Refusal::new(Rule::Cap, "GPS hits of the mission: 11, at most 10"));
        plugin.step(&with(411, false, refused)).unwrap();
        assert_eq!(plugin.step(&input(2000, false)).unwrap(), []);
    }

    #[test]
    fn a_new_instance_knows_what_is_open() {
        let mut first = plugin();
        first.step(&input(0, true)).unwrap();
        first.step(&input(410, false)).unwrap();
        let mut second = plugin();
        second.restore(&first.snapshot()).unwrap();
        assert_eq!(second.state, first.state);
        assert_eq!(second.step(&input(420, false)).unwrap(), []);
        assert!(second.restore(&[255; 3]).is_err());
    }

    #[test]
    fn invalid_settings_are_refused() {
        let config = |places, drift_max_m| Config {
            places,
            drift_m_per_sqrt_h: 60.0,
            drift_max_m,
            retry_s: 60.0,
        };
        assert!(GpsHits::new(config(vec![], 20.0)).unwrap_err().starts_with("places"));
        assert!(
            GpsHits::new(config(vec![[95.0, 0.0]], 20.0))
                .unwrap_err()
                .starts_with("places")
        );
        assert!(
            GpsHits::new(config(vec![NEAR], 0.0))
                .unwrap_err()
                .starts_with("drift_max_m")
        );
    }
}
