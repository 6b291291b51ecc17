//! Turns the messages of a log's channels into items.

mod link;
mod requests;
mod sonar;
mod thin;

use std::borrow::Cow;
use std::collections::BTreeMap;

use backseat_units::Timestamp;
use serde::Deserialize;
use serde_json::Value;

use crate::feed::{PING, SONAR_EVENT};
use crate::item::Item;
use link::Link;
use requests::Requests;
use sonar::Sonar;
use thin::Thin;

/// Navigation in the history comes this often, seconds; so do measures. The rest of it reaches only who listens.
const KEPT_EVERY_S: f64 = 1.0;
/// Sensors in the history.
const SENSORS_KEPT_EVERY_S: f64 = 10.0;
/// Budgets are told this often, seconds.
const HEADROOM_EVERY_S: f64 = 5.0;
/// Texts of others are cut after so many characters.
const TEXT_MAX: usize = 2000;

/// Turns the messages of a log's channels into items. What it keeps is bounded, and a message that it cannot read makes
/// no item.
#[derive(Debug)]
pub struct Teller {
    plugins: Vec<Member>,
    link: Link,
    requests: Requests,
    thin: Thin,
    sonar: Sonar,
    newest_s: f64,
    /// Whether there is control, if that was said.
    controlled: Option<bool>,
    /// Who has just asked for something at the console.
    asked: Option<String>,
    /// The vehicle's last line, without its time.
    said: String,
}

#[derive(Debug)]
struct Member {
    name: String,
    fuel_limit: Option<u64>,
    fuel: u64,
    steps: u64,
    failures: u64,
}

#[derive(Deserialize)]
struct Bytes<'a> {
    #[serde(borrow)]
    text: Option<Cow<'a, str>>,
}

impl Teller {
    /// A teller of a run with these plugins in priority order, each with its name and its fuel for a step.
    #[must_use]
    pub fn new(plugins: impl IntoIterator<Item = (String, Option<u64>)>) -> Self {
        let plugins = plugins.into_iter().map(|(name, fuel_limit)| Member {
            name,
            fuel_limit,
            fuel: 0,
            steps: 0,
            failures: 0,
        });
        Self {
            plugins: plugins.collect(),
            link: Link::new(),
            requests: Requests::default(),
            thin: Thin::default(),
            sonar: Sonar::default(),
            newest_s: 0.0,
            controlled: None,
            asked: None,
            said: String::new(),
        }
    }

    /// The time of the newest message, seconds.
    #[must_use]
    pub const fn newest_s(&self) -> f64 {
        self.newest_s
    }

    /// Takes a message, and calls `tell` with the time of each item, the item, and whether it belongs into the history.
    pub fn hear(&mut self, now: Timestamp, topic: &str, data: &[u8], mut tell: impl FnMut(f64, Item, bool)) {
        let t = now.as_secs_f64();
        self.newest_s = self.newest_s.max(t);
        match topic {
            "/link/from_vehicle" => self.link.heard(t, text(data).as_deref()),
            "/link/to_vehicle" => {
                if let Some(text) = text(data) {
                    let Self {
                        link,
                        requests,
                        controlled,
                        ..
                    } = self;
                    let before = link.beat().refreshed;
                    let controlled = *controlled;
                    link.sent(t, &text, requests.leads(), |item| {
                        // Another reason for which there is no control.
                        if let (Item::Status { text }, Some(false)) = (&item, controlled) {
                            let reason = Some(text.clone());
                            tell(t, Item::Control { granted: false, reason }, true);
                        }
                        tell(t, item, true);
                    });
                    if link.beat().refreshed != before && link.beat().refreshed.is_some() {
                        tell(t, Item::Beat(link.beat()), false);
                    }
                }
            }
            "/core/input" if data.starts_with(PING) => self.sonar.ping(t, data, &mut tell),
            "/core/input" if data.starts_with(SONAR_EVENT) => self.sonar.event(t, data, &mut tell),
            "/core/input" => self.input(t, data, &mut tell),
            "/navigation" => self.navigation(t, data, &mut tell),
            _ => {
                if let Ok(value) = serde_json::from_slice::<Value>(data) {
                    self.message(t, topic, value, &mut tell);
                }
            }
        }
        if self.thin.takes("beat", t, 1.0) {
            tell(t, Item::Beat(self.link.beat()), true);
        }
        if let Some(counts) = self.requests.counts(t) {
            tell(t, counts, true);
        }
    }

