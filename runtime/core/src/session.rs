//! The session with the vehicle: connects, subscribes, asks for the plan, notices silence, and sends our status (SPI 4,
//! 7.1, 7.2, 7.19, 7.25).

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
use crate::session::heartbeat::Remedy;
use crate::session::subscriptions::ACKNOWLEDGEMENTS;
use crate::settings::StatusCondition;
use crate::timer::Timer;

/// The version of the interface that we speak.
const VERSION: &str = "1.12";
/// Navigation comes at 10 Hz. After this long without any, we subscribe again.
const SILENT: Duration = Duration::from_secs(5);
/// We reset the connection when [`SILENT`] has passed this many times in a row without navigation.
const SILENCES_MAX: u32 = 3;
const PLAN_RETRY: Duration = Duration::from_secs(5);
/// How many times a minute we ask for the plan at once because of a message of the vehicle, or ask again because it did
/// not come. After that, a message makes us ask when [`PLAN_ASKED_ANEW`] has passed.
const PLAN_ASKS_PER_MIN: u32 = 6;
const PLAN_ASKED_ANEW: Duration = Duration::from_secs(10);
/// After something was lost that may have said who has control, we wait for this long for the vehicle to say it, and then
/// reset the connection. The next reset for that comes no sooner than after the second of these, doubled each time, at most
/// so many times.
const CONTROL_SAID_WITHIN: Duration = Duration::from_secs(3);
const CONTROL_RESET_EVERY: Duration = Duration::from_secs(30);
const CONTROL_RESET_DOUBLINGS: u32 = 4;
/// How often we report the changes of control that were too many to report one by one.
const CATCH_UP_EVERY: Duration = Duration::from_secs(10);
/// The messages that can take control away. A damaged one may have done so.
const ABOUT_CONTROL: [&str; 3] = ["BFCTL", "BFMIS", "BFMSC"];
const RETRY_MIN_S: f64 = 0.5;
/// The longest pause between two attempts to connect, including its random part.
const RETRY_MAX_S: f64 = 10.0;
/// A subscription that is not answered is sent again after 2, 4, 8, 16 and then every 32 s. Some vehicles never
/// acknowledge, and repeated subscriptions must not fill their link.
const SUBSCRIPTION_DOUBLINGS: u32 = 4;
/// How many changes of control are reported at once, and how long it takes until one more is. So a vehicle that hands
/// control over and takes it back ten times a second does not fill the log.
const CONTROL_NOTES: u32 = 8;
const CONTROL_NOTE_EVERY: Duration = Duration::from_secs(5);
/// The smallest change of the vehicle's clock against ours that is reported, nanoseconds.
const CLOCK_STEP_NANOS: i64 = 500_000_000;
const CLOCK_NOTE_EVERY: Duration = Duration::from_secs(10);

/// Talks to the vehicle: connects, subscribes, asks for the plan, sends our status, and checks that each side hears the
/// other.
#[derive(Debug)]
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub(crate) struct Session {
    #[cfg_attr(feature = "explore", serde(skip))]
    framer: Framer,
    /// How many lines the framer had lost when we last asked it.
    lost: u64,
    /// Makes the pauses between two attempts to connect random.
    jitter: u64,
    /// Attempts to connect since navigation last came.
    attempts: u32,
    /// How many times in a row [`SILENT`] has passed without navigation.
    silences: u32,
    malformed: u64,
    /// When we asked for the vehicle's plan.
    plan_asks: LastMinute,
    /// Since when something is lost that may have been a message about control, or such a message could not be used.
    control_lost: Option<Timestamp>,
    /// When we last reset the connection for that, and how often since the vehicle last said what we need.
    control_reset: Option<(Timestamp, u32)>,
    /// We have reported that the vehicle does not answer in time, and it has not done so since.
    unheard_told: bool,
    /// The offset of the vehicle's clock that we last reported on this connection, and when.
    clock_told: Option<(i64, Timestamp)>,
    control_notes: ControlNotes,
}

