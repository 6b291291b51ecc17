//! Where a replay and its log part.

use serde::Serialize;
use serde_json::Value;

/// How many values that differ are listed.
const CHANGES_MAX: usize = 12;
/// How much of a value is shown, characters.
const SHOWN_MAX: usize = 120;

/// A difference between a replay and its log.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "kind", rename_all = "kebab-case")]
pub enum Difference {
    /// Core did something else.
    Output(OutputDifference),
    /// A plugin's step returned something else.
    Step(StepDifference),
    /// A plugin's restart went otherwise.
    Restart(RestartDifference),
}

/// An output of core that differs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct OutputDifference {
    /// When core handled the input, seconds of the run.
    pub at_s: f64,
    /// The sequence number of the recorded output in the log; `None` if the log lacks it.
    pub message: Option<u32>,
    /// The sequence number of the input that led to it.
    pub input_message: u32,
    /// That input.
    pub input: String,
    /// The channel of the recorded output, or else of the replayed one.
    pub channel: String,
    /// As recorded; `None` if the log lacks it.
    pub recorded: Option<String>,
    /// As core produced it in the replay; `None` if it did not.
    pub replayed: Option<String>,
    /// The values that differ.
    pub changes: Vec<String>,
}

/// A step of a plugin that differs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct StepDifference {
    /// When the step was asked for, seconds of the run.
    pub at_s: f64,
    /// The sequence number of what it returned, in the log.
    pub message: u32,
    /// The plugin's name in the mission.
    pub plugin: String,
    /// Which step of the plugin, from 1.
    pub step: u64,
    /// What differs: `requests`, `fault`, `fuel`, `log`, `measures`.
    pub differs: Vec<&'static str>,
    /// What the plugin knew, in words.
    pub input: String,
    /// What was recorded.
    pub recorded: Side,
    /// What came of it now.
    pub replayed: Side,
    /// The values that differ.
    pub changes: Vec<String>,
    /// What core made of the recorded requests: each state that they came to at once, with the reason.
    pub judgement: Vec<String>,
    /// What the safety monitor says of each request of the other plugin that differs: its clearance, or why it would be
    /// refused.
    pub monitor: Vec<String>,
}

/// What a step returned.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Side {
    /// What it asked for, in words.
    pub requests: Vec<String>,
    /// How it failed, if it did.
    pub fault: Option<String>,
    /// The fuel that it used.
    pub fuel: u64,
    /// The lines that it logged.
    pub log: Vec<String>,
}

/// A restart of a plugin that differs.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct RestartDifference {
    /// When core learned of it, seconds of the run.
    pub at_s: f64,
    /// The sequence number in the log.
    pub message: u32,
    /// The plugin's name in the mission.
    pub plugin: String,
    /// As recorded.
    pub recorded: String,
    /// As it went now.
    pub replayed: String,
    /// The values that differ.
    pub changes: Vec<String>,
}

impl Difference {
    /// When it is, seconds of the run.
    #[must_use]
    pub const fn at_s(&self) -> f64 {
        match self {
            Self::Output(output) => output.at_s,
            Self::Step(step) => step.at_s,
            Self::Restart(restart) => restart.at_s,
        }
    }

    /// In lines for people. The first one says what it is.
    #[must_use]
    pub fn lines(&self) -> Vec<String> {
        match self {
            Self::Output(output) => output.lines(),
            Self::Step(step) => step.lines(),
            Self::Restart(restart) => {
                let mut lines = vec![format!(
                    "at {:.3} s (message {}) the restart of {} went otherwise",
                    restart.at_s, restart.message, restart.plugin
                )];
                lines.extend(restart.changes.iter().map(|change| format!("  {change}")));
                lines
            }
        }
    }
}

impl OutputDifference {
    fn lines(&self) -> Vec<String> {
        let what = match (&self.recorded, &self.replayed) {
            (Some(_), None) => "core does not do what is recorded",
            (None, Some(_)) => "core does something that is not recorded",
            _ => "core does something else than recorded",
        };
        let place = self
            .message
            .map_or_else(|| "not in the log".to_owned(), |message| format!("message {message}"));
        let mut lines = vec![
            format!("at {:.3} s ({place}, {}) {what}", self.at_s, self.channel),
            format!("  after message {}: {}", self.input_message, short(&self.input)),
        ];
        for (name, text) in [("recorded", &self.recorded), ("replayed", &self.replayed)] {
            let text = text.as_deref().map_or_else(|| "nothing".to_owned(), short);
            lines.push(format!("  {name}: {text}"));
        }
        lines.extend(self.changes.iter().map(|change| format!("  {change}")));
        lines
    }
}

