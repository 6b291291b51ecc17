//! The two-way heartbeat: whether the vehicle hears us, and how long messages take (SPI 4.4, 6.21, 7.25; safety
//! requirement 023).
//!
//! Navigation that comes does not show that our messages arrive. An acknowledgement echoes the time of its command, so
//! each one measures a round trip. We send a beat every second, so there is always a round trip to measure. The beat is
//! BPSTS. Some vehicles acknowledge only the commands whose sections say so; for them the beat is BPLOG,ACK,ON.

use std::collections::{BTreeSet, VecDeque};
use std::time::Duration;

use backseat_spi::{Acknowledgement, CommandName};
use backseat_units::{TimeOfDay, Timestamp};

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
/// How long to wait before a BPLOG is sent as a beat. An acknowledgement of BPLOG echoes no time, so an answer that is
/// still under way could be taken for the answer to another BPLOG. The wait begins with the connection, with an answer
/// while BPSTS is the beat, and with an answer that matches no BPLOG. A BPLOG that subscribes may be sent sooner. Its
/// round trip is then counted from an earlier BPLOG, so it is never taken to be shorter than it was.
const LOG_QUIET: Duration = Duration::from_secs(3);
/// How long to wait after each answer to a BPLOG. If a BPLOG arrives twice, the vehicle answers it twice, and the second
/// answer must not be taken for the answer to the next one. It matches no BPLOG then.
const LOG_SETTLES: Duration = Duration::from_millis(900);
/// A BPLOG that has no answer after this long will not get one.
const LOG_FORGOTTEN: Duration = Duration::from_secs(30);
/// A command that has no answer after this long will not get one.
const SENT_FORGOTTEN: Duration = Duration::from_secs(60);
/// How many commands without an answer are remembered.
const SENT_MAX: usize = 64;
/// How many BPLOG without an answer are remembered: several subscriptions to everything.
const LOGS_MAX: usize = 256;
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

/// A BPLOG that waits for its answer.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
struct SentLog {
    at: Timestamp,
    /// When the earliest BPLOG was sent whose answer could be taken for the answer to this one.
    since: Timestamp,
}

/// The round trips of a connection.
#[derive(Debug)]
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub(crate) struct Heartbeat {
    delay_max: Duration,
    /// Commands with a time whose first acknowledgement has not come, oldest first.
    sent: VecDeque<Sent>,
    /// Each BPLOG that waits for its answer, oldest first: the vehicle answers them in order.
    logs: VecDeque<SentLog>,
    /// [`SentLog::since`] of the BPLOG that was sent last.
    logs_since: Option<Timestamp>,
    /// When the vehicle wrote the last answer to a BPLOG, and [`SentLog::since`] of the BPLOG that it was taken to
    /// answer.
    log_answered: Option<(TimeOfDay, Timestamp)>,
    /// When a BPLOG was sent before the subscription to acknowledgements.
    early_log: Option<Timestamp>,
    /// No BPLOG is sent as a beat before this time.
    quiet_until: Timestamp,
    /// The good round trip on this connection whose command was sent last.
    good: Option<Trip>,
    /// The newest round trip on this connection, however long.
    newest: Option<Trip>,
    carrier: Carrier,
    /// How many BPSTS were sent on this connection since the vehicle last answered one.
    unanswered_beats: u32,
    /// When the command of the last good round trip was sent, or when the connection began if there has been none.
    lost_at: Timestamp,
    remedies: u32,
    /// Commands that this vehicle answers: inserts, and those that it has ever answered.
    answers: BTreeSet<CommandName>,
}

impl Heartbeat {
    /// Round trips are good up to `delay_max`.
    pub(crate) fn new(delay_max: Duration) -> Self {
        Self {
            delay_max,
            sent: VecDeque::new(),
            logs: VecDeque::new(),
            logs_since: None,
            log_answered: None,
            early_log: None,
            quiet_until: Timestamp::ZERO,
            good: None,
            newest: None,
            carrier: Carrier::Status,
            unanswered_beats: 0,
            lost_at: Timestamp::ZERO,
            remedies: 0,
            answers: INSERTS.into_iter().map(name).collect(),
        }
    }