    fn message(&mut self, t: f64, topic: &str, value: Value, tell: &mut impl FnMut(f64, Item, bool)) {
        match topic {
            "/notes" => self.note(t, &value, tell),
            "/requests" => {
                let name = |plugin| self.plugins.get(plugin).map(|member: &Member| member.name.clone());
                let led = self.requests.leads().map(str::to_owned);
                if let Some(item) = self.requests.transition(&value, name) {
                    tell(t, item, true);
                }
                // Its first modify was written before this.
                if let Some(leads) = self.requests.leads().filter(|leads| led.as_deref() != Some(*leads))
                    && let Some(item) = self.link.led_by(leads)
                {
                    tell(t, item, true);
                }
            }
            "/control" => {
                let granted = value["granted"] == true;
                self.controlled = Some(granted);
                if !granted && let Some(item) = self.link.ended(words(&value["reason"])) {
                    tell(t, item, true);
                }
                let reason = words(&value["reason"]).filter(|reason| !granted && !reason.is_empty());
                tell(t, Item::Control { granted, reason }, true);
            }
            "/log" => {
                let level = match value["level"].as_u64() {
                    Some(1) => "debug",
                    Some(3) => "warn",
                    Some(4 | 5) => "error",
                    _ => "info",
                };
                let who = words(&value["name"]).unwrap_or_default();
                let text = words(&value["message"]).unwrap_or_default();
                // A mock vehicle logs each modify, and each status that it is told, which is the same for hours.
                let level = if who == "vehicle" && level == "info" && self.is_routine(&text) {
                    "debug"
                } else {
                    level
                };
                if who == "operator" {
                    self.asked = text.split_once(" at the console: ").map(|(who, _)| who.to_owned());
                }
                if let Some(contact) = who
                    .strip_prefix("plugin ")
                    .and_then(|plugin| sonar::contact(plugin, &text))
                {
                    tell(t, contact, true);
                }
                tell(t, Item::Line { level, who, text }, true);
            }
            "/recording" => {
                let written = value["written"] == Value::Bool(true);
                let text = words(&value["text"]).unwrap_or_default();
                tell(t, Item::Recording { written, text }, true);
            }
            "/map/plan" => layer(t, "plan", &value, tell),
            "/map/reach" => tell(t, reach(&value), true),
            "/map/inserts" => layer(t, "inserts", &value, tell),
            "/map/requests" => layer(t, "requests", &value, tell),
            "/truth" => {
                let degrees = |key: &str| value["position"][key].as_f64();
                if let (Some(lat), Some(lon)) = (degrees("latitude_deg"), degrees("longitude_deg")) {
                    let item = Item::Truth {
                        lat,
                        lon,
                        depth_m: value["depth_m"].as_f64().unwrap_or(0.0),
                        water_depth_m: value["water_depth_m"].as_f64(),
                    };
                    let keep = self.thin.takes("truth", t, SENSORS_KEPT_EVERY_S);
                    tell(t, item, keep);
                }
            }
            other => {
                if let Some(rest) = other.strip_prefix("/measures/") {
                    self.measure(t, rest, &value, tell);
                } else if let Some(name) = other.strip_prefix("/sensors/")
                    && self.thin.takes(other, t, KEPT_EVERY_S)
                {
                    let keep = self.thin.takes(&format!("{other} kept"), t, SENSORS_KEPT_EVERY_S);
                    let name = name.to_owned();
                    tell(t, Item::Sensor { name, data: value }, keep);
                }
            }
        }
    }

