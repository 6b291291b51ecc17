use std::collections::BTreeMap;
use std::time::Duration;

use crate::margin::Margin;
use crate::moment::Moment;
use crate::time_of_day::{Echo, TimeOfDay};

use crate::rule::Rule;
use crate::violation::Findings;

/// A plan that was not reported to its end within this time will not be.
const PLAN_TOLD_WITHIN: Duration = Duration::from_secs(10);

/// The inserts that we asked the vehicle to fly, and what the vehicle reported about them.
#[derive(Clone, Debug, Default)]
pub(crate) struct Inserts {
    known: BTreeMap<u32, Insert>,
    /// Our BPRCN by their times, because the acknowledgement may lack the identifier.
    cancels: BTreeMap<TimeOfDay, u32>,
    open: Open,
    /// The requests for plans that have not been reported to their ends: the time in the BPRMP, and when it left;
    /// oldest first.
    plans_asked: Vec<(TimeOfDay, Moment)>,
    /// The vehicle has named an insert of a previous process that waits.
    named: bool,
    /// The first element of the plan that is being reported, and its place in the plan.
    plan_begins: Option<(PlanPlace, u32)>,
    /// The first identifier that no previous run can have given without our knowledge.
    first: u32,
    /// The record has had a gap, in which inserts may have been sent.
    unseen: bool,
    /// How many were sent and not refused, without GPS hits, which have a cap of their own.
    counted: u64,
    sent: u64,
    refused: u64,
    accepted: u64,
    begun: u64,
    cancelled: u64,
}

/// The number and the identifier of an element of the plan.
type PlanPlace = (Option<u32>, Option<u32>);

/// One BPRTK, BPRTC or BPRGP.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Insert {
    /// The command that sent it, as acknowledgements name it.
    pub(crate) command: [u8; 3],
    pub(crate) sent: Moment,
    /// When our sentence says that it was made.
    pub(crate) created: Option<TimeOfDay>,
    /// It interrupts the current behavior.
    pub(crate) interrupts: bool,
    /// BPRCN can cancel it.
    pub(crate) cancellable: bool,
    /// How long it takes to fly, seconds.
    pub(crate) duration_s: f64,
    pub(crate) state: State,
    /// BPRCN was sent for it.
    pub(crate) cancel_asked: bool,
    /// The plan that is being reported has it.
    pub(crate) listed: bool,
    /// A previous process has sent it, and the vehicle has not named it to this one.
    pub(crate) foreign: bool,
    /// A previous process has sent it, so this one does not know how long it flies.
    pub(crate) inherited: bool,
    /// It was open during a gap of the record: it may have begun, and flown for any time.
    pub(crate) unwatched: bool,
}

/// What the vehicle has reported about an insert.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum State {
    /// Nothing yet, on this connection.
    Sent,
    /// Nothing before the link was lost.
    Unknown,
    Accepted(Moment),
    Begun(Moment),
    /// A complete plan that was reported later did not have it, or the vehicle could not read it.
    Absent,
    Closed,
}

/// The greatest difference between the time at which the vehicle does something and the time at which it reports it.
const APART: Duration = Duration::from_millis(100);

/// How many inserts are in each state.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Open {
    /// Neither accepted nor refused.
    pub(crate) asked: u32,
    /// Accepted and not begun.
    pub(crate) queued: u32,
    /// Begun and not ended.
    pub(crate) flown: u32,
}

impl Open {
    const fn of(&mut self, state: State) -> Option<&mut u32> {
        match state {
            State::Sent | State::Unknown => Some(&mut self.asked),
            State::Accepted(_) => Some(&mut self.queued),
            State::Begun(_) => Some(&mut self.flown),
            State::Absent | State::Closed => None,
        }
    }

    fn goes(&mut self, insert: &mut Insert, state: State) {
        if let Some(count) = self.of(insert.state) {
            *count -= 1;
        }
        if let Some(count) = self.of(state) {
            *count += 1;
        }
        insert.state = state;
    }
}

impl Insert {
    pub(crate) const fn new(command: [u8; 3], sent: Moment, created: TimeOfDay, duration_s: f64) -> Self {
        Self {
            command,
            sent,
            created: Some(created),
            interrupts: false,
            cancellable: true,
            duration_s,
            state: State::Sent,
            cancel_asked: false,
            listed: false,
            foreign: false,
            inherited: false,
            unwatched: false,
        }
    }
}

