//! Plugins as core sees them: when each is stepped, what it is told, what it may ask, and what becomes of it when it
//! fails. One step of a plugin is under way at a time; core never waits for it (safety requirement 006).

use std::time::Duration;

use backseat_spi::{LogMessage, Text, ToVehicle};
use backseat_units::Timestamp;

use crate::adjustment::Adjusts;
use crate::budget::LineBudget;
use crate::context::Context;
use crate::envelope::limit;
use crate::io::{Note, Output, Restarted};
use crate::limits::{FailAction, Grant};
use crate::machine::Core;
use crate::orders::{Condition, Order};
use crate::plugin::{
    Event, FaultKind, LogLevel, PluginFault, PluginId, Refusal, Request, RequestState, Returned, StepInput, Topic,
};
use crate::plugin_limits::PluginLimits;
use crate::refusal::refused;
use crate::settings::PluginSetup;
use crate::switches::{Check, is_on};

/// More events than this for one plugin while it runs, and it has failed.
const EVENTS_MAX: usize = 256;
/// A plugin that fails this often is quarantined.
const FAILURES_MAX: u32 = 5;
/// Failures longer ago than this are forgiven.
const FORGIVEN_AFTER: Duration = Duration::from_secs(600);
const BACK_OFF: Duration = Duration::from_secs(1);
const TIMERS_MAX: usize = 64;
/// A plugin is stepped no more often than this, whatever its timers say.
const PERIOD_MIN: Duration = Duration::from_millis(20);
const MESSAGE_BYTES_MAX: usize = 200;
/// The rule by which a plugin's request is rejected that comes too soon.
const OVER_RATE: &str = "rate";

/// Where a plugin stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum State {
    Idle,
    /// A step is under way.
    Running,
    /// A step is under way whose return is no longer wanted.
    Condemned,
    BackingOff {
        until: Timestamp,
    },
    Restarting,
    Quarantined,
}

#[derive(Debug)]
pub(crate) struct Slot {
    setup: PluginSetup,
    state: State,
    events: Vec<Event>,
    due: Timestamp,
    /// When its last step began.
    invoked: Timestamp,
    /// It was due while a step was under way.
    overdue: bool,
    timers: Vec<(Timestamp, u64)>,
    failures: u32,
    failed_at: Timestamp,
    requests: Allowance,
    /// Rejections of what was over the rate that are told one by one.
    pub(crate) over_rate: LineBudget,
    messages: Allowance,
    /// How many tracklines and trackcircles of its have been sent.
    inserts_sent: u32,
}

impl Slot {
    pub(crate) fn new(setup: PluginSetup) -> Self {
        Self {
            setup,
            state: State::Idle,
            events: Vec::new(),
            due: Timestamp::ZERO,
            invoked: Timestamp::ZERO,
            overdue: false,
            timers: Vec::new(),
            failures: 0,
            failed_at: Timestamp::ZERO,
            requests: Allowance::default(),
            over_rate: LineBudget::of(1),
            messages: Allowance::default(),
            inserts_sent: 0,
        }
    }

    pub(crate) fn name(&self) -> &str {
        &self.setup.name
    }

    pub(crate) fn limits(&self) -> &PluginLimits {
        &self.setup.limits
    }

    pub(crate) const fn inserts_sent(&self) -> u32 {
        self.inserts_sent
    }

    pub(crate) fn count_insert(&mut self) {
        self.inserts_sent += 1;
    }

    pub(crate) fn wants(&self, topic: Topic) -> bool {
        self.setup.description.topics.contains(&topic)
    }

    pub(crate) fn grants(&self) -> &[Grant] {
        &self.setup.grants
    }

    pub(crate) fn is_quarantined(&self) -> bool {
        self.state == State::Quarantined
    }

    /// The vehicle says so much that the queue fills before the plugin's time. Outcomes do not count: they are answers to
    /// what the plugin asked, and one that floods would be stepped the more often the more it asks.
    fn is_filling(&self) -> bool {
        let told = |event: &&Event| !matches!(event, Event::Outcome { .. });
        self.events.len() >= EVENTS_MAX / 2 && self.events.iter().filter(told).count() >= EVENTS_MAX / 2
    }