    /// Begins a new connection. Which commands the vehicle answers is a property of the vehicle, so it is kept.
    pub(crate) fn begin(&mut self, now: Timestamp) {
        let fresh = Self::new(self.delay_max);
        *self = Self {
            carrier: self.carrier,
            answers: core::mem::take(&mut self.answers),
            quiet_until: now + LOG_QUIET,
            lost_at: now,
            ..fresh
        };
    }

    /// A command has been sent. `early` means before the subscription to acknowledgements.
    pub(crate) fn left(&mut self, now: Timestamp, command: CommandName, created: Option<TimeOfDay>, early: bool) {
        match created {
            Some(created) => {
                let forgotten = |sent: &Sent| now.since(sent.at) >= SENT_FORGOTTEN;
                while self.sent.len() >= SENT_MAX || self.sent.front().is_some_and(forgotten) {
                    self.sent.pop_front();
                }
                self.sent.push_back(Sent {
                    name: command,
                    created,
                    at: now,
                });
                if command == name("STS") {
                    self.unanswered_beats = self.unanswered_beats.saturating_add(1);
                }
            }
            None if command == name("LOG") && early => self.early_log = Some(now),
            None if command == name("LOG") => {
                if self.logs.len() >= LOGS_MAX {
                    self.logs.pop_front();
                    // Its answer may still come, and each later answer would be taken for the answer to another BPLOG.
                    self.quiet_until = self.quiet_until.max(now + LOG_FORGOTTEN);
                }
                // An answer does not say which BPLOG it answers. If one comes twice, the second is taken for the answer
                // to the next BPLOG, and so on, until no BPLOG is under way.
                let alone = self.logs.is_empty() && now >= self.quiet_until;
                let since = self.logs_since.filter(|_| !alone).unwrap_or(now);
                self.logs_since = Some(since);
                self.logs.push_back(SentLog { at: now, since });
            }
            None => {}
        }
    }

