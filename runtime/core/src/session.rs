//! The session: connection, subscriptions, the plan's asking, silence, status (SPI 4, 7.1, 7.2, 7.19, 7.25).

use std::time::Duration;

use backseat_spi::{
    Acknowledgement, CommandName, LoggingControl, PayloadStatus, PayloadVersion, RequestPlan, Text, ToVehicle,
};
use backseat_units::{TimeOfDay, Timestamp};

use crate::commands::{Answer, Command, FIRST_WITHIN, PLAN_WITHIN, Purpose};
use crate::conductor::Slot;
use crate::context::Context;
use crate::expected::Compared;
use crate::heartbeat::{BEAT_EVERY, Remedy};
use crate::io::{Note, Output};
use crate::machine::Core;
use crate::plugin::RequestState;
use crate::reads::Reads;
use crate::settings::StatusCondition;
use crate::subscriptions::{self, ACKNOWLEDGEMENTS};
use crate::switches::{Check, is_on};
use crate::timer::Timer;

/// The interface that we speak.
const VERSION: &str = "1.12";
/// Navigation comes at 10 Hz: nothing for this long, and we subscribe anew.
const SILENT: Duration = Duration::from_secs(5);
/// Nothing for this many times in a row, and the connection is reset.
const SILENCES_MAX: u32 = 3;
const PLAN_RETRY: Duration = Duration::from_secs(5);
/// So often a minute the vehicle's words have its plan asked for at once, and past that after a pause.
const PLAN_ASKS_PER_MIN: u32 = 6;
const PLAN_ASKED_ANEW: Duration = Duration::from_secs(10);
/// What was not told of control when it changed too often is told so often.
const CATCH_UP_EVERY: Duration = Duration::from_secs(10);
const RETRY_MIN_S: f64 = 0.5;
/// The longest pause between two attempts to connect, chance included.
const RETRY_MAX_S: f64 = 10.0;
/// Subscriptions that are not answered are sent again after 2, 4, 8, 16 and then every 32 s: there are vehicles that
/// never acknowledge, and their link is not to be filled with asking.
const SUBSCRIPTION_DOUBLINGS: u32 = 4;
/// Changes of control that are told of at once, and how long until one more is: a vehicle that hands over and takes back
/// ten times a second does not fill the log.
const CONTROL_NOTES: u32 = 8;
const CONTROL_NOTE_EVERY: Duration = Duration::from_secs(5);
/// A change of the vehicle's clock against ours that is told of, nanoseconds.
const CLOCK_STEP_NANOS: i64 = 500_000_000;
const CLOCK_NOTE_EVERY: Duration = Duration::from_secs(10);

/// Where the connection stands.
#[derive(Debug)]
pub(crate) struct Session {
    up: bool,
    pub(crate) reads: Reads,
    /// Connections tried since navigation last came.
    attempts: u32,
    /// How often in a row navigation has not come.
    silences: u32,
    subscriptions: Vec<&'static str>,
    /// Which of them the vehicle has acknowledged, or has sent the data of, on this connection.
    confirmed: Vec<bool>,
    /// How often each has been sent on this connection without an answer.
    unanswered: Vec<u32>,
    /// How many are not confirmed.
    unconfirmed: usize,
    /// Acknowledgements have been subscribed on this connection.
    acknowledged: bool,
    malformed: u64,
    /// That nothing is acknowledged has been told on this connection.
    unheard_told: bool,
    /// The vehicle's clock as it was last told of on this connection, and when.
    clock_told: Option<(i64, Timestamp)>,
    control_notes: ControlNotes,
}

/// How many changes of control are still told of, and what has not been.
#[derive(Debug)]
struct ControlNotes {
    left: u32,
    /// When one more was let through last.
    refilled: Timestamp,
    untold: u64,
    /// When that was last looked at.
    caught_up: Timestamp,
    /// What was last told.
    told: bool,
}

