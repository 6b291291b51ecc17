use backseat_core::plugin::{EndKind, LogLevel, RequestState};
use backseat_core::{Note, Owner, RequestKind, Transition};
use serde::Serialize;

use super::position::Time;
use super::{Batch, Moment, Topic, plugin_name};

/// Levels of `foxglove.Log`.
const DEBUG: u8 = 1;
const INFO: u8 = 2;
const WARNING: u8 = 3;
const ERROR: u8 = 4;

#[derive(Serialize)]
struct Line<'a> {
    timestamp: Time,
    level: u8,
    message: &'a str,
    name: &'a str,
    file: &'static str,
    line: u32,
}

/// `/log`: what plugins logged, notes, new states of requests, and the lines of the simulated vehicle.
#[derive(Default)]
pub(super) struct Journal {
    /// Kept to reuse its allocation.
    text: String,
}

impl Journal {
    pub(super) fn noted(&mut self, moment: Moment, note: &Note, names: &[String], batch: &mut Batch) {
        use std::fmt::Write as _;
        if is_routine(note) {
            return;
        }
        let mut text = std::mem::take(&mut self.text);
        text.clear();
        if let Note::PluginLog { line, .. } = note {
            text.push_str(&line.text);
        } else {
            write!(text, "{}", note.describe(names)).expect("a String takes everything");
        }
        let plugin = speaker(note).map(|plugin| format!("plugin {}", plugin_name(plugin, names)));
        let name = plugin.as_deref().unwrap_or("runtime");
        write_line(moment, level(note), name, &text, batch);
        self.text = text;
    }

    pub(super) fn vehicle_said(&self, moment: Moment, text: &str, batch: &mut Batch) {
        write_line(moment, INFO, "vehicle", text, batch);
    }

    pub(super) fn operator_asked(&self, moment: Moment, text: &str, batch: &mut Batch) {
        write_line(moment, INFO, "operator", text, batch);
    }
}

fn write_line(moment: Moment, level: u8, name: &str, message: &str, batch: &mut Batch) {
    let line = Line {
        timestamp: Time::from_nanos(moment.utc_ns),
        level,
        message,
        name,
        file: "",
        line: 0,
    };
    batch.add(Topic::Log, |out| {
        serde_json::to_writer(out, &line).expect("a Vec takes every string");
    });
}

/// The plugin that a note is about.
fn speaker(note: &Note) -> Option<usize> {
    let plugin = match note {
        Note::PluginLog { plugin, .. }
        | Note::PluginFailed { plugin, .. }
        | Note::PluginRestarted { plugin }
        | Note::PluginSwap { plugin, .. }
        | Note::PluginSwapped { plugin }
        | Note::PluginNotSwapped { plugin, .. }
        | Note::PluginMeasure { plugin, .. }
        | Note::LeaseEnded { plugin, .. } => *plugin,
        Note::Request(Transition {
            owner: Owner::Plugin(plugin),
            ..
        }) => *plugin,
        Note::Request(_)
        | Note::LinkUp
        | Note::LinkDown { .. }
        | Note::VehicleVersion { .. }
        | Note::Clock { .. }
        | Note::Mission { .. }
        | Note::Control { .. }
        | Note::Plan { .. }
        | Note::Behavior { .. }
        | Note::Navigation { .. }
        | Note::Malformed { .. }
        | Note::Operator { .. }
        | Note::Recovery { .. }
        | Note::Sonar { .. }
        | Note::Late { .. }
        | Note::Text { .. } => return None,
    };
    Some(plugin.0)
}

fn level(note: &Note) -> u8 {
    match note {
        Note::PluginLog { line, .. } => match line.level {
            LogLevel::Debug => DEBUG,
            LogLevel::Info => INFO,
            LogLevel::Warn => WARNING,
            LogLevel::Error => ERROR,
        },
        Note::PluginFailed { .. } => ERROR,
        Note::LinkDown { .. }
        | Note::Recovery { .. }
        | Note::Late { .. }
        | Note::Malformed { .. }
        | Note::PluginNotSwapped { .. } => WARNING,
        Note::Request(transition) => request_level(transition),
        Note::LinkUp
        | Note::VehicleVersion { .. }
        | Note::Clock { .. }
        | Note::Mission { .. }
        | Note::Control { .. }
        | Note::LeaseEnded { .. }
        | Note::Plan { .. }
        | Note::Behavior { .. }
        | Note::Navigation { .. }
        | Note::PluginRestarted { .. }
        | Note::PluginSwap { .. }
        | Note::PluginSwapped { .. }
        | Note::PluginMeasure { .. }
        | Note::Operator { .. }
        | Note::Sonar { .. }
        | Note::Text { .. } => INFO,
    }
}

fn request_level(transition: &Transition) -> u8 {
    match &transition.state {
        RequestState::Rejected(_) | RequestState::Failed(_) | RequestState::TimedOut | RequestState::Unknown => WARNING,
        RequestState::Sent | RequestState::Pending => DEBUG,
        RequestState::Accepted | RequestState::Started | RequestState::Ended(_) | RequestState::Cancelled => INFO,
    }
}

/// Whether a note says that a modify took the place of another one, as it does twice a second. These would be most of
/// the lines; `/requests` has them.
fn is_routine(note: &Note) -> bool {
    // Measures have channels of their own.
    if let Note::PluginMeasure { .. } = note {
        return true;
    }
    let Note::Request(transition) = note else { return false };
    transition.kind == RequestKind::Modify
        && match &transition.state {
            RequestState::Sent | RequestState::Pending | RequestState::Accepted => true,
            RequestState::Ended(ended) => ended.kind() == EndKind::Replaced,
            RequestState::Rejected(_)
            | RequestState::Failed(_)
            | RequestState::TimedOut
            | RequestState::Unknown
            | RequestState::Started
            | RequestState::Cancelled => false,
        }
}