    /// Handles an acknowledgement. Returns the round trip that it ends, if it is the first answer to a known command.
    /// If it may answer several commands, the oldest counts: its round trip is the longest, so none is taken to be
    /// shorter than it was.
    pub(crate) fn acknowledged(&mut self, now: Timestamp, ack: &Acknowledgement) -> Option<Heard> {
        let sent = if ack.command == name("LOG") {
            self.log_answered(now, ack.created)?
        } else {
            let index = self
                .sent
                .iter()
                .position(|sent| sent.name == ack.command && ack.command_created.echoes(sent.created))?;
            let sent = self.sent.remove(index)?;
            if sent.name == name("VER")
                && let Some(early) = self.early_log.take()
            {
                // This vehicle answers commands that were sent before the subscription to acknowledgements.
                self.logs.push_front(SentLog {
                    at: early,
                    since: early,
                });
            }
            if sent.name == name("STS") {
                self.carrier = Carrier::Status;
                self.unanswered_beats = 0;
            }
            sent.at
        };
        self.answers.insert(ack.command);
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

    fn log_answered(&mut self, now: Timestamp, created: TimeOfDay) -> Option<Timestamp> {
        // The vehicle has not answered BPVER, so it does not answer the early BPLOG either.
        self.early_log = None;
        // A BPLOG with a later `since` was sent after the last answer had come, so an answer that was written at the
        // same time as that one is not its own.
        let repeats = |log: &SentLog| {
            self.log_answered
                .is_some_and(|(written, since)| written == created && log.since > since)
        };
        if self.logs.front().is_some_and(repeats) {
            return None;
        }
        let answered = self.logs.pop_front();
        let is_sure = answered.is_some() && self.carrier == Carrier::Logging;
        let quiet = if is_sure { LOG_SETTLES } else { LOG_QUIET };
        self.quiet_until = self.quiet_until.max(now + quiet);
        let since = answered?.since;
        self.log_answered = Some((created, since));
        Some(since)
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
        let just = now.since(trip.received) <= JUST_NOW && now.since(trip.sent) <= 2 * JUST_NOW;
        let waits = |sent: &Sent| sent.at > trip.sent && self.answers.contains(&sent.name);
        just && self.logs.iter().all(|log| log.at <= trip.sent) && !self.sent.iter().any(waits)
    }

    /// Whether a beat was sent so recently that its answer is as good as the answer to another one.
    pub(crate) fn beat_is_under_way(&self, now: Timestamp) -> bool {
        let recent = |at: Timestamp| now.since(at) < ANOTHER_AFTER;
        match self.carrier {
            Carrier::Status => self.sent.iter().any(|sent| sent.name == name("STS") && recent(sent.at)),
            Carrier::Logging => self.logs.back().is_some_and(|log| recent(log.at)),
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
        self.forget_logs(now);
        self.carrier == Carrier::Logging && self.logs.is_empty() && now >= self.quiet_until
    }

    fn forget_logs(&mut self, now: Timestamp) {
        if self.logs.back().is_some_and(|log| now.since(log.at) >= LOG_FORGOTTEN) {
            self.logs.clear();
        }
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
        // If BPLOG is the beat and an answer to one was lost, each later answer would be taken for the answer to the
        // BPLOG before, for ever. So none is sent until all that are under way would have been answered.
        let subscribe = match self.logs.back() {
            Some(last) if self.carrier == Carrier::Logging && self.remedies >= 3 => {
                subscribe.max(last.at + LOG_FORGOTTEN)
            }
            Some(_) | None => subscribe,
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
        self.forget_logs(now);
        Some(Remedy::Subscribe)
    }

    /// How many times we have subscribed to acknowledgements again since the last good round trip.
    pub(crate) const fn remedies(&self) -> u32 {
        self.remedies
    }
}

#[cfg(test)]
mod tests {
    use backseat_spi::{AckStatus, EchoedTime, Text};

    use super::*;

    const DELAY_MAX: Duration = Duration::from_secs(1);

    fn stamp(millis: u64) -> TimeOfDay {
        TimeOfDay::from_nanos((10_000_000 + millis) * 1_000_000).unwrap()
    }

    fn at(millis: u64) -> Timestamp {
        Timestamp::from_millis(millis)
    }

    fn ack(letters: &'static str, echo: EchoedTime) -> Acknowledgement {
        Acknowledgement {
            created: TimeOfDay::MIDNIGHT,
            command: name(letters),
            command_created: echo,
            behavior: None,
            status: AckStatus::Succeeded,
            text: Text::cleaned(""),
        }
    }

    /// An answer to a BPLOG, written at this time.
    fn log_answer(millis: u64) -> Acknowledgement {
        Acknowledgement {
            created: stamp(millis),
            ..ack("LOG", EchoedTime::NONE)
        }
    }

    fn connected() -> Heartbeat {
        let mut heartbeat = Heartbeat::new(DELAY_MAX);
        heartbeat.begin(at(0));
        heartbeat
    }

    /// Sends a BPSTS at one time, and its answer comes at another.
    fn beat(heartbeat: &mut Heartbeat, sent: u64, answered: u64) -> Option<Heard> {
        heartbeat.left(at(sent), name("STS"), Some(stamp(sent)), false);
        heartbeat.acknowledged(at(answered), &ack("STS", EchoedTime::of(stamp(sent))))
    }

    #[test]
    fn sr_023_a_good_round_trip_counts_for_3_s_from_when_its_command_was_sent() {
        let mut heartbeat = connected();
        assert!(!heartbeat.is_heard(at(0)));
        assert!(beat(&mut heartbeat, 100, 1100).unwrap().good);
        assert!(heartbeat.is_heard(at(3099)) && !heartbeat.is_heard(at(3100)));
        assert_eq!(heartbeat.lapses_at(), Some(at(3100)));
        assert!(!beat(&mut heartbeat, 3000, 4001).unwrap().good);
        assert!(!heartbeat.is_heard(at(4001)));
        heartbeat.begin(at(4100));
        assert!(
            !heartbeat.is_heard(at(4100)),
            "the round trip was on another connection"
        );
    }

    #[test]
    fn sr_023_only_the_first_answer_to_a_sent_command_counts() {
        let mut heartbeat = connected();
        assert!(beat(&mut heartbeat, 100, 110).is_some());
        let again = ack("STS", EchoedTime::of(stamp(100)));
        assert_eq!(heartbeat.acknowledged(at(2000), &again), None);
        let never_sent = ack("STS", EchoedTime::of(stamp(900)));
        assert_eq!(heartbeat.acknowledged(at(2000), &never_sent), None);
        heartbeat.left(at(2000), name("STS"), Some(stamp(2000)), false);
        assert_eq!(heartbeat.acknowledged(at(2001), &ack("STS", EchoedTime::NONE)), None);
        assert_eq!(heartbeat.acknowledged(at(2001), &ack("NAK", EchoedTime::NONE)), None);
    }

    #[test]
    fn sr_023_an_echo_that_matches_two_commands_counts_for_the_older() {
        let mut heartbeat = connected();
        heartbeat.left(at(100), name("RMB"), Some(stamp(100)), false);
        heartbeat.left(at(300), name("RMB"), Some(stamp(300)), false);
        let echo = EchoedTime::with_decimals(stamp(300), 0);
        let heard = heartbeat.acknowledged(at(310), &ack("RMB", echo)).unwrap();
        assert_eq!(heard.trip.lasted(), Duration::from_millis(210));
    }

    #[test]
    fn sr_023_if_only_status_is_not_answered_subscriptions_are_the_beat_one_at_a_time() {
        let mut heartbeat = connected();
        heartbeat.left(at(0), name("LOG"), None, false);
        assert!(heartbeat.acknowledged(at(10), &log_answer(9)).unwrap().good);
        let mut logs = Vec::new();
        for second in 0..20u64 {
            let now = 20 + second * 1000;
            if heartbeat.needs_log(at(now)) {
                heartbeat.left(at(now), name("LOG"), None, false);
                logs.push(second);
                if second < 10 {
                    let heard = heartbeat.acknowledged(at(now + 5), &log_answer(now + 4));
                    assert_eq!(heard.unwrap().trip.lasted(), Duration::from_millis(5));
                }
            }
            heartbeat.left(at(now), name("STS"), Some(stamp(now)), false);
        }
        // The BPLOG that was sent at 10 s is not answered, and no other follows it.
        assert_eq!(logs, [4, 5, 6, 7, 8, 9, 10]);
        assert!(!heartbeat.is_heard(at(20_000)));
        // Its answer comes late, and is taken for its own.
        let late = heartbeat.acknowledged(at(20_500), &log_answer(20_400)).unwrap();
        assert!(!late.good && late.trip.lasted() > Duration::from_secs(10));
    }

    #[test]
    fn sr_023_a_lost_answer_to_a_subscription_costs_a_minute_and_not_the_day() {
        let mut heartbeat = connected();
        heartbeat.left(at(0), name("LOG"), None, false);
        heartbeat.acknowledged(at(10), &log_answer(9));
        let mut heard = Vec::new();
        for second in 0..200u64 {
            let now = 20 + second * 1000;
            let beat = heartbeat.needs_log(at(now));
            let subscribe = heartbeat.remedy(at(now)) == Some(Remedy::Subscribe);
            for _ in 0..u32::from(beat) + u32::from(subscribe) {
                heartbeat.left(at(now), name("LOG"), None, false);
                // One of the answers is damaged on its way.
                if second != 20 {
                    heartbeat.acknowledged(at(now + 5), &log_answer(now + 4));
                }
            }
            heartbeat.left(at(now), name("STS"), Some(stamp(now)), false);
            if heartbeat.is_heard(at(now + 6)) {
                heard.push(second);
            }
        }
        assert!(heard.contains(&19) && !heard.contains(&30), "{heard:?}");
        assert!((85..200).all(|second| heard.contains(&second)), "{heard:?}");
    }

    #[test]
    fn sr_023_a_repeated_answer_is_no_round_trip_of_the_next_subscription() {
        let mut heartbeat = connected();
        let subscribe = |heartbeat: &mut Heartbeat, millis| {
            for _ in 0..3 {
                heartbeat.left(at(millis), name("LOG"), None, false);
            }
        };
        // The vehicle hears us only after 2 s, when everything has been sent again. One of its answers comes twice, and
        // then the others come.
        subscribe(&mut heartbeat, 0);
        subscribe(&mut heartbeat, 2000);
        for (answered, written) in [
            (2010, 2000),
            (2010, 2000),
            (2010, 2000),
            (2011, 2001),
            (4010, 4000),
            (4010, 4000),
        ] {
            let heard = heartbeat.acknowledged(at(answered), &log_answer(written)).unwrap();
            assert_eq!(heard.trip.sent, at(0), "{answered}");
            assert!(!heartbeat.is_heard(at(answered)));
        }
        assert_eq!(
            heartbeat.acknowledged(at(4011), &log_answer(4000)),
            None,
            "no BPLOG waits for an answer"
        );
        // An answer that is under way now could belong to an earlier BPLOG.
        heartbeat.left(at(5000), name("LOG"), None, false);
        assert!(!heartbeat.acknowledged(at(5010), &log_answer(5005)).unwrap().good);
        heartbeat.left(at(8010), name("LOG"), None, false);
        assert!(heartbeat.acknowledged(at(8020), &log_answer(8015)).unwrap().good);
    }

    #[test]
    fn sr_023_if_subscriptions_are_the_beat_a_repeated_answer_counts_once() {
        let mut heartbeat = connected();
        heartbeat.left(at(0), name("LOG"), None, false);
        heartbeat.acknowledged(at(10), &log_answer(9));
        for millis in [1000, 2000, 3000, 4000] {
            heartbeat.left(at(millis), name("STS"), Some(stamp(millis)), false);
        }
        assert!(heartbeat.needs_log(at(5000)));
        heartbeat.left(at(5000), name("LOG"), None, false);
        assert!(!heartbeat.acknowledged(at(8000), &log_answer(6500)).unwrap().good);
        // The same answer comes again when the next BPLOG has just been sent.
        assert!(heartbeat.needs_log(at(9000)));
        heartbeat.left(at(9000), name("LOG"), None, false);
        assert_eq!(heartbeat.acknowledged(at(9001), &log_answer(6500)), None);
        assert!(!heartbeat.is_heard(at(9001)) && !heartbeat.needs_log(at(10_000)));
        let heard = heartbeat.acknowledged(at(12_000), &log_answer(10_500)).unwrap();
        assert_eq!(heard.trip.sent, at(9000));
        assert!(!heartbeat.is_heard(at(12_000)));
    }

    #[test]
    fn sr_023_if_subscriptions_are_the_beat_and_arrive_twice_no_answer_is_taken_for_the_next_one() {
        for takes in (1100..4100u64).step_by(20) {
            let mut heartbeat = connected();
            heartbeat.left(at(0), name("LOG"), None, false);
            heartbeat.acknowledged(at(10), &log_answer(9));
            for millis in [1000, 2000, 3000, 4000] {
                heartbeat.left(at(millis), name("STS"), Some(stamp(millis)), false);
            }
            // The way there and back is long, and everything that we send arrives twice: each BPLOG has two answers, which
            // the vehicle writes at times of their own.
            let mut answers = VecDeque::new();
            let mut sent = 0;
            for millis in (5000..60_000u64).step_by(10) {
                while answers.front().is_some_and(|(comes, _)| *comes <= millis) {
                    let (comes, written) = answers.pop_front().unwrap();
                    heartbeat.acknowledged(at(comes), &log_answer(written));
                }
                if millis.is_multiple_of(1000) && heartbeat.needs_log(at(millis)) {
                    sent += 1;
                    heartbeat.left(at(millis), name("LOG"), None, false);
                    let written = millis + takes / 2;
                    answers.extend([(millis + takes, written), (millis + takes + 50, written + 50)]);
                }
                assert!(!heartbeat.is_heard(at(millis)), "{takes}: {millis}");
            }
            assert!(sent > 5, "{takes}: {sent} beats");
        }
    }

    #[test]
    fn sr_023_answers_that_take_a_while_leave_no_gap_between_beats_of_subscriptions() {
        for takes in [5, 400, 1000] {
            let mut heartbeat = connected();
            heartbeat.left(at(0), name("LOG"), None, false);
            heartbeat.acknowledged(at(10), &log_answer(9));
            for millis in [1000, 2000, 3000, 4000] {
                heartbeat.left(at(millis), name("STS"), Some(stamp(millis)), false);
            }
            let mut comes = None;
            for millis in (5000..60_000u64).step_by(5) {
                if comes == Some(millis) {
                    heartbeat.acknowledged(at(millis), &log_answer(millis - 2));
                }
                if millis.is_multiple_of(1000) && heartbeat.needs_log(at(millis)) {
                    heartbeat.left(at(millis), name("LOG"), None, false);
                    comes = Some(millis + takes);
                }
                assert!(millis < 6000 || heartbeat.is_heard(at(millis)), "{takes}: {millis}");
            }
        }
    }

    #[test]
    fn sr_023_more_subscriptions_than_are_remembered_make_no_late_answer_look_prompt() {
        for (sent, answered) in [(100, 64), (LOGS_MAX + 20, LOGS_MAX)] {
            let mut heartbeat = connected();
            heartbeat.left(at(0), name("LOG"), None, false);
            heartbeat.acknowledged(at(10), &log_answer(9));
            for millis in [1000, 2000, 3000, 4000] {
                heartbeat.left(at(millis), name("STS"), Some(stamp(millis)), false);
            }
            assert!(heartbeat.needs_log(at(5000)), "BPLOG is the beat");
            // On a link that takes 11 s, everything is subscribed again and again. The first answers come.
            for _ in 0..sent {
                heartbeat.left(at(5000), name("LOG"), None, false);
            }
            for written in 10_000..10_000 + answered as u64 {
                heartbeat.acknowledged(at(16_000), &log_answer(written));
            }
            // The next answer belongs to a BPLOG of 11 s ago, and not to the one that has just been sent.
            heartbeat.left(at(16_100), name("LOG"), None, false);
            heartbeat.acknowledged(at(16_200), &log_answer(11_000));
            assert!(!heartbeat.is_heard(at(16_200)), "{sent} subscriptions");
        }
    }

    #[test]
    fn a_vehicle_that_answers_nothing_gets_no_subscriptions_as_beats() {
        let mut heartbeat = connected();
        for second in 0..60u64 {
            assert!(!heartbeat.needs_log(at(second * 1000)));
            heartbeat.left(at(second * 1000), name("STS"), Some(stamp(second * 1000)), false);
        }
    }

    #[test]
    fn with_early_answers_round_trips_count_from_the_first_command() {
        let mut heartbeat = connected();
        heartbeat.left(at(0), name("VER"), Some(stamp(0)), true);
        heartbeat.left(at(0), name("LOG"), None, true);
        heartbeat.left(at(1000), name("LOG"), None, false);
        heartbeat.acknowledged(at(1500), &ack("VER", EchoedTime::of(stamp(0))));
        let first = heartbeat.acknowledged(at(1500), &log_answer(1000)).unwrap();
        assert_eq!(first.trip.sent, at(0));
        let second = heartbeat.acknowledged(at(2500), &log_answer(2000)).unwrap();
        assert_eq!(second.trip.sent, at(1000));
    }

    #[test]
    fn sr_023_an_irrevocable_command_needs_an_answer_of_this_second_and_none_outstanding() {
        let mut heartbeat = connected();
        beat(&mut heartbeat, 1000, 1010);
        assert!(heartbeat.has_just_answered(at(2010)) && !heartbeat.has_just_answered(at(2011)));
        beat(&mut heartbeat, 2000, 2010);
        heartbeat.left(at(2020), name("STS"), Some(stamp(2020)), false);
        assert!(!heartbeat.has_just_answered(at(2030)), "a beat is under way");
        heartbeat.acknowledged(at(2040), &ack("STS", EchoedTime::of(stamp(2020))));
        // A kind of command that this vehicle has never answered is not waited for, unless it is an insert.
        heartbeat.left(at(2050), name("MSG"), Some(stamp(2050)), false);
        assert!(heartbeat.has_just_answered(at(2060)));
        heartbeat.left(at(2070), name("RGP"), Some(stamp(2070)), false);
        assert!(!heartbeat.has_just_answered(at(2080)));
        heartbeat.acknowledged(at(2090), &ack("RGP", EchoedTime::of(stamp(2070))));
        assert!(heartbeat.has_just_answered(at(2090)));
    }

    #[test]
    fn acknowledgements_are_subscribed_again_after_3_6_and_12_s_and_a_good_connection_is_reset_after_30() {
        let mut heartbeat = connected();
        beat(&mut heartbeat, 1000, 1010);
        let mut done = Vec::new();
        for millis in (1000..60_000).step_by(100) {
            if let Some(remedy) = heartbeat.remedy(at(millis)) {
                done.push((millis, remedy));
            }
        }
        use Remedy::{Reset, Subscribe};
        assert_eq!(
            done[..5],
            [
                (4000, Subscribe),
                (7000, Subscribe),
                (13_000, Subscribe),
                (25_000, Subscribe),
                (31_000, Reset)
            ]
        );
        assert!(done[5..].iter().all(|(_, remedy)| *remedy == Subscribe), "{done:?}");
    }
}