    fn period(&self) -> Duration {
        self.setup
            .description
            .step_period
            .clamp(PERIOD_MIN, Duration::from_secs(60))
    }

    /// Steps go with navigation; where none comes they go without, half a period late.
    fn due_without_navigation(&self) -> Timestamp {
        self.due + self.period() / 2
    }

    fn wakes_at(&self) -> Option<Timestamp> {
        match self.state {
            State::Idle => {
                let timer = self.timers.iter().map(|(at, _)| *at).min();
                let due = self.due_without_navigation();
                // A queue that fills is emptied before its time.
                let due = if self.is_filling() {
                    self.invoked + PERIOD_MIN
                } else {
                    due
                };
                Some(timer.map_or(due, |timer| timer.min(due)))
            }
            State::BackingOff { until } => Some(until),
            State::Running | State::Condemned | State::Restarting | State::Quarantined => None,
        }
    }
}

/// How often something may be asked: so many at once as in a second, refilled as time passes.
#[derive(Clone, Copy, Debug, Default)]
struct Allowance {
    used: f64,
    at: Timestamp,
}

impl Allowance {
    /// Takes one, where one is left.
    fn take(&mut self, now: Timestamp, per_second: f64) -> bool {
        let refilled = now.since(self.at).as_secs_f64() * per_second;
        self.used = (self.used - refilled).max(0.0);
        self.at = now;
        let left = self.used + 1.0 <= per_second;
        if left {
            self.used += 1.0;
        }
        left
    }
}

impl Core {
    /// Steps every plugin that is due: with navigation, at its period; without, when that is overdue.
    pub(crate) fn step_due(&mut self, with_navigation: bool) {
        let now = self.cx.now;
        for index in 0..self.cx.plugins.len() {
            let slot = &mut self.cx.plugins[index];
            // Navigation's own jitter must not make a step wait for the next one.
            let early = if with_navigation {
                slot.period() / 10
            } else {
                Duration::ZERO
            };
            let due = if with_navigation {
                slot.due
            } else {
                slot.due_without_navigation()
            };
            match slot.state {
                State::Idle => {
                    let mut timed = false;
                    slot.timers.retain(|(at, id)| {
                        let expired = *at <= now;
                        if expired {
                            slot.events.push(Event::Timer(*id));
                            timed = true;
                        }
                        !expired
                    });
                    let filling = slot.is_filling() && now >= slot.invoked + PERIOD_MIN;
                    if timed || filling || now + early >= due {
                        self.cx.invoke(index);
                    }
                }
                State::Running if with_navigation && now + early >= due => slot.overdue = true,
                State::BackingOff { until } if until <= now => {
                    slot.state = State::Restarting;
                    self.cx.outbox.push(Output::Restart(PluginId(index)));
                }
                State::Running
                | State::Condemned
                | State::BackingOff { .. }
                | State::Restarting
                | State::Quarantined => {}
            }
        }
    }

    pub(crate) fn returned(&mut self, plugin: PluginId, returned: Returned) {
        for line in returned.log {
            self.cx.note(Note::PluginLog { plugin, line });
        }
        let Some(slot) = self.cx.plugins.get_mut(plugin.0) else {
            return;
        };
        match slot.state {
            State::Running => slot.state = State::Idle,
            State::Condemned => return self.cx.back_off(plugin),
            State::Idle | State::BackingOff { .. } | State::Restarting | State::Quarantined => return,
        }
        match returned.result {
            Ok(requests) => {
                for request in requests {
                    // One that has failed by the events of its own requests gets nothing more.
                    if self.cx.plugins[plugin.0].state != State::Idle {
                        break;
                    }
                    self.ask(plugin, request);
                    if core::mem::take(&mut self.cx.link.wants_beat) {
                        self.session.beat(&mut self.cx);
                    }
                    self.fail_plugins();
                }
            }
            Err(fault) => self.failed(plugin, fault),
        }
        let slot = &self.cx.plugins[plugin.0];
        if slot.overdue && slot.state == State::Idle {
            self.cx.invoke(plugin.0);
        }
    }

