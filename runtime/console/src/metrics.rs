//! Figures for Prometheus, in the names that its conventions ask for: base units, and a counter ends in `_total`.

use std::collections::BTreeMap;
use std::sync::Mutex;
use std::sync::PoisonError;
use std::sync::atomic::Ordering::Relaxed;
use std::sync::atomic::{AtomicBool, AtomicU64};

use prometheus_client::encoding::text::encode;
use prometheus_client::metrics::counter::Counter;
use prometheus_client::metrics::family::Family;
use prometheus_client::metrics::gauge::Gauge;
use prometheus_client::metrics::info::Info;
use prometheus_client::registry::Registry;

use crate::about::{About, Kind};
use crate::item::{Counts, Item};

/// Older navigation is neither plausible nor implausible, seconds.
const NAVIGATION_AGE_MAX_S: f64 = 5.0;

type Labels = Vec<(&'static str, String)>;
type Number = Gauge<f64, AtomicU64>;

/// What the scrapes of Prometheus see of a run.
pub(crate) struct Metrics {
    registry: Registry,
    armed: Number,
    control: Number,
    steered: Family<Labels, Number>,
    held: Number,
    requests: Family<Labels, Counter>,
    counted: Mutex<BTreeMap<String, Counts>>,
    failures: Family<Labels, Counter>,
    steps: Family<Labels, Counter>,
    fuel: Family<Labels, Number>,
    measures: Family<Labels, Number>,
    position: Family<Labels, Number>,
    depth: Number,
    altitude: Number,
    speed: Number,
    heading: Number,
    integrity: Number,
    /// Whether navigation was plausible when it last came.
    plausible: AtomicBool,
    recording: Number,
    round_trip: Number,
    gap: Number,
    ages: Family<Labels, Number>,
    /// When something was heard or sent last, as the last beat has it, seconds of the run.
    last: Mutex<BTreeMap<&'static str, Option<f64>>>,
}

impl std::fmt::Debug for Metrics {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str("Metrics")
    }
}

impl Metrics {
    pub(crate) fn new(about: &About) -> Self {
        let mut registry = Registry::with_prefix("backseat");
        let info = Info::new(vec![
            ("mission", about.mission.clone()),
            ("version", about.version.clone()),
        ]);
        registry.register("run", "What runs", info);
        let armed = Number::default();
        armed.set(f64::from(u8::from(about.armed == Some(true))));
        registry.register("armed", "Whether the runtime may steer", armed.clone());
        let mut number = |name: &str, help: &str| {
            let gauge = Number::default();
            registry.register(name, help, gauge.clone());
            gauge
        };
        let control = number("control", "Whether the runtime has control of the vehicle");
        let held = number("operator_hold", "Whether the operator holds");
        let depth = number("depth_meters", "Depth of the vehicle");
        let altitude = number("altitude_meters", "Altitude of the vehicle above the seabed");
        let speed = number("speed_meters_per_second", "Speed of the vehicle over ground");
        let heading = number("heading_degrees", "Heading of the vehicle from true north");
        let integrity = number(
            "navigation_plausible",
            "Whether navigation is plausible, NaN while none comes",
        );
        let recording = number("log_written", "Whether the log of the run is written");
        // A simulation that nobody can hold may have no log.
        let unknown = matches!(about.kind, Kind::Simulated) && !about.operator;
        recording.set(if unknown { f64::NAN } else { 1.0 });
        let round_trip = number(
            "round_trip_seconds",
            "From the last command that was acknowledged to its acknowledgement",
        );
        let gap = number(
            "refresh_gap_max_seconds",
            "The longest time between two modifies of a lease",
        );
        let mut family = |name: &str, help: &str| {
            let family = Family::<Labels, Number>::default();
            registry.register(name, help, family.clone());
            family
        };
        let steered = family("steering", "Whose lease goes on");
        let fuel = family(
            "plugin_fuel_ratio",
            "The largest share of its fuel that a step of a plugin used",
        );
        let measures = family("measure", "What a plugin publishes, in its own unit");
        let position = family("position_degrees", "Latitude and longitude of the vehicle");
        let ages = family("age_seconds", "How long ago something was heard or sent");
        let mut counters = |name: &str, help: &str| {
            let family = Family::<Labels, Counter>::default();
            registry.register(name, help, family.clone());
            family
        };
        let requests = counters("requests", "Requests by owner and state");
        let failures = counters("plugin_failures", "How often a plugin has failed");
        let steps = counters("plugin_steps", "Steps of a plugin");
        Self {
            registry,
            armed,
            control,
            steered,
            held,
            requests,
            counted: Mutex::default(),
            failures,
            steps,
            fuel,
            measures,
            position,
            depth,
            altitude,
            speed,
            heading,
            integrity,
            plausible: AtomicBool::new(true),
            recording,
            round_trip,
            gap,
            ages,
            last: Mutex::default(),
        }
    }

