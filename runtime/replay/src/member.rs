//! A plugin in a replay: it does the steps that core asks for, when the log says what came of them.

use std::borrow::Cow;
use std::collections::VecDeque;

use backseat_core::plugin::{FaultKind, Judge, PluginFault, PluginId, Request, Returned, StepInput, Version};
use backseat_core::{Input, Restarted};
use backseat_mission::{Mission, PluginTable};
use backseat_plugin_host::{NextRestart, PANICKED, Plugin, Seat};
use backseat_plugin_loader::{Components, LoadError};
use backseat_recorder::{Message, encode_input};
use backseat_units::{EastNorth, Timestamp};

use crate::difference::{RestartDifference, Side, StepDifference, changes};
use crate::report::PluginReport;
use crate::words::{describe_input, describe_request};

/// A plugin of the run.
pub(crate) struct Member {
    pub(crate) id: PluginId,
    /// The name of its component among the compiled ones.
    pub(crate) component: String,
    pub(crate) table: PluginTable,
    /// `None` after a panic of its host in the recorded run.
    pub(crate) plugin: Option<Seat>,
    /// What core has asked for and the log has not answered yet, oldest first.
    pub(crate) orders: VecDeque<Order>,
    /// A simulation has put another plugin in its place.
    pub(crate) substituted: bool,
    /// The operator has put a version in its place that is not there. What comes after it, another version too, goes on from
    /// that version's state.
    pub(crate) lost: bool,
    pub(crate) steps_begun: u64,
    pub(crate) stops_played: u64,
    pub(crate) steps_max: usize,
    pub(crate) report: PluginReport,
}

/// What core asks of a plugin.
pub(crate) struct Order {
    /// When, in the run's time.
    pub(crate) at: Timestamp,
    /// A step, or a restart.
    pub(crate) step: Option<Box<StepInput>>,
    /// The plugin that was stepped then is not in the log.
    pub(crate) unplayed: bool,
}

/// What came of a step.
pub(crate) enum Stepped {
    /// The same as recorded, or not compared.
    Same,
    /// Something else.
    Apart(Box<Apart>),
    /// The log has an answer that nobody asked for.
    Unasked,
}

/// A step that differs.
pub(crate) struct Apart {
    pub(crate) difference: StepDifference,
    pub(crate) from: Option<EastNorth>,
    pub(crate) recorded: Vec<Request>,
    pub(crate) now: Vec<Request>,
}

impl Member {
    /// A new process begins.
    pub(crate) fn begin(&mut self, components: &Components, mission: &Mission) -> Result<(), LoadError> {
        self.orders.clear();
        (self.substituted, self.lost) = (false, false);
        self.plugin = Some(Seat::new(components.start_one(
            &self.component,
            &self.table,
            mission,
        )?));
        Ok(())
    }

    /// Has a version take the plugin's place at the next restart, as the operator did.
    pub(crate) fn offer(&mut self, ready: Plugin, version: Version) {
        if let Some(plugin) = &mut self.plugin {
            plugin.offer(ready, version);
        }
    }

    /// Does the step that the log answers here, and compares.
    pub(crate) fn returned(
        &mut self,
        recorded: &Returned,
        message: &Message,
        mission: &Mission,
    ) -> Result<Stepped, serde_json::Error> {
        let Some(Order {
            at,
            step: Some(input),
            unplayed,
        }) = self.orders.pop_front()
        else {
            return Ok(Stepped::Unasked);
        };
        self.steps_begun += 1;
        if unplayed {
            self.report.unplayed += 1;
            return Ok(Stepped::Same);
        }
        self.report.steps += 1;
        let Some(now) = self.step(&input, recorded) else {
            return Ok(Stepped::Same);
        };
        let requests = |returned: &Returned| returned.result.as_ref().map_or(0, |requests| requests.len() as u64);
        self.report.requests_recorded += requests(recorded);
        self.report.requests_now += requests(&now);
        let (then_bytes, now_bytes) = if self.report.component.other {
            (Cow::Owned(self.essence(recorded)?), self.essence(&now)?)
        } else {
            (Cow::Borrowed(&message.data), self.encoded(now.clone())?)
        };
        if *then_bytes == now_bytes {
            return Ok(Stepped::Same);
        }
        self.report.different += 1;
        let difference = StepDifference {
            at_s: at.as_secs_f64(),
            message: message.sequence,
            plugin: self.report.name.clone(),
            step: self.steps_begun,
            differs: self.differs(recorded, &now),
            input: describe_input(&input),
            recorded: side(recorded),
            replayed: side(&now),
            changes: changes(&then_bytes, &now_bytes),
            judgement: Vec::new(),
            monitor: monitor(recorded, &now, &input, mission),
        };
        Ok(Stepped::Apart(Box::new(Apart {
            difference,
            from: input.navigation.as_ref().map(|navigation| navigation.local),
            recorded: recorded.result.clone().unwrap_or_default(),
            now: now.result.unwrap_or_default(),
        })))
    }

    /// Keeps a step that differs for the report, if there is room.
    pub(crate) fn keep(&mut self, difference: &StepDifference) {
        if self.report.different_steps.len() < self.steps_max {
            self.report.different_steps.push(difference.clone());
        }
    }

