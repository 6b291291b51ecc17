//! Lets the oracle judge the log of a run: what the runtime sent and received, and when.
//!
//! In simulation the oracle sees the vehicle's bytes when they leave the vehicle, ours when they leave us, and the
//! truth. A log has one side only. It has the vehicle's bytes when the runtime has read them, so the runtime knows what
//! they say from that moment on. It has ours when core has released them, whether or not they arrived. So the oracle
//! judges as usual every rule about what was sent, or about what was sent after something was received. The log of a
//! dive has neither what the vehicle truly did nor when our messages reached it. The oracle does not judge rules about
//! these, even if the log of a simulation has the truth.
//!
//! The oracle excuses two things of a real computer. The computer may record what it does up to [`LATE_S`] late. And if
//! the log has no record at all for [`STANDSTILL`], not even of core's own timers, the process stood still. Then the
//! oracle does not count what the process should have sent meanwhile, but it does judge what the process sends when it
//! goes on.

use std::time::Duration;

use backseat_core::Operator;
use backseat_mission::{MissionError, MissionFile};
use backseat_oracle::{Judged, Limits, Oracle, OracleError, Violation};
use backseat_recorder::{Log, LoggedInput, Record};
use backseat_units::Timestamp;
use serde::Serialize;
use serde_json::Value;

use crate::simulation::judge::limits;

/// How late a runtime on a real computer may record what it does, seconds. This is less than the delay that ends its
/// leases.
const LATE_S: f64 = 0.1;
/// A runtime with a link records something far more often than this: it sends a beat every second, and navigation comes
/// ten times a second.
const STANDSTILL: Duration = Duration::from_millis(1100);

/// Why a log cannot be judged.
#[derive(Debug, thiserror::Error)]
pub enum VerdictError {
    /// The mission or the fence of the run is not attached.
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

/// What the oracle found in a log.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Verdict {
    /// The mission's name.
    pub mission: String,
    /// The simulation's seed; `None` for a dive.
    pub seed: Option<u64>,
    /// How long it was recorded, seconds.
    pub seconds: f64,
    /// Whether the log has its end.
    pub complete: bool,
    /// Where records are missing. After a gap the oracle assumes nothing about what was before it.
    pub gaps: Vec<Gap>,
    /// How often the process stood still.
    pub standstills: u64,
    /// Each rule, and how often it was judged.
    pub rules: Vec<Judged>,
    /// The violations in the order of time: the first hundred, and how many more there were.
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
    /// Whether no rule was broken.
    #[must_use]
    pub const fn passed(&self) -> bool {
        self.broken.is_empty()
    }
}

/// Judges a log by what is attached to it. The truth in the log of a simulation is not used.
///
/// # Errors
/// [`VerdictError`] if mission or fence are missing or cannot be read.
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

/// Gives the records of a log to the oracle, one after the other.
struct LogJudge {
    oracle: Oracle,
    /// The time of the newest record. A record with an earlier time counts as of this time.
    now: Timestamp,
    /// A process has begun.
    began: bool,
    up: bool,
    gaps: Vec<Gap>,
    standstills: u64,
}

impl LogJudge {
    /// How many gaps are listed. A disk so slow that there are more has left next to nothing.
    const GAPS_MAX: usize = 1000;

    fn take(&mut self, at: Timestamp, record: &Record) {
        if matches!(record, Record::Truth(_) | Record::Vehicle(_)) {
            // Only a simulation has these records: the runtime does not know them.
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
            | LoggedInput::Swap(..)
            | LoggedInput::External(..)
            | LoggedInput::Reserved(_)
            | LoggedInput::Sonar(_)
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

    /// Policies and mission commands can also act for the operator. Core reports that in a note.
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
        // The link counts as up again with the first bytes that are received.
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
