//! The session: connection, subscriptions, the plan's asking, silence, status (SPI 4, 7.1, 7.2, 7.19, 7.25).

pub(crate) mod commands;
pub(crate) mod dispatch;
pub(crate) mod heartbeat;
pub(crate) mod link;
pub(crate) mod reads;
pub(crate) mod subscriptions;

use std::time::Duration;

use backseat_spi::{
    CommandName, DecodeError, Framer, FromVehicle, LoggingControl, PayloadStatus, PayloadVersion, Policy, RequestPlan,
    Text, ToVehicle,
};
use backseat_units::{TimeOfDay, Timestamp};

use crate::context::Context;
use crate::io::{Note, Output};
use crate::quota::LastMinute;
use crate::refusal::Uncontrolled;
use crate::session::commands::{Answer, Command, FIRST_WITHIN, PLAN_WITHIN, Purpose};
use crate::session::heartbeat::{BEAT_EVERY, Remedy};
use crate::session::subscriptions::ACKNOWLEDGEMENTS;
use crate::settings::StatusCondition;
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

/// Speaks with the vehicle: connects, subscribes, asks for the plan, tells our status, and sees to it that both are heard.
#[derive(Debug)]
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub(crate) struct Session {
    #[cfg_attr(feature = "explore", serde(skip))]
    framer: Framer,
    /// How many lines the framer had lost when it was last asked.
    lost: u64,
    /// For the pauses between two attempts to connect.
    jitter: u64,
    /// Connections tried since navigation last came.
    attempts: u32,
    /// How often in a row navigation has not come.
    silences: u32,
    malformed: u64,
    /// When the vehicle's words have had us ask for its plan.
    plan_asks: LastMinute,
    /// That nothing is acknowledged has been told on this connection.
    unheard_told: bool,
    /// The vehicle's clock as it was last told of on this connection, and when.
    clock_told: Option<(i64, Timestamp)>,
    control_notes: ControlNotes,
}

/// A line of the vehicle's.
pub(crate) struct Line {
    pub(crate) message: Result<FromVehicle, DecodeError>,
    /// It calls itself a BFPLN, readable or not.
    pub(crate) is_of_plan: bool,
    /// It has another beginning in it. Where it cannot be read it may have swallowed a sentence.
    pub(crate) swallows: bool,
}