    /// Whether a line of the vehicle tells of a modify, or is its last other line again but for the time. Notes the line.
    fn is_routine(&mut self, line: &str) -> bool {
        let words = line.split_once(" s: ").map_or(line, |(_, words)| words);
        if words.starts_with("client ") && words.contains(" modifies the behavior") {
            return true;
        }
        let before = self.said == words;
        if !before {
            words.clone_into(&mut self.said);
        }
        before
    }

    fn measure(&mut self, t: f64, topic: &str, value: &Value, tell: &mut impl FnMut(f64, Item, bool)) {
        let Some((plugin, name)) = topic.split_once('/') else {
            return;
        };
        let Some(number) = value["value"].as_f64() else { return };
        if self.thin.takes(topic, t, KEPT_EVERY_S) {
            let item = Item::Measure {
                plugin: plugin.to_owned(),
                name: name.to_owned(),
                value: number,
                unit: words(&value["unit"]).unwrap_or_default(),
            };
            tell(t, item, true);
        }
    }

    fn navigation(&mut self, t: f64, data: &[u8], tell: &mut impl FnMut(f64, Item, bool)) {
        #[derive(Deserialize)]
        struct Row {
            time_s: f64,
            latitude_deg: f64,
            longitude_deg: f64,
            depth_m: f64,
            altitude_m: Option<f64>,
            heading_deg: f64,
            roll_deg: f64,
            pitch_deg: f64,
            east_mps: f64,
            north_mps: f64,
            yaw_rate_dps: f64,
            gps: bool,
        }
        let Ok(row) = serde_json::from_slice::<Row>(data) else {
            return;
        };
        self.link.navigated(row.time_s);
        self.sonar
            .navigated(t, [row.latitude_deg, row.longitude_deg, row.heading_deg]);
        let round = |value: f64, digits: usize| {
            let scale = [1.0, 10.0, 100.0, 1e3, 1e4, 1e5, 1e6, 1e7][digits];
            (value * scale).round() / scale
        };
        let course = backseat_units::math::atan2(row.east_mps, row.north_mps).to_degrees();
        let item = Item::Navigation {
            lat: round(row.latitude_deg, 7),
            lon: round(row.longitude_deg, 7),
            depth_m: round(row.depth_m, 2),
            altitude_m: row.altitude_m.map(|altitude| round(altitude, 2)),
            heading_deg: round(row.heading_deg, 2),
            roll_deg: round(row.roll_deg, 1),
            pitch_deg: round(row.pitch_deg, 1),
            speed_mps: round((row.east_mps * row.east_mps + row.north_mps * row.north_mps).sqrt(), 3),
            course_deg: round(course.rem_euclid(360.0), 1),
            yaw_rate_dps: round(row.yaw_rate_dps, 2),
            gps: row.gps,
        };
        let keep = self.thin.takes("navigation", t, KEPT_EVERY_S);
        tell(t, item, keep);
    }

    fn input(&mut self, t: f64, data: &[u8], tell: &mut impl FnMut(f64, Item, bool)) {
        #[derive(Deserialize)]
        struct Returned {
            fuel: Option<u64>,
        }
        #[derive(Deserialize)]
        struct Input {
            plugin: Option<usize>,
            returned: Option<Returned>,
        }
        #[derive(Deserialize)]
        struct Start {
            held: bool,
        }
        #[derive(Deserialize)]
        struct Started {
            start: Start,
        }
        let Ok(input) = serde_json::from_slice::<Input>(data) else {
            return;
        };
        let (Some(plugin), Some(returned)) = (input.plugin, input.returned) else {
            if data.starts_with(br#"{"input":"link-down""#) {
                self.link.went_down();
            }
            if let Ok(Started { start }) = serde_json::from_slice(data)
                && start.held
            {
                let (act, who) = ("hold".to_owned(), None);
                tell(t, Item::Operator { act, who }, true);
            }
            return;
        };
        let Some(member) = self.plugins.get_mut(plugin) else {
            return;
        };
        member.steps += 1;
        if member.steps == 1 {
            let item = Item::Plugin {
                plugin: member.name.clone(),
                state: "running",
                text: None,
                failures: member.failures,
            };
            tell(t, item, true);
        }
        member.fuel = member.fuel.max(returned.fuel.unwrap_or(0));
        if self.thin.takes(&format!("headroom {plugin}"), t, HEADROOM_EVERY_S) {
            let share = |limit: u64| (1e5 * member.fuel as f64 / limit.max(1) as f64).round() / 1e5;
            let item = Item::Headroom {
                plugin: member.name.clone(),
                fuel: member.fuel_limit.map(share),
                steps: member.steps,
            };
            tell(t, item, true);
        }
    }