impl StepDifference {
    /// In lines for people.
    #[must_use]
    pub fn lines(&self) -> Vec<String> {
        let mut lines = vec![
            format!(
                "at {:.3} s (message {}) step {} of {} differs: {}",
                self.at_s,
                self.message,
                self.step,
                self.plugin,
                self.differs.join(", ")
            ),
            format!("  it knew: {}", self.input),
        ];
        for (name, side) in [("recorded", &self.recorded), ("now", &self.replayed)] {
            lines.push(format!("  {name}: {}", side.line()));
        }
        lines.extend(self.changes.iter().map(|change| format!("    {change}")));
        let judgement = self.judgement.iter();
        lines.extend(judgement.map(|line| format!("  core, of the recorded one: {line}")));
        let monitor = self.monitor.iter();
        lines.extend(monitor.map(|line| format!("  the monitor, of the one now: {line}")));
        lines
    }
}

impl Side {
    fn line(&self) -> String {
        match &self.fault {
            Some(fault) => format!("failed: {fault}"),
            None if self.requests.is_empty() => format!("no request ({} fuel)", self.fuel),
            None => format!("{} ({} fuel)", self.requests.join("; "), self.fuel),
        }
    }
}

/// The values that differ between two messages, by their paths.
pub(crate) fn changes(recorded: &[u8], replayed: &[u8]) -> Vec<String> {
    let parsed = (
        serde_json::from_slice::<Value>(recorded),
        serde_json::from_slice::<Value>(replayed),
    );
    let mut found = Vec::new();
    match parsed {
        (Ok(recorded), Ok(replayed)) => compare(&mut found, "", Some(&recorded), Some(&replayed)),
        (Err(error), _) => found.push(format!("the recorded message is not JSON: {error}")),
        (_, Err(_)) => {}
    }
    if found.is_empty() {
        let byte = recorded.iter().zip(replayed).take_while(|(a, b)| a == b).count();
        found.push(format!("byte {byte} differs"));
    }
    let more = found.len().saturating_sub(CHANGES_MAX);
    found.truncate(CHANGES_MAX);
    if more > 0 {
        found.push(format!("and {more} more"));
    }
    found
}

fn compare(found: &mut Vec<String>, path: &str, recorded: Option<&Value>, replayed: Option<&Value>) {
    match (recorded, replayed) {
        (Some(Value::Object(one)), Some(Value::Object(other))) => {
            for (key, value) in one {
                compare(found, &joined(path, key), Some(value), other.get(key));
            }
            for (key, value) in other.iter().filter(|(key, _)| !one.contains_key(*key)) {
                compare(found, &joined(path, key), None, Some(value));
            }
        }
        (Some(Value::Array(one)), Some(Value::Array(other))) => {
            for place in 0..one.len().max(other.len()) {
                compare(found, &format!("{path}[{place}]"), one.get(place), other.get(place));
            }
        }
        (one, other) if one == other => {}
        (one, other) => {
            let shown =
                |value: Option<&Value>| value.map_or_else(|| "nothing".to_owned(), |value| short(&value.to_string()));
            found.push(format!("{path}: {} recorded, {} now", shown(one), shown(other)));
        }
    }
}

fn joined(path: &str, key: &str) -> String {
    if path.is_empty() {
        key.to_owned()
    } else {
        format!("{path}.{key}")
    }
}

/// The text in one line, cut where it is long.
pub(crate) fn short(text: &str) -> String {
    let text = text.trim_end();
    match text.char_indices().nth(SHOWN_MAX) {
        Some((cut, _)) => format!("{}… ({} characters)", &text[..cut], text.chars().count()),
        None => text.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_that_differ_are_named_by_their_paths() {
        let recorded = br#"{"a": 1, "list": [{"b": 2.5}, 3], "gone": true}"#;
        let replayed = br#"{"a": 1, "list": [{"b": 2.25}, 3, 4], "new": "x"}"#;
        assert_eq!(
            changes(recorded, replayed),
            [
                "gone: true recorded, nothing now",
                "list[0].b: 2.5 recorded, 2.25 now",
                "list[2]: nothing recorded, 4 now",
                "new: nothing recorded, \"x\" now",
            ]
        );
    }

    #[test]
    fn bytes_that_mean_the_same_are_still_a_difference() {
        assert_eq!(changes(br#"{"a":1}"#, br#"{"a": 1}"#), ["byte 5 differs"]);
        assert!(changes(b"{", b"{}")[0].contains("not JSON"));
    }

    #[test]
    fn a_long_text_is_cut_between_characters() {
        let text = "ä".repeat(500);
        assert!(short(&text).ends_with("… (500 characters)"));
    }
}
