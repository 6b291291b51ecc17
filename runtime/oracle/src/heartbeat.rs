use std::collections::VecDeque;
use std::time::Duration;

use crate::limits::{Limits, seconds};
use crate::moment::Moment;
use crate::time_of_day::TimeOfDay;
use crate::wire::{Answer, Ours, Outcome, Request};

/// For so long after a command left, its answer in time proves that the vehicle hears us.
const SPEAKS_FOR: Duration = Duration::from_secs(3);
/// A request that cannot be taken back leaves only if the vehicle has answered within this time ...
const JUST_NOW: Duration = Duration::from_secs(1);
/// ... a command that left within this time.
const JUST_LEFT: Duration = Duration::from_secs(2);
/// A command that was not answered for so long gets no answer.
const FORGOTTEN: Duration = Duration::from_secs(60);
/// A BPLOG that is later than the last answer to one by so much gets no answer.
const LOG_LOST_AFTER: Duration = Duration::from_secs(1);
/// A BPLOG that was not answered for so long gets no answer.
const LOG_FORGOTTEN: Duration = Duration::from_secs(30);

/// The round trips of a connection. The first acknowledgement of each command echoes the command's own time (SPI 6.21),
/// so it measures how long the way there and back took.
///
/// An answer counts from the moment when it starts on its way. If an answer can belong to several commands, the oracle
/// takes the newest, so that no other interpretation makes the trip shorter. BPLOG has no time, and the vehicle answers
/// them in order; those that left before acknowledgements were requested may stay without an answer. What is between the
/// vehicle and us may pass an answer to a BPLOG on in a later connection, so for a while after a reconnection nobody knows
/// which BPLOG an answer belongs to.
#[derive(Clone, Debug)]
pub(crate) struct Heartbeat {
    within: Duration,
    late: Duration,
    /// Commands without an answer, oldest first: the last three letters of the name, the command's own time, and when
    /// it left.
    sent: VecDeque<([u8; 3], TimeOfDay, Moment)>,
    /// When each BPLOG without an answer left, oldest first.
    logs: VecDeque<Moment>,
    /// When the first BPLOG of late left that is thought to be lost.
    log_lost: Option<Moment>,
    /// How long after its BPLOG had left the vehicle wrote the last answer to one.
    log_took: Option<Duration>,
    subscribed: bool,
    early_log: Option<Moment>,
    /// When the last BPLOG left, on any connection.
    last_log: Option<Moment>,
    /// When the last BPLOG of an earlier connection left.
    earlier_log: Option<Moment>,
    /// When the last answered BPLOG left, if the early BPLOG before all others was not answered.
    log_before: Option<Moment>,
    /// When commands left that were answered in time, and when their answers came; those of the last seconds.
    trips: VecDeque<(Moment, Moment)>,
    /// When commands left whose answers came while the runtime was stopped.
    unread: Vec<Moment>,
    /// The record has a gap until this time.
    unseen_until: Option<Moment>,
    /// The vehicle has answered a BPSTS of this process otherwise than by refusing it.
    status_is_answered: bool,
}

impl Heartbeat {
    const SENT_MAX: usize = 256;
    const TRIPS_MAX: usize = 64;

    pub(crate) fn new(limits: &Limits) -> Self {
        Self {
            within: seconds(limits.answered_within_s) + limits.runtime_late(),
            late: limits.runtime_late(),
            sent: VecDeque::new(),
            logs: VecDeque::new(),
            log_lost: None,
            log_took: None,
            subscribed: false,
            early_log: None,
            last_log: None,
            earlier_log: None,
            log_before: None,
            trips: VecDeque::new(),
            unread: Vec::new(),
            unseen_until: None,
            status_is_answered: false,
        }
    }

    /// We sent a sentence.
    pub(crate) fn we_say(&mut self, at: Moment, request: &Request) {
        if let Ours::Subscribe { acknowledgements } = request.asks {
            self.last_log = Some(at);
            self.subscribed |= acknowledgements;
            if !self.subscribed {
                self.early_log = Some(at);
                return;
            }
            while self.logs.len() >= Self::SENT_MAX || self.logs.front().is_some_and(|left| self.is_lost(at, *left)) {
                let lost = self.logs.pop_front();
                let late = self.log_lost.filter(|lost| at.since(*lost) < FORGOTTEN);
                self.log_lost = late.or(lost);
            }
            self.logs.push_back(at);
        } else if let Some(created) = request.created
            && let Some(letters) = request.name.last_chunk::<3>()
        {
            while self.sent.len() >= Self::SENT_MAX
                || self
                    .sent
                    .front()
                    .is_some_and(|(_, _, left)| at.since(*left) >= FORGOTTEN)
            {
                self.sent.pop_front();
            }
            self.sent.push_back((*letters, created, at));
        }
    }

    /// Whether a BPLOG that left at this time gets no answer any more: the vehicle took much less time for the last answer
    /// to one.
    fn is_lost(&self, now: Moment, left: Moment) -> bool {
        let took = self.log_took.map(|took| took * 5 / 4 + LOG_LOST_AFTER);
        now.since(left) >= took.unwrap_or(LOG_FORGOTTEN).min(LOG_FORGOTTEN)
    }

