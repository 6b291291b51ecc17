//! The answers to BPLOG (SPI 7.1; safety requirement 023). They echo no time, so an answer does not say which BPLOG it
//! answers.
//!
//! The vehicle answers in order, so an answer belongs to the oldest BPLOG that waits for one. But if a BPLOG or its
//! answer comes twice, or is lost, then each later answer would be taken for the answer to another BPLOG, until nothing
//! is under way. So a round trip counts from the earliest BPLOG that the answer could belong to. That is a BPLOG of the
//! same row: a row begins with a BPLOG that is sent when no answer can be under way.

use std::collections::VecDeque;
use std::time::Duration;

use backseat_units::{TimeOfDay, Timestamp};

/// A second answer to a BPLOG comes within this time, so a row goes on this long after its last answer at least.
const SETTLES: Duration = Duration::from_millis(900);
/// How long the row of an earlier connection goes on at least.
const QUIET: Duration = Duration::from_secs(3);
/// If answers have not come so long after the time at which the last of them should have come, they will not come.
const GIVES_UP: Duration = Duration::from_secs(2);
/// A BPLOG that has no answer after this long will not get one, even if nothing has been answered since.
pub(super) const FORGOTTEN: Duration = Duration::from_secs(60);
/// How many BPLOG without an answer are remembered: several subscriptions to everything.
pub(super) const WAITING_MAX: usize = 256;

/// A BPLOG that waits for its answer.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
struct Waiting {
    at: Timestamp,
    /// When the first BPLOG of its row was sent.
    since: Timestamp,
    /// Its answer cannot be taken for that of another connection's.
    counts: bool,
}

/// The BPLOG that have been sent on one connection, and their answers.
#[derive(Clone, Debug, Default)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
pub(super) struct Logs {
    /// Oldest first.
    waiting: VecDeque<Waiting>,
    /// When the first BPLOG of the present row was sent, and when the last.
    row: Option<(Timestamp, Timestamp)>,
    /// When the last answer came in the present row.
    answer_came: Option<Timestamp>,
    /// When the vehicle wrote the last answer, and [`Waiting::since`] of the BPLOG that it was taken to answer.
    answered: Option<(TimeOfDay, Timestamp)>,
    /// When a BPLOG was sent before the subscription to acknowledgements.
    early: Option<Timestamp>,
    /// The last answer took no longer than this.
    took: Duration,
    /// When the last BPLOG of the connection before was sent, in the first row of this one.
    earlier: Option<Timestamp>,
    /// The present row goes on until this time at least.
    quiet_until: Timestamp,
}

impl Logs {
    /// The BPLOG of a new connection. Something between the vehicle and us may keep answers of the last connection, and
    /// pass them on in this one. So the first row does not count, and if BPLOG that were sent after the last answer waited
    /// when that one ended, an answer may take as long as from the first of them on.
    pub(super) fn begin(&self, now: Timestamp) -> Self {
        let recent = |at: &Timestamp| now.since(*at) < FORGOTTEN;
        let earlier = self.row.map(|(_, last)| last).filter(recent);
        let waits = |at: &Timestamp| self.answer_came.is_none_or(|came| came <= *at);
        let unanswered = self.waiting.iter().map(|waiting| waiting.at).find(waits).filter(recent);
        let quiet = (self.took * 5 / 4 + SETTLES).clamp(QUIET, FORGOTTEN);
        Self {
            row: unanswered.zip(earlier),
            took: self.took,
            earlier,
            quiet_until: earlier.map_or(Timestamp::ZERO, |_| now + quiet),
            ..Self::default()
        }
    }

    /// A BPLOG was sent before the subscription to acknowledgements.
    pub(super) const fn left_early(&mut self, now: Timestamp) {
        self.early = Some(now);
    }

    /// A BPLOG was sent.
    pub(super) fn left(&mut self, now: Timestamp) {
        if self.waiting.len() >= WAITING_MAX {
            self.waiting.pop_front();
            // Its answer may still come, and each later answer would be taken for the answer to another BPLOG.
            self.quiet_until = self.quiet_until.max(now + FORGOTTEN);
        }
        let first = match self.row {
            Some((first, _)) if !self.are_quiet(now) => first,
            Some(_) => {
                self.answer_came = None;
                self.earlier = None;
                now
            }
            None => now,
        };
        self.row = Some((first, now));
        self.waiting.push_back(Waiting {
            at: now,
            since: self.earlier.unwrap_or(first),
            counts: self.earlier.is_none(),
        });
    }

    /// The vehicle answers commands that were sent before the subscription to acknowledgements.
    pub(super) fn early_is_answered(&mut self) {
        if let Some(at) = self.early.take() {
            self.waiting.push_front(Waiting {
                at,
                since: at,
                counts: true,
            });
        }
    }

    /// Handles an answer that the vehicle wrote at `created`. Returns when the earliest BPLOG was sent that it could answer;
    /// `None` if that may be one of another connection.
    pub(super) fn answered(&mut self, now: Timestamp, created: TimeOfDay) -> Option<Timestamp> {
        // The vehicle has not answered BPVER, so it does not answer the early BPLOG either.
        self.early = None;
        // A BPLOG of a later row was sent after the last answer had come, so an answer that was written at the same time
        // as that one is not its own.
        let repeats = |waiting: &Waiting| {
            self.answered
                .is_some_and(|(written, since)| written == created && waiting.since > since)
        };
        if self.waiting.front().is_some_and(repeats) {
            return None;
        }
        self.answer_came = Some(now);
        if let Some((first, _)) = self.row {
            self.took = now.since(first);
        }
        let Waiting { since, counts, .. } = self.waiting.pop_front()?;
        self.answered = Some((created, since));
        counts.then_some(since)
    }

    /// Whether no answer is under way: what is sent now begins a row.
    pub(super) fn are_quiet(&self, now: Timestamp) -> bool {
        self.waiting.is_empty() && now >= self.quiet_at()
    }

    /// When a row may begin if no other answer comes.
    pub(super) fn quiet_at(&self) -> Timestamp {
        let quiet = match (self.row, self.answer_came) {
            (Some((first, last)), Some(came)) if first < last => {
                // No answer has taken longer than this, if none is late by more than a quarter of it from now on.
                let longest = came.since(first) * 5 / 4;
                Some(came.max(last + longest.min(FORGOTTEN)) + SETTLES)
            }
            (Some(_), Some(came)) => Some(came + SETTLES),
            (_, None) | (None, _) => None,
        };
        let forgotten = self.waiting.back().map(|last| {
            let never = last.at + FORGOTTEN;
            quiet.map_or(never, |quiet| never.min(quiet + GIVES_UP))
        });
        let known = [quiet, forgotten].into_iter().flatten().max();
        known.map_or(self.quiet_until, |known| known.max(self.quiet_until))
    }

    /// Whether the vehicle has answered a BPLOG of the present row.
    pub(super) const fn has_answer(&self) -> bool {
        self.answer_came.is_some()
    }

    /// Gives up on answers that have not come.
    pub(super) fn forget(&mut self, now: Timestamp) {
        if now >= self.quiet_at() {
            self.waiting.clear();
        }
    }

    /// Whether every BPLOG that was sent after this time has been answered.
    pub(super) fn none_waits_after(&self, at: Timestamp) -> bool {
        self.waiting.iter().all(|waiting| waiting.at <= at)
    }

    /// When the last of those was sent that wait.
    pub(super) fn last_sent(&self) -> Option<Timestamp> {
        self.waiting.back().map(|last| last.at)
    }
}
