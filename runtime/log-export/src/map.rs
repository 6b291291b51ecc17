//! What a map of a run shows: tracks, and the features of the log's layers.

mod layer;
mod track;

use std::collections::BTreeMap;

use geojson::{Feature, GeoJson, Geometry, GeometryValue, JsonObject};
use serde_json::Value;

pub(crate) use self::layer::{Layer, Moment, Standing};
pub(crate) use self::track::{Fix, Track};
use crate::contents::{Contents, Message};
use crate::error::Error;
use crate::flatten::flatten;
use crate::source::Source;
use crate::time::rfc3339;

/// The schema of a layer: its messages have a GeoJSON text.
const GEOJSON: &str = "foxglove.GeoJSON";
/// The vehicle's position in Foxglove's schema.
const POSITION: &str = "/position";
const NAVIGATION: &str = "/navigation";
const TRUTH: &str = "/truth";
const REQUESTS: &str = "/requests";
/// Colours for the panels of Foxglove, and a nested object that a table of attributes cannot show.
const STYLE: &str = "style";
/// The layers with this end of their topic are known by name.
const FENCE: &str = "fence";
const REQUEST_LAYER: &str = "requests";

/// A map of a run.
#[derive(Debug)]
pub(crate) struct Map {
    /// Where the vehicle believed that it was.
    pub(crate) track: Track,
    /// Where it truly was, in a simulation.
    pub(crate) truth: Track,
    /// The fence first, then the others in the order of the log.
    pub(crate) layers: Vec<Layer>,
}

impl Map {
    /// Reads a map from a log. The tracks have a point each `every_s`.
    pub(crate) fn of(source: &Source, contents: &Contents, every_s: f64) -> Result<Self, Error> {
        let mut map = Self {
            track: Track::new("track", every_s, &contents.gaps),
            truth: Track::new("truth", every_s, &contents.gaps),
            layers: Vec::new(),
        };
        let layers: Vec<&str> = contents
            .channels
            .iter()
            .filter(|channel| channel.schema == GEOJSON)
            .map(|channel| channel.topic.as_str())
            .collect();
        // A channel that has no messages, or a log without these channels, has no layers.
        let mut refused = BTreeMap::new();
        let has_position = contents.has(POSITION);
        let wanted = |topic: &str| [POSITION, NAVIGATION, TRUTH, REQUESTS].contains(&topic) || layers.contains(&topic);
        contents.read(source, wanted, |message| {
            match message.topic {
                POSITION => map.track.add(&message),
                NAVIGATION if has_position => map.track.describe(&message),
                NAVIGATION => map.track.add(&message),
                TRUTH => map.truth.add(&message),
                REQUESTS => refuse(&mut refused, &message, map.track.last()),
                topic => map.layer(topic.rsplit('/').next().unwrap_or(topic)).take(&message),
            }
            Ok(())
        })?;
        if !map.layers.iter().any(|layer| layer.name == FENCE)
            && let Some(fence) = &contents.fence
        {
            map.layer(FENCE).set(fence, contents.start_ns, 0.0);
        }
        map.layers.sort_by_key(|layer| layer.name != FENCE);
        if !refused.is_empty() {
            map.layer(REQUEST_LAYER).add_refused(refused);
        }
        Ok(map)
    }

    /// What a map lacks of the log, a line each.
    pub(crate) fn remarks(&self, source: &Source) -> Vec<String> {
        if !self.track.parts.is_empty() {
            return Vec::new();
        }
        vec![format!(
            "{}: no position: the map has no track",
            source.path().display()
        )]
    }

    fn layer(&mut self, name: &str) -> &mut Layer {
        let place = self.layers.iter().position(|layer| layer.name == name);
        let place = place.unwrap_or_else(|| {
            self.layers.push(Layer::new(name));
            self.layers.len() - 1
        });
        &mut self.layers[place]
    }
}

/// A request that was refused, with where the vehicle was, unless its last state is another.
fn refuse(refused: &mut BTreeMap<u64, Standing>, message: &Message<'_>, at: Option<Fix>) {
    let Some(request) = message.value.get("request").and_then(Value::as_u64) else {
        return;
    };
    let state = message.value.get("state").and_then(Value::as_str);
    let (true, Some(at)) = (matches!(state, Some("rejected" | "failed" | "timed-out")), at) else {
        refused.remove(&request);
        return;
    };
    let mut properties = JsonObject::new();
    flatten(&message.value, &mut |path, value| {
        properties.insert(path.to_owned(), value.clone());
    });
    let now = Moment {
        log_time: message.log_time,
        t_s: message.t_s,
    };
    refused.insert(request, Standing::new(feature(point(at), properties), now));
}

fn feature(value: GeometryValue, properties: JsonObject) -> Feature {
    Feature {
        bbox: None,
        geometry: Some(Geometry::new(value)),
        id: None,
        properties: Some(properties),
        foreign_members: None,
    }
}

fn point(fix: Fix) -> GeometryValue {
    GeometryValue::Point {
        coordinates: fix.position().into(),
    }
}

/// Properties with the time of a message.
fn stamped(message: &Message<'_>) -> JsonObject {
    let mut properties = JsonObject::new();
    properties.insert("time".to_owned(), rfc3339(message.log_time).into());
    properties.insert("t_s".to_owned(), message.t_s.into());
    properties
}

/// The features of a GeoJSON text; none if it is not GeoJSON.
fn features(text: &str) -> Vec<Feature> {
    let mut features = match text.parse::<GeoJson>() {
        Ok(GeoJson::FeatureCollection(collection)) => collection.features,
        Ok(GeoJson::Feature(feature)) => vec![feature],
        Ok(GeoJson::Geometry(geometry)) => vec![feature(geometry.value, JsonObject::new())],
        Err(_) => Vec::new(),
    };
    for properties in features.iter_mut().filter_map(|feature| feature.properties.as_mut()) {
        properties.remove(STYLE);
    }
    features
}