impl Session {
    pub(crate) fn new(plugins: &[Slot]) -> Self {
        let subscriptions = subscriptions::of(plugins);
        Self {
            up: false,
            reads: Reads::default(),
            attempts: 0,
            silences: 0,
            confirmed: vec![false; subscriptions.len()],
            unanswered: vec![0; subscriptions.len()],
            unconfirmed: subscriptions.len(),
            acknowledged: false,
            subscriptions,
            malformed: 0,
            unheard_told: false,
            clock_told: None,
            control_notes: ControlNotes {
                left: CONTROL_NOTES,
                refilled: Timestamp::ZERO,
                untold: 0,
                caught_up: Timestamp::ZERO,
                told: false,
            },
        }
    }

    /// A new connection: nothing is subscribed on it.
    fn begin(&mut self) {
        self.up = true;
        self.silences = 0;
        self.malformed = 0;
        self.unheard_told = false;
        self.clock_told = None;
        self.acknowledged = false;
        self.doubt_subscriptions();
    }

    /// The vehicle may have none of the subscriptions.
    fn doubt_subscriptions(&mut self) {
        self.confirmed.fill(false);
        self.unanswered.fill(0);
        self.unconfirmed = self.subscriptions.len();
    }

    /// The vehicle may not have the subscription at this place of the list, though it seemed to be answered: the answers to
    /// BPLOG do not say to which (SPI 7.1).
    fn doubt_subscription(&mut self, index: usize) {
        self.unanswered[index] = 0;
        if core::mem::take(&mut self.confirmed[index]) {
            self.unconfirmed += 1;
        }
    }

    /// The messages that are subscribed, in order.
    pub(crate) fn subscriptions(&self) -> &[&'static str] {
        &self.subscriptions
    }

    /// A message has come, `BFNVG`: its subscription stands, whatever became of the acknowledgement.
    pub(crate) fn confirm_by_data(&mut self, message: &str) {
        if self.unconfirmed == 0 {
            return;
        }
        for index in 0..self.subscriptions.len() {
            if message.strip_prefix("BF") == Some(self.subscriptions[index]) {
                self.confirm(index);
            }
        }
    }

    fn confirm(&mut self, index: usize) {
        self.unanswered[index] = 0;
        if !self.confirmed[index] {
            self.confirmed[index] = true;
            self.unconfirmed -= 1;
        }
    }

    pub(crate) const fn is_up(&self) -> bool {
        self.up
    }

    /// Whether the vehicle has acknowledged the subscription to a message on this connection, or sent the message.
    pub(crate) fn is_subscribed(&self, message: &str) -> bool {
        let mut both = self.subscriptions.iter().zip(&self.confirmed);
        both.any(|(subscription, confirmed)| *subscription == message && *confirmed)
    }

    /// Counts a sentence that cannot be read; how many there were. Told at 1, 10, 100, ...
    pub(crate) fn malformed(&mut self) -> Option<u64> {
        self.malformed += 1;
        is_told(self.malformed).then_some(self.malformed)
    }

    /// Navigation came: the connection is good.
    pub(crate) fn heard_navigation(&mut self) {
        self.attempts = 0;
        self.silences = 0;
    }
}

impl Core {
    pub(crate) fn link_up(&mut self) {
        self.cx.framer.clear();
        self.cx.tracker.reset();
        self.capabilities.station.reset();
        self.cx.relative.reset();
        self.cx.cartesian.reset();
        self.cx.commands.clear();
        self.cx.plan.forget();
        self.cx.compared = Compared::default();
        self.cx.handed_over = None;
        self.cx.running = None;
        self.cx.session.begin();
        self.cx.heartbeat.begin(self.cx.now);
        self.cx.session.reads.begin(self.cx.now);
        self.cx.note(Note::LinkUp);
        let created = self.cx.stamper.stamp(self.cx.now, "VER");
        let version = ToVehicle::PayloadVersion(PayloadVersion {
            created,
            version: Text::cleaned(VERSION),
        });
        let command = self.cx.early("VER", Some(created));
        self.cx.transmit(&version, Some(command));
        self.cx.subscribe_all();
        self.cx.ask_for_plan();
        self.orders.link_up(&mut self.cx, &mut self.capabilities);
        self.capabilities.inserts.link_up(&mut self.cx);
        if self.cx.held && is_on(Check::HoldCancels) {
            // The operator may have taken the helm while nothing could be sent.
            self.capabilities.inserts.take_back_all(&mut self.cx, None);
            self.capabilities.inserts.cancel_former(&mut self.cx);
        }
        self.cx.timers.set(Timer::Silence, self.cx.now + SILENT);
        self.cx.beat();
    }