impl Inserts {
    /// More inserts than this are not followed, to bound the memory. The total cap was broken long before.
    const KNOWN_MAX: usize = 65_536;
    /// How many requests for plans are remembered.
    const PLANS_MAX: usize = 64;

    pub(crate) const fn counts(&self) -> [u64; 5] {
        [self.sent, self.refused, self.accepted, self.begun, self.cancelled]
    }

    pub(crate) const fn open(&self) -> Open {
        self.open
    }

    /// We wrote an insert.
    pub(crate) fn sent(
        &mut self,
        at: Moment,
        identifier: u32,
        insert: Insert,
        total_max: u32,
        findings: &mut Findings,
    ) {
        self.sent += 1;
        self.counted += u64::from(insert.cancellable);
        if insert.interrupts {
            findings.judge(Rule::InterruptOfInterrupt);
        }
        for rule in [Rule::InsertInDoubt, Rule::InsertsTotal, Rule::IdentifierRepeated] {
            findings.judge(rule);
        }
        if insert.interrupts
            && let Some((running, _)) = self.known.iter().find(|(_, other)| {
                other.interrupts
                    && !other.foreign
                    && matches!(other.state, State::Sent | State::Accepted(_) | State::Begun(_))
            })
        {
            findings.add(at, Rule::InterruptOfInterrupt, || {
                format!("insert {identifier} interrupts while the interrupting insert {running} is still open")
            });
        }
        if let Some((doubt, _)) = self
            .known
            .iter()
            .find(|(_, other)| other.state == State::Unknown && !other.foreign)
        {
            findings.add(at, Rule::InsertInDoubt, || {
                format!(
                    "insert {identifier} was sent although the fate of insert {doubt}, sent before a link loss, is unknown"
                )
            });
        }
        let total = self.counted;
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
            self.open.asked += 1;
            self.known.insert(identifier, insert);
        }
    }

    /// Whether we have sent an insert with this identifier; `None` if it may have been sent without a record.
    pub(crate) fn is_ours(&self, identifier: u32) -> Option<bool> {
        let unseen = self.unseen || identifier < self.first || self.known.len() >= Self::KNOWN_MAX;
        let known = self.known.contains_key(&identifier);
        (known || !unseen).then_some(known)
    }

    /// We wrote a BPRCN.
    pub(crate) fn cancel_sent(&mut self, created: TimeOfDay, identifier: u32) {
        if self.cancels.len() >= Self::KNOWN_MAX {
            self.cancels.pop_first();
        }
        self.cancels.insert(created.to_the_millisecond(), identifier);
        if let Some(insert) = self.known.get_mut(&identifier) {
            insert.cancel_asked = true;
        }
    }

    /// Whether the vehicle has named a waiting insert of a previous process since this was asked last.
    pub(crate) fn take_named(&mut self) -> bool {
        std::mem::take(&mut self.named)
    }

    /// An insert that was accepted before `by`, has not begun, can be cancelled, and was not.
    pub(crate) fn not_taken_back(&self, by: Moment) -> Option<u32> {
        if self.open.queued == 0 {
            return None;
        }
        self.known.iter().find_map(|(identifier, insert)| {
            let waits = matches!(insert.state, State::Accepted(at) if at <= by);
            (waits && !insert.unwatched && insert.cancellable && !insert.cancel_asked && !insert.foreign)
                .then_some(*identifier)
        })
    }

    /// The vehicle accepted or refused an insert.
    pub(crate) fn answered(&mut self, at: Moment, identifier: Option<u32>, echo: Echo, taken: bool) {
        let entry = match identifier {
            Some(identifier) => self.known.get_mut(&identifier),
            // Rare: an acknowledgement without the identifier.
            None => self
                .known
                .values_mut()
                .find(|insert| insert.created.is_some_and(|created| echo.echoes(created))),
        };
        let Some(insert) = entry else { return };
        // A process that follows another knows of an insert since the vehicle has named it.
        if std::mem::take(&mut insert.foreign)
            && taken
            && let State::Accepted(since) = &mut insert.state
        {
            *since = at;
            self.named = true;
        }
        if !matches!(insert.state, State::Sent | State::Unknown | State::Absent) {
            return;
        }
        if taken {
            self.open.goes(insert, State::Accepted(at));
            self.accepted += 1;
        } else {
            self.open.goes(insert, State::Closed);
            self.refused += 1;
            self.counted = self.counted.saturating_sub(u64::from(insert.cancellable));
        }
    }

    /// The vehicle could not read a command, so it does not say which. It may be the oldest insert of that name without
    /// an answer, or the oldest of any name if the name could not be read either.
    pub(crate) fn unreadable(&mut self, command: Option<[u8; 3]>) {
        let oldest = self
            .known
            .values_mut()
            .filter(|insert| insert.state == State::Sent && command.is_none_or(|command| command == insert.command))
            .min_by_key(|insert| insert.sent);
        if let Some(insert) = oldest {
            self.open.goes(insert, State::Absent);
            self.refused += 1;
            self.counted = self.counted.saturating_sub(u64::from(insert.cancellable));
        }
    }

    /// We asked for the plan. If we ask again before the plan was reported, it comes twice.
    pub(crate) fn plan_asked(&mut self, at: Moment, created: TimeOfDay) {
        self.plans_asked
            .retain(|(_, asked)| at.since(*asked) < PLAN_TOLD_WITHIN);
        if self.plans_asked.is_empty() {
            self.unlist();
        }
        if self.plans_asked.len() < Self::PLANS_MAX {
            self.plans_asked.push((created.to_the_millisecond(), at));
        }
    }

    /// The vehicle reports an element of its plan. If the first element comes again, the plan starts again, and the
    /// earlier report was not complete.
    pub(crate) fn element(&mut self, at: Moment, place: PlanPlace, index: u32) {
        if self.plan_begins == Some((place, index)) {
            self.unlist();
        }
        self.plan_begins.get_or_insert((place, index));
        if let (_, Some(identifier)) = place {
            self.planned(at, identifier);
        }
    }

    fn unlist(&mut self) {
        self.plan_begins = None;
        for insert in self.known.values_mut() {
            insert.listed = false;
        }
    }

    /// The vehicle's plan has an insert: the vehicle accepted it, even if the acknowledgement was lost.
    fn planned(&mut self, at: Moment, identifier: u32) {
        self.answered(at, Some(identifier), Echo::NONE, true);
        if let Some(insert) = self.known.get_mut(&identifier) {
            insert.listed = true;
        }
    }

    /// A plan was reported to its end if `whole`, or will not be. An insert that a whole plan does not have is not
    /// waiting.
    pub(crate) fn plan_told(&mut self, echo: Echo, whole: bool) {
        let Some(told) = self.plans_asked.iter().position(|(asked, _)| echo.echoes(*asked)) else {
            return;
        };
        let Some((_, asked)) = self.plans_asked.drain(..=told).next_back() else {
            return;
        };
        for insert in self.known.values_mut().filter(|_| whole) {
            if insert.sent < asked
                && !insert.listed
                && matches!(insert.state, State::Sent | State::Unknown | State::Accepted(_))
            {
                self.open.goes(insert, State::Absent);
                self.counted = self.counted.saturating_sub(u64::from(insert.cancellable));
            }
        }
        self.unlist();
    }

    /// The vehicle acknowledged a cancel.
    pub(crate) fn cancel_done(&mut self, identifier: Option<u32>, echo: Echo) {
        let asked = |(created, _): &(&TimeOfDay, &u32)| echo.echoes(**created);
        let identifier =
            identifier.or_else(|| self.cancels.iter().rev().find(asked).map(|(_, identifier)| *identifier));
        let Some(insert) = identifier.and_then(|identifier| self.known.get_mut(&identifier)) else {
            return;
        };
        if insert.state != State::Closed {
            self.open.goes(insert, State::Closed);
            self.cancelled += 1;
        }
    }

    /// The vehicle acknowledged a BPRCA: all waiting inserts that can be cancelled are cancelled (SPI 7.9).
    pub(crate) fn all_cancelled(&mut self) {
        for insert in self.known.values_mut() {
            if matches!(insert.state, State::Accepted(_)) && insert.cancellable {
                self.open.goes(insert, State::Closed);
                self.cancelled += 1;
            }
        }
    }

    /// The vehicle begins an insert.
    pub(crate) fn begins(&mut self, at: Moment, identifier: u32) {
        self.planned(at, identifier);
        if let Some(insert) = self.known.get_mut(&identifier)
            && !matches!(insert.state, State::Begun(_))
        {
            self.open.goes(insert, State::Begun(at));
            self.begun += 1;
        }
    }

    /// The vehicle truly flies an insert. This counts only if the vehicle has reported that it accepted the insert,
    /// because otherwise the runtime cannot know.
    pub(crate) fn is_flown(&mut self, at: Moment, identifier: u32) {
        if let Some(insert) = self.known.get_mut(&identifier)
            && matches!(insert.state, State::Accepted(_))
        {
            self.open.goes(insert, State::Begun(at));
            self.begun += 1;
        }
    }

    /// The vehicle has ended an insert.
    pub(crate) fn ends(&mut self, identifier: u32) {
        if let Some(insert) = self.known.get_mut(&identifier) {
            self.open.goes(insert, State::Closed);
        }
    }

    /// The vehicle flies a behavior of the plan: every insert of ours that had begun is over, although its end may not
    /// have been reported.
    pub(crate) fn plan_goes_on(&mut self, at: Moment) {
        if self.open.flown == 0 {
            return;
        }
        for insert in self.known.values_mut() {
            if matches!(insert.state, State::Begun(since) if since + APART < at) {
                self.open.goes(insert, State::Closed);
            }
        }
    }

    /// The mission is over, and with it all inserts.
    pub(crate) fn all_end(&mut self) {
        for insert in self.known.values_mut() {
            self.open.goes(insert, State::Closed);
        }
    }

    /// The link was lost: inserts without an answer stay open. If the run does not have the truth, accepted inserts may
    /// be flown and end before the vehicle names them again.
    pub(crate) fn cut(&mut self, truth_told: bool) {
        self.plans_asked.clear();
        if !truth_told && self.open.queued + self.open.flown > 0 {
            for insert in self.known.values_mut() {
                if matches!(insert.state, State::Accepted(_) | State::Begun(_)) {
                    insert.unwatched = true;
                    self.open.goes(insert, State::Absent);
                }
            }
        }
        if self.open.asked == 0 {
            return;
        }
        for insert in self.known.values_mut() {
            if insert.state == State::Sent {
                insert.state = State::Unknown;
            }
        }
    }

    /// The record has a gap: other inserts may have been sent, and the open ones may have been refused, accepted or
    /// flown.
    pub(crate) fn forget(&mut self) {
        self.unseen = true;
        self.plans_asked.clear();
        self.unlist();
        for insert in self.known.values_mut() {
            if matches!(insert.state, State::Sent | State::Unknown) {
                self.counted = self.counted.saturating_sub(u64::from(insert.cancellable));
            }
            if insert.state != State::Closed {
                insert.unwatched = true;
                self.open.goes(insert, State::Absent);
            }
        }
    }

    /// Identifiers below this one may belong to a previous run.
    pub(crate) const fn begin_with(&mut self, first: u32) {
        self.first = first;
    }

    /// A new process does not know what the previous one sent.
    pub(crate) fn new_process(&mut self) {
        self.plans_asked.clear();
        for insert in self.known.values_mut() {
            insert.foreign = true;
            insert.inherited = true;
        }
    }

    /// Judges the open inserts, after the vehicle accepted one more.
    pub(crate) fn check_open(&self, at: Moment, open_max: u32, duration_max_s: f64, findings: &mut Findings) {
        findings.judge(Rule::InsertsOpen);
        findings.judge(Rule::InsertsDuration);
        let mut open = 0_u64;
        let mut remaining_s = 0.0;
        for insert in self.known.values().filter(|insert| !insert.foreign) {
            let left_s = match insert.state {
                State::Accepted(_) => insert.duration_s,
                State::Begun(since) => (insert.duration_s - at.since(since).as_secs_f64()).max(0.0),
                State::Sent | State::Unknown | State::Absent | State::Closed => continue,
            };
            open += 1;
            if !insert.inherited && !insert.unwatched {
                remaining_s += left_s;
            }
        }
        #[expect(clippy::cast_precision_loss, reason = "a handful of inserts")]
        findings.near(Margin::InsertsOpen, open as f64, f64::from(open_max));
        if open > u64::from(open_max) {
            findings.add(at, Rule::InsertsOpen, || {
                format!("{open} inserts open, {open_max} allowed")
            });
        }
        if remaining_s > duration_max_s + 1.0 {
            findings.add(at, Rule::InsertsDuration, || {
                format!("open inserts take {remaining_s:.0} s more, {duration_max_s} s allowed")
            });
        }
    }
}