    /// Plugins that have failed meanwhile.
    pub(crate) fn fail_plugins(&mut self) {
        while let Some((plugin, fault)) = self.cx.failures.pop_front() {
            self.failed(plugin, fault);
        }
    }

    /// A plugin has failed: it steers no longer, what it declared for the case is done, and it comes back later or not
    /// at all. Its siblings notice nothing.
    fn failed(&mut self, plugin: PluginId, fault: PluginFault) {
        let now = self.cx.now;
        let slot = &mut self.cx.plugins[plugin.0];
        if now.since(slot.failed_at) > FORGIVEN_AFTER {
            slot.failures = 0;
        }
        slot.failures += 1;
        slot.failed_at = now;
        let on_failure = if is_on(Check::AbortByPolicy) {
            slot.setup.on_failure
        } else {
            FailAction::Abort
        };
        let lost = fault.kind != FaultKind::Error;
        let running = slot.state == State::Running;
        let then = if slot.failures > FAILURES_MAX {
            slot.state = State::Quarantined;
            slot.events.clear();
            "it is quarantined"
        } else if lost && running {
            slot.state = State::Condemned;
            "it will be restarted"
        } else if lost {
            // Before the lease ends, whose outcome a full queue would take for another failure.
            self.cx.back_off(plugin);
            "it will be restarted"
        } else {
            "it goes on"
        };
        let quarantined = self.cx.plugins[plugin.0].is_quarantined();
        self.cx.note(Note::PluginFailed { plugin, fault, then });
        if is_on(Check::PluginFailure) {
            self.capabilities.modify.plugin_failed(&mut self.cx, plugin);
            self.capabilities.station.plugin_failed(&mut self.cx, plugin);
        }
        self.capabilities.dvl.plugin_failed(&mut self.cx, plugin);
        self.capabilities.inserts.plugin_failed(&mut self.cx, plugin);
        match on_failure {
            FailAction::Yield => {}
            FailAction::Cancel => {
                self.capabilities.inserts.take_back_judged(&mut self.cx, Some(plugin));
            }
            FailAction::Abort => {
                self.capabilities.inserts.take_back_judged(&mut self.cx, Some(plugin));
                self.orders.order_in_advance(
                    &mut self.cx,
                    &mut self.capabilities,
                    &Order::Abort {
                        text: "a plugin failed".to_owned(),
                        errors: true,
                    },
                );
            }
        }
        if quarantined {
            self.orders.carry_out(&mut self.cx, &mut self.capabilities, |when| {
                matches!(when, Condition::PluginQuarantined)
            });
        }
    }

