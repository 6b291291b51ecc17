use std::cmp::Reverse;
use std::collections::BTreeMap;

use backseat_core::Grant;
use backseat_core::plugin::{EndCause, PluginId};
use backseat_recorder::{LogReader, LoggedInput, Message, Record};
use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::grant::{is_in_the_ledger, kind_and_needs};

/// What became of all requests of a kind.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize)]
pub struct KindTally {
    /// How many the plugin made.
    pub made: u64,
    /// How many were sent.
    pub sent: u64,
    /// How many the vehicle accepted.
    pub accepted: u64,
    /// How they ended, in words, and how often. Of a kind that the runtime keeps account of, they add up to `made`.
    pub ends: BTreeMap<String, u64>,
    /// Why they were refused before they were sent, the most frequent reason first.
    pub refusals: Vec<Refused>,
}

/// Refusals for one reason.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Refused {
    /// How many.
    pub count: u64,
    /// The rule of the safety monitor.
    pub rule: String,
    /// The exact cause.
    pub cause: String,
    /// The first refusal in words.
    pub example: String,
}

/// Failures of a plugin in one way.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Fault {
    /// Which bound it broke: `trap`, `out-of-fuel`.
    pub kind: String,
    /// How often.
    pub count: u64,
    /// The seed of the trial in which it happened first.
    pub seed: u64,
    /// When, seconds since the start of that trial.
    pub at_s: f64,
    /// The first fault in words.
    pub text: String,
}

/// Counts what a plugin did in any number of trials, from their logs.
pub(crate) struct Tally {
    plugin: PluginId,
    pub(crate) kinds: BTreeMap<String, KindTally>,
    /// How many of its requests needed which grant.
    pub(crate) needs: BTreeMap<Grant, u64>,
    pub(crate) faults: Vec<Fault>,
    /// Requests of the present trial that have not ended.
    open: BTreeMap<u64, Open>,
    /// Requests of the present trial that the log has, by kind.
    logged: BTreeMap<String, u64>,
    made: BTreeMap<&'static str, u64>,
}

/// A request that has not ended.
struct Open {
    kind: String,
    sent: bool,
    accepted: bool,
}

/// A line of `/requests`, as far as it is needed.
#[derive(Deserialize)]
struct Line {
    request: u64,
    plugin: Option<PluginId>,
    kind: String,
    state: String,
    #[serde(default)]
    reason: String,
    #[serde(default)]
    why: Why,
}

#[derive(Default, Deserialize)]
struct Why {
    #[serde(default)]
    rule: String,
    #[serde(default)]
    cause: String,
}

/// A line of `/notes` about a failed plugin, as far as it is needed.
#[derive(Deserialize)]
struct Failed {
    note: String,
    plugin: PluginId,
    fault: FailedHow,
}

#[derive(Deserialize)]
struct FailedHow {
    kind: String,
    text: String,
}

impl Tally {
    pub(crate) fn new(plugin: PluginId) -> Self {
        Self {
            plugin,
            kinds: BTreeMap::new(),
            needs: BTreeMap::new(),
            faults: Vec::new(),
            open: BTreeMap::new(),
            logged: BTreeMap::new(),
            made: BTreeMap::new(),
        }
    }

    /// Counts a whole log.
    ///
    /// # Errors
    ///
    /// If it cannot be read.
    pub(crate) fn take_log<R: std::io::Read>(
        &mut self,
        seed: u64,
        log: &mut LogReader<R>,
    ) -> Result<(), backseat_recorder::RecorderError> {
        while let Some(message) = log.next_message()? {
            if !["/core/input", "/requests", "/notes"].contains(&&*message.topic) {
                continue;
            }
            if let Some(record) = log.record(&message)? {
                self.take(seed, &message, record);
            }
        }
        self.end_trial();
        Ok(())
    }

    fn take(&mut self, seed: u64, message: &Message, record: Record) {
        if let Record::Input(LoggedInput::Returned(plugin, returned)) = &record {
            if *plugin == self.plugin {
                for request in returned.result.iter().flatten() {
                    let (kind, needs) = kind_and_needs(request);
                    *self.made.entry(kind).or_default() += 1;
                    for grant in needs {
                        *self.needs.entry(grant).or_default() += 1;
                    }
                }
            }
        } else if let Record::Request(line) = record {
            // Lines of other sources have no plugin.
            if let Ok(line) = serde_json::from_value::<Line>(line)
                && line.plugin == Some(self.plugin)
            {
                self.transition(line);
            }
        } else if let Record::Note(note) = record {
            self.note(seed, message.now.as_secs_f64(), note);
        }
    }

