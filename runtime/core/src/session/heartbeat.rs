//! The two-way heartbeat: whether the vehicle hears us, and how long messages take (SPI 4.4, 6.21, 7.25; safety
//! requirement 023).
//!
//! Navigation that comes does not show that our messages arrive. An acknowledgement echoes the time of its command, so
//! each one measures a round trip. We send a beat every second, so there is always a round trip to measure. The beat is
//! BPSTS. Some vehicles acknowledge only the commands whose sections say so; for them the beat is BPLOG,ACK,ON.

mod logs;

use std::collections::{BTreeSet, VecDeque};
use std::time::Duration;

use backseat_spi::{AckStatus, Acknowledgement, CommandName};
use backseat_units::{TimeOfDay, Timestamp};

use crate::session::heartbeat::logs::Logs;
use crate::session::name;
use crate::vehicle::clock::Trip;

/// The period of the beat.
pub(crate) const BEAT_EVERY: Duration = Duration::from_secs(1);
/// How long a round trip is evidence for the link, counted from when its command was sent.
const TRIP_LASTS: Duration = Duration::from_secs(3);
/// A command that cannot be taken back is sent only if the vehicle has answered within this time.
const JUST_NOW: Duration = Duration::from_secs(1);
/// A request that waits for an answer causes another beat if the last one was sent longer ago than this.
const ANOTHER_AFTER: Duration = Duration::from_millis(250);
/// After this many BPSTS without an answer we assume that the vehicle does not answer them.
const BEATS_WITHOUT_ANSWER: u32 = 4;
/// A command that has no answer after this long will not get one.
const SENT_FORGOTTEN: Duration = Duration::from_secs(60);
/// How many commands without an answer are remembered.
const SENT_MAX: usize = 64;
/// How long after the last good round trip we subscribe to acknowledgements again. After the third time we do so every
/// 12 s.
const SUBSCRIBE_AFTER: [Duration; 3] = [Duration::from_secs(3), Duration::from_secs(6), Duration::from_secs(12)];
/// A connection that has had a good round trip is reset when there has been none for this long.
const RESET_AFTER: Duration = Duration::from_secs(30);

/// What a vehicle answers although it has not done so yet: a command that cannot be taken back waits for the answer to
/// the first of these too.
const INSERTS: [&str; 3] = ["RTK", "RTC", "RGP"];

/// Which message is the beat.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
pub(crate) enum Carrier {
    /// BPSTS.
    #[default]
    Status,
    /// BPLOG,ACK,ON, in addition to the BPSTS that the vehicle does not answer.
    Logging,
}

/// What to do if the vehicle does not answer in time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Remedy {
    /// Subscribe to acknowledgements again.
    Subscribe,
    /// Reset the connection.
    Reset,
}

/// The round trip that an acknowledgement has measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Heard {
    pub(crate) trip: Trip,
    /// It is no longer than the mission allows.
    pub(crate) good: bool,
}

#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
struct Sent {
    name: CommandName,
    created: TimeOfDay,
    at: Timestamp,
}

/// The round trips of a connection.
#[derive(Debug)]
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub(crate) struct Heartbeat {
    delay_max: Duration,
    /// Commands with a time whose first acknowledgement has not come, oldest first.
    sent: VecDeque<Sent>,
    /// Commands whose answers echoed less than milliseconds, so that they could answer others too, oldest first. `created`
    /// is the echo.
    echoed: VecDeque<Sent>,
    /// The vehicle echoes whole seconds.
    echoes_seconds: bool,
    logs: Logs,
    /// When this connection began.
    began: Timestamp,
    /// The good round trip on this connection whose command was sent last.
    good: Option<Trip>,
    /// The newest round trip on this connection, however long.
    newest: Option<Trip>,
    carrier: Carrier,
    /// How many BPSTS were sent on this connection since the vehicle last answered one without refusing it.
    unanswered_beats: u32,
    /// When the command of the last good round trip was sent, or when the connection began if there has been none.
    lost_at: Timestamp,
    remedies: u32,
    /// Commands that this vehicle answers: inserts, and those that it has ever answered without refusing them.
    answers: BTreeSet<CommandName>,
}

impl Heartbeat {
    /// Round trips are good up to `delay_max`.
    pub(crate) fn new(delay_max: Duration) -> Self {
        Self {
            delay_max,
            sent: VecDeque::new(),
            echoed: VecDeque::new(),
            echoes_seconds: false,
            logs: Logs::default(),
            began: Timestamp::ZERO,
            good: None,
            newest: None,
            carrier: Carrier::Status,
            unanswered_beats: 0,
            lost_at: Timestamp::ZERO,
            remedies: 0,
            answers: INSERTS.into_iter().map(name).collect(),
        }
    }