    fn note(&mut self, t: f64, value: &Value, tell: &mut impl FnMut(f64, Item, bool)) {
        let note = value["note"].as_str().unwrap_or_default();
        let text = || words(&value["text"]).unwrap_or_default();
        let item = match note {
            "mission" => Item::Mission {
                status: words(&value["status"]).unwrap_or_default(),
            },
            "behavior" => Item::Behavior {
                began: value["began"] == true,
                number: value["number"].as_u64(),
                behavior: words(&value["kind"]).unwrap_or_default(),
            },
            "lease-ended" => {
                let reason = words(&value["reason_by"]).or_else(|| words(&value["reason"]));
                let Some(item) = self.link.ended(reason.map(|reason| reason.replace('-', " "))) else {
                    return;
                };
                item
            }
            "plugin-failed" | "plugin-restarted" | "plugin-swapped" => {
                let plugin = value["plugin"].as_u64().and_then(|plugin| usize::try_from(plugin).ok());
                let Some(member) = plugin.and_then(|plugin| self.plugins.get_mut(plugin)) else {
                    return;
                };
                let failed = note == "plugin-failed";
                member.failures += u64::from(failed);
                let quarantined = value["then"].as_str().is_some_and(|then| then.contains("quarantine"));
                Item::Plugin {
                    plugin: member.name.clone(),
                    state: match (failed, quarantined) {
                        (true, true) => "quarantined",
                        (true, false) => "failed",
                        (false, _) => "running",
                    },
                    text: failed.then(|| words(&value["fault"]["text"]).unwrap_or_else(text)),
                    failures: member.failures,
                }
            }
            "operator" => Item::Operator {
                act: words(&value["act"]).unwrap_or_default(),
                who: self.asked.take(),
            },
            "navigation" => {
                let text = text();
                Item::Integrity {
                    ok: text.contains("good"),
                    text,
                }
            }
            "sonar" => Item::Sonar { text: text() },
            _ => return,
        };
        tell(t, item, true);
    }
}

fn layer(t: f64, layer: &'static str, value: &Value, tell: &mut impl FnMut(f64, Item, bool)) {
    let geojson = value["geojson"]
        .as_str()
        .and_then(|text| serde_json::from_str(text).ok());
    if let Some(geojson) = geojson {
        tell(t, Item::Map { layer, geojson }, true);
    }
}

fn reach(value: &Value) -> Item {
    let geojson = value["geojson"].as_str();
    let geojson: Value = geojson
        .and_then(|text| serde_json::from_str(text).ok())
        .unwrap_or_default();
    let reach = &geojson["features"][0]["properties"];
    let figure = |value: &Value| value.as_f64().filter(|value| value.is_finite()).unwrap_or(0.0);
    let degrees = |name: &str, axis: usize| figure(&reach[name][axis]);
    Item::Reach {
        lat: degrees("here", 1),
        lon: degrees("here", 0),
        ahead_lat: degrees("ahead", 1),
        ahead_lon: degrees("ahead", 0),
        radius_m: figure(&reach["radius_m"]),
    }
}

fn text(data: &[u8]) -> Option<Cow<'_, str>> {
    serde_json::from_slice::<Bytes<'_>>(data).ok()?.text
}

/// A text of somebody else, cut to a length.
fn words(value: &Value) -> Option<String> {
    let text = value.as_str()?;
    Some(match text.char_indices().nth(TEXT_MAX) {
        Some((end, _)) => format!("{}...", &text[..end]),
        None => text.to_owned(),
    })
}

/// Counts by name, for [`requests`].
type ByName<T> = BTreeMap<String, T>;

#[cfg(test)]
mod tests;