    fn transition(&mut self, line: Line) {
        let open = self.open.entry(line.request).or_insert_with(|| {
            *self.logged.entry(line.kind.clone()).or_default() += 1;
            Open {
                kind: line.kind.clone(),
                sent: false,
                accepted: false,
            }
        });
        let end = match line.state.as_str() {
            "sent" => {
                open.sent = true;
                return;
            }
            "accepted" | "started" => {
                open.accepted = true;
                return;
            }
            "rejected" => "refused before it was sent".to_owned(),
            "failed" if line.why.cause == "not-in-plan" => line.reason.clone(),
            "failed" => "the vehicle refused it, or it failed there".to_owned(),
            "timed-out" => "no answer".to_owned(),
            "cancelled" => "cancelled before it began".to_owned(),
            "ended" => words_of(&line.why.cause),
            // `pending` and `unknown` are followed by another state.
            _ => return,
        };
        if let Some(open) = self.open.remove(&line.request) {
            let tally = self.close(open, end);
            if line.state == "rejected" {
                tally.refuse(line.why, line.reason, 1);
            }
        }
    }

    fn close(&mut self, open: Open, end: String) -> &mut KindTally {
        let tally = self.kinds.entry(open.kind).or_default();
        tally.sent += u64::from(open.sent);
        tally.accepted += u64::from(open.accepted);
        *tally.ends.entry(end).or_default() += 1;
        tally
    }

    fn note(&mut self, seed: u64, at_s: f64, note: Value) {
        let Ok(failed) = serde_json::from_value::<Failed>(note) else {
            return;
        };
        if failed.note != "plugin-failed" || failed.plugin != self.plugin {
            return;
        }
        let FailedHow { kind, text } = failed.fault;
        match self.faults.iter_mut().find(|fault| fault.kind == kind) {
            Some(fault) => fault.count += 1,
            None => self.faults.push(Fault {
                kind,
                count: 1,
                seed,
                at_s,
                text,
            }),
        }
    }

    /// Closes the account of a trial.
    fn end_trial(&mut self) {
        for open in std::mem::take(&mut self.open).into_values() {
            self.close(open, "not ended when the trial was over".to_owned());
        }
        let logged = std::mem::take(&mut self.logged);
        for (kind, made) in std::mem::take(&mut self.made) {
            let tally = self.kinds.entry(kind.to_owned()).or_default();
            tally.made += made;
            // The log has only some of the refusals for a rate, and a step of an open DVL request is none of its own.
            let unlogged = made.saturating_sub(logged.get(kind).copied().unwrap_or(0));
            if !is_in_the_ledger(kind) || unlogged == 0 {
                continue;
            }
            let over_rate = tally.refusals.iter().find(|refused| refused.rule == "rate").cloned();
            let end = match over_rate {
                Some(rate) => {
                    let why = Why {
                        rule: rate.rule,
                        cause: rate.cause,
                    };
                    tally.refuse(why, rate.example, unlogged);
                    "refused before it was sent"
                }
                None if kind == "dvl-trigger" => "a further step of an open request",
                None => "not looked at, because the runtime or the plugin had ended",
            };
            *tally.ends.entry(end.to_owned()).or_default() += unlogged;
        }
    }
}

impl KindTally {
    fn refuse(&mut self, why: Why, example: String, count: u64) {
        let same = |refused: &&mut Refused| refused.rule == why.rule && refused.cause == why.cause;
        match self.refusals.iter_mut().find(same) {
            Some(refused) => refused.count += count,
            None => self.refusals.push(Refused {
                count,
                rule: why.rule,
                cause: why.cause,
                example,
            }),
        }
        self.refusals.sort_by_key(|refused| Reverse(refused.count));
    }
}

/// What has ended a request, in words.
fn words_of(cause: &str) -> String {
    let known = EndCause::ALL.iter().find(|known| known.name() == cause);
    known.map_or_else(
        || format!("a later check refused it: {cause}"),
        |known| known.text().to_owned(),
    )
}
