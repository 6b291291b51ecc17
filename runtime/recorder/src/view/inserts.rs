use std::collections::VecDeque;
use std::time::Duration;

use backseat_core::{Owner, RequestKind, Transition};
use backseat_spi::ToVehicle;
use backseat_units::Timestamp;
use serde_json::{Value, json};

use super::geometry::{Shape, colour, write_features};
use super::link::name;
use super::{Batch, Moment, Topic, plugin_name};
use crate::message::described;

/// How many inserts are kept. Those that are over go first, then the oldest.
const INSERTS_MAX: usize = 64;
/// The least time between two messages, because each has all inserts.
const PERIOD: Duration = Duration::from_secs(1);

/// `/map/inserts`: the inserts as they were sent, with their states, when one of them has changed.
#[derive(Default)]
pub(super) struct Inserts {
    inserts: VecDeque<Insert>,
    changed: bool,
    next: Timestamp,
}

struct Insert {
    identifier: u32,
    /// `None` until it is sent.
    shape: Option<(&'static str, Shape)>,
    /// `None` until core has told of the request.
    request: Option<Request>,
}

struct Request {
    owner: Owner,
    tag: u64,
    state: &'static str,
    is_over: bool,
}

/// Whether a request asks for an insert.
pub(super) const fn is_insert(kind: RequestKind) -> bool {
    matches!(
        kind,
        RequestKind::Trackline | RequestKind::Trackcircle | RequestKind::GpsHit
    )
}

impl Inserts {
    pub(super) fn wants_sent(line: &[u8]) -> bool {
        matches!(name(line), b"BPRTK" | b"BPRTC" | b"BPRGP")
    }

    pub(super) fn sent(&mut self, message: &ToVehicle) {
        let (identifier, kind, shape) = if let ToVehicle::Trackline(line) = message {
            let shape = Shape::Line(vec![line.start, line.end]);
            (line.identifier, "trackline", Some(shape))
        } else if let ToVehicle::Trackcircle(circle) = message {
            let shape = Shape::circle(circle.centre, circle.radius_m);
            (circle.identifier, "trackcircle", shape)
        } else if let ToVehicle::GpsHit(hit) = message {
            (hit.identifier, "gps-hit", Some(Shape::Point(hit.position)))
        } else {
            return;
        };
        let Some(shape) = shape else { return };
        self.of(identifier.get()).shape = Some((kind, shape));
        self.changed = true;
    }

    pub(super) fn noted(&mut self, transition: &Transition) {
        let Some(identifier) = transition.identifier.filter(|_| is_insert(transition.kind)) else {
            return;
        };
        let (state, _) = described(&transition.state);
        self.of(identifier).request = Some(Request {
            owner: transition.owner,
            tag: transition.tag,
            state,
            is_over: is_over(state),
        });
        self.changed = true;
    }

    pub(super) fn came_round(&mut self, moment: Moment, names: &[String], batch: &mut Batch) {
        if self.changed && moment.now >= self.next {
            self.next = moment.now + PERIOD;
            self.finish(names, batch);
        }
    }

    pub(super) fn finish(&mut self, names: &[String], batch: &mut Batch) {
        if !std::mem::take(&mut self.changed) {
            return;
        }
        let features: Vec<Value> = self.inserts.iter().filter_map(|insert| insert.feature(names)).collect();
        if !features.is_empty() {
            write_features(Topic::Inserts, features, batch);
        }
    }

    /// The insert of this identifier, which is added if it is new.
    fn of(&mut self, identifier: u32) -> &mut Insert {
        let place = self.inserts.iter().position(|insert| insert.identifier == identifier);
        let place = place.unwrap_or_else(|| {
            if self.inserts.len() == INSERTS_MAX {
                let over = self.inserts.iter().position(Insert::is_over);
                self.inserts.remove(over.unwrap_or(0));
            }
            self.inserts.push_back(Insert {
                identifier,
                shape: None,
                request: None,
            });
            self.inserts.len() - 1
        });
        &mut self.inserts[place]
    }
}

/// Whether nothing more comes of a request in this state.
pub(super) fn is_over(state: &str) -> bool {
    matches!(state, "rejected" | "failed" | "timed-out" | "ended" | "cancelled")
}

impl Insert {
    fn is_over(&self) -> bool {
        self.request.as_ref().is_some_and(|request| request.is_over)
    }

    fn feature(&self, names: &[String]) -> Option<Value> {
        let (kind, shape) = self.shape.as_ref()?;
        let state = self.request.as_ref().map_or("sent", |request| request.state);
        let mut properties = json!({"identifier": self.identifier, "kind": kind, "state": state});
        if let Some(request) = &self.request {
            properties["tag"] = request.tag.into();
            if let Owner::Plugin(plugin) = request.owner {
                properties["plugin"] = plugin_name(plugin.0, names).into();
            }
        }
        Some(shape.feature(colour(state), properties))
    }
}