    /// The vehicle answered a command. Returns the earliest time at which that command can have left, if it is certain.
    /// `stopped` is true while the runtime is stopped; it reads the answer when it continues.
    pub(crate) fn answered(&mut self, at: Moment, answer: &Answer, stopped: bool) -> Option<Moment> {
        let (command, echo) = (answer.command, answer.command_created);
        let mut earliest = None;
        let left = if command == *b"LOG" {
            // If the vehicle answers the early BPLOG too, each answer belongs to the BPLOG before.
            let early = self.early_log;
            let known = self.logs.pop_front().or_else(|| self.early_log.take());
            if self.unseen_until.is_none()
                && let Some(left) = known
            {
                let before = self.log_before.replace(left);
                earliest = if early.is_some() { before.or(early) } else { known };
                // It may not be lost, but late.
                let late = self.log_lost.filter(|lost| at.since(*lost) < FORGOTTEN);
                let of_earlier = self.earlier_log.is_some_and(|last| at.since(last) < FORGOTTEN);
                earliest = late.or(earliest).filter(|_| !of_earlier);
                self.log_took = Some(at.since(left));
            }
            // The answer may belong to a BPLOG that left during a gap of the record.
            known.or(self.unseen_until.map(|_| at))
        } else {
            let meant = |(name, created, _): &([u8; 3], TimeOfDay, Moment)| *name == command && echo.echoes(*created);
            let index = self.sent.iter().rposition(meant);
            let left = index.and_then(|index| self.sent.remove(index)).map(|(_, _, left)| left);
            // An echo that is not precise can belong to several commands.
            earliest = left.filter(|_| echo.is_precise());
            left
        };
        match left {
            Some(left) if stopped && self.unread.len() < Self::TRIPS_MAX => self.unread.push(left),
            Some(left) if !stopped => {
                // A vehicle that does not answer BPSTS may refuse one (SPI 6.21).
                let usual = matches!(answer.outcome, Outcome::Succeeded | Outcome::Pending);
                self.status_is_answered |= command == *b"STS" && usual;
                self.trip(left, at);
            }
            Some(_) | None => {}
        }
        earliest
    }

    /// The runtime continues, and reads the answers that came meanwhile.
    pub(crate) fn goes_on(&mut self, at: Moment) {
        for left in core::mem::take(&mut self.unread) {
            self.trip(left, at);
        }
    }

    fn trip(&mut self, left: Moment, came: Moment) {
        if came.since(left) > self.within {
            return;
        }
        if self.trips.len() == Self::TRIPS_MAX {
            self.trips.pop_front();
        }
        self.trips.push_back((left, came));
    }

    /// The command that left last of those answered in time: when it left, and when its answer came.
    pub(crate) fn newest(&self) -> Option<(Moment, Moment)> {
        self.trips.iter().copied().max()
    }

    /// How long an answered command counts, from when it left.
    pub(crate) fn lasts(&self) -> Duration {
        SPEAKS_FOR + self.late
    }

    /// Whether a command that left under 3 s ago was answered in time.
    pub(crate) fn is_heard(&self, now: Moment) -> bool {
        let recent = |left: Moment| now.since(left) < self.lasts();
        self.trips.iter().any(|(left, _)| recent(*left)) || self.unseen_until.is_some_and(recent)
    }

    /// Whether a command that left at most 2 s ago was answered within the last second. `sure` is the longest time
    /// until the runtime has certainly read an answer.
    pub(crate) fn has_just_answered(&self, now: Moment, sure: Duration) -> bool {
        let just = |(left, came): &(Moment, Moment)| {
            now.since(*left) <= JUST_LEFT + self.late && now.since(*came) <= JUST_NOW + sure
        };
        self.trips.iter().any(just) || self.unseen_until.is_some_and(|until| just(&(until, until)))
    }

    /// When a BPSTS left that waits for its answer, if it left after every answered command and the vehicle answers
    /// BPSTS at all. While it waits, the runtime does not know whether the vehicle has read what left before it.
    pub(crate) fn waits(&self) -> Option<Moment> {
        let (newest, _) = self.newest()?;
        let waits = |(name, _, left): &&([u8; 3], TimeOfDay, Moment)| name == b"STS" && *left > newest;
        let waiting = self.sent.iter().find(waits).map(|(_, _, left)| *left);
        waiting.filter(|_| self.status_is_answered)
    }

    /// A new process knows nothing of the vehicle's habits.
    pub(crate) fn new_process(&mut self) {
        self.cut();
        self.status_is_answered = false;
    }

    /// Forgets the connection, which is over.
    pub(crate) fn cut(&mut self) {
        self.sent.clear();
        self.logs.clear();
        self.log_lost = None;
        self.log_took = None;
        self.subscribed = false;
        self.early_log = None;
        self.earlier_log = self.last_log;
        self.log_before = None;
        self.trips.clear();
        self.unread.clear();
        self.unseen_until = None;
    }

    /// The record has a gap until now: the vehicle may have answered a moment ago.
    pub(crate) fn forget(&mut self, at: Moment) {
        self.cut();
        self.subscribed = true;
        self.unseen_until = Some(at);
    }
}
