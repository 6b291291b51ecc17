//! Plugins as core sees them: when each is stepped, what it is told, and what becomes of it when it fails. One step of a
//! plugin is under way at a time; core never waits for it (safety requirement 006).

use std::collections::VecDeque;
use std::time::Duration;

use backseat_units::Timestamp;

use crate::monitor::limits::plugin::PluginLimits;
use crate::monitor::limits::{FailAction, Grant};
use crate::mutations::{Check, is_on};
use crate::outbox::budget::LineBudget;
use crate::plugin::{Event, FaultKind, PluginFault, PluginId, Topic};
use crate::settings::PluginSetup;

/// More events than this for one plugin while it runs, and it has failed.
const EVENTS_MAX: usize = 256;
/// A plugin that fails this often is quarantined.
const FAILURES_MAX: u32 = 5;
/// Failures longer ago than this are forgiven.
const FORGIVEN_AFTER: Duration = Duration::from_secs(600);
const BACK_OFF: Duration = Duration::from_secs(1);
/// So many timers of one plugin are set at once.
pub(crate) const TIMERS_MAX: usize = 64;
/// A plugin is stepped no more often than this, whatever its timers say.
const PERIOD_MIN: Duration = Duration::from_millis(20);

/// Where a plugin stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
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
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
struct Slot {
    #[cfg_attr(feature = "explore", serde(skip))]
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
    over_rate: LineBudget,
    messages: Allowance,
    /// How many tracklines and trackcircles of its have been sent.
    inserts_sent: u32,
}

impl Slot {
    fn new(setup: PluginSetup) -> Self {
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

    fn is_quarantined(&self) -> bool {
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

    fn back_off(&mut self, now: Timestamp) {
        let doublings = self.failures.saturating_sub(1).min(8);
        self.state = State::BackingOff {
            until: now + BACK_OFF * (1 << doublings),
        };
    }
}

/// How often something may be asked: so many at once as in a second, refilled as time passes.
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
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

/// The plugins of the mission, in priority order, and what each is to be told.
#[derive(Debug)]
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub(crate) struct Plugins {
    slots: Vec<Slot>,
    /// Those that have failed while something else was being done, which is finished first.
    failures: VecDeque<(PluginId, PluginFault)>,
}

/// What is due of a plugin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Due {
    /// A step.
    Step,
    /// Another instance.
    Restart,
}

/// What becomes of a step that has returned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Step {
    /// Its requests are heard.
    Counts,
    /// It is over, and so is all that it asks for.
    Dropped,
}

/// What is done about a failure.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Failed {
    /// In words.
    pub(crate) then: &'static str,
    pub(crate) on_failure: FailAction,
    pub(crate) quarantined: bool,
}

impl Plugins {
    pub(crate) fn new(setups: Vec<PluginSetup>) -> Self {
        Self {
            slots: setups.into_iter().map(Slot::new).collect(),
            failures: VecDeque::new(),
        }
    }

    /// All of them, in priority order.
    pub(crate) fn ids(&self) -> impl Iterator<Item = PluginId> + use<> {
        (0..self.slots.len()).map(PluginId)
    }

    pub(crate) fn name(&self, plugin: PluginId) -> &str {
        &self.slots[plugin.0].setup.name
    }

    pub(crate) fn limits(&self, plugin: PluginId) -> &PluginLimits {
        &self.slots[plugin.0].setup.limits
    }

    pub(crate) fn grants(&self, plugin: PluginId) -> &[Grant] {
        &self.slots[plugin.0].setup.grants
    }

    /// Whether any of them has a grant.
    pub(crate) fn any_has(&self, grant: Grant) -> bool {
        self.slots.iter().any(|slot| slot.setup.grants.contains(&grant))
    }

    pub(crate) fn wants(&self, plugin: PluginId, topic: Topic) -> bool {
        self.slots[plugin.0].setup.description.topics.contains(&topic)
    }

    pub(crate) fn any_is_quarantined(&self) -> bool {
        self.slots.iter().any(Slot::is_quarantined)
    }

    /// How many tracklines and trackcircles of a plugin's have been sent.
    pub(crate) fn inserts_sent(&self, plugin: PluginId) -> u32 {
        self.slots[plugin.0].inserts_sent
    }

    pub(crate) fn count_insert(&mut self, plugin: PluginId) {
        self.slots[plugin.0].inserts_sent += 1;
    }

    /// Takes one of the requests that a plugin may make in a second, where one is left.
    pub(crate) fn take_request(&mut self, now: Timestamp, plugin: PluginId, per_second: f64) -> bool {
        self.slots[plugin.0].requests.take(now, per_second)
    }

    /// The same of its messages to the vehicle's log.
    pub(crate) fn take_message(&mut self, now: Timestamp, plugin: PluginId) -> bool {
        self.slots[plugin.0].messages.take(now, 1.0)
    }

    /// Whether a rejection for the rate is told by itself; else it is counted.
    pub(crate) fn tells_over_rate(&mut self, now: Timestamp, plugin: PluginId) -> bool {
        self.slots[plugin.0].over_rate.take(now)
    }

    /// How many rejections for the rate were counted and not told since this was last asked.
    pub(crate) fn take_dropped(&mut self, plugin: PluginId) -> u64 {
        self.slots[plugin.0].over_rate.take_dropped()
    }