    fn ask(&mut self, plugin: PluginId, request: Request) {
        match request {
            Request::Modify(modify) => {
                if let Some(changed) = self.capabilities.modify.asked(&mut self.cx, plugin, &modify) {
                    // BPRES comes before BPRMB.
                    self.capabilities.station.end(&mut self.cx, "a modify took its place");
                    self.capabilities.modify.begin(&mut self.cx, changed);
                }
            }
            Request::EndModify => self.capabilities.modify.asked_end(&mut self.cx, plugin),
            Request::Trackline(_) | Request::Trackcircle(_) => {
                self.capabilities.inserts.asked(&mut self.cx, plugin, &request)
            }
            Request::Cancel(tag) => self.capabilities.inserts.asked_cancel(&mut self.cx, plugin, tag),
            Request::Message(text) => self.cx.ask_message(plugin, &text),
            Request::GpsHit(_) => self.capabilities.inserts.asked(&mut self.cx, plugin, &request),
            Request::Topside(asked) => self.capabilities.topside.asked(&mut self.cx, plugin, &asked),
            Request::DvlTrigger(asked) => self.capabilities.dvl.asked(&mut self.cx, plugin, &asked),
            Request::Silent(asked) => self.capabilities.silent.asked(&mut self.cx, plugin, &asked),
            Request::Trim(tag) => self
                .capabilities
                .adjustments
                .asked(&mut self.cx, plugin, tag, Adjusts::Trim),
            Request::Buoyancy(tag) => self
                .capabilities
                .adjustments
                .asked(&mut self.cx, plugin, tag, Adjusts::Buoyancy),
            Request::Packet(asked) => self.capabilities.acoustic.asked(&mut self.cx, plugin, asked),
            Request::Hold(asked) => {
                if let Some(before) = self.capabilities.station.asked(&mut self.cx, plugin, &asked) {
                    // BPEMB comes before BPSUS.
                    self.capabilities.modify.end(&mut self.cx, "a hold took its place");
                    self.capabilities.station.begin(&mut self.cx, before);
                }
            }
            Request::EndHold => self.capabilities.station.asked_end(&mut self.cx, plugin),
            Request::SonarAngle(asked) => self
                .capabilities
                .devices
                .asked_sonar_angle(&mut self.cx, plugin, &asked),
            Request::Camera(asked) => self.capabilities.devices.asked_camera(&mut self.cx, plugin, &asked),
            Request::Light(asked) => self.capabilities.devices.asked_light(&mut self.cx, plugin, &asked),
            Request::Timer { id, after } => {
                let slot = &mut self.cx.plugins[plugin.0];
                if slot.timers.len() < TIMERS_MAX {
                    slot.timers.push((self.cx.now + after.max(PERIOD_MIN), id));
                } else {
                    let text = format!("a timer was dropped: {TIMERS_MAX} are set already");
                    let line = crate::plugin::LogLine {
                        level: LogLevel::Warn,
                        text,
                    };
                    self.cx.note(Note::PluginLog { plugin, line });
                }
            }
        }
    }
}

impl Context {
    pub(crate) fn tell(&mut self, plugin: PluginId, event: Event) {
        let slot = &mut self.plugins[plugin.0];
        match slot.state {
            State::Quarantined => {}
            State::Idle | State::Running if slot.events.len() >= EVENTS_MAX => {
                if self.failures.iter().all(|(failed, _)| *failed != plugin) {
                    let fault = PluginFault {
                        kind: FaultKind::Overflow,
                        text: format!("more than {EVENTS_MAX} events came before it returned"),
                    };
                    self.failures.push_back((plugin, fault));
                }
            }
            State::Condemned | State::BackingOff { .. } | State::Restarting if slot.events.len() >= EVENTS_MAX => {}
            State::Idle | State::Running | State::Condemned | State::BackingOff { .. } | State::Restarting => {
                slot.events.push(event);
            }
        }
    }

    pub(crate) fn reject(&mut self, request: u64, refusal: Refusal) {
        let reason = format!("{}: {}", refusal.rule, refusal.text);
        let owner = self.ledger.get(request).and_then(|entry| entry.owner.plugin());
        let counted =
            owner.is_some_and(|plugin| refusal.rule == OVER_RATE && !self.plugins[plugin.0].over_rate.take(self.now));
        if counted {
            self.transition_unnoted(request, RequestState::Rejected(reason));
        } else {
            self.transition(request, RequestState::Rejected(reason));
        }
    }

    /// What every request that steers must pass before its figures are looked at.
    pub(crate) fn admit(&mut self, plugin: PluginId, grant: Grant) -> Result<(), Refusal> {
        let now = self.now;
        let slot = &mut self.plugins[plugin.0];
        let most = self.monitor.limits().requests_per_s;
        let per_second = f64::from(slot.limits().requests_per_s.map_or(most, |own| own.min(most)));
        if !slot.setup.grants.contains(&grant) {
            return Err(limit(format!("the mission does not grant it {grant:?}")));
        }
        if !slot.requests.take(now, per_second) && is_on(Check::RequestRate) {
            return Err(refused(OVER_RATE, &format!("more than {per_second} requests a second")));
        }
        self.admit_standing(grant)
    }

