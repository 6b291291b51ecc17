//! A log of a run, judged by the oracle: of what the runtime sent and heard, by the times at which it did.
//!
//! In simulation the oracle sees the vehicle's bytes when they leave the vehicle, ours when they leave us, and the truth.
//! A log has one side alone. The vehicle's bytes are there when the runtime has read them, so that what they say was known
//! from that moment on; ours are there when core has let them go, whether or not they arrived. So a rule that is about what
//! was sent, or about what was sent after what was heard, is judged as ever. What the vehicle truly does, and when our
//! words come to it, nobody has written down: those rules are not judged, even where the log of a simulation has the truth.
//!
//! Two things of a real computer are excused. It may note what it does up to [`LATE_S`] late. And where nothing at all is
//! written down for [`STANDSTILL`], core's own timers included, the process stood still: what it should have said meanwhile
//! is not held against it, but what it says when it goes on is.

use std::time::Duration;

use backseat_core::Operator;
use backseat_mission::{MissionError, MissionFile};
use backseat_oracle::{Judged, Limits, Oracle, OracleError, Violation};
use backseat_recorder::{Log, LoggedInput, Record};
use backseat_units::Timestamp;
use serde::Serialize;
use serde_json::Value;

use crate::simulation::judge::limits;

/// How late a runtime on a real computer may note what it does, seconds: less than what ends its leases.
const LATE_S: f64 = 0.1;
/// A runtime with a link writes something down far more often: a beat leaves each second, navigation comes ten times in it.
const STANDSTILL: Duration = Duration::from_millis(1100);

/// A log that cannot be judged.
#[derive(Debug, thiserror::Error)]
pub enum VerdictError {
    /// What the run was judged by is not attached.
    #[error("no attachment {name}: expected the log of a run, which has its mission and its fence attached")]
    Attachment {
        /// Its name.
        name: &'static str,
    },
    /// The attached mission cannot be read.
    #[error(transparent)]
    Mission(#[from] MissionError),
    /// The attached fence or a limit cannot be used.
    #[error("fence.geojson, as the oracle reads it: {0}")]
    Oracle(#[from] OracleError),
}

/// What the oracle made of a log.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Verdict {
    /// The mission's name.
    pub mission: String,
    /// The simulation's seed; nothing for a dive.
    pub seed: Option<u64>,
    /// How long it was recorded, seconds.
    pub seconds: f64,
    /// The log has its end.
    pub complete: bool,
    /// Where records are missing, and past which nothing is claimed of what was before.
    pub gaps: Vec<Gap>,
    /// How often the process stood still.
    pub standstills: u64,
    /// Each rule, by how often it was judged.
    pub rules: Vec<Judged>,
    /// What broke, in the order of time; the first hundred, and how many more.
    pub broken: Vec<Violation>,
}

/// Records that are missing.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Gap {
    /// Since when, seconds of the run.
    pub since_s: f64,
    /// Until when.
    pub until_s: f64,
    /// How many.
    pub records: u64,
}

impl Verdict {
    /// Nothing broke.
    #[must_use]
    pub const fn passed(&self) -> bool {
        self.broken.is_empty()
    }
}

/// Judges a log by what is attached to it. The truth in the log of a simulation is not used.
///
/// # Errors
/// [`VerdictError`] where mission or fence are missing or cannot be read.
pub fn judge_log(log: &Log) -> Result<Verdict, VerdictError> {
    let mission = MissionFile::from_toml("mission.toml", text_of(log, "mission.toml")?)?;
    let limits = Limits {
        runtime_late_s: LATE_S,
        truth_told: false,
        ..limits(&mission)
    };
    let mut judge = LogJudge {
        oracle: Oracle::new(text_of(log, "fence.geojson")?, limits)?,
        now: Timestamp::ZERO,
        began: false,
        up: false,
        gaps: Vec::new(),
        standstills: 0,
    };
    for entry in &log.entries {
        judge.take(entry.now, &entry.record);
    }
    let end = judge.now;
    Ok(Verdict {
        mission: log.run.mission.clone(),
        seed: log.run.seed,
        seconds: end.as_secs_f64(),
        complete: log.complete,
        gaps: judge.gaps,
        standstills: judge.standstills,
        rules: judge.oracle.rules(),
        broken: judge.oracle.finish(end.as_nanos()),
    })
}

