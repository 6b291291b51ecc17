//! The session: connection, subscriptions, the plan's asking, silence, status (SPI 4, 7.1, 7.2, 7.19, 7.25).

use std::time::Duration;

use backseat_spi::{CommandName, LoggingControl, PayloadStatus, PayloadVersion, RequestPlan, Text, ToVehicle};
use backseat_units::Timestamp;

use crate::commands::{Answer, Command, FIRST_WITHIN, PLAN_WITHIN, Purpose};
use crate::conductor::Slot;
use crate::io::{Note, Output};
use crate::machine::Core;
use crate::plugin::RequestState;
use crate::settings::StatusCondition;
use crate::subscriptions;
use crate::timer::Timer;

/// The interface that we speak.
const VERSION: &str = "1.12";
/// Navigation comes at 10 Hz: nothing for this long, and we subscribe anew.
const SILENT: Duration = Duration::from_secs(5);
/// Nothing for this many times in a row, and the connection is reset.
const SILENCES_MAX: u32 = 3;
/// Navigation comes, and all of it is old: after this long the clocks are learnt anew on a new connection. The vehicle's
/// clock has been set back, by a leap second or a GPS fix, or what we read has been held up ever since.
const OLD_FOR: Duration = Duration::from_secs(30);
const PLAN_RETRY: Duration = Duration::from_secs(5);
const STATUS_EVERY: Duration = Duration::from_secs(10);
const RETRY_MIN_S: f64 = 0.5;
const RETRY_MAX_S: f64 = 10.0;

/// Where the connection stands.
#[derive(Debug)]
pub(crate) struct Session {
    up: bool,
    /// Connections tried since navigation last came.
    attempts: u32,
    /// How often in a row navigation has not come.
    silences: u32,
    subscriptions: Vec<&'static str>,
    /// Which of them the vehicle has acknowledged on this connection.
    confirmed: Vec<bool>,
    malformed: u64,
    /// Since when navigation has come and been old.
    old_since: Option<Timestamp>,
}

impl Session {
    pub(crate) fn new(plugins: &[Slot]) -> Self {
        let subscriptions = subscriptions::of(plugins);
        Self {
            up: false,
            attempts: 0,
            silences: 0,
            confirmed: vec![false; subscriptions.len()],
            subscriptions,
            malformed: 0,
            old_since: None,
        }
    }

    pub(crate) const fn is_up(&self) -> bool {
        self.up
    }

    /// Whether the vehicle has acknowledged the subscription to a message on this connection.
    pub(crate) fn is_subscribed(&self, message: &str) -> bool {
        let mut both = self.subscriptions.iter().zip(&self.confirmed);
        both.any(|(subscription, confirmed)| *subscription == message && *confirmed)
    }

    /// Counts a sentence that cannot be read; how many there were. Told at 1, 10, 100, ...
    pub(crate) fn malformed(&mut self) -> Option<u64> {
        self.malformed += 1;
        let mut told = 1;
        while told < self.malformed {
            told *= 10;
        }
        (told == self.malformed).then_some(told)
    }

    /// Navigation came: the connection is good.
    pub(crate) fn heard_navigation(&mut self) {
        self.attempts = 0;
        self.silences = 0;
    }
}

impl Core {
    pub(crate) fn link_up(&mut self) {
        self.framer.clear();
        self.tracker.reset();
        self.commands.clear();
        self.plan.forget();
        self.handed_over = None;
        self.running = None;
        self.session.up = true;
        self.session.silences = 0;
        self.session.malformed = 0;
        self.session.old_since = None;
        self.session.confirmed.fill(false);
        self.note(Note::LinkUp);
        let created = self.stamper.stamp(self.now, "VER");
        let version = ToVehicle::PayloadVersion(PayloadVersion {
            created,
            version: Text::cleaned(VERSION),
        });
        self.transmit(&version, None);
        self.subscribe_all();
        self.ask_for_plan();
        if self.held {
            // The operator may have taken the helm while nothing could be sent.
            self.cancel_all_of(None, "the operator holds");
        }
        self.timers.set(Timer::Silence, self.now + SILENT);
        self.timers.set(Timer::Status, self.now + STATUS_EVERY);
    }