    /// Takes an item.
    pub(crate) fn observe(&self, item: &Item) {
        let plugin = |name: &str| vec![("plugin", name.to_owned())];
        match item {
            Item::Navigation {
                lat,
                lon,
                depth_m,
                altitude_m,
                heading_deg,
                speed_mps,
                ..
            } => {
                self.depth.set(*depth_m);
                self.altitude.set(altitude_m.unwrap_or(f64::NAN));
                self.speed.set(*speed_mps);
                self.heading.set(*heading_deg);
                for (axis, value) in [("latitude", lat), ("longitude", lon)] {
                    self.position
                        .get_or_create(&vec![("axis", axis.to_owned())])
                        .set(*value);
                }
            }
            Item::Beat(beat) => {
                self.gap.set(beat.worst_gap_s);
                self.round_trip.set(beat.round_trip_s.unwrap_or(f64::NAN));
                for (what, at) in [
                    ("refreshed", beat.refreshed),
                    ("acknowledged", beat.acknowledged),
                    ("heard", beat.heard),
                    ("navigated", beat.navigated),
                ] {
                    self.last
                        .lock()
                        .unwrap_or_else(PoisonError::into_inner)
                        .insert(what, at);
                }
            }
            Item::Control { granted, .. } => flag(&self.control, *granted),
            Item::Steering(steering) => {
                self.steered.clear();
                if let Some(owner) = &steering.owner {
                    let owner = vec![("owner", owner.clone())];
                    self.steered.get_or_create(&owner).set(1.0);
                }
            }
            Item::Counts { by, .. } => self.count(by),
            Item::Plugin {
                plugin: name, failures, ..
            } => {
                reach(&self.failures.get_or_create(&plugin(name)), *failures);
            }
            Item::Headroom {
                plugin: name,
                fuel,
                steps,
            } => {
                reach(&self.steps.get_or_create(&plugin(name)), *steps);
                if let Some(fuel) = fuel {
                    self.fuel.get_or_create(&plugin(name)).set(*fuel);
                }
            }
            Item::Measure {
                plugin: of,
                name,
                value,
                unit,
            } => {
                let labels = vec![("plugin", of.clone()), ("name", name.clone()), ("unit", unit.clone())];
                self.measures.get_or_create(&labels).set(*value);
            }
            Item::Operator { act, .. } if act == "hold" || act == "release" => flag(&self.held, act == "hold"),
            Item::Integrity { ok, .. } => self.plausible.store(*ok, Relaxed),
            Item::Recording { written, .. } => flag(&self.recording, *written),
            // Nothing steers any more.
            Item::End { .. } => {
                flag(&self.armed, false);
                flag(&self.control, false);
                self.steered.clear();
            }
            Item::Status { .. }
            | Item::Mission { .. }
            | Item::Behavior { .. }
            | Item::Request { .. }
            | Item::Line { .. }
            | Item::Sensor { .. }
            | Item::Map { .. }
            | Item::Reach { .. }
            | Item::Operator { .. }
            | Item::Sonar { .. }
            | Item::Ping { .. }
            | Item::Swath { .. }
            | Item::Contact { .. }
            | Item::Pace { .. }
            | Item::Truth { .. } => {}
        }
    }

    fn count(&self, by: &BTreeMap<String, Counts>) {
        let mut counted = self.counted.lock().unwrap_or_else(PoisonError::into_inner);
        for (owner, now) in by {
            let before = counted.insert(owner.clone(), *now).unwrap_or_default();
            for (state, now, before) in [
                ("rejected", now.rejected, before.rejected),
                ("sent", now.sent, before.sent),
                ("accepted", now.accepted, before.accepted),
                ("failed", now.failed, before.failed),
            ] {
                let labels = vec![("owner", owner.clone()), ("state", state.to_owned())];
                self.requests.get_or_create(&labels).inc_by(now.saturating_sub(before));
            }
        }
    }

    /// All figures, in OpenMetrics' text. `t` is the time now, seconds of the run: ages grow also if nothing comes any more.
    pub(crate) fn text(&self, t: f64) -> String {
        let mut navigated = f64::NAN;
        for (what, at) in self.last.lock().unwrap_or_else(PoisonError::into_inner).iter() {
            // What was heard after the last item that has a time.
            let age = at.map_or(f64::NAN, |at| (t - at).max(0.0));
            self.ages.get_or_create(&vec![("what", (*what).to_owned())]).set(age);
            if *what == "navigated" {
                navigated = age;
            }
        }
        if navigated <= NAVIGATION_AGE_MAX_S {
            flag(&self.integrity, self.plausible.load(Relaxed));
        } else {
            self.integrity.set(f64::NAN);
        }
        let mut text = String::new();
        // A String takes everything.
        encode(&mut text, &self.registry).ok();
        text
    }
}

