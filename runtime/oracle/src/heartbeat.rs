use std::collections::VecDeque;
use std::time::Duration;

use crate::limits::{Limits, seconds};
use crate::moment::Moment;
use crate::time_of_day::{Echo, TimeOfDay};
use crate::wire::{Ours, Request};

/// An answer in time speaks for the link for so long after its command left.
const SPEAKS_FOR: Duration = Duration::from_secs(3);
/// What nothing takes back leaves only where the vehicle has answered within this ...
const JUST_NOW: Duration = Duration::from_secs(1);
/// ... what left within this.
const JUST_LEFT: Duration = Duration::from_secs(2);
/// What was not answered for so long will not be.
const FORGOTTEN: Duration = Duration::from_secs(60);
/// A BPLOG that was not answered for so long will not be.
const LOG_FORGOTTEN: Duration = Duration::from_secs(30);

/// The round trips of a connection: each first acknowledgement echoes its command's own time (SPI 6.21), and so measures
/// how long the way there and back took.
///
/// An answer counts from when it is let on its way: where several commands may be meant, it is the newest, so that no
/// reading makes a trip shorter than it is taken for here. BPLOG has no time, and is answered in order; those that left
/// before acknowledgements were asked for may go without an answer.
#[derive(Clone, Debug)]
pub(crate) struct Heartbeat {
    within: Duration,
    late: Duration,
    /// Commands without an answer, oldest first: the last letters of their names, their own times, when they left.
    sent: VecDeque<([u8; 3], TimeOfDay, Moment)>,
    /// When each BPLOG without an answer left, oldest first.
    logs: VecDeque<Moment>,
    subscribed: bool,
    early_log: Option<Moment>,
    /// When the BPLOG left that was answered last, if the one before all others was not answered.
    log_before: Option<Moment>,
    /// When commands left that were answered in time, and when their answers came; of the last seconds.
    trips: VecDeque<(Moment, Moment)>,
    /// When commands left whose answers came while the runtime stood still.
    unread: Vec<Moment>,
    /// What was said before this is not known.
    unseen_until: Option<Moment>,
    /// The vehicle has answered a BPSTS of this process.
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
            subscribed: false,
            early_log: None,
            log_before: None,
            trips: VecDeque::new(),
            unread: Vec::new(),
            unseen_until: None,
            status_is_answered: false,
        }
    }

    /// We said something.
    pub(crate) fn we_say(&mut self, at: Moment, request: &Request) {
        if let Ours::Subscribe { acknowledgements } = request.asks {
            self.subscribed |= acknowledgements;
            if !self.subscribed {
                self.early_log = Some(at);
                return;
            }
            while self.logs.len() >= Self::SENT_MAX
                || self.logs.front().is_some_and(|left| at.since(*left) >= LOG_FORGOTTEN)
            {
                self.logs.pop_front();
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

    /// The vehicle answered something: when that left at the earliest, where that is certain. `stopped` where the runtime
    /// stands still, and reads it when it goes on.
    pub(crate) fn answered(&mut self, at: Moment, command: [u8; 3], echo: Echo, stopped: bool) -> Option<Moment> {
        let mut earliest = None;
        let left = if command == *b"LOG" {
            // If the vehicle answers the early one too, each answer is to the BPLOG before.
            let early = self.early_log;
            let known = self.logs.pop_front().or_else(|| self.early_log.take());
            if self.unseen_until.is_none()
                && let Some(left) = known
            {
                let before = self.log_before.replace(left);
                earliest = if early.is_some() { before.or(early) } else { known };
            }
            // One that left unseen may be meant.
            known.or(self.unseen_until.map(|_| at))
        } else {
            let meant = |(name, created, _): &([u8; 3], TimeOfDay, Moment)| *name == command && echo.echoes(*created);
            let index = self.sent.iter().rposition(meant);
            let left = index.and_then(|index| self.sent.remove(index)).map(|(_, _, left)| left);
            // One that is not precise may mean several.
            earliest = left.filter(|_| echo.is_precise());
            left
        };
        match left {
            Some(left) if stopped && self.unread.len() < Self::TRIPS_MAX => self.unread.push(left),
            Some(left) if !stopped => {
                self.status_is_answered |= command == *b"STS";
                self.trip(left, at);
            }
            Some(_) | None => {}
        }
        earliest
    }

    /// The runtime goes on, and reads what came meanwhile.
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

    /// The last answer in time: when its command left, and when it came.
    pub(crate) fn newest(&self) -> Option<(Moment, Moment)> {
        self.trips.iter().copied().max()
    }

    /// Whether a command that left under 3 s ago was answered in time.
    pub(crate) fn is_heard(&self, now: Moment) -> bool {
        let recent = |left: Moment| now.since(left) < SPEAKS_FOR + self.late;
        self.trips.iter().any(|(left, _)| recent(*left)) || self.unseen_until.is_some_and(recent)
    }

    /// Whether a command that left at most 2 s ago was answered within the last second. `sure` is how long it takes at most
    /// until an answer is read.
    pub(crate) fn has_just_answered(&self, now: Moment, sure: Duration) -> bool {
        let just = |(left, came): &(Moment, Moment)| {
            now.since(*left) <= JUST_LEFT + self.late && now.since(*came) <= JUST_NOW + sure
        };
        self.trips.iter().any(just) || self.unseen_until.is_some_and(|until| just(&(until, until)))
    }

    /// When a BPSTS left, after all that was answered, that waits for its answer though the vehicle answers them: who
    /// knows no more than that does not know that what left before it was read.
    pub(crate) fn waits(&self) -> Option<Moment> {
        let (newest, _) = self.newest()?;
        let waits = |(name, _, left): &&([u8; 3], TimeOfDay, Moment)| name == b"STS" && *left > newest;
        let waiting = self.sent.iter().find(waits).map(|(_, _, left)| *left);
        waiting.filter(|_| self.status_is_answered)
    }

    /// Another process knows nothing of the vehicle's habits.
    pub(crate) fn new_process(&mut self) {
        self.cut();
        self.status_is_answered = false;
    }

    /// The connection is over.
    pub(crate) fn cut(&mut self) {
        self.sent.clear();
        self.logs.clear();
        self.subscribed = false;
        self.early_log = None;
        self.log_before = None;
        self.trips.clear();
        self.unread.clear();
        self.unseen_until = None;
    }

    /// What was said until now is not known: the vehicle may have answered a moment ago.
    pub(crate) fn forget(&mut self, at: Moment) {
        self.cut();
        self.subscribed = true;
        self.unseen_until = Some(at);
    }
}