    pub(crate) fn link_down(&mut self) {
        // No BPEMB reaches the vehicle: its own clock ends the modify.
        self.session.up = false;
        self.end_lease("the link is down");
        self.end_hold("the link is down");
        self.handed_over = None;
        self.running = None;
        self.commands.clear();
        self.plan.forget();
        self.tracker.reset();
        self.silent_link_lost();
        self.adjustments_link_lost();
        self.acoustic_link_lost();
        self.dvl_link_lost();
        let undecided: Vec<(u64, bool)> = self
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
            self.transition(request, to);
        }
        for timer in [Timer::Silence, Timer::Plan, Timer::Status] {
            self.timers.stop(timer);
        }
        if self.stopping {
            return;
        }
        let after_s = self.retry_s();
        self.note(Note::LinkDown {
            counts: self.framer.counts(),
            retry_s: after_s,
        });
        self.outputs.push_back(Output::Connect {
            after: Duration::from_secs_f64(after_s),
        });
        self.session.attempts = self.session.attempts.saturating_add(1);
    }

    /// Doubled at each attempt, within half and one and a half of it by chance, so that payloads that lost the vehicle
    /// together do not come back together.
    fn retry_s(&self) -> f64 {
        let doubled = RETRY_MIN_S * f64::from(1u32 << self.session.attempts.min(5));
        let mut bits = self.start.jitter ^ u64::from(self.session.attempts) ^ self.now.as_nanos();
        // The finaliser of splitmix64 (Steele, Lea, Flood, OOPSLA 2014): every bit of the state counts.
        bits = (bits ^ (bits >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        bits = (bits ^ (bits >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        let chance = ((bits ^ (bits >> 31)) >> 11) as f64 / (1u64 << 53) as f64;
        (doubled.min(RETRY_MAX_S) * (0.5 + chance)).max(RETRY_MIN_S)
    }

    fn subscribe_all(&mut self) {
        for index in 0..self.session.subscriptions.len() {
            self.subscribe(index);
        }
    }

    fn subscribe(&mut self, index: usize) {
        let message = ToVehicle::LoggingControl(LoggingControl {
            message: Text::cleaned(self.session.subscriptions[index]),
            on: true,
        });
        // The first comes before acknowledgements are on.
        let command = (index > 0).then(|| Command {
            name: name("LOG"),
            created: None,
            identifier: None,
            purpose: Purpose::Subscription(index),
            deadline: self.now + 2 * FIRST_WITHIN,
            pending: false,
        });
        self.transmit(&message, command);
    }

    pub(crate) fn subscription_answered(&mut self, index: usize, answer: Answer<'_>) {
        match answer {
            Answer::Pending => {}
            Answer::Done => self.session.confirmed[index] = true,
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
            self.plan.begin();
        }
    }

    pub(crate) fn plan_answered(&mut self, answer: Answer<'_>) {
        match answer {
            // The series follows its own pending acknowledgement; what came before is of an earlier asking.
            Answer::Pending => self.plan.begin(),
            Answer::Done => {
                self.plan.end(true);
                if self.plan.is_complete() {
                    self.note(Note::Plan {
                        elements: self.plan.len(),
                    });
                    self.resolve_by_plan();
                    self.tell_of_plan();
                } else {
                    self.plan_failed();
                }
            }
            Answer::Refused(_) | Answer::Missing => self.plan_failed(),
        }
    }

    /// The plan did not come: it is asked for again.
    pub(crate) fn plan_failed(&mut self) {
        self.plan.end(false);
        self.timers.set(Timer::Plan, self.now + PLAN_RETRY);
    }

    pub(crate) fn navigation_came(&mut self) {
        self.session.heard_navigation();
        self.timers.set(Timer::Silence, self.now + SILENT);
        if self.tracker.fresh(self.now).is_some() && self.tracker.steady(self.now) {
            self.session.old_since = None;
            return;
        }
        let since = *self.session.old_since.get_or_insert(self.now);
        if self.now.since(since) >= OLD_FOR {
            self.session.old_since = None;
            let text = "navigation has come old for 30 s: the connection is reset and the clocks are learnt anew";
            self.note(Note::Text { text: text.to_owned() });
            self.outputs.push_back(Output::ResetLink);
        }
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
            self.subscribe_all();
        }
        self.timers.set(Timer::Silence, self.now + SILENT);
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
        let text = match (self.lease.is_some(), self.lost_because()) {
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
        self.timers.set(Timer::Status, self.now + STATUS_EVERY);
    }

    /// A command whose answer is taken note of and no more.
    pub(crate) fn courtesy(&self, command: &'static str, created: Option<backseat_units::TimeOfDay>) -> Command {
        Command {
            name: name(command),
            created,
            identifier: None,
            purpose: Purpose::Courtesy,
            deadline: self.now + 2 * FIRST_WITHIN,
            pending: false,
        }
    }
}

/// A command's three letters.
pub(crate) fn name(letters: &'static str) -> CommandName {
    CommandName::new(letters).expect("the names of our commands are three letters")
}