/// How many changes of control are still told of, and what has not been.
#[derive(Debug)]
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
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
    pub(crate) fn new(jitter: u64) -> Self {
        Self {
            framer: Framer::new(Policy::FromVehicle),
            lost: 0,
            jitter,
            attempts: 0,
            silences: 0,
            malformed: 0,
            plan_asks: LastMinute::default(),
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

    /// A new connection: says who we are, subscribes, and asks for the plan.
    pub(crate) fn begin(&mut self, cx: &mut Context) {
        self.framer.clear();
        self.lost = self.framer.counts().lost();
        self.silences = 0;
        self.malformed = 0;
        self.unheard_told = false;
        self.clock_told = None;
        let created = cx.stamper.stamp(cx.now, "VER");
        let version = ToVehicle::PayloadVersion(PayloadVersion {
            created,
            version: Text::cleaned(VERSION),
        });
        let command = self.early(cx, "VER", Some(created));
        cx.transmit(&version, Some(command));
        self.subscribe_all(cx);
        self.ask_for_plan(cx);
    }

    /// The connection is gone: another is tried after a while.
    pub(crate) fn connect_again(&mut self, cx: &mut Context) {
        let retry_s = self.retry_s(cx);
        let counts = self.framer.counts();
        cx.note(Note::LinkDown { counts, retry_s });
        cx.outbox.push(Output::Connect {
            after: Duration::from_secs_f64(retry_s),
        });
        self.attempts = self.attempts.saturating_add(1);
    }

    /// Sets when navigation will have stayed away.
    pub(crate) fn watch_silence(&self, cx: &mut Context) {
        cx.timers.set(Timer::Silence, cx.now + SILENT);
    }

    /// Bytes from the vehicle, in any split.
    pub(crate) fn push(&mut self, bytes: &[u8]) {
        self.framer.push(bytes);
    }

    /// The next line that is whole.
    pub(crate) fn next_line(&mut self) -> Option<Line> {
        let sentence = self.framer.next_sentence()?;
        Some(Line {
            is_of_plan: sentence.name() == "BFPLN",
            swallows: sentence.raw().rfind('$').is_some_and(|at| at > 0),
            message: FromVehicle::decode(&sentence),
        })
    }

    /// Whether anything was lost on the link since this was last asked.
    pub(crate) fn take_lost(&mut self) -> bool {
        let lost = self.framer.counts().lost();
        core::mem::replace(&mut self.lost, lost) != lost
    }

    /// Counts a sentence that cannot be read; how many there were. Told at 1, 10, 100, ...
    pub(crate) fn malformed(&mut self) -> Option<u64> {
        self.malformed += 1;
        is_told(self.malformed).then_some(self.malformed)
    }

    /// Navigation came: the connection is good.
    pub(crate) fn heard_navigation(&mut self, cx: &mut Context) {
        self.attempts = 0;
        self.silences = 0;
        self.watch_silence(cx);
        self.watch_clock(cx);
    }

    /// The vehicle hears us, and has just said what time it has.
    pub(crate) fn is_heard(&mut self, cx: &mut Context, written: TimeOfDay) {
        self.unheard_told = false;
        if self.clock_told.is_none() {
            self.tell_of_clock(cx, written);
        }
    }

    /// An answer to BPRMP. True where the plan has come whole with it.
    pub(crate) fn plan_answered(&mut self, cx: &mut Context, answer: Answer<'_>) -> bool {
        match answer {
            // The series follows its own pending acknowledgement; what came before is of an earlier asking.
            Answer::Pending => self.begin_plan(cx),
            Answer::Done if cx.vehicle.plan.end(self.framer.counts().lost()) => {
                let elements = cx.vehicle.plan.len();
                cx.note(Note::Plan { elements });
                return true;
            }
            Answer::Done | Answer::Refused(_) | Answer::Missing => self.plan_failed(cx),
        }
        false
    }

    /// The plan is asked for again in a while.
    pub(crate) fn ask_for_plan_again(&self, cx: &mut Context) {
        cx.timers.set(Timer::Plan, cx.now + PLAN_RETRY);
    }
}

impl Session {
    /// Control has changed hands: told at once, unless it does so all the time.
    pub(crate) fn tell_of_control(&mut self, cx: &mut Context, reason: Option<Uncontrolled>) {
        let granted = cx.control.granted;
        let notes = &mut self.control_notes;
        let every = CONTROL_NOTE_EVERY.as_nanos();
        let refill = u32::try_from(cx.now.since(notes.refilled).as_nanos() / every).unwrap_or(u32::MAX);
        if refill > 0 {
            notes.left = notes.left.saturating_add(refill).min(CONTROL_NOTES);
            notes.refilled = cx.now;
        }
        if notes.left == 0 {
            notes.untold += 1;
            return;
        }
        notes.left -= 1;
        notes.told = granted;
        cx.note(Note::Control { granted, reason });
    }

    /// What was not told of control when it changed too often.
    pub(crate) fn catch_up_on_control(&mut self, cx: &mut Context) {
        let granted = cx.control.granted;
        let notes = &mut self.control_notes;
        if cx.now.since(notes.caught_up) < CATCH_UP_EVERY {
            return;
        }
        notes.caught_up = cx.now;
        let untold = std::mem::take(&mut notes.untold);
        if untold == 0 {
            return;
        }
        let changed = std::mem::replace(&mut notes.told, granted) != granted;
        cx.note(Note::Text {
            text: format!("control has changed hands {untold} times more"),
        });
        if changed {
            cx.note(Note::Control {
                granted,
                reason: cx.lost_because(),
            });
        }
    }

    /// The second's BPSTS (SPI 7.2), and what carries the beat beside it where the vehicle does not answer that.
    pub(crate) fn beat(&mut self, cx: &mut Context) {
        self.catch_up_on_control(cx);
        self.tell_what_was_counted(cx);
        if cx.link.heartbeat.needs_log(cx.now) {
            self.subscribe_acknowledgements(cx, Purpose::Beat);
        }
        self.send_status(cx);
        cx.timers.set(Timer::Status, cx.now + BEAT_EVERY);
    }

    /// Tells what was counted and not told.
    fn tell_what_was_counted(&self, cx: &mut Context) {
        let untold = cx.outbox.take_dropped();
        if untold > 0 {
            let text = format!("{untold} lines more of what the vehicle said were left out");
            cx.note(Note::Text { text });
        }
        for plugin in cx.plugins.ids() {
            let untold = cx.plugins.take_dropped(plugin);
            if untold > 0 {
                let name = cx.plugins.name(plugin);
                let text = format!("{untold} requests more of {name} were over its rate and rejected");
                cx.note(Note::Text { text });
            }
        }
    }

    pub(crate) fn send_status(&mut self, cx: &mut Context) {
        let failed = cx.settings.status_failed_when.iter().any(|condition| match condition {
            StatusCondition::PluginQuarantined => cx.plugins.any_is_quarantined(),
            StatusCondition::NavigationStale => cx.vehicle.navigation.fresh(cx.now).is_none(),
        });
        let text = match (cx.arbiter.is_steering(), cx.lost_because()) {
            (true, _) => "steering",
            (false, None) => "has control",
            (false, Some(reason)) => reason.text(),
        };
        let created = cx.stamper.stamp(cx.now, "STS");
        let status = PayloadStatus {
            created,
            ok: !failed,
            text: Text::cleaned(text),
        };
        let command = cx.courtesy("STS", Some(created));
        cx.transmit(&ToVehicle::PayloadStatus(status), Some(command));
    }

    pub(crate) fn subscribe_acknowledgements(&mut self, cx: &mut Context, purpose: Purpose) {
        let message = ToVehicle::LoggingControl(LoggingControl {
            message: Text::cleaned(ACKNOWLEDGEMENTS),
            on: true,
        });
        let command = Command {
            purpose,
            ..cx.courtesy("LOG", None)
        };
        cx.transmit(&message, Some(command));
    }

    /// Doubled at each attempt, half of it by chance, so that payloads that lost the vehicle together do not come back
    /// together.
    pub(crate) fn retry_s(&self, cx: &Context) -> f64 {
        let doubled = 2.0 * RETRY_MIN_S * f64::from(1u32 << self.attempts.min(5));
        let mut bits = self.jitter ^ u64::from(self.attempts) ^ cx.now.as_nanos();
        // The finaliser of splitmix64 (Steele, Lea, Flood, OOPSLA 2014): every bit of the state counts.
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        let chance = ((bits ^ (bits >> 31)) >> 11) as f64 / (1u64 << 53) as f64;
        doubled.min(RETRY_MAX_S) * (0.5 + 0.5 * chance)
    }

    pub(crate) fn subscribe_all(&mut self, cx: &mut Context) {
        for index in 0..cx.link.subscriptions.len() {
            self.subscribe(cx, index);
        }
    }

    /// A message stays away that was subscribed.
    pub(crate) fn subscribe_anew(&mut self, cx: &mut Context, message: &str) {
        if let Some(index) = cx.link.subscriptions.doubt(message) {
            self.subscribe(cx, index);
        }
    }

    fn subscribe(&mut self, cx: &mut Context, index: usize) {
        let (subject, unanswered) = cx.link.subscriptions.asked(index);
        let message = ToVehicle::LoggingControl(LoggingControl {
            message: Text::cleaned(subject),
            on: true,
        });
        let command = match unanswered {
            Some(unanswered) => Command {
                name: name("LOG"),
                created: None,
                identifier: None,
                purpose: Purpose::Subscription(index),
                deadline: cx.now + 2 * FIRST_WITHIN * (1 << unanswered.min(SUBSCRIPTION_DOUBLINGS)),
                pending: false,
            },
            None => self.early(cx, "LOG", None),
        };
        cx.transmit(&message, Some(command));
    }

    /// A command that leaves before acknowledgements are asked for.
    pub(crate) fn early(&self, cx: &Context, letters: &'static str, created: Option<TimeOfDay>) -> Command {
        Command {
            purpose: Purpose::Early,
            ..cx.courtesy(letters, created)
        }
    }

    pub(crate) fn subscription_answered(&mut self, cx: &mut Context, index: usize, answer: Answer<'_>) {
        match answer {
            Answer::Pending => {}
            Answer::Done => cx.link.subscriptions.confirm(index),
            Answer::Refused(text) => {
                let message = cx.link.subscriptions.subject(index);
                cx.note(Note::Text {
                    text: format!("the vehicle refused the subscription to BF{message}: {text}"),
                });
            }
            // What it asked for may come all the same.
            Answer::Missing if cx.link.subscriptions.is_confirmed(index) => {}
            Answer::Missing => self.subscribe(cx, index),
        }
    }

    pub(crate) fn ask_for_plan(&mut self, cx: &mut Context) {
        if cx.vehicle.plan.is_collecting() {
            return;
        }
        let created = cx.stamper.stamp(cx.now, "RMP");
        let command = Command {
            name: name("RMP"),
            created: Some(created),
            identifier: None,
            purpose: Purpose::Plan,
            deadline: cx.now + PLAN_WITHIN,
            pending: false,
        };
        if cx.transmit(&ToVehicle::RequestPlan(RequestPlan { created }), Some(command)) {
            cx.vehicle.plan.asked(cx.now);
            self.begin_plan(cx);
        }
    }

    /// What the vehicle says makes its plan worth asking for. It may say so a hundred times a second: then it is asked for
    /// now and then.
    pub(crate) fn want_plan(&mut self, cx: &mut Context) {
        if self.plan_asks.has_room(cx.now, PLAN_ASKS_PER_MIN) {
            self.plan_asks.add(cx.now);
            return self.ask_for_plan(cx);
        }
        cx.timers.set_unless_set(Timer::Plan, cx.now + PLAN_ASKED_ANEW);
    }

    pub(crate) fn begin_plan(&mut self, cx: &mut Context) {
        cx.vehicle.plan.begin(self.framer.counts().lost());
    }

    /// The plan did not come: it is asked for again.
    pub(crate) fn plan_failed(&mut self, cx: &mut Context) {
        cx.vehicle.plan.fail();
        cx.timers.set(Timer::Plan, cx.now + PLAN_RETRY);
    }

    /// Tells of the vehicle's clock where it has moved against ours since it was last told on this connection, which the
    /// first round trip does.
    pub(crate) fn watch_clock(&mut self, cx: &mut Context) {
        let Some(offset) = cx.vehicle.navigation.clock().offset_nanos(cx.now) else {
            return;
        };
        let told = self.clock_told;
        let moved = told.is_some_and(|(told, at)| {
            offset.abs_diff(told) >= CLOCK_STEP_NANOS.unsigned_abs() && cx.now.since(at) >= CLOCK_NOTE_EVERY
        });
        if !moved {
            return;
        }
        if let Some(written) = cx.vehicle.navigation.written() {
            self.tell_of_clock(cx, written);
        }
    }

    /// Tells of the vehicle's clock, which has just said `written`.
    pub(crate) fn tell_of_clock(&mut self, cx: &mut Context, written: TimeOfDay) {
        let Some(offset) = cx.vehicle.navigation.clock().offset_nanos(cx.now) else {
            return;
        };
        self.clock_told = Some((offset, cx.now));
        cx.note(Note::Clock {
            offset_s: offset as f64 / 1e9,
            vehicle: written,
        });
    }

    /// Keep-alive is by navigation, never by acknowledgements.
    pub(crate) fn silence(&mut self, cx: &mut Context) {
        self.silences += 1;
        if self.silences >= SILENCES_MAX {
            cx.note(Note::Text {
                text: "no navigation: the connection is reset".to_owned(),
            });
            cx.outbox.push(Output::ResetLink);
        } else {
            cx.note(Note::Text {
                text: "no navigation for 5 s: subscribing anew".to_owned(),
            });
            cx.link.subscriptions.doubt_all();
            self.subscribe_all(cx);
        }
        cx.timers.set(Timer::Silence, cx.now + SILENT);
    }

    /// What is done where the vehicle is not heard to answer. The lease has ended by then, and its BPEMB is on its way.
    pub(crate) fn remedy(&mut self, cx: &mut Context) {
        match cx.link.heartbeat.remedy(cx.now) {
            None => {}
            Some(Remedy::Subscribe) => {
                self.subscribe_acknowledgements(cx, Purpose::Beat);
                self.tell_that_unheard(cx);
            }
            Some(Remedy::Reset) => {
                let text = "the vehicle has not answered in time for 30 s: the connection is reset";
                cx.note(Note::Text { text: text.to_owned() });
                cx.outbox.push(Output::ResetLink);
            }
        }
    }

    /// Told once for each time that the answers stay away: it may be the vehicle's habit, and then it is never steered.
    pub(crate) fn tell_that_unheard(&mut self, cx: &mut Context) {
        if cx.link.heartbeat.remedies() < 3 || core::mem::replace(&mut self.unheard_told, true) {
            return;
        }
        let text = match cx.link.heartbeat.newest() {
            None => "the vehicle acknowledges nothing on this connection: it is not steered".to_owned(),
            Some(trip) => format!(
                "the vehicle does not answer within {} s, the last time after {:.1} s: it is not steered",
                cx.monitor.limits().link_delay_max_s,
                trip.lasted().as_secs_f64()
            ),
        };
        cx.note(Note::Text { text });
    }

    pub(crate) fn settle_heartbeat(&mut self, cx: &mut Context) {
        if !cx.timers.is_set(Timer::Status) {
            // There is no link, or the logs are closed.
            return;
        }
        let lapses = cx.link.heartbeat.lapses_at().filter(|at| *at > cx.now);
        let remedy = cx.link.heartbeat.remedy_at();
        cx.timers
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