    pub(crate) fn link_down(&mut self) {
        // No BPEMB reaches the vehicle: its own clock ends the modify (safety requirement 007).
        self.cx.session.up = false;
        self.cx.former.link_lost();
        if self.cx.ledger.interrupts() {
            self.cx.courses.leave_plan();
        }
        self.cx.courses.lose();
        self.capabilities.end_leases(&mut self.cx, "the link is down");
        self.cx.handed_over = None;
        self.cx.running = None;
        self.cx.commands.clear();
        self.cx.plan.forget();
        self.cx.compared = Compared::default();
        self.cx.tracker.reset();
        self.capabilities.station.reset();
        self.cx.relative.reset();
        self.cx.cartesian.reset();
        self.capabilities.silent.link_lost(&mut self.cx);
        self.capabilities.adjustments.link_lost(&mut self.cx);
        self.capabilities.acoustic.link_lost(&mut self.cx);
        self.capabilities.dvl.link_lost(&mut self.cx);
        self.orders.link_lost(&mut self.cx);
        self.capabilities.inserts.link_lost(&mut self.cx);
        let undecided: Vec<(u64, bool)> = self
            .cx
            .ledger
            .iter()
            .filter(|(_, entry)| matches!(entry.state, RequestState::Sent | RequestState::Pending))
            .map(|(request, entry)| (request, entry.is_open_insert()))
            .collect();
        for (request, insert) in undecided {
            // What has no identifier of its own cannot be resolved by one.
            let to = if insert {
                RequestState::Unknown
            } else {
                RequestState::TimedOut
            };
            self.cx.transition(request, to);
        }
        for timer in [Timer::Silence, Timer::Plan, Timer::Status, Timer::Heartbeat] {
            self.cx.timers.stop(timer);
        }
        if self.cx.stopping {
            return;
        }
        let after_s = self.cx.retry_s();
        self.cx.note(Note::LinkDown {
            counts: self.cx.framer.counts(),
            retry_s: after_s,
        });
        self.cx.outputs.push_back(Output::Connect {
            after: Duration::from_secs_f64(after_s),
        });
        self.cx.session.attempts = self.cx.session.attempts.saturating_add(1);
    }

    pub(crate) fn plan_answered(&mut self, answer: Answer<'_>) {
        match answer {
            // The series follows its own pending acknowledgement; what came before is of an earlier asking.
            Answer::Pending => self.cx.begin_plan(),
            Answer::Done => {
                if self.cx.plan.end(self.cx.framer.counts().lost()) {
                    self.cx.note(Note::Plan {
                        elements: self.cx.plan.len(),
                    });
                    self.cx.dive_planned();
                    if self.cx.compare_plan() {
                        // Once more, for the day when two answers came mixed.
                        self.cx.timers.set(Timer::Plan, self.cx.now + PLAN_RETRY);
                    }
                    self.capabilities.inserts.resolve_by_plan(&mut self.cx);
                    self.cx.former_in_plan();
                    self.cx.tell_of_plan();
                    self.capabilities.inserts.judge_waiting(&mut self.cx);
                    if self.cx.held && is_on(Check::HoldCancels) {
                        self.capabilities.inserts.cancel_former(&mut self.cx);
                    }
                } else {
                    self.cx.plan_failed();
                }
            }
            Answer::Refused(_) | Answer::Missing => self.cx.plan_failed(),
        }
    }

    pub(crate) fn navigation_came(&mut self) {
        self.cx.session.heard_navigation();
        self.cx.timers.set(Timer::Silence, self.cx.now + SILENT);
        self.cx.watch_clock();
        self.capabilities.inserts.watch_schedules(&mut self.cx);
    }