    /// What every request needs at the moment that it leaves: control, and an armed runtime inside the fence.
    pub(crate) fn admit_standing(&self, grant: Grant) -> Result<(), Refusal> {
        let steers = matches!(
            grant,
            Grant::Modify | Grant::Insert | Grant::Interrupt | Grant::Surface | Grant::Hull
        );
        if let Some(reason) = self.lost_because()
            && (steers || is_on(Check::ListWithoutControl))
        {
            return Err(refused("control", reason));
        }
        if !self.control.armed {
            return Err(refused("control", "the runtime is not armed"));
        }
        if self.control.recovering {
            return Err(refused("recovery", "the vehicle is outside the fence"));
        }
        Ok(())
    }

    /// Whether a plugin may steer for so much longer.
    pub(crate) fn cap_steering(&self, plugin: PluginId, duration: Duration) -> Result<(), Refusal> {
        let most = self.plugins[plugin.0].limits().steering_max();
        self.arbiter.cap(self.now, plugin, duration, most)
    }

    /// When the next plugin is due for something.
    pub(crate) fn plugins_due(&self) -> Option<Timestamp> {
        self.plugins.iter().filter_map(Slot::wakes_at).min()
    }

    pub(crate) fn invoke(&mut self, index: usize) {
        let navigation = self.vehicle.navigation.fresh(self.now).copied();
        let (relative, cartesian) = (
            self.vehicle.relative.fresh(self.now),
            self.vehicle.cartesian.fresh(self.now),
        );
        let clocks = self.clocks();
        let (now, control) = (self.now, self.control.granted);
        let slot = &mut self.plugins[index];
        slot.state = State::Running;
        slot.overdue = false;
        slot.invoked = now;
        // A little jitter does not move the cadence; more than that is another phase, navigation's own.
        slot.due = if now.since(slot.due) <= slot.period() / 4 {
            slot.due + slot.period()
        } else {
            now + slot.period()
        };
        let events = std::mem::take(&mut slot.events);
        self.outbox.push(Output::Invoke(
            PluginId(index),
            StepInput {
                now,
                utc: clocks.utc,
                clocks_apart: clocks.apart,
                navigation,
                relative,
                cartesian,
                control,
                events,
            },
        ));
    }

    pub(crate) fn restarted(&mut self, plugin: PluginId, restarted: Restarted) {
        let Some(slot) = self.plugins.get_mut(plugin.0) else {
            return;
        };
        if slot.state != State::Restarting {
            return;
        }
        match restarted.result {
            Ok(()) => {
                slot.state = State::Idle;
                slot.events.clear();
                slot.timers.clear();
                self.note(Note::PluginRestarted { plugin });
                let open = self
                    .ledger
                    .iter()
                    .filter(|(_, entry)| entry.owner == plugin)
                    .map(|(_, entry)| entry.tag)
                    .collect();
                self.tell(
                    plugin,
                    Event::Restored {
                        lost_steps: restarted.lost_steps,
                        open,
                    },
                );
                self.tell(plugin, Event::Control(self.control.granted));
            }
            Err(fault) => {
                // Whatever it says of itself, there is no instance.
                let kind = FaultKind::Start;
                self.failures.push_back((plugin, PluginFault { kind, ..fault }));
            }
        }
    }

    pub(crate) fn back_off(&mut self, plugin: PluginId) {
        let now = self.now;
        let slot = &mut self.plugins[plugin.0];
        let doublings = slot.failures.saturating_sub(1).min(8);
        slot.state = State::BackingOff {
            until: now + BACK_OFF * (1 << doublings),
        };
    }

    pub(crate) fn ask_message(&mut self, plugin: PluginId, text: &str) {
        let now = self.now;
        let slot = &mut self.plugins[plugin.0];
        let in_time = slot.messages.take(now, 1.0) || !is_on(Check::MessageRate);
        if !slot.setup.grants.contains(&Grant::Message) || !in_time {
            return;
        }
        let created = self.stamper.stamp(now, "MSG");
        let cut: String = text.chars().take(MESSAGE_BYTES_MAX).collect();
        // In lower case: there are vehicles that take a sentence for the one whose name its text contains.
        let text = Text::cleaned(&cut.to_lowercase());
        let command = self.courtesy("MSG", Some(created));
        self.transmit(&ToVehicle::LogMessage(LogMessage { created, text }), Some(command));
    }
}
