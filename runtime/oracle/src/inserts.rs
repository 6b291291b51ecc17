use std::collections::BTreeMap;
use std::time::Duration;

use crate::moment::Moment;
use crate::time_of_day::{Echo, TimeOfDay};

use crate::rule::Rule;
use crate::violation::Findings;

/// A plan that was not told to its end by then will not be.
const PLAN_TOLD_WITHIN: Duration = Duration::from_secs(10);

/// What we asked the vehicle to fly by itself, and what it said of it.
#[derive(Clone, Debug, Default)]
pub(crate) struct Inserts {
    known: BTreeMap<u32, Insert>,
    /// Our BPRCN, by their times: the acknowledgement may leave the identifier out.
    cancels: BTreeMap<TimeOfDay, u32>,
    open: Open,
    /// When the plans were asked for that are not told to their ends, by their BPRMP, oldest first.
    plans_asked: Vec<(TimeOfDay, Moment)>,
    /// What the plan that is being told begins with: an element, and its place in it.
    plan_begins: Option<(PlanPlace, u32)>,
    /// The first identifier that no previous run, unknown to us, can have given.
    first: u32,
    /// Inserts may have been sent that nobody has written down.
    unseen: bool,
    /// Sent and not refused, GPS hits apart, which have a cap of their own.
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
    /// What sent it, as acknowledgements name it.
    pub(crate) command: [u8; 3],
    pub(crate) sent: Moment,
    /// What our sentence said of when it was made.
    pub(crate) created: Option<TimeOfDay>,
    /// It interrupts the current behavior.
    pub(crate) interrupts: bool,
    /// BPRCN can take it back.
    pub(crate) cancellable: bool,
    /// How long it takes to fly, seconds.
    pub(crate) duration_s: f64,
    pub(crate) state: State,
    /// BPRCN was sent for it.
    pub(crate) cancel_asked: bool,
    /// The plan that is being told has it.
    pub(crate) listed: bool,
    /// A previous run has sent it, and the vehicle has not named it to this one.
    pub(crate) foreign: bool,
    /// A previous run has sent it: this one cannot know how long it flies.
    pub(crate) inherited: bool,
    /// It was open while nobody has written down what became of it: it may have begun, and flown for any time.
    pub(crate) unwatched: bool,
}

/// What the vehicle said of an insert.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum State {
    /// Nothing yet, on this connection.
    Sent,
    /// Nothing before the link was lost.
    Unknown,
    Accepted(Moment),
    Begun(Moment),
    /// A whole plan, told later, did not have it, or the vehicle could not read it.
    Absent,
    Closed,
}

/// What the vehicle tells as it does it, and what it truly does, are no further apart.
const APART: Duration = Duration::from_millis(100);

/// How many inserts stand where.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Open {
    /// Neither taken nor refused.
    pub(crate) asked: u32,
    /// Taken and not begun.
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
    /// More are not followed: the memory is bounded, and the total cap was broken long before.
    const KNOWN_MAX: usize = 65_536;
    /// How many plans that were asked for are remembered.
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
                format!("insert {identifier} interrupts while the interrupting insert {running} is not done")
            });
        }
        if let Some((doubt, _)) = self
            .known
            .iter()
            .find(|(_, other)| other.state == State::Unknown && !other.foreign)
        {
            findings.add(at, Rule::InsertInDoubt, || {
                format!(
                    "insert {identifier} while it is not known what became of {doubt}, sent before the link was lost"
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

    /// Whether we have sent an insert with this identifier; nothing where it may have been sent unseen.
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

    /// One that was taken before `by`, has not begun, can be taken back, and was not.
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

    /// The vehicle took or refused an insert.
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
        insert.foreign = false;
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

    /// The vehicle could not read a command, and so does not say which: it may have been the oldest of that name that
    /// has no answer, or of any name where that could not be read either.
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

    /// We asked for the plan. Where it is asked for again before it was told, it comes twice.
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

    /// The vehicle tells an element of its plan. Where the first comes again, so does the plan, and what was told of it
    /// before was not told to its end.
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

    /// The vehicle's plan holds an insert: it was accepted, whatever became of the acknowledgement.
    fn planned(&mut self, at: Moment, identifier: u32) {
        self.answered(at, Some(identifier), Echo::NONE, true);
        if let Some(insert) = self.known.get_mut(&identifier) {
            insert.listed = true;
        }
    }

    /// A plan was told to its end, or will not be: what it does not hold does not wait.
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

    /// The vehicle acknowledged a BPRCA: what waits and can be taken back is (SPI 7.9).
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

    /// The vehicle truly flies an insert. That it was taken must have been said: else nobody could know.
    pub(crate) fn is_flown(&mut self, at: Moment, identifier: u32) {
        if let Some(insert) = self.known.get_mut(&identifier)
            && matches!(insert.state, State::Accepted(_))
        {
            self.open.goes(insert, State::Begun(at));
            self.begun += 1;
        }
    }

    /// The vehicle is done with an insert.
    pub(crate) fn ends(&mut self, identifier: u32) {
        if let Some(insert) = self.known.get_mut(&identifier) {
            self.open.goes(insert, State::Closed);
        }
    }

    /// A behavior of the plan is flown: what had begun of ours is over, though its end may not have been told.
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

    /// The mission is over, and all inserts with it.
    pub(crate) fn all_end(&mut self) {
        for insert in self.known.values_mut() {
            self.open.goes(insert, State::Closed);
        }
    }

    /// The link was lost: what was not answered stays open. Where nobody tells what the vehicle truly does, what was taken
    /// may be flown and over before it is heard of again.
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

    /// What was said of late is not known: others may have been sent, and what is open may have been refused, taken or
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

    /// Identifiers below this one may be a previous run's.
    pub(crate) const fn begin_with(&mut self, first: u32) {
        self.first = first;
    }

    /// A new process knows nothing of what another one sent.
    pub(crate) fn new_process(&mut self) {
        self.plans_asked.clear();
        for insert in self.known.values_mut() {
            insert.foreign = true;
            insert.inherited = true;
        }
    }

    /// Judges what is open, after the vehicle took one more.
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