    /// Begins a new connection. Which commands the vehicle answers is a property of the vehicle, so it is kept. The commands
    /// of the connection before are kept too. A vehicle that echoes whole seconds may echo two beats alike, and something
    /// between the vehicle and us may pass late answers on in this connection: the answer to a command that is not kept
    /// would be taken for that to the next one, and so on to the last.
    pub(crate) fn begin(&mut self, now: Timestamp) {
        let fresh = Self::new(self.delay_max);
        *self = Self {
            carrier: self.carrier,
            echoes_seconds: self.echoes_seconds,
            answers: core::mem::take(&mut self.answers),
            sent: core::mem::take(&mut self.sent),
            echoed: core::mem::take(&mut self.echoed),
            logs: self.logs.begin(now),
            began: now,
            lost_at: now,
            ..fresh
        };
    }

    /// A command has been sent. `early` means before the subscription to acknowledgements.
    pub(crate) fn left(&mut self, now: Timestamp, command: CommandName, created: Option<TimeOfDay>, early: bool) {
        match created {
            Some(created) => {
                let sent = Sent {
                    name: command,
                    created,
                    at: now,
                };
                remember(&mut self.sent, now, sent);
                if command == name("STS") {
                    self.unanswered_beats = self.unanswered_beats.saturating_add(1);
                }
            }
            None if command == name("LOG") && early => self.logs.left_early(now),
            None if command == name("LOG") => self.logs.left(now),
            None => {}
        }
    }

    /// Handles an acknowledgement. Returns the round trip that it ends, if it is the first answer to a known command.
    /// If it may answer several commands, the oldest counts: its round trip is the longest, so none is taken to be
    /// shorter than it was.
    pub(crate) fn acknowledged(&mut self, now: Timestamp, ack: &Acknowledgement) -> Option<Heard> {
        // Some vehicles answer only what their sections of the specification say, and whatever they refuse (SPI 6.21). So a
        // refusal does not show that the vehicle answers this command at other times.
        let usual = matches!(ack.status, AckStatus::Succeeded | AckStatus::Pending);
        let sent = if ack.command == name("LOG") {
            self.logs.answered(now, ack.created)?
        } else {
            let sent = self.answered(now, ack)?;
            if sent.name == name("VER") {
                self.logs.early_is_answered();
            }
            if sent.name == name("STS") && usual {
                self.carrier = Carrier::Status;
                self.unanswered_beats = 0;
            }
            sent.at
        };
        if usual {
            self.answers.insert(ack.command);
        }
        if sent < self.began {
            // It left on another connection.
            return None;
        }
        let trip = Trip { sent, received: now };
        let good = trip.lasted() <= self.delay_max;
        self.newest = Some(trip);
        if good && self.good.is_none_or(|known| known.sent <= sent) {
            self.good = Some(trip);
            self.lost_at = sent;
            self.remedies = 0;
        }
        Some(Heard { trip, good })
    }

    /// The oldest command that this acknowledgement could answer, if one has not been answered before. If the echo has too
    /// few decimals to tell two commands apart, a second answer to one counts for no other.
    fn answered(&mut self, now: Timestamp, ack: &Acknowledgement) -> Option<Sent> {
        let echo = ack.command_created;
        if !echo.is_none() {
            self.echoes_seconds = echo.decimals() == 0;
        }
        let repeats = |older: &&Sent| older.name == ack.command && older.created == echo.time();
        if let Some(older) = self.echoed.iter().find(repeats) {
            return Some(*older);
        }
        let echoes = |sent: &Sent| sent.name == ack.command && echo.echoes(sent.created);
        let index = self.sent.iter().position(echoes)?;
        let sent = self.sent.remove(index)?;
        // Our own times are whole milliseconds.
        if echo.decimals() < 3 {
            let created = echo.time();
            remember(&mut self.echoed, now, Sent { created, ..sent });
        }
        Some(sent)
    }

    /// Whether the vehicle hears us: a good round trip whose command was sent less than 3 s ago.
    pub(crate) fn is_heard(&self, now: Timestamp) -> bool {
        self.good.is_some_and(|trip| now.since(trip.sent) < TRIP_LASTS)
    }

    /// Whether the vehicle has answered anything on this connection.
    pub(crate) const fn has_answered(&self) -> bool {
        self.newest.is_some()
    }

    /// The newest round trip, however long.
    pub(crate) const fn newest(&self) -> Option<Trip> {
        self.newest
    }

    /// When the newest good round trip stops being evidence for the link.
    pub(crate) fn lapses_at(&self) -> Option<Timestamp> {
        self.good.map(|trip| trip.sent + TRIP_LASTS)
    }