fn text_of<'a>(log: &'a Log, name: &'static str) -> Result<&'a str, VerdictError> {
    log.attachment(name)
        .and_then(|data| std::str::from_utf8(data).ok())
        .ok_or(VerdictError::Attachment { name })
}

/// The records of a log, given to the oracle one after the other.
struct LogJudge {
    oracle: Oracle,
    /// The time of the newest record; a record that says an earlier one is of this.
    now: Timestamp,
    /// A process has begun.
    began: bool,
    up: bool,
    gaps: Vec<Gap>,
    standstills: u64,
}

impl LogJudge {
    /// More gaps are not listed: a disk that slow has left next to nothing.
    const GAPS_MAX: usize = 1000;

    fn take(&mut self, at: Timestamp, record: &Record) {
        if matches!(record, Record::Truth(_) | Record::Vehicle(_)) {
            // A simulation's: the runtime knows nothing of them.
            return;
        }
        let (before, now) = (self.now, self.now.max(at));
        self.now = now;
        let is_gap = matches!(record, Record::Gap { .. });
        if self.up && !is_gap && now.since(before) > STANDSTILL {
            self.standstills += 1;
            self.oracle.runtime_stopped(before.as_nanos());
            self.oracle.runtime_continued(now.as_nanos());
        }
        match record {
            Record::Start(start) => {
                if std::mem::replace(&mut self.began, true) {
                    self.oracle.link(now.as_nanos(), false);
                    self.oracle.runtime_started(now.as_nanos());
                } else {
                    let first = start.identifiers.map_or(u32::MAX, |identifiers| identifiers.next);
                    self.oracle.identifiers_from(first);
                }
                self.oracle.operator(now.as_nanos(), start.held);
            }
            Record::Gap { since_s, records } => self.gap(before, *since_s, *records),
            Record::Sent(bytes) => self.oracle.to_vehicle(now.as_nanos(), bytes),
            Record::Input(input) => self.input(input),
            Record::Note(note) => self.note(note),
            Record::Output(_)
            | Record::Request(_)
            | Record::Control(_)
            | Record::Navigation(_)
            | Record::Truth(_)
            | Record::Vehicle(_) => {}
        }
    }

    fn input(&mut self, input: &LoggedInput) {
        let at = self.now.as_nanos();
        match input {
            LoggedInput::LinkUp => self.link(true),
            LoggedInput::LinkDown => self.link(false),
            LoggedInput::Received(bytes) => {
                self.up = true;
                self.oracle.from_vehicle(at, bytes);
            }
            LoggedInput::Operator(act) => self.operator(act),
            LoggedInput::Returned(..)
            | LoggedInput::Restarted(..)
            | LoggedInput::External(..)
            | LoggedInput::Reserved(_)
            | LoggedInput::UtcSet(_)
            | LoggedInput::Timeout => {}
        }
    }

    fn link(&mut self, up: bool) {
        self.up = up;
        self.oracle.link(self.now.as_nanos(), up);
    }

    fn operator(&mut self, act: &Operator) {
        match act {
            Operator::Hold => self.oracle.operator(self.now.as_nanos(), true),
            Operator::Release => self.oracle.operator(self.now.as_nanos(), false),
            Operator::Stop | Operator::Order(_) => {}
        }
    }

    /// Policies and mission commands act for the operator too: core says so in a note.
    fn note(&mut self, note: &Value) {
        if note.get("note").and_then(Value::as_str) == Some("operator")
            && let Some(act) = note.get("act").and_then(Value::as_str)
        {
            match act {
                "hold" => self.operator(&Operator::Hold),
                "release" => self.operator(&Operator::Release),
                _ => {}
            }
        }
    }

    fn gap(&mut self, before: Timestamp, since_s: f64, records: u64) {
        let (until, since) = (self.now, Duration::try_from_secs_f64(since_s).unwrap_or_default());
        let since = (Timestamp::ZERO + since).clamp(before.min(until), until);
        self.oracle.gap(since.as_nanos(), until.as_nanos());
        // It comes up again with the first bytes.
        self.up = false;
        if self.gaps.len() < Self::GAPS_MAX {
            self.gaps.push(Gap {
                since_s: since.as_secs_f64(),
                until_s: until.as_secs_f64(),
                records,
            });
        }
    }
}
