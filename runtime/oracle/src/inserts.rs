use std::collections::BTreeMap;

use backseat_units::{TimeOfDay, Timestamp};

use crate::rule::Rule;
use crate::violation::Findings;

/// What we asked the vehicle to fly by itself, and what it said of it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Inserts {
    known: BTreeMap<u32, Insert>,
    /// Our BPRCN, by their times: the acknowledgement may leave the identifier out.
    cancels: BTreeMap<TimeOfDay, u32>,
    sent: u64,
    refused: u64,
    accepted: u64,
    begun: u64,
    cancelled: u64,
}

/// One BPRTK, BPRTC or BPRGP.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Insert {
    /// What our sentence said of when it was made.
    pub(crate) created: Option<TimeOfDay>,
    /// It interrupts the current behavior.
    pub(crate) interrupts: bool,
    /// How long it takes to fly, seconds.
    pub(crate) duration_s: f64,
    pub(crate) state: State,
}

/// What the vehicle said of an insert.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum State {
    /// Nothing yet, on this connection.
    Sent,
    /// Nothing before the link was lost.
    Unknown,
    Accepted,
    Begun(Timestamp),
    Closed,
}

impl Inserts {
    /// More are not followed: the memory is bounded, and the total cap was broken long before.
    const KNOWN_MAX: usize = 65_536;

    pub(crate) const fn counts(&self) -> [u64; 5] {
        [self.sent, self.refused, self.accepted, self.begun, self.cancelled]
    }

    /// We wrote an insert.
    pub(crate) fn sent(
        &mut self,
        at: Timestamp,
        identifier: u32,
        insert: Insert,
        total_max: u32,
        findings: &mut Findings,
    ) {
        self.sent += 1;
        if insert.interrupts
            && let Some((running, _)) = self
                .known
                .iter()
                .find(|(_, other)| other.interrupts && !matches!(other.state, State::Closed | State::Unknown))
        {
            findings.add(at, Rule::InterruptOfInterrupt, || {
                format!("insert {identifier} interrupts while the interrupting insert {running} is not done")
            });
        }
        let total = self.sent - self.refused;
        if total > u64::from(total_max) {
            findings.add(at, Rule::InsertsTotal, || {
                format!("{total} inserts sent, {total_max} allowed")
            });
        }
        if self.known.contains_key(&identifier) {
            findings.add(at, Rule::IdentifierRepeated, || {
                format!("identifier {identifier} was used before")
            });
        } else if self.known.len() < Self::KNOWN_MAX {
            self.known.insert(identifier, insert);
        }
    }

    /// We wrote a BPRCN.
    pub(crate) fn cancel_sent(&mut self, created: TimeOfDay, identifier: u32) {
        if self.cancels.len() >= Self::KNOWN_MAX {
            self.cancels.pop_first();
        }
        self.cancels.insert(created.truncated_to_millis(), identifier);
    }

    /// The vehicle took or refused an insert.
    pub(crate) fn answered(&mut self, identifier: Option<u32>, created: TimeOfDay, taken: bool) {
        let entry = match identifier {
            Some(identifier) => self.known.get_mut(&identifier),
            // Rare: an acknowledgement without the identifier.
            None => self
                .known
                .values_mut()
                .find(|insert| insert.created.map(TimeOfDay::truncated_to_millis) == Some(created)),
        };
        let Some(insert) = entry else { return };
        if !matches!(insert.state, State::Sent | State::Unknown) {
            return;
        }
        if taken {
            insert.state = State::Accepted;
            self.accepted += 1;
        } else {
            insert.state = State::Closed;
            self.refused += 1;
        }
    }

    /// The vehicle's plan holds an insert: it was accepted, whatever became of the acknowledgement.
    pub(crate) fn planned(&mut self, identifier: u32) {
        self.answered(Some(identifier), TimeOfDay::MIDNIGHT, true);
    }

    /// The vehicle acknowledged a cancel.
    pub(crate) fn cancel_done(&mut self, identifier: Option<u32>, created: TimeOfDay) {
        let identifier = identifier.or_else(|| self.cancels.get(&created).copied());
        let Some(insert) = identifier.and_then(|identifier| self.known.get_mut(&identifier)) else {
            return;
        };
        if insert.state != State::Closed {
            insert.state = State::Closed;
            self.cancelled += 1;
        }
    }

    /// The vehicle begins an insert.
    pub(crate) fn begins(&mut self, at: Timestamp, identifier: u32) {
        self.planned(identifier);
        if let Some(insert) = self.known.get_mut(&identifier)
            && !matches!(insert.state, State::Begun(_))
        {
            insert.state = State::Begun(at);
            self.begun += 1;
        }
    }

    /// The vehicle is done with an insert.
    pub(crate) fn ends(&mut self, identifier: u32) {
        if let Some(insert) = self.known.get_mut(&identifier) {
            insert.state = State::Closed;
        }
    }

    /// The mission is over, and all inserts with it.
    pub(crate) fn all_end(&mut self) {
        for insert in self.known.values_mut() {
            insert.state = State::Closed;
        }
    }

    /// The link was lost: what was not answered stays open.
    pub(crate) fn cut(&mut self) {
        for insert in self.known.values_mut() {
            if insert.state == State::Sent {
                insert.state = State::Unknown;
            }
        }
    }

    /// Judges what is open, after the vehicle took one more.
    pub(crate) fn check_open(&self, at: Timestamp, open_max: u32, duration_max_s: f64, findings: &mut Findings) {
        let mut open = 0_u64;
        let mut remaining_s = 0.0;
        for insert in self.known.values() {
            match insert.state {
                State::Accepted => {
                    open += 1;
                    remaining_s += insert.duration_s;
                }
                State::Begun(since) => {
                    open += 1;
                    remaining_s += (insert.duration_s - at.since(since).as_secs_f64()).max(0.0);
                }
                State::Sent | State::Unknown | State::Closed => {}
            }
        }
        if open > u64::from(open_max) {
            findings.add(at, Rule::InsertsOpen, || {
                format!("{open} inserts open, {open_max} allowed")
            });
        }
        if remaining_s > duration_max_s + 1.0 {
            findings.add(at, Rule::InsertsDuration, || {
                format!("open inserts fly {remaining_s:.0} s more, {duration_max_s} s allowed")
            });
        }
    }
}