fn flag(gauge: &Number, is: bool) {
    gauge.set(f64::from(u8::from(is)));
}

/// Counts up to a number.
fn reach(counter: &Counter, count: u64) {
    counter.inc_by(count.saturating_sub(counter.get()));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::about::Origin;
    use crate::item::Beat;

    #[test]
    fn a_scrape_has_the_figures_of_a_run() {
        let origin = Origin { lat: 42.0, lon: -70.0 };
        let metrics = Metrics::new(&About::new(Kind::Live, "a \"mission\"", 7, origin, "", "{}"));
        let counts = |sent| Counts {
            sent,
            ..Counts::default()
        };
        for sent in [3, 5] {
            let by = BTreeMap::from([("isobath".to_owned(), counts(sent))]);
            metrics.observe(&Item::Counts { all: counts(sent), by });
        }
        let reason = None;
        metrics.observe(&Item::Control { granted: true, reason });
        let plausible = |t| {
            let text = metrics.text(t);
            let line = text
                .lines()
                .find(|line| line.starts_with("backseat_navigation_plausible "));
            line.expect("it is there").to_owned()
        };
        assert_eq!(plausible(1.0), "backseat_navigation_plausible NaN");
        let beat = Beat {
            heard: Some(1.5),
            navigated: Some(1.5),
            ..Beat::default()
        };
        metrics.observe(&Item::Beat(beat));
        assert_eq!(plausible(2.0), "backseat_navigation_plausible 1.0");
        assert_eq!(plausible(60.0), "backseat_navigation_plausible NaN");
        let failed = |failures| Item::Plugin {
            plugin: "isobath".to_owned(),
            state: "failed",
            text: None,
            failures,
        };
        metrics.observe(&failed(1));
        metrics.observe(&failed(3));
        assert!(metrics.text(2.0).contains("backseat_log_written 1.0"));
        metrics.observe(&Item::Recording {
            written: false,
            text: String::new(),
        });
        let text = metrics.text(2.0);
        for line in [
            "backseat_control 1.0",
            "backseat_requests_total{owner=\"isobath\",state=\"sent\"} 5",
            "backseat_age_seconds{what=\"heard\"} 0.5",
            "# TYPE backseat_plugin_failures counter",
            "backseat_plugin_failures_total{plugin=\"isobath\"} 3",
            "backseat_log_written 0.0",
            "backseat_run_info{mission=\"a \\\"mission\\\"\"",
            "# EOF",
        ] {
            assert!(text.contains(line), "{line} is not in\n{text}");
        }
    }

    #[test]
    fn what_is_over_does_not_look_new() {
        let origin = Origin { lat: 42.0, lon: -70.0 };
        let about = About {
            armed: Some(true),
            ..About::new(Kind::Live, "m", 7, origin, "", "{}")
        };
        let metrics = Metrics::new(&about);
        let beat = Beat {
            heard: Some(1.5),
            navigated: Some(2.0004),
            ..Beat::default()
        };
        metrics.observe(&Item::Beat(beat));
        // Nothing comes any more, and the age grows.
        assert!(metrics.text(8.5).contains("backseat_age_seconds{what=\"heard\"} 7.0"));
        // What was heard after the last item is not of the future.
        assert!(
            metrics
                .text(2.0)
                .contains("backseat_age_seconds{what=\"navigated\"} 0.0")
        );
        assert!(metrics.text(2.0).contains("backseat_armed 1.0"));
        metrics.observe(&Item::End { text: String::new() });
        assert!(metrics.text(2.0).contains("backseat_armed 0.0"));
    }

    /// The dashboard of the docs asks for metrics that there are.
    #[test]
    fn the_dashboard_shows_what_is_measured() {
        let dashboard = include_str!("../../docs/grafana.json");
        let dashboard: serde_json::Value = serde_json::from_str(dashboard).unwrap();
        let panels = dashboard["panels"].as_array().unwrap();
        assert!(panels.len() > 10);
        for panel in panels {
            for target in panel["targets"].as_array().unwrap() {
                let expression = target["expr"].as_str().unwrap();
                let begin = expression.find("backseat_").unwrap();
                let name: String = expression[begin..]
                    .chars()
                    .take_while(|letter| letter.is_ascii_alphanumeric() || *letter == '_')
                    .collect();
                // A counter is registered without its suffix. One without a value is not in a scrape.
                let registered = name.trim_start_matches("backseat_").trim_end_matches("_total");
                let source = include_str!("metrics.rs");
                assert!(source.contains(&format!("\"{registered}\"")), "{name} is not measured");
            }
        }
    }
}
