//! The channels that are derived from what the recorder is given, for viewers of logs.
//!
//! Each channel is a type of its own with private state and the same small hooks: `heard` and `sent` take sentences of
//! the link, `noted` a note of core, `navigated` navigation, `came_round` writes what waits for its second. What a vehicle
//! or a plugin says is not trusted here: a sentence that cannot be read makes no message, nothing returns an error, and
//! everything that is kept has a bound.

mod fence;
mod geometry;
mod inserts;
mod journal;
mod link;
mod plan;
mod position;
mod requests;
mod sensors;
mod topic;

use backseat_core::plugin::NavigationSample;
use backseat_core::{Input, LeaseReach, Note, Output};
use backseat_units::{LocalFrame, Timestamp};
use serde_json::json;

use crate::header::Header;

use self::fence::FenceMap;
use self::geometry::{Shape, write_features};
use self::inserts::Inserts;
use self::journal::Journal;
use self::link::Link;
use self::plan::Plan;
use self::position::Fixes;
use self::requests::Requests;
use self::sensors::Sensors;

pub(crate) use topic::Topic;

/// The time of a record.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moment {
    /// Since the start of the run.
    pub(crate) now: Timestamp,
    /// UTC, nanoseconds since 1970.
    pub(crate) utc_ns: u64,
}

/// Messages that wait to be written.
#[derive(Debug, Default)]
pub(crate) struct Batch {
    bytes: Vec<u8>,
    /// The topic of each message, and where it ends.
    ends: Vec<(Topic, usize)>,
}

impl Batch {
    pub(crate) fn add(&mut self, topic: Topic, write: impl FnOnce(&mut Vec<u8>)) {
        write(&mut self.bytes);
        self.ends.push((topic, self.bytes.len()));
    }

    pub(crate) const fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    pub(crate) fn messages(&self) -> impl Iterator<Item = (Topic, &[u8])> {
        let mut begin = 0;
        self.ends.iter().map(move |(topic, end)| {
            let message = &self.bytes[begin..*end];
            begin = *end;
            (*topic, message)
        })
    }

    pub(crate) fn clear(&mut self) {
        self.bytes.clear();
        self.ends.clear();
    }
}

/// All derived channels.
pub(crate) struct View {
    utc_at_start_ns: u64,
    /// The plugins' names in priority order.
    names: Vec<String>,
    link: Link,
    fence: FenceMap,
    journal: Journal,
    fixes: Fixes,
    plan: Plan,
    inserts: Inserts,
    requests: Requests,
    sensors: Sensors,
}

impl View {
    pub(crate) fn new(header: &Header<'_>) -> Self {
        Self {
            utc_at_start_ns: header.utc_at_start.as_unix_nanos(),
            names: header.components.iter().map(|(name, _)| name.clone()).collect(),
            link: Link::new(),
            fence: FenceMap::new(header.fence),
            journal: Journal::default(),
            fixes: Fixes::new(),
            plan: Plan::default(),
            inserts: Inserts::default(),
            requests: Requests::default(),
            sensors: Sensors::new(header.rate.period()),
        }
    }

    /// Core was started.
    pub(crate) fn started(&mut self, batch: &mut Batch) {
        self.fence.started(batch);
    }

    /// Core was given an input.
    pub(crate) fn input(&mut self, moment: Moment, input: &Input<'_>, batch: &mut Batch) {
        match input {
            Input::Received(bytes) => {
                let (plan, sensors) = (&mut self.plan, &mut self.sensors);
                self.link
                    .receive(bytes, |line| plan.wants(line) || sensors.wants(moment, line));
                self.link.heard(|line, message| {
                    plan.heard(message);
                    sensors.heard(moment, line, message, batch);
                });
            }
            Input::LinkUp => {
                self.link.begin();
                self.plan.link_began();
            }
            Input::Returned(plugin, returned) => self.requests.returned(moment, *plugin, returned),
            Input::LinkDown
            | Input::Restarted(..)
            | Input::Swap(..)
            | Input::Operator(_)
            | Input::External(..)
            | Input::Sonar(_)
            | Input::Reserved(_)
            | Input::UtcSet(_)
            | Input::Timeout => {}
        }
        self.come_round(moment, batch);
    }

    /// Core gave an output.
    pub(crate) fn output(&mut self, moment: Moment, output: &Output, batch: &mut Batch) {
        if let Output::Send(bytes) = output {
            self.link
                .send(bytes, |line| Plan::wants_sent(line) || Inserts::wants_sent(line));
            self.link.sent(|message| {
                self.plan.sent(message);
                self.inserts.sent(message);
            });
        } else if let Output::Note(note) = output {
            self.journal.noted(moment, note, &self.names, batch);
            if let Note::Request(transition) = note {
                self.requests.noted(transition);
                self.inserts.noted(transition);
            } else if let Note::Plan { .. } = note {
                self.plan.complete(batch);
            }
        }
        self.come_round(moment, batch);
    }

    /// Where the live modify can lead has changed; `None` if nothing steers any more.
    pub(crate) fn reach(&self, frame: &LocalFrame, reach: Option<&LeaseReach>, batch: &mut Batch) {
        let feature = reach.and_then(|reach| {
            let LeaseReach { here, ahead, radius_m } = *reach;
            let shape = Shape::capsule(frame, here, ahead, radius_m)?;
            let place = |local| {
                let position = frame.to_position(local);
                json!([position.longitude.as_deg(), position.latitude.as_deg()])
            };
            let properties = json!({"kind": "reach", "here": place(here), "ahead": place(ahead), "radius_m": radius_m});
            Some(shape.feature("#17becf", properties))
        });
        write_features(Topic::Reach, feature.into_iter().collect(), batch);
    }

    /// Navigation was recorded.
    pub(crate) fn navigation(&mut self, moment: Moment, sample: &NavigationSample, batch: &mut Batch) {
        let solution_ns = self.utc_at_start_ns.saturating_add(sample.solution.as_nanos());
        self.fixes.navigated(moment, solution_ns, sample, batch);
        self.come_round(moment, batch);
    }

    /// The simulated vehicle logged a line.
    pub(crate) fn vehicle_event(&mut self, moment: Moment, text: &str, batch: &mut Batch) {
        self.journal.vehicle_said(moment, text, batch);
    }

    /// Somebody at a console asked for something.
    pub(crate) fn asked(&mut self, moment: Moment, text: &str, batch: &mut Batch) {
        self.journal.operator_asked(moment, text, batch);
    }

    /// The log ends.
    pub(crate) fn finish(&mut self, batch: &mut Batch) {
        self.inserts.finish(&self.names, batch);
        self.requests.finish(&self.names, batch);
    }

    fn come_round(&mut self, moment: Moment, batch: &mut Batch) {
        self.inserts.came_round(moment, &self.names, batch);
        self.requests.came_round(moment, &self.names, batch);
    }
}

/// The name of a plugin, or its number if the log does not have its name.
fn plugin_name(plugin: usize, names: &[String]) -> String {
    names.get(plugin).cloned().unwrap_or_else(|| plugin.to_string())
}