/// A line that the vehicle sent.
pub(crate) struct Line {
    pub(crate) message: Result<FromVehicle, DecodeError>,
    /// Its name is BFPLN, whether or not it can be decoded.
    pub(crate) is_of_plan: bool,
    /// It contains another `$`. If the line cannot be decoded, another sentence may be lost in it.
    pub(crate) swallows: bool,
}

/// How many more changes of control may be reported at once, and how many were not reported.
#[derive(Debug)]
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
struct ControlNotes {
    left: u32,
    /// When `left` was last refilled.
    refilled: Timestamp,
    untold: u64,
    /// When `untold` was last checked.
    caught_up: Timestamp,
    /// The state that was last reported: whether control was ours.
    told: bool,
}

impl Session {
    pub(crate) fn new(jitter: u64) -> Self {
        Self {
            framer: Framer::new(Policy::FromVehicle).watching(&ABOUT_CONTROL),
            lost: 0,
            jitter,
            attempts: 0,
            silences: 0,
            malformed: 0,
            plan_asks: LastMinute::default(),
            control_lost: None,
            control_reset: None,
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

    /// Begins a new connection: sends our version, subscribes, and asks for the plan.
    pub(crate) fn begin(&mut self, cx: &mut Context) {
        self.framer.clear();
        self.lost = self.framer.counts().lost();
        self.framer.take_watched();
        self.control_lost = None;
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

    /// The connection is gone: asks the driver to connect again after a pause.
    pub(crate) fn connect_again(&mut self, cx: &mut Context) {
        let retry_s = self.retry_s(cx);
        let counts = self.framer.counts();
        cx.note(Note::LinkDown { counts, retry_s });
        cx.outbox.push(Output::Connect {
            after: Duration::from_secs_f64(retry_s),
        });
        self.attempts = self.attempts.saturating_add(1);
    }

    /// Starts the timer that expires if no navigation comes.
    pub(crate) fn watch_silence(&self, cx: &mut Context) {
        cx.timers.set(Timer::Silence, cx.now + SILENT);
    }

    /// Takes bytes from the vehicle, cut anywhere.
    pub(crate) fn push(&mut self, bytes: &[u8]) {
        self.framer.push(bytes);
    }

    /// The next complete line.
    pub(crate) fn next_line(&mut self) -> Option<Line> {
        let sentence = self.framer.next_sentence()?;
        Some(Line {
            is_of_plan: sentence.name() == "BFPLN",
            swallows: sentence.raw().rfind('$').is_some_and(|at| at > 0),
            message: FromVehicle::decode(&sentence),
        })
    }

    /// Whether the framer has lost anything since the last call.
    pub(crate) fn take_lost(&mut self) -> bool {
        let lost = self.framer.counts().lost();
        core::mem::replace(&mut self.lost, lost) != lost
    }

    /// Which messages about control the framer has lost since the last call, as far as their names can be read.
    pub(crate) fn take_damaged(&mut self) -> impl Iterator<Item = &'static str> + use<> {
        let damaged = self.framer.take_watched();
        ABOUT_CONTROL
            .into_iter()
            .enumerate()
            .filter(move |(index, _)| damaged & (1 << index) != 0)
            .map(|(_, message)| message)
    }

    /// Counts a sentence that cannot be decoded. Returns the count if it is one to report: 1, 10, 100, ...
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

    /// The vehicle hears us: it has answered in time, and wrote that answer at `written`.
    pub(crate) fn is_heard(&mut self, cx: &mut Context, written: TimeOfDay) {
        self.unheard_told = false;
        if self.clock_told.is_none() {
            self.tell_of_clock(cx, written);
        }
    }

    /// Handles an answer to BPRMP. Returns true if the plan is now complete.
    pub(crate) fn plan_answered(&mut self, cx: &mut Context, answer: Answer<'_>) -> bool {
        match answer {
            // The plan follows the pending acknowledgement of its request. Elements before that belong to an earlier
            // request.
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

    /// Asks for the plan again after [`PLAN_RETRY`].
    pub(crate) fn ask_for_plan_again(&self, cx: &mut Context) {
        cx.timers.set(Timer::Plan, cx.now + PLAN_RETRY);
    }
}

impl Session {
    /// Control has changed: reports it at once, unless it has changed too often.
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

    /// Reports the changes of control that were too many to report one by one.
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
            text: format!("control has changed {untold} more times"),
        });
        if changed {
            cx.note(Note::Control {
                granted,
                reason: cx.lost_because(),
            });
        }
    }

    /// Sends this second's BPSTS (SPI 7.2), and a BPLOG as the beat if the vehicle does not answer BPSTS.
    pub(crate) fn beat(&mut self, cx: &mut Context) {
        self.catch_up_on_control(cx);
        self.ask_about_control(cx);
        self.tell_what_was_counted(cx);
        if cx.link.heartbeat.needs_log(cx.now) {
            self.subscribe_acknowledgements(cx, Purpose::Beat);
        }
        let created = self.send_status(cx);
        cx.timers
            .set(Timer::Status, cx.link.heartbeat.next_beat(cx.now, created));
    }

    /// Reports how many lines and rejections were counted but not logged.
    fn tell_what_was_counted(&self, cx: &mut Context) {
        let untold = cx.outbox.take_dropped();
        if untold > 0 {
            let text = format!("{untold} more lines about what the vehicle said were left out");
            cx.note(Note::Text { text });
        }
        for plugin in cx.plugins.ids() {
            let untold = cx.plugins.take_dropped(plugin);
            if untold > 0 {
                let name = cx.plugins.name(plugin);
                let text = format!("{untold} more requests of {name} were over its rate and rejected");
                cx.note(Note::Text { text });
            }
        }
    }

    /// Sends a BPSTS (SPI 7.2). Returns its time.
    pub(crate) fn send_status(&mut self, cx: &mut Context) -> TimeOfDay {
        let failed = cx.settings.status_failed_when.iter().any(|condition| match condition {
            StatusCondition::PluginQuarantined => cx.plugins.any_is_quarantined(),
            StatusCondition::NavigationStale => cx.vehicle.navigation.fresh(cx.now).is_none(),
            StatusCondition::SonarNotReady
            | StatusCondition::SonarAlarm
            | StatusCondition::SonarUnhealthy
            | StatusCondition::SonarNotLogging => cx.sonars.has(*condition),
        });
        let text = match (cx.arbiter.is_steering(), cx.lost_because()) {
            (true, _) => "steering",
            (false, None) => "has control",
            (false, Some(reason)) => reason.text(),
        };
        let text = match &cx.settings.sonar {
            Some(_) => Text::cleaned(&format!("{text}; {}", cx.sonars.status())),
            None => Text::cleaned(text),
        };
        let created = cx.stamper.stamp(cx.now, "STS");
        let status = PayloadStatus {
            created,
            ok: !failed,
            text,
        };
        let command = cx.courtesy("STS", Some(created));
        cx.transmit(&ToVehicle::PayloadStatus(status), Some(command));
        created
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

    /// The pause before the next attempt to connect, seconds. It doubles at each attempt, and up to half of it is
    /// random: payloads that lost the vehicle at the same time should not come back at the same time.
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

    /// Subscribes again to a message that does not come.
    pub(crate) fn subscribe_anew(&mut self, cx: &mut Context, message: &str) {
        if let Some(index) = cx.link.subscriptions.doubt(message) {
            self.subscribe(cx, index);
        }
    }

    /// Something was lost, or cannot be used. If the vehicle has yet to say who has control or whether its mission runs, it
    /// may have done so in that.
    pub(crate) fn lost(&mut self, now: Timestamp) {
        self.control_lost.get_or_insert(now);
    }

    /// Vehicles tell their state when it changes, and to a new subscriber. So if a message about control is lost, core
    /// resets the connection, and subscribes on a new one. Until the vehicle has told its state there, core has no control.
    fn ask_about_control(&mut self, cx: &mut Context) {
        if cx.control.is_told(&cx.settings.control) {
            (self.control_lost, self.control_reset) = (None, None);
            return;
        }
        let Some(lost) = self.control_lost else { return };
        let (again_at, resets) = self.control_reset.map_or((lost, 0), |(at, resets)| {
            (
                at + CONTROL_RESET_EVERY * (1 << resets.min(CONTROL_RESET_DOUBLINGS)),
                resets + 1,
            )
        });
        if cx.now < again_at.max(lost + CONTROL_SAID_WITHIN) {
            return;
        }
        self.control_reset = Some((cx.now, resets));
        let text = "a message about control may be lost: the connection is reset";
        cx.note(Note::Text { text: text.to_owned() });
        cx.outbox.push(Output::ResetLink);
    }

    fn subscribe(&mut self, cx: &mut Context, index: usize) {
        // The answer to an earlier one may still come, but only the newest is sent again if there is none.
        cx.link.commands.supersede(Purpose::Subscription(index));
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

    /// A command that is sent before the subscription to acknowledgements.
    pub(crate) fn early(&self, cx: &Context, letters: &'static str, created: Option<TimeOfDay>) -> Command {
        Command {
            purpose: Purpose::Early,
            ..cx.courtesy(letters, created)
        }
    }

    /// The vehicle's answer to a subscription, or the lack of one. `named` is whether the answer names the message.
    pub(crate) fn subscription_answered(&mut self, cx: &mut Context, index: usize, answer: Answer<'_>, named: bool) {
        match answer {
            Answer::Pending => {}
            Answer::Done if named => cx.link.subscriptions.confirm(index),
            Answer::Done => cx.link.subscriptions.confirm_by_place(index),
            Answer::Refused(text) => self.tell_of_refused_subscription(cx, index, text),
            Answer::Missing => return self.subscribe_doubtful(cx, Some(index)),
        }
        self.log_answered(cx, answer);
    }

    /// A BPLOG has had its answer, or the answer is missing. If no other waits, and none was missing since, all answers
    /// have come.
    pub(crate) fn log_answered(&mut self, cx: &mut Context, answer: Answer<'_>) {
        match answer {
            Answer::Pending => {}
            Answer::Missing => self.subscribe_doubtful(cx, None),
            Answer::Done | Answer::Refused(_) if cx.link.commands.awaits_log() => {}
            Answer::Done | Answer::Refused(_) => cx.link.subscriptions.trust_places(),
        }
    }

    pub(crate) fn tell_of_refused_subscription(&self, cx: &mut Context, index: usize, text: &str) {
        let message = cx.link.subscriptions.subject(index);
        cx.note_of_vehicle(Note::Text {
            text: format!("the vehicle refused the subscription to BF{message}: {text}"),
        });
    }

    /// An answer to a BPLOG is missing, that of the subscription `missing` if it was one. Acknowledgements of BPLOG
    /// seldom name a message, so the vehicle may lack any subscription that is confirmed by nothing else: all of them
    /// are sent again, in the order of the list. A subscription whose message comes is not, even if its answer is
    /// missing.
    pub(crate) fn subscribe_doubtful(&mut self, cx: &mut Context, missing: Option<usize>) {
        let mut doubtful = cx.link.subscriptions.doubt_by_place();
        doubtful.extend(missing.filter(|index| !cx.link.subscriptions.is_confirmed(*index)));
        doubtful.sort_unstable();
        doubtful.dedup();
        for index in doubtful {
            self.subscribe(cx, index);
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
            self.plan_asks.add(cx.now);
            cx.vehicle.plan.asked(cx.now);
            self.begin_plan(cx);
        }
    }

    /// A message of the vehicle shows that we need its plan again. The vehicle may send a hundred such messages a
    /// second, so after the first few the request waits.
    pub(crate) fn want_plan(&mut self, cx: &mut Context) {
        if self.plan_asks.has_room(cx.now, PLAN_ASKS_PER_MIN) {
            return self.ask_for_plan(cx);
        }
        cx.timers.set_unless_set(Timer::Plan, cx.now + PLAN_ASKED_ANEW);
    }

    pub(crate) fn begin_plan(&mut self, cx: &mut Context) {
        cx.vehicle.plan.begin(self.framer.counts().lost());
    }

    /// The plan did not come: asks for it again after [`PLAN_RETRY`], or later, when that is within
    /// [`PLAN_ASKS_PER_MIN`].
    pub(crate) fn plan_failed(&mut self, cx: &mut Context) {
        cx.vehicle.plan.fail();
        let room_at = self.plan_asks.room_at(cx.now, PLAN_ASKS_PER_MIN);
        cx.timers.set(Timer::Plan, room_at.max(cx.now + PLAN_RETRY));
    }

    /// Reports the vehicle's clock if it has moved against ours since the last report on this connection. The first
    /// report comes with the first good round trip.
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

    /// Reports the vehicle's clock. `written` is the newest time that the vehicle has sent.
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

    /// No navigation has come for [`SILENT`]. Only navigation keeps a connection alive; acknowledgements do not.
    pub(crate) fn silence(&mut self, cx: &mut Context) {
        self.silences += 1;
        if self.silences >= SILENCES_MAX {
            cx.note(Note::Text {
                text: "no navigation: the connection is reset".to_owned(),
            });
            cx.outbox.push(Output::ResetLink);
        } else {
            cx.note(Note::Text {
                text: "no navigation for 5 s: the subscriptions are sent again".to_owned(),
            });
            cx.link.subscriptions.doubt_all();
            self.subscribe_all(cx);
        }
        cx.timers.set(Timer::Silence, cx.now + SILENT);
    }

    /// Acts if the vehicle does not answer in time. By then the lease has ended, and its BPEMB has been sent.
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

    /// Reports that the vehicle does not answer in time, once until it does again. Some vehicles never answer, and
    /// those are never steered.
    pub(crate) fn tell_that_unheard(&mut self, cx: &mut Context) {
        if cx.link.heartbeat.remedies() < 3 || core::mem::replace(&mut self.unheard_told, true) {
            return;
        }
        let text = match cx.link.heartbeat.newest() {
            None => "the vehicle acknowledges nothing on this connection: it is not steered".to_owned(),
            Some(trip) => format!(
                "the vehicle does not answer within {} s (its last answer took {:.1} s): it is not steered",
                cx.monitor.limits().link_delay_max_s,
                trip.lasted().as_secs_f64()
            ),
        };
        cx.note(Note::Text { text });
    }

    pub(crate) fn settle_heartbeat(&mut self, cx: &mut Context) {
        if !cx.timers.is_set(Timer::Status) {
            // There is no link, or the run has finished.
            return;
        }
        let lapses = cx.link.heartbeat.lapses_at().filter(|at| *at > cx.now);
        let remedy = cx.link.heartbeat.remedy_at();
        cx.timers
            .set(Timer::Heartbeat, lapses.map_or(remedy, |lapses| lapses.min(remedy)));
    }
}

/// Whether to report something that is counted at this count: at 1, 10, 100, ...
pub(crate) fn is_told(count: u64) -> bool {
    let mut told = 1u64;
    while told < count {
        told = told.saturating_mul(10);
    }
    told == count
}

/// The name of a command, from its three letters.
pub(crate) fn name(letters: &'static str) -> CommandName {
    CommandName::new(letters).expect("the names of our commands are three letters")
}