    /// An acknowledgement may end a round trip.
    pub(crate) fn round_trip(&mut self, ack: &Acknowledgement) {
        let Some(heard) = self.cx.heartbeat.acknowledged(self.cx.now, ack) else {
            return;
        };
        let utc = self.cx.utc();
        if let Some(step) = self.cx.tracker.measured(heard.trip, utc, ack.created) {
            let text = format!("the vehicle's clock was set by {:+.3} s", -(step as f64) / 1e9);
            self.cx.note(Note::Navigation { text });
            self.capabilities
                .end_leases(&mut self.cx, "the vehicle's clock was set");
        }
        if heard.good {
            self.cx.session.unheard_told = false;
            if self.cx.session.clock_told.is_none() {
                self.cx.tell_of_clock(ack.created);
            }
        }
    }
}

impl Context {
    /// A command whose answer is taken note of and no more.
    pub(crate) fn courtesy(&self, command: &'static str, created: Option<TimeOfDay>) -> Command {
        Command {
            name: name(command),
            created,
            identifier: None,
            purpose: Purpose::Courtesy,
            deadline: self.now + 2 * FIRST_WITHIN,
            pending: false,
        }
    }

    /// Why the vehicle does not hear us; `None` where it does (safety requirement 023).
    pub(crate) fn unheard(&self) -> Option<&'static str> {
        if self.heartbeat.is_heard(self.now) || !is_on(Check::Heard) {
            None
        } else if self.heartbeat.has_answered() {
            Some("the vehicle does not answer in time")
        } else {
            Some("the vehicle has not answered yet")
        }
    }

    /// Control has changed hands: told at once, unless it does so all the time.
    pub(crate) fn tell_of_control(&mut self, reason: &str) {
        let granted = self.granted;
        let notes = &mut self.session.control_notes;
        let every = CONTROL_NOTE_EVERY.as_nanos();
        let refill = u32::try_from(self.now.since(notes.refilled).as_nanos() / every).unwrap_or(u32::MAX);
        if refill > 0 {
            notes.left = notes.left.saturating_add(refill).min(CONTROL_NOTES);
            notes.refilled = self.now;
        }
        if notes.left == 0 {
            notes.untold += 1;
            return;
        }
        notes.left -= 1;
        notes.told = granted;
        self.note(Note::Control {
            granted,
            reason: reason.to_owned(),
        });
    }

    /// What was not told of control when it changed too often.
    pub(crate) fn catch_up_on_control(&mut self) {
        let granted = self.granted;
        let notes = &mut self.session.control_notes;
        if self.now.since(notes.caught_up) < CATCH_UP_EVERY {
            return;
        }
        notes.caught_up = self.now;
        let untold = std::mem::take(&mut notes.untold);
        if untold == 0 {
            return;
        }
        let changed = std::mem::replace(&mut notes.told, granted) != granted;
        self.note(Note::Text {
            text: format!("control has changed hands {untold} times more"),
        });
        if changed {
            self.note(Note::Control {
                granted,
                reason: self.lost_because().unwrap_or("").to_owned(),
            });
        }
    }

    /// The second's BPSTS (SPI 7.2), and what carries the beat beside it where the vehicle does not answer that.
    pub(crate) fn beat(&mut self) {
        self.catch_up_on_control();
        self.tell_what_was_counted();
        if self.heartbeat.needs_log(self.now) {
            self.subscribe_acknowledgements(Purpose::Beat);
        }
        self.send_status();
        self.timers.set(Timer::Status, self.now + BEAT_EVERY);
    }

    pub(crate) fn send_status(&mut self) {
        let failed = self
            .settings
            .status_failed_when
            .iter()
            .any(|condition| match condition {
                StatusCondition::PluginQuarantined => self.plugins.iter().any(Slot::is_quarantined),
                StatusCondition::NavigationStale => self.tracker.fresh(self.now).is_none(),
            });
        let text = match (self.arbiter.is_steering(), self.lost_because()) {
            (true, _) => "steering",
            (false, None) => "has control",
            (false, Some(reason)) => reason,
        };
        let created = self.stamper.stamp(self.now, "STS");
        let status = PayloadStatus {
            created,
            ok: !failed,
            text: Text::cleaned(text),
        };
        let command = self.courtesy("STS", Some(created));
        self.transmit(&ToVehicle::PayloadStatus(status), Some(command));
    }

    pub(crate) fn subscribe_acknowledgements(&mut self, purpose: Purpose) {
        let message = ToVehicle::LoggingControl(LoggingControl {
            message: Text::cleaned(ACKNOWLEDGEMENTS),
            on: true,
        });
        let command = Command {
            purpose,
            ..self.courtesy("LOG", None)
        };
        self.transmit(&message, Some(command));
    }

    /// Doubled at each attempt, half of it by chance, so that payloads that lost the vehicle together do not come back
    /// together.
    pub(crate) fn retry_s(&self) -> f64 {
        let doubled = 2.0 * RETRY_MIN_S * f64::from(1u32 << self.session.attempts.min(5));
        let mut bits = self.start.jitter ^ u64::from(self.session.attempts) ^ self.now.as_nanos();
        // The finaliser of splitmix64 (Steele, Lea, Flood, OOPSLA 2014): every bit of the state counts.
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        let chance = ((bits ^ (bits >> 31)) >> 11) as f64 / (1u64 << 53) as f64;
        doubled.min(RETRY_MAX_S) * (0.5 + 0.5 * chance)
    }

    pub(crate) fn subscribe_all(&mut self) {
        for index in 0..self.session.subscriptions.len() {
            self.subscribe(index);
        }
    }

    /// A message stays away that was subscribed.
    pub(crate) fn subscribe_anew(&mut self, message: &str) {
        let index = self.session.subscriptions.iter().position(|known| *known == message);
        if let Some(index) = index {
            self.session.doubt_subscription(index);
            self.subscribe(index);
        }
    }

    pub(crate) fn subscribe(&mut self, index: usize) {
        let subject = self.session.subscriptions[index];
        let message = ToVehicle::LoggingControl(LoggingControl {
            message: Text::cleaned(subject),
            on: true,
        });
        self.session.acknowledged |= subject == ACKNOWLEDGEMENTS;
        let command = if self.session.acknowledged {
            let doublings = self.session.unanswered[index].min(SUBSCRIPTION_DOUBLINGS);
            self.session.unanswered[index] += 1;
            Command {
                name: name("LOG"),
                created: None,
                identifier: None,
                purpose: Purpose::Subscription(index),
                deadline: self.now + 2 * FIRST_WITHIN * (1 << doublings),
                pending: false,
            }
        } else {
            self.early("LOG", None)
        };
        self.transmit(&message, Some(command));
    }

    /// A command that leaves before acknowledgements are asked for.
    pub(crate) fn early(&self, letters: &'static str, created: Option<TimeOfDay>) -> Command {
        Command {
            purpose: Purpose::Early,
            ..self.courtesy(letters, created)
        }
    }

    pub(crate) fn subscription_answered(&mut self, index: usize, answer: Answer<'_>) {
        match answer {
            Answer::Pending => {}
            Answer::Done => self.session.confirm(index),
            Answer::Refused(text) => {
                let message = self.session.subscriptions[index];
                self.note(Note::Text {
                    text: format!("the vehicle refused the subscription to BF{message}: {text}"),
                });
            }
            // What it asked for may come all the same.
            Answer::Missing if self.session.confirmed[index] => {}
            Answer::Missing => self.subscribe(index),
        }
    }

    pub(crate) fn ask_for_plan(&mut self) {
        if self.plan.is_collecting() {
            return;
        }
        let created = self.stamper.stamp(self.now, "RMP");
        let command = Command {
            name: name("RMP"),
            created: Some(created),
            identifier: None,
            purpose: Purpose::Plan,
            deadline: self.now + PLAN_WITHIN,
            pending: false,
        };
        if self.transmit(&ToVehicle::RequestPlan(RequestPlan { created }), Some(command)) {
            self.plan.asked(self.now);
            self.begin_plan();
        }
    }

    /// What the vehicle says makes its plan worth asking for. It may say so a hundred times a second: then it is asked for
    /// now and then.
    pub(crate) fn want_plan(&mut self) {
        if self.plan_asks.has_room(self.now, PLAN_ASKS_PER_MIN) {
            self.plan_asks.add(self.now);
            return self.ask_for_plan();
        }
        self.timers.set_unless_set(Timer::Plan, self.now + PLAN_ASKED_ANEW);
    }

    pub(crate) fn begin_plan(&mut self) {
        self.plan.begin(self.framer.counts().lost());
    }

    /// The plan did not come: it is asked for again.
    pub(crate) fn plan_failed(&mut self) {
        self.plan.fail();
        self.timers.set(Timer::Plan, self.now + PLAN_RETRY);
    }

    /// Tells of the vehicle's clock where it has moved against ours since it was last told on this connection, which the
    /// first round trip does.
    pub(crate) fn watch_clock(&mut self) {
        let Some(offset) = self.tracker.clock().offset_nanos(self.now) else {
            return;
        };
        let told = self.session.clock_told;
        let moved = told.is_some_and(|(told, at)| {
            offset.abs_diff(told) >= CLOCK_STEP_NANOS.unsigned_abs() && self.now.since(at) >= CLOCK_NOTE_EVERY
        });
        if !moved {
            return;
        }
        if let Some(written) = self.tracker.written() {
            self.tell_of_clock(written);
        }
    }

    /// Tells of the vehicle's clock, which has just said `written`.
    pub(crate) fn tell_of_clock(&mut self, written: TimeOfDay) {
        let Some(offset) = self.tracker.clock().offset_nanos(self.now) else {
            return;
        };
        self.session.clock_told = Some((offset, self.now));
        self.note(Note::Clock {
            offset_s: offset as f64 / 1e9,
            vehicle: written,
        });
    }

    /// Keep-alive is by navigation, never by acknowledgements.
    pub(crate) fn silence(&mut self) {
        self.session.silences += 1;
        if self.session.silences >= SILENCES_MAX {
            self.note(Note::Text {
                text: "no navigation: the connection is reset".to_owned(),
            });
            self.outputs.push_back(Output::ResetLink);
        } else {
            self.note(Note::Text {
                text: "no navigation for 5 s: subscribing anew".to_owned(),
            });
            self.session.doubt_subscriptions();
            self.subscribe_all();
        }
        self.timers.set(Timer::Silence, self.now + SILENT);
    }

    /// What is done where the vehicle is not heard to answer. The lease has ended by then, and its BPEMB is on its way.
    pub(crate) fn remedy(&mut self) {
        match self.heartbeat.remedy(self.now) {
            None => {}
            Some(Remedy::Subscribe) => {
                self.subscribe_acknowledgements(Purpose::Beat);
                self.tell_that_unheard();
            }
            Some(Remedy::Reset) => {
                let text = "the vehicle has not answered in time for 30 s: the connection is reset";
                self.note(Note::Text { text: text.to_owned() });
                self.outputs.push_back(Output::ResetLink);
            }
        }
    }

    /// Told once for each time that the answers stay away: it may be the vehicle's habit, and then it is never steered.
    pub(crate) fn tell_that_unheard(&mut self) {
        if self.heartbeat.remedies() < 3 || core::mem::replace(&mut self.session.unheard_told, true) {
            return;
        }
        let text = match self.heartbeat.newest() {
            None => "the vehicle acknowledges nothing on this connection: it is not steered".to_owned(),
            Some(trip) => format!(
                "the vehicle does not answer within {} s, the last time after {:.1} s: it is not steered",
                self.envelope.limits().link_delay_max_s,
                trip.lasted().as_secs_f64()
            ),
        };
        self.note(Note::Text { text });
    }

    pub(crate) fn settle_heartbeat(&mut self) {
        if !self.timers.is_set(Timer::Status) {
            // There is no link, or the logs are closed.
            return;
        }
        let lapses = self.heartbeat.lapses_at().filter(|at| *at > self.now);
        let remedy = self.heartbeat.remedy_at();
        self.timers
            .set(Timer::Heartbeat, lapses.map_or(remedy, |lapses| lapses.min(remedy)));
    }
}

/// Whether something that is counted is told of at this count: at 1, 10, 100, ...
pub(crate) fn is_told(count: u64) -> bool {
    let mut told = 1u64;
    while told < count {
        told = told.saturating_mul(10);
    }
    told == count
}

/// A command's three letters.
pub(crate) fn name(letters: &'static str) -> CommandName {
    CommandName::new(letters).expect("the names of our commands are three letters")
}