    /// Restarts the plugin where the log says that it was restarted, and compares.
    pub(crate) fn restarted(
        &mut self,
        recorded: &Restarted,
        message: &Message,
    ) -> Result<Option<RestartDifference>, serde_json::Error> {
        let order = self.orders.pop_front();
        if order.as_ref().is_some_and(|order| order.unplayed) {
            self.report.unplayed += 1;
            return Ok(None);
        }
        let takes_over = match self.plugin.as_ref().map(Seat::next_restart) {
            Some(NextRestart::TakesOver) => true,
            Some(NextRestart::BringsBack) => {
                self.report.swaps_failed += 1;
                false
            }
            Some(NextRestart::Begins) | None => {
                self.report.restarts += 1;
                false
            }
        };
        self.report.swaps_failed += u64::from(takes_over && recorded.result.is_err());
        if order.is_none_or(|order| order.step.is_some()) {
            self.report.different += 1;
            return Ok(Some(self.restart_difference(message, "no restart".to_owned(), b"{}")));
        }
        let Some(now) = self.restart(recorded) else {
            return Ok(None);
        };
        if self.report.component.other {
            self.report.failures += u64::from(now.result.is_err());
            return Ok(None);
        }
        let described = match &now.result {
            Ok(()) => format!("restarted, {} steps lost, {} fuel", now.lost_steps, now.fuel),
            Err(fault) => format!("failed: {}", fault.text),
        };
        let now = encode_input(&Input::Restarted(self.id, now))?.data;
        if now == message.data {
            return Ok(None);
        }
        self.report.different += 1;
        Ok(Some(self.restart_difference(message, described, &now)))
    }

    fn restart_difference(&self, message: &Message, replayed: String, now: &[u8]) -> RestartDifference {
        RestartDifference {
            at_s: message.now.as_secs_f64(),
            message: message.sequence,
            plugin: self.report.name.clone(),
            recorded: String::from_utf8_lossy(&message.data).into_owned(),
            replayed,
            changes: changes(&message.data, now),
        }
    }

    /// What the step returns now; `None` if its host panicked in the recorded run.
    fn step(&mut self, input: &StepInput, recorded: &Returned) -> Option<Returned> {
        let other = self.report.component.other;
        if !other && panicked(recorded.result.as_ref().err()) {
            self.plugin = None;
        }
        let Some(plugin) = &mut self.plugin else {
            self.stops_played += 1;
            return None;
        };
        if other {
            // Core would have restarted it later. It has failed in a run that never was, so it goes on at once.
            if !plugin.plugin().is_running() {
                plugin.restart();
            }
            let now = plugin.step(input);
            self.report.failures += u64::from(now.result.is_err());
            return Some(now);
        }
        let ended = recorded.result.as_ref().err().map(|fault| fault.kind);
        self.stops_played += u64::from(ended == Some(FaultKind::Deadline));
        let now = plugin.step_again(input, recorded);
        self.report.failures += u64::from(now.result.is_err());
        Some(now)
    }

    fn restart(&mut self, recorded: &Restarted) -> Option<Restarted> {
        let other = self.report.component.other;
        if !other && panicked(recorded.result.as_ref().err()) {
            self.plugin = None;
        }
        let Some(plugin) = &mut self.plugin else {
            self.stops_played += 1;
            return None;
        };
        let now = if other {
            plugin.restart()
        } else {
            plugin.restart_again(recorded)
        };
        Some(now)
    }

    fn encoded(&self, returned: Returned) -> Result<Vec<u8>, serde_json::Error> {
        Ok(encode_input(&Input::Returned(self.id, returned))?.data)
    }

    /// What counts of another plugin: what it asks for, and how it fails.
    fn essence(&self, returned: &Returned) -> Result<Vec<u8>, serde_json::Error> {
        self.encoded(Returned {
            fuel: 0,
            log: Vec::new(),
            measures: Vec::new(),
            result: returned.result.clone(),
        })
    }

    fn differs(&self, recorded: &Returned, now: &Returned) -> Vec<&'static str> {
        let mut differs = Vec::new();
        // Compared as text, because a request may have a figure that equals nothing.
        let asked = |returned: &Returned| format!("{:?}", returned.result.as_ref().ok());
        let failed = |returned: &Returned| returned.result.as_ref().err().cloned();
        if asked(recorded) != asked(now) {
            differs.push("requests");
        }
        if failed(recorded) != failed(now) {
            differs.push("fault");
        }
        if !self.report.component.other {
            if recorded.fuel != now.fuel {
                differs.push("fuel");
            }
            if recorded.log != now.log {
                differs.push("log");
            }
            if recorded.measures != now.measures {
                differs.push("measures");
            }
        }
        differs
    }
}

/// Whether the host of the recorded run panicked, which lost the plugin for good.
fn panicked(fault: Option<&PluginFault>) -> bool {
    fault.is_some_and(|fault| fault.kind == FaultKind::Start && fault.text == PANICKED)
}

fn side(returned: &Returned) -> Side {
    let (requests, fault) = match &returned.result {
        Ok(requests) => (requests.iter().map(describe_request).collect(), None),
        Err(fault) => (Vec::new(), Some(format!("{:?}: {}", fault.kind, fault.text))),
    };
    Side {
        requests,
        fault,
        fuel: returned.fuel,
        log: returned.log.iter().map(|line| line.text.clone()).collect(),
    }
}

/// What the safety monitor says of the requests that are not among the recorded ones.
fn monitor(recorded: &Returned, now: &Returned, input: &StepInput, mission: &Mission) -> Vec<String> {
    let recorded = recorded.result.as_deref().unwrap_or_default();
    let now = now.result.as_deref().unwrap_or_default();
    let new = now.iter().filter(|request| !recorded.contains(request));
    let judged = new.filter_map(|request| match mission.envelope.judge(request, input) {
        // It has no geometry.
        Ok(f64::MAX) => None,
        Ok(clearance_m) => Some(format!(
            "{}: allowed, {clearance_m:.1} m clearance",
            describe_request(request)
        )),
        Err(refusal) => Some(format!("{}: refused, {refusal}", describe_request(request))),
    });
    judged.collect()
}
