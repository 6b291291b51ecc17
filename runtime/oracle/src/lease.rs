use std::time::Duration;

use crate::margin::Margin;
use crate::moment::Moment;
use crate::time_of_day::{Echo, TimeOfDay};

use crate::due::Due;
use crate::rule::Rule;
use crate::violation::Findings;

/// The longest time between two BPRMB of a live lease.
const GAP_MAX: Duration = Duration::from_millis(2500);
/// When the vehicle ends a modify by itself (SPI 7.12).
const LAPSE: Duration = Duration::from_secs(5);
/// The shortest time between two BPRMB: 5 Hz, less 5 ms for jitter.
const GAP_MIN: Duration = Duration::from_millis(195);

/// The cadence of our modifies. A lease lives from its first BPRMB to its BPEMB, or until the vehicle forgets it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Lease {
    last_modify: Option<Moment>,
    alive_since: Option<Moment>,
    /// A BPRMB was sent, and no BPEMB since.
    unended: bool,
    gap_told: bool,
    stale_told: bool,
    /// Something has ended it, and a BPEMB must come.
    due: Option<Due>,
    /// When the first and the last BPRMB of the lease say that they were made.
    created: Option<(TimeOfDay, TimeOfDay)>,
    /// The first BPRMB since the last answer to any BPRMB.
    unanswered: Option<Moment>,
    unanswered_told: bool,
    opened: u64,
    alive: Duration,
}

impl Lease {
    pub(crate) const fn is_alive(&self) -> bool {
        self.alive_since.is_some()
    }

    /// Whether a BPEMB has something to end.
    pub(crate) const fn is_unended(&self) -> bool {
        self.unended
    }

    pub(crate) const fn opened(&self) -> u64 {
        self.opened
    }

    /// How long leases have lived until now.
    pub(crate) fn alive_s(&self, now: Moment) -> f64 {
        let open = self.alive_since.map_or(Duration::ZERO, |since| now.since(since));
        (self.alive + open).as_secs_f64()
    }

    /// Judges the effects of silence. `answer_max` is how long an answer may take.
    pub(crate) fn check(&mut self, now: Moment, answer_max: Duration, findings: &mut Findings) {
        if self.alive_since.is_none() {
            return;
        }
        if let Some(due) = self.due
            && due.is_missed(now)
        {
            due.tell(now, "BPEMB", findings);
            self.close(now);
            return;
        }
        if let Some(since) = self.unanswered
            && now.since(since) > answer_max
            && !core::mem::replace(&mut self.unanswered_told, true)
        {
            findings.add(now, Rule::ModifyUnanswered, || {
                format!(
                    "the lease continues although the vehicle has not answered the BPRMB of {since} or any later one"
                )
            });
        }
        let Some(last) = self.last_modify else { return };
        let idle = now.since(last);
        if idle > GAP_MAX && !self.gap_told {
            self.gap_told = true;
            findings.add(now, Rule::ModifyGap, || {
                format!("no BPRMB for over 2.5 s after the one at {last}")
            });
        }
        if idle > LAPSE {
            findings.add(now, Rule::ModifyAbandoned, || {
                format!("the last BPRMB left at {last}, and no BPEMB followed although the link was up")
            });
            self.close(last + LAPSE);
        }
    }

    /// We wrote a BPRMB. `counts` is true if the vehicle may accept it; `late` is how late the runtime may have
    /// recorded it; `due` says when it must end, if it must end at once.
    pub(crate) fn modify(
        &mut self,
        at: Moment,
        created: TimeOfDay,
        counts: bool,
        late: Duration,
        due: Option<Due>,
        findings: &mut Findings,
    ) {
        // If the runtime's record may be late, two BPRMB are too fast only if their own times are also too near to each
        // other.
        let made_apart = self.created.filter(|_| !late.is_zero()).map(|(_, last)| {
            let apart_ns = created.nanos_since(last);
            Duration::from_nanos(u64::try_from(apart_ns).unwrap_or(0))
        });
        if let Some(last) = self.last_modify
            && at.since(last) < GAP_MIN
            && made_apart.is_none_or(|apart| apart < GAP_MIN)
        {
            findings.add(at, Rule::ModifyTooFast, || {
                format!("a BPRMB {} ms after the one at {last}", at.since(last).as_millis())
            });
        }
        if let Some(last) = self.last_modify.filter(|_| self.alive_since.is_some()) {
            findings.near(Margin::ModifyGap, at.since(last).as_secs_f64(), GAP_MAX.as_secs_f64());
        }
        self.last_modify = Some(at);
        self.unended = true;
        self.gap_told = false;
        if counts && self.alive_since.is_none() {
            self.alive_since = Some(at);
            self.opened += 1;
            self.stale_told = false;
            self.due = due;
            self.created = None;
            self.unanswered = None;
            self.unanswered_told = false;
        }
        self.unanswered.get_or_insert(at);
        let first = self.created.map_or(created, |(first, _)| first);
        self.created = Some((first, created));
    }

    /// The vehicle answered a BPRMB, with any result.
    pub(crate) fn answered(&mut self) {
        self.unanswered = None;
    }

    /// Whether the BPRMB of this time belongs to the live lease.
    pub(crate) fn has(&self, echo: Echo) -> bool {
        self.alive_since.is_some()
            && self.created.is_some_and(|(first, last)| {
                let between = echo.time().nanos_since(first) >= 0 && echo.time().nanos_since(last) <= 0;
                !echo.is_none() && between || echo.echoes(first) || echo.echoes(last)
            })
    }

    /// We wrote a BPEMB.
    pub(crate) fn end(&mut self, at: Moment, findings: &mut Findings) {
        if let Some(due) = self.due.filter(|_| self.alive_since.is_some()) {
            findings.near(Margin::ModifyEnd, due.left_s(at), 0.0);
        }
        self.unended = false;
        self.close(at);
    }

    /// Something has ended the lease: a BPEMB is due.
    pub(crate) fn must_end(&mut self, due: Due) {
        if self.alive_since.is_some() {
            self.due = Due::first(self.due, due);
        }
    }

    /// The link was lost: nothing more can be sent, and the vehicle ends the modify by itself.
    pub(crate) fn cut(&mut self, at: Moment) {
        self.close(at);
    }

    /// The record has a gap: there may be a lease to end.
    pub(crate) fn forget(&mut self, at: Moment) {
        self.close(at);
        self.last_modify = None;
        self.unended = true;
        self.created = None;
        self.unanswered = None;
    }

    /// Whether stale navigation is reported for the first time for this lease.
    pub(crate) const fn tell_stale(&mut self) -> bool {
        !core::mem::replace(&mut self.stale_told, true)
    }

    fn close(&mut self, at: Moment) {
        if let Some(since) = self.alive_since.take() {
            self.alive += at.since(since);
        }
        self.due = None;
        self.gap_told = false;
    }
}
