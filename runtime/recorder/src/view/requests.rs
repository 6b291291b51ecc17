use std::collections::VecDeque;
use std::time::Duration;

use backseat_core::plugin::{PluginId, Request, RequestState, Returned};
use backseat_core::{Owner, RequestKind, Transition};
use backseat_units::Timestamp;
use serde_json::{Value, json};

use super::geometry::{Shape, asked, colour, write_features};
use super::inserts::is_insert;
use super::{Batch, Moment, Topic, plugin_name};
use crate::message::described;

/// How many requests are kept; the oldest goes first.
const REQUESTS_MAX: usize = 32;
/// The least time between two messages, because each has all requests.
const PERIOD: Duration = Duration::from_secs(1);

/// `/map/requests`: the inserts as plugins asked for them, with their states, when one of them has changed.
#[derive(Default)]
pub(super) struct Requests {
    requests: VecDeque<Asked>,
    changed: bool,
    next: Timestamp,
}

struct Asked {
    plugin: PluginId,
    tag: u64,
    kind: RequestKind,
    shape: Shape,
    at: Timestamp,
    /// Its number in the ledger, once core has told it.
    number: Option<u64>,
    state: &'static str,
    reason: Option<String>,
}

impl Requests {
    pub(super) fn returned(&mut self, moment: Moment, plugin: PluginId, returned: &Returned) {
        let Ok(requests) = &returned.result else { return };
        for request in requests {
            if let Some((tag, kind, shape)) = insert_of(request) {
                self.take(Asked {
                    plugin,
                    tag,
                    kind,
                    shape,
                    at: moment.now,
                    number: None,
                    state: "asked",
                    reason: None,
                });
            }
        }
    }

    fn take(&mut self, mut asked: Asked) {
        // A plugin may ask for the same again and again while it is refused: that is one request on the map.
        let again = self.requests.iter().position(|earlier| {
            earlier.state == "rejected"
                && (earlier.plugin, earlier.tag, earlier.kind) == (asked.plugin, asked.tag, asked.kind)
                && earlier.shape == asked.shape
        });
        match again.and_then(|place| self.requests.remove(place)) {
            Some(earlier) => (asked.state, asked.reason) = (earlier.state, earlier.reason),
            None => self.changed = true,
        }
        if self.requests.len() == REQUESTS_MAX {
            self.requests.pop_front();
        }
        self.requests.push_back(asked);
    }

    pub(super) fn noted(&mut self, transition: &Transition) {
        let Owner::Plugin(plugin) = transition.owner else {
            return;
        };
        if !is_insert(transition.kind) {
            return;
        }
        let known = self
            .requests
            .iter()
            .position(|asked| asked.number == Some(transition.request));
        let Some(place) = known.or_else(|| self.unnumbered(plugin, transition)) else {
            return;
        };
        let asked = &mut self.requests[place];
        let (state, reason) = described(&transition.state);
        asked.number = Some(transition.request);
        if (asked.state, &asked.reason) != (state, &reason) {
            (asked.state, asked.reason) = (state, reason);
            self.changed = true;
        }
    }

    /// The place of the request that core tells of for the first time. Core tells in order. But it refuses at once, so a
    /// request that it refuses is one of the newest step.
    fn unnumbered(&self, plugin: PluginId, transition: &Transition) -> Option<usize> {
        let is_such = |asked: &Asked| {
            asked.number.is_none() && (asked.plugin, asked.tag, asked.kind) == (plugin, transition.tag, transition.kind)
        };
        let newest = self.requests.iter().rfind(|asked| is_such(asked))?.at;
        let is_refused = matches!(transition.state, RequestState::Rejected(_));
        self.requests
            .iter()
            .position(|asked| is_such(asked) && (!is_refused || asked.at == newest))
    }

    pub(super) fn came_round(&mut self, moment: Moment, names: &[String], batch: &mut Batch) {
        if self.changed && moment.now >= self.next {
            self.next = moment.now + PERIOD;
            self.finish(names, batch);
        }
    }

    pub(super) fn finish(&mut self, names: &[String], batch: &mut Batch) {
        if std::mem::take(&mut self.changed) {
            let features = self.requests.iter().map(|asked| asked.feature(names)).collect();
            write_features(Topic::Requests, features, batch);
        }
    }
}

/// Tag, kind and shape of a request for an insert; `None` if it is for something else, or cannot be drawn.
fn insert_of(request: &Request) -> Option<(u64, RequestKind, Shape)> {
    if let Request::Trackline(line) = request {
        let shape = Shape::Line(vec![asked(line.start)?, asked(line.end)?]);
        Some((line.tag, RequestKind::Trackline, shape))
    } else if let Request::Trackcircle(circle) = request {
        let shape = Shape::circle(asked(circle.centre)?, circle.radius_m)?;
        Some((circle.tag, RequestKind::Trackcircle, shape))
    } else if let Request::GpsHit(hit) = request {
        Some((hit.tag, RequestKind::GpsHit, Shape::Point(asked(hit.position)?)))
    } else {
        None
    }
}

impl Asked {
    fn feature(&self, names: &[String]) -> Value {
        let mut properties = json!({
            "plugin": plugin_name(self.plugin.0, names),
            "tag": self.tag,
            "kind": self.kind,
            "state": self.state,
        });
        if let Some(number) = self.number {
            properties["request"] = number.into();
        }
        if let Some(reason) = &self.reason {
            properties["reason"] = reason.as_str().into();
        }
        self.shape.feature(colour(self.state), properties)
    }
}
