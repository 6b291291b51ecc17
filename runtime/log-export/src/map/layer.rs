use std::collections::{BTreeMap, BTreeSet};

use geojson::{Feature, JsonObject};
use serde_json::Value;

use super::{REQUEST_LAYER, features};
use crate::contents::Message;
use crate::time::rfc3339;

/// Layers whose features have a state that changes. A message has those that have changed, each with what tells it from
/// the others. In every other layer a message has the whole layer.
const CHANGING: [&str; 2] = ["inserts", REQUEST_LAYER];

/// Properties that tell an insert or a request from the others.
const NUMBERS: [&str; 2] = ["request", "identifier"];

/// A layer of a map: its features, with the time from which each stood, and the time until which.
#[derive(Debug)]
pub(crate) struct Layer {
    pub(crate) name: String,
    pub(crate) features: Vec<Standing>,
}

/// A feature, and when it stood.
#[derive(Clone, Debug)]
pub(crate) struct Standing {
    pub(crate) feature: Feature,
    pub(crate) from: Moment,
    /// `None` for what stood at the end.
    pub(crate) until: Option<Moment>,
    /// When it had its last state, if that was not when it came.
    pub(crate) changed: Option<Moment>,
}

/// A time in both forms: nanoseconds since 1970, and seconds of the run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Moment {
    pub(crate) log_time: u64,
    pub(crate) t_s: f64,
}

impl Layer {
    pub(super) fn new(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            features: Vec::new(),
        }
    }

    pub(super) fn take(&mut self, message: &Message<'_>) {
        if let Some(text) = message.value.get("geojson").and_then(Value::as_str) {
            self.set(text, message.log_time, message.t_s);
        }
    }

    pub(super) fn set(&mut self, text: &str, log_time: u64, t_s: f64) {
        let (new, now) = (features(text), Moment { log_time, t_s });
        if CHANGING.contains(&self.name.as_str()) {
            self.change(new, now);
        } else {
            self.replace(new, now);
        }
    }

    /// A feature that is in both states stays, without a new time.
    fn replace(&mut self, mut new: Vec<Feature>, now: Moment) {
        for old in self.features.iter_mut().filter(|old| old.until.is_none()) {
            match new.iter().position(|feature| *feature == old.feature) {
                Some(place) => drop(new.remove(place)),
                None => old.until = Some(now),
            }
        }
        let new = new.into_iter().map(|feature| Standing::new(feature, now));
        self.features.extend(new);
    }

    /// A message may also have features that have not changed. What has a number is looked for first, so that one without
    /// a number is not taken for a like one that has its number already.
    fn change(&mut self, mut new: Vec<Feature>, now: Moment) {
        new.sort_by_key(|feature| NUMBERS.iter().all(|name| number(feature, name).is_none()));
        let mut matched = BTreeSet::new();
        for feature in new {
            let place = [has_same_number, looks_same].iter().find_map(|is_same| {
                let mut olds = self.features.iter().enumerate().rev();
                olds.find(|(place, old)| !matched.contains(place) && is_same(&old.feature, &feature))
                    .map(|(place, _)| place)
            });
            match place.and_then(|place| Some((place, self.features.get_mut(place)?))) {
                Some((place, old)) => {
                    matched.insert(place);
                    if old.feature != feature {
                        old.feature = feature;
                        old.changed = Some(now);
                    }
                }
                None => {
                    matched.insert(self.features.len());
                    self.features.push(Standing::new(feature, now));
                }
            }
        }
    }

    /// Adds those refused requests that the layer does not have with their own geometry.
    pub(super) fn add_refused(&mut self, refused: BTreeMap<u64, Standing>) {
        for (request, standing) in refused {
            let mut known = self.features.iter();
            if !known.any(|known| number(&known.feature, "request") == Some(request)) {
                self.features.push(standing);
            }
        }
    }
}

