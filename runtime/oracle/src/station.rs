use std::time::Duration;

use crate::margin::Margin;
use crate::moment::Moment;

use crate::due::Due;
use crate::rule::Rule;
use crate::violation::Findings;

/// The longest time between two sentences that refresh a suspension.
const GAP_MAX: Duration = Duration::from_secs(1);
/// When the vehicle resumes its mission by itself (SPI 8.1).
const LAPSE: Duration = Duration::from_secs(2);

/// The cadence of our suspensions. A suspension lives from BPSUS to BPRES, or until the vehicle resumes by itself.
#[derive(Clone, Debug, Default)]
pub(crate) struct Station {
    last: Option<Moment>,
    alive_since: Option<Moment>,
    /// BPSUS was sent on this connection, and no BPRES since.
    suspended: bool,
    /// BPSUS was sent, and no BPRES since.
    unended: bool,
    due: Option<Due>,
    opened: u64,
    alive: Duration,
}

impl Station {
    pub(crate) const fn is_alive(&self) -> bool {
        self.alive_since.is_some()
    }

    /// Whether a BPRES has something to end.
    pub(crate) const fn is_unended(&self) -> bool {
        self.unended
    }

    pub(crate) const fn opened(&self) -> u64 {
        self.opened
    }

    /// How long the vehicle has kept station until now.
    pub(crate) fn alive_s(&self, now: Moment) -> f64 {
        let open = self.alive_since.map_or(Duration::ZERO, |since| now.since(since));
        (self.alive + open).as_secs_f64()
    }

    /// Judges the effects of silence.
    pub(crate) fn check(&mut self, now: Moment, findings: &mut Findings) {
        if self.alive_since.is_none() {
            return;
        }
        if let Some(due) = self.due
            && due.is_missed(now)
        {
            due.tell(now, "BPRES", findings);
            self.close(now);
            return;
        }
        let Some(last) = self.last else { return };
        if now.since(last) > GAP_MAX {
            findings.add(now, Rule::StationGap, || {
                format!("station keeping was neither refreshed nor ended for over 1 s after {last}")
            });
            self.close(last + LAPSE);
        }
    }

    /// We wrote a BPSUS. `counts` is true if the vehicle may accept it; `due` says when it must end, if it must end at
    /// once.
    pub(crate) fn suspend(&mut self, at: Moment, counts: bool, due: Option<Due>, findings: &mut Findings) {
        self.suspended = true;
        self.unended = true;
        self.refresh(at, counts, due, findings);
    }

    /// We wrote BPCON, BPGHP or BPGBP. Returns whether there was a suspension to refresh.
    pub(crate) fn keep(&mut self, at: Moment, counts: bool, due: Option<Due>, findings: &mut Findings) -> bool {
        if self.suspended {
            self.refresh(at, counts, due, findings);
        }
        self.suspended
    }

    fn refresh(&mut self, at: Moment, counts: bool, due: Option<Due>, findings: &mut Findings) {
        if let Some(last) = self.last.filter(|_| self.alive_since.is_some()) {
            findings.near(Margin::StationGap, at.since(last).as_secs_f64(), GAP_MAX.as_secs_f64());
        }
        self.last = Some(at);
        if counts && self.alive_since.is_none() {
            self.alive_since = Some(at);
            self.opened += 1;
            self.due = due;
        }
    }

    /// We wrote a BPRES.
    pub(crate) fn end(&mut self, at: Moment, findings: &mut Findings) {
        if let Some(due) = self.due.filter(|_| self.alive_since.is_some()) {
            findings.near(Margin::StationEnd, due.left_s(at), 0.0);
        }
        self.suspended = false;
        self.unended = false;
        self.close(at);
    }

    /// Something has ended station keeping: a BPRES is due.
    pub(crate) fn must_end(&mut self, due: Due) {
        if self.alive_since.is_some() {
            self.due = Due::first(self.due, due);
        }
    }

    /// The link was lost: the vehicle resumes by itself, and nothing is suspended on the next connection.
    pub(crate) fn cut(&mut self, at: Moment) {
        self.suspended = false;
        self.close(at);
    }

    /// The runtime is stopped and cannot refresh.
    pub(crate) fn pause(&mut self, at: Moment) {
        self.close(at);
    }

    /// The record has a gap: the mission may be suspended.
    pub(crate) fn forget(&mut self, at: Moment) {
        self.close(at);
        self.last = None;
        self.suspended = true;
        self.unended = true;
    }

    fn close(&mut self, at: Moment) {
        if let Some(since) = self.alive_since.take() {
            self.alive += at.since(since);
        }
        self.due = None;
    }
}