    /// A plugin is told of something with its next step.
    pub(crate) fn tell(&mut self, plugin: PluginId, event: Event) {
        let slot = &mut self.slots[plugin.0];
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

    pub(crate) fn tell_all(&mut self, event: &Event) {
        for plugin in self.ids() {
            self.tell(plugin, event.clone());
        }
    }

    /// Those are told that listen to a topic.
    pub(crate) fn tell_wanting(&mut self, topic: Topic, event: &Event) {
        for plugin in self.ids() {
            if self.wants(plugin, topic) {
                self.tell(plugin, event.clone());
            }
        }
    }

    /// Sets a timer of a plugin's; false where it has as many as it may.
    pub(crate) fn set_timer(&mut self, now: Timestamp, plugin: PluginId, id: u64, after: Duration) -> bool {
        let timers = &mut self.slots[plugin.0].timers;
        let room = timers.len() < TIMERS_MAX;
        if room {
            timers.push((now + after.max(PERIOD_MIN), id));
        }
        room
    }

    /// When the next plugin is due for something.
    pub(crate) fn wakes_at(&self) -> Option<Timestamp> {
        self.slots.iter().filter_map(Slot::wakes_at).min()
    }

    /// What is due of a plugin: a step with navigation at its period, without when that is overdue.
    pub(crate) fn due(&mut self, now: Timestamp, plugin: PluginId, with_navigation: bool) -> Option<Due> {
        let slot = &mut self.slots[plugin.0];
        // Navigation's own jitter must not make a step wait for the next one.
        let (early, due) = if with_navigation {
            (slot.period() / 10, slot.due)
        } else {
            (Duration::ZERO, slot.due_without_navigation())
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
                return (timed || filling || now + early >= due).then_some(Due::Step);
            }
            State::Running if with_navigation && now + early >= due => slot.overdue = true,
            State::BackingOff { until } if until <= now => {
                slot.state = State::Restarting;
                return Some(Due::Restart);
            }
            State::Running | State::Condemned | State::BackingOff { .. } | State::Restarting | State::Quarantined => {}
        }
        None
    }

    /// A step begins; what the plugin is told with it.
    pub(crate) fn begin_step(&mut self, now: Timestamp, plugin: PluginId) -> Vec<Event> {
        let slot = &mut self.slots[plugin.0];
        slot.state = State::Running;
        slot.overdue = false;
        slot.invoked = now;
        // A little jitter does not move the cadence; more than that is another phase, navigation's own.
        slot.due = if now.since(slot.due) <= slot.period() / 4 {
            slot.due + slot.period()
        } else {
            now + slot.period()
        };
        std::mem::take(&mut slot.events)
    }

    /// A step has returned.
    pub(crate) fn returned(&mut self, now: Timestamp, plugin: PluginId) -> Step {
        let Some(slot) = self.slots.get_mut(plugin.0) else {
            return Step::Dropped;
        };
        match slot.state {
            State::Running => {
                slot.state = State::Idle;
                return Step::Counts;
            }
            State::Condemned => slot.back_off(now),
            State::Idle | State::BackingOff { .. } | State::Restarting | State::Quarantined => {}
        }
        Step::Dropped
    }

    /// Whether a plugin waits for nothing but its next step.
    pub(crate) fn is_idle(&self, plugin: PluginId) -> bool {
        self.slots[plugin.0].state == State::Idle
    }

    /// Whether a step was due while the last one was under way.
    pub(crate) fn is_overdue(&self, plugin: PluginId) -> bool {
        self.slots[plugin.0].overdue && self.is_idle(plugin)
    }

    /// Whether another instance was awaited, which has come, or has failed to.
    pub(crate) fn restarted(&mut self, plugin: PluginId) -> bool {
        let Some(slot) = self.slots.get_mut(plugin.0) else {
            return false;
        };
        let awaited = slot.state == State::Restarting;
        if awaited {
            slot.state = State::Idle;
            slot.events.clear();
            slot.timers.clear();
        }
        awaited
    }

    /// The next plugin that has failed meanwhile.
    pub(crate) fn take_failure(&mut self) -> Option<(PluginId, PluginFault)> {
        self.failures.pop_front()
    }

    /// A plugin has failed: it comes back later or not at all.
    pub(crate) fn fail(&mut self, now: Timestamp, plugin: PluginId, kind: FaultKind) -> Failed {
        let slot = &mut self.slots[plugin.0];
        if now.since(slot.failed_at) > FORGIVEN_AFTER {
            slot.failures = 0;
        }
        slot.failures += 1;
        slot.failed_at = now;
        let lost = kind != FaultKind::Error;
        let then = if slot.failures > FAILURES_MAX {
            slot.state = State::Quarantined;
            slot.events.clear();
            "it is quarantined"
        } else if lost && slot.state == State::Running {
            slot.state = State::Condemned;
            "it will be restarted"
        } else if lost {
            slot.back_off(now);
            "it will be restarted"
        } else {
            "it goes on"
        };
        Failed {
            then,
            on_failure: if is_on(Check::AbortByPolicy) {
                slot.setup.on_failure
            } else {
                FailAction::Abort
            },
            quarantined: slot.is_quarantined(),
        }
    }
}