impl Standing {
    pub(super) fn new(feature: Feature, from: Moment) -> Self {
        Self {
            feature,
            from,
            until: None,
            changed: None,
        }
    }

    /// The feature with its times, for GeoJSON.
    pub(crate) fn stamped(&self) -> Feature {
        let mut feature = self.feature.clone();
        let properties = feature.properties.get_or_insert_with(JsonObject::new);
        let times = [("", Some(self.from)), ("until", self.until), ("changed", self.changed)];
        for (name, moment) in times {
            let Some(Moment { log_time, t_s }) = moment else {
                continue;
            };
            let (time, seconds) = if name.is_empty() {
                ("time".to_owned(), "t_s".to_owned())
            } else {
                (name.to_owned(), format!("{name}_s"))
            };
            properties.insert(time, rfc3339(log_time).into());
            properties.insert(seconds, t_s.into());
        }
        feature
    }
}

fn number(feature: &Feature, name: &str) -> Option<u64> {
    feature.property(name).and_then(Value::as_u64)
}

/// The numbers under a name that both have.
fn both(a: &Feature, b: &Feature) -> Option<(u64, u64)> {
    let mut numbers = NUMBERS.iter().map(|name| Some((number(a, name)?, number(b, name)?)));
    numbers.find_map(|both| both)
}

fn has_same_number(a: &Feature, b: &Feature) -> bool {
    both(a, b).is_some_and(|(a, b)| a == b)
}

/// Whether two states are of the same insert or request, of which one has no number.
fn looks_same(a: &Feature, b: &Feature) -> bool {
    let told = |feature: &Feature| ["plugin", "tag"].map(|name| feature.property(name).cloned());
    both(a, b).is_none() && told(a) == told(b) && a.geometry == b.geometry
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    /// Feeds messages of requests, one a second.
    fn told(messages: &[Value]) -> Layer {
        let mut layer = Layer::new(REQUEST_LAYER);
        for (second, features) in messages.iter().enumerate() {
            let collection = json!({"type": "FeatureCollection", "features": features});
            layer.set(&collection.to_string(), second as u64, second as f64);
        }
        layer
    }

    fn request(number: Option<u64>, state: &str) -> Value {
        let mut feature = json!({
            "type": "Feature", "geometry": {"type": "Point", "coordinates": [1.0, 2.0]},
            "properties": {"plugin": "pilot", "tag": 3, "state": state, "style": {"color": "#ff0000"}}
        });
        if let Some(number) = number {
            feature["properties"]["request"] = number.into();
        }
        feature
    }

    fn states(layer: &Layer) -> Vec<(Option<u64>, String, Option<f64>)> {
        let features = layer.features.iter();
        features
            .map(|standing| {
                let state = standing.feature.property("state").and_then(Value::as_str);
                (
                    number(&standing.feature, "request"),
                    state.unwrap_or_default().to_owned(),
                    standing.changed.map(|moment| moment.t_s),
                )
            })
            .collect()
    }

    #[test]
    fn a_request_gets_its_number_later_and_a_like_one_is_another() {
        let layer = told(&[
            json!([request(None, "asked")]),
            json!([request(Some(1), "sent")]),
            json!([request(None, "asked"), request(Some(1), "sent")]),
            json!([request(Some(1), "sent"), request(Some(2), "rejected")]),
        ]);
        assert_eq!(
            states(&layer),
            [
                (Some(1), "sent".to_owned(), Some(1.0)),
                (Some(2), "rejected".to_owned(), Some(3.0))
            ]
        );
    }

    #[test]
    fn what_a_message_repeats_has_not_changed_and_what_it_leaves_out_stays() {
        let layer = told(&[
            json!([request(Some(1), "ended")]),
            json!([request(Some(1), "ended")]),
            json!([]),
        ]);
        assert_eq!(states(&layer), [(Some(1), "ended".to_owned(), None)]);
        assert!(layer.features[0].feature.property("style").is_none());
        assert_eq!(layer.features[0].until, None);
    }
}