    /// Whether a command that cannot be taken back may be sent: the vehicle has just answered, and no command that it
    /// would answer has been sent since. The vehicle reads in order, so it has also read everything that was sent
    /// before the answered command.
    pub(crate) fn has_just_answered(&self, now: Timestamp) -> bool {
        let Some(trip) = self.good else { return false };
        // The vehicle may have written the answer as soon as the command had left.
        let just = now.since(trip.sent) <= JUST_NOW || now == trip.received;
        let waits = |sent: &Sent| sent.at > trip.sent && self.answers.contains(&sent.name);
        just && self.logs.none_waits_after(trip.sent) && !self.sent.iter().any(waits)
    }

    /// Whether a beat was sent so recently that its answer is as good as the answer to another one.
    pub(crate) fn beat_is_under_way(&self, now: Timestamp) -> bool {
        let recent = |at: Timestamp| now.since(at) < ANOTHER_AFTER;
        match self.carrier {
            Carrier::Status => self.sent.iter().any(|sent| sent.name == name("STS") && recent(sent.at)),
            Carrier::Logging => self.logs.last_sent().is_some_and(recent),
        }
    }

    /// Whether to send a BPLOG as the beat of this second. Called once for each BPSTS, before it is sent.
    pub(crate) fn needs_log(&mut self, now: Timestamp) -> bool {
        if self.carrier == Carrier::Status
            && self.unanswered_beats >= BEATS_WITHOUT_ANSWER
            && !self.answers.contains(&name("STS"))
            && self.has_answered()
        {
            self.carrier = Carrier::Logging;
        }
        self.logs.forget(now);
        self.carrier == Carrier::Logging && self.logs.are_quiet(now)
    }

    /// When the next beat is due after one that left now with the time `created`. If the vehicle echoes whole seconds, beats
    /// leave in the first half of a second. Then the echo of one cannot be the echo of the next too, whether the vehicle
    /// cuts the decimals off or rounds.
    pub(crate) fn next_beat(&self, now: Timestamp, created: TimeOfDay) -> Timestamp {
        if !self.echoes_seconds {
            return now + BEAT_EVERY;
        }
        let second = BEAT_EVERY.as_nanos() as u64;
        let past = created.as_nanos() % second;
        let wait = (second + second / 4 - past) % second;
        now + Duration::from_nanos(if wait == 0 { second } else { wait })
    }

    /// When the next remedy is due if no good round trip comes before.
    pub(crate) fn remedy_at(&self) -> Timestamp {
        let [first, second, third] = SUBSCRIBE_AFTER;
        let after = match self.remedies {
            0 => first,
            1 => second,
            more => third * (more - 1),
        };
        let subscribe = self.lost_at + after;
        // If BPLOG is the beat, another one makes the row of those longer whose answers cannot be told apart. So the first
        // waits as long for the last beat, and after an answer, or a second try, we wait until a beat has begun a new row.
        let subscribe = match self.carrier {
            Carrier::Status => subscribe,
            Carrier::Logging if self.remedies > 0 || self.logs.has_answer() => {
                subscribe.max(self.logs.quiet_at() + 2 * BEAT_EVERY)
            }
            Carrier::Logging => {
                let last = self.logs.last_sent().map(|sent| sent + first);
                last.map_or(subscribe, |last| last.max(subscribe))
            }
        };
        match self.good {
            Some(_) => subscribe.min(self.lost_at + RESET_AFTER),
            None => subscribe,
        }
    }

    /// The remedy that is due now, if any.
    pub(crate) fn remedy(&mut self, now: Timestamp) -> Option<Remedy> {
        if now < self.remedy_at() {
            return None;
        }
        if self.good.is_some() && now.since(self.lost_at) >= RESET_AFTER {
            self.good = None;
            return Some(Remedy::Reset);
        }
        self.remedies = self.remedies.saturating_add(1);
        self.logs.forget(now);
        Some(Remedy::Subscribe)
    }

    /// How many times we have subscribed to acknowledgements again since the last good round trip.
    pub(crate) const fn remedies(&self) -> u32 {
        self.remedies
    }
}

/// Adds a command to these, oldest first, and forgets those that will not be answered.
fn remember(commands: &mut VecDeque<Sent>, now: Timestamp, sent: Sent) {
    let forgotten = |sent: &Sent| now.since(sent.at) >= SENT_FORGOTTEN;
    while commands.len() >= SENT_MAX || commands.front().is_some_and(forgotten) {
        commands.pop_front();
    }
    commands.push_back(sent);
}

#[cfg(test)]
mod model;
#[cfg(test)]
mod tests;
