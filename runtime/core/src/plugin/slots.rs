//! Plugins as core sees them: when each is stepped, which events it gets, and what happens when it fails. At most one
//! step of a plugin is under way at a time, and core never waits for it (safety requirement 006).

use std::collections::VecDeque;
use std::time::Duration;

use backseat_units::Timestamp;

use crate::monitor::limits::plugin::PluginLimits;
use crate::monitor::limits::{FailAction, Grant};
use crate::mutations::{Check, is_on};
use crate::outbox::budget::LineBudget;
use crate::plugin::{Event, FaultKind, PINGS_MAX, PluginFault, PluginId, SonarPing, Topic};
use crate::settings::PluginSetup;

/// A plugin fails if more events than this wait for its next step.
const EVENTS_MAX: usize = 256;
/// A plugin that fails more often than this is quarantined.
const FAILURES_MAX: u32 = 5;
/// The count of failures starts again if the last failure was longer ago than this.
const FORGIVEN_AFTER: Duration = Duration::from_secs(600);
/// What happens to a plugin that has failed too often, in words.
pub const QUARANTINED: &str = "it is quarantined";
const BACK_OFF: Duration = Duration::from_secs(1);
/// How many timers of one plugin can be set at once.
pub(crate) const TIMERS_MAX: usize = 64;
/// The shortest time between two steps of a plugin, whatever its timers say.
const PERIOD_MIN: Duration = Duration::from_millis(20);

/// The state of a plugin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
enum State {
    Idle,
    /// A step is under way.
    Running,
    /// A step is under way, and its result will be dropped.
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
    /// Its next step was due while one was under way.
    overdue: bool,
    timers: Vec<(Timestamp, u64)>,
    failures: u32,
    failed_at: Timestamp,
    requests: Allowance,
    /// Limits how many rejections for its rate are logged one by one.
    over_rate: LineBudget,
    messages: Allowance,
    /// How many of its tracklines and trackcircles have been sent.
    inserts_sent: u32,
    swap: Swap,
}

/// Another version that the operator puts in a plugin's place.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
enum Swap {
    None,
    /// It takes over when the plugin does nothing else.
    Wanted,
    /// It is taking over.
    Begun,
    /// It has failed on trial, and the version before it comes back.
    Returns,
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
            swap: Swap::None,
        }
    }

    fn is_quarantined(&self) -> bool {
        self.state == State::Quarantined
    }

    /// Whether messages of the vehicle fill the queue before the plugin's next step is due. Outcomes do not count,
    /// because they answer the plugin's own requests: otherwise the more a plugin asks for, the more often it would be
    /// stepped.
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

    /// When a step is due without navigation. Steps normally come with navigation; if none comes, they come without it,
    /// half a period late.
    fn due_without_navigation(&self) -> Timestamp {
        self.due + self.period() / 2
    }

    fn wakes_at(&self) -> Option<Timestamp> {
        match self.state {
            State::Idle => {
                let timer = self.timers.iter().map(|(at, _)| *at).min();
                let due = self.due_without_navigation();
                // A plugin whose queue fills is stepped early.
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

/// A limit on how often a plugin may ask for something: as many at once as in a second, refilled as time passes.
#[derive(Clone, Copy, Debug, Default)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
struct Allowance {
    used: f64,
    at: Timestamp,
}

impl Allowance {
    /// Takes one, if one is left.
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

/// The plugins of the mission, in priority order, and the events that wait for each.
#[derive(Debug)]
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub(crate) struct Plugins {
    slots: Vec<Slot>,
    /// Plugins that have failed while core was doing something else, which it finishes first.
    failures: VecDeque<(PluginId, PluginFault)>,
}

/// What a plugin is due for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Due {
    /// A step.
    Step,
    /// A new instance.
    Restart,
}

/// What to do with the result of a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Step {
    /// Its requests count.
    Counts,
    /// Its requests are dropped.
    Dropped,
}

/// What follows from a failure.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Failed {
    /// What happens to the plugin, in words.
    pub(crate) then: &'static str,
    pub(crate) on_failure: FailAction,
    pub(crate) quarantined: bool,
    /// The version before it comes back at once.
    pub(crate) returns: bool,
}

/// What a new instance is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Instance {
    /// The version that was there.
    Same,
    /// The version that the operator has put in its place.
    OtherVersion,
    /// The version before one that has failed on trial. It is stepped at once, because it may have to steer on.
    Before,
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

    /// Whether there is such a plugin.
    pub(crate) fn includes(&self, plugin: PluginId) -> bool {
        plugin.0 < self.slots.len()
    }

    pub(crate) fn wants(&self, plugin: PluginId, topic: Topic) -> bool {
        self.slots[plugin.0].setup.description.topics.contains(&topic)
    }

    pub(crate) fn any_is_quarantined(&self) -> bool {
        self.slots.iter().any(Slot::is_quarantined)
    }

    /// How many tracklines and trackcircles of a plugin have been sent.
    pub(crate) fn inserts_sent(&self, plugin: PluginId) -> u32 {
        self.slots[plugin.0].inserts_sent
    }

    pub(crate) fn count_insert(&mut self, plugin: PluginId) {
        self.slots[plugin.0].inserts_sent += 1;
    }

    /// Takes one of the requests that a plugin may make in a second, if one is left.
    pub(crate) fn take_request(&mut self, now: Timestamp, plugin: PluginId, per_second: f64) -> bool {
        self.slots[plugin.0].requests.take(now, per_second)
    }

    /// The same for its messages to the vehicle's log, one a second.
    pub(crate) fn take_message(&mut self, now: Timestamp, plugin: PluginId) -> bool {
        self.slots[plugin.0].messages.take(now, 1.0)
    }

    /// Whether a rejection for the rate is logged by itself; otherwise it is only counted.
    pub(crate) fn tells_over_rate(&mut self, now: Timestamp, plugin: PluginId) -> bool {
        self.slots[plugin.0].over_rate.take(now)
    }

    /// How many rejections for the rate were only counted since the last call.
    pub(crate) fn take_dropped(&mut self, plugin: PluginId) -> u64 {
        self.slots[plugin.0].over_rate.take_dropped()
    }

    /// Gives a plugin an event with its next step.
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

    /// Gives a plugin a ping with its next step. If [`PINGS_MAX`] wait already, the oldest is dropped: a plugin that is
    /// slower than its sonar has not failed.
    pub(crate) fn tell_ping(&mut self, plugin: PluginId, ping: SonarPing) {
        let is_ping = |event: &Event| matches!(event, Event::Sidescan(_) | Event::SubBottom(_));
        let events = &mut self.slots[plugin.0].events;
        if events.iter().filter(|event| is_ping(event)).count() >= PINGS_MAX
            && let Some(oldest) = events.iter().position(is_ping)
        {
            events.remove(oldest);
        }
        let event = if ping.sub_bottom {
            Event::SubBottom(ping)
        } else {
            Event::Sidescan(ping)
        };
        self.tell(plugin, event);
    }

    pub(crate) fn tell_all(&mut self, event: &Event) {
        for plugin in self.ids() {
            self.tell(plugin, event.clone());
        }
    }

    /// Gives an event to the plugins that asked for a topic.
    pub(crate) fn tell_wanting(&mut self, topic: Topic, event: &Event) {
        for plugin in self.ids() {
            if self.wants(plugin, topic) {
                self.tell(plugin, event.clone());
            }
        }
    }

    /// Sets a timer of a plugin. Returns false if it has as many as it may have.
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

    /// What a plugin is due for. With navigation, a step is due at its period; without, when such a step is overdue.
    pub(crate) fn due(&mut self, now: Timestamp, plugin: PluginId, with_navigation: bool) -> Option<Due> {
        let slot = &mut self.slots[plugin.0];
        // Jitter of navigation must not make a step wait for the next navigation.
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

    /// Begins a step. Returns the events that the plugin gets with it.
    pub(crate) fn begin_step(&mut self, now: Timestamp, plugin: PluginId) -> Vec<Event> {
        let slot = &mut self.slots[plugin.0];
        slot.state = State::Running;
        slot.overdue = false;
        slot.invoked = now;
        // A little jitter does not shift the schedule. After a longer delay the schedule takes navigation's phase.
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

    /// The operator wants another version of a plugin. Returns whether there is such a plugin.
    pub(crate) fn want_swap(&mut self, plugin: PluginId) -> bool {
        let slot = self.slots.get_mut(plugin.0);
        slot.map(|slot| slot.swap = Swap::Wanted).is_some()
    }

    /// Begins a swap that is wanted, if the plugin does nothing else. A plugin that waits to be restarted, or is
    /// quarantined, begins anew with the other version.
    pub(crate) fn begin_swap(&mut self, plugin: PluginId) -> bool {
        let Some(slot) = self.slots.get_mut(plugin.0).filter(|slot| slot.swap == Swap::Wanted) else {
            return false;
        };
        match slot.state {
            State::Idle => {}
            State::BackingOff { .. } | State::Quarantined => slot.failures = 0,
            State::Running | State::Condemned | State::Restarting => return false,
        }
        slot.state = State::Restarting;
        slot.swap = Swap::Begun;
        true
    }

    /// A new instance has started or has failed to. Returns which one it is, if core was waiting for one.
    pub(crate) fn restarted(&mut self, plugin: PluginId) -> Option<Instance> {
        let slot = self.slots.get_mut(plugin.0)?;
        if slot.state != State::Restarting {
            return None;
        }
        slot.state = State::Idle;
        if slot.swap == Swap::Begun {
            slot.swap = Swap::None;
            return Some(Instance::OtherVersion);
        }
        slot.events.clear();
        slot.timers.clear();
        if slot.swap == Swap::Returns {
            slot.swap = Swap::None;
            return Some(Instance::Before);
        }
        Some(Instance::Same)
    }

    /// A new instance works. It gets these events first. One of another version that took over between two steps also
    /// gets what has come since; it sets its timers itself.
    pub(crate) fn begin_instance(&mut self, plugin: PluginId, instance: Instance, events: [Event; 2]) {
        let slot = &mut self.slots[plugin.0];
        match instance {
            Instance::Same | Instance::Before => slot.events.extend(events),
            Instance::OtherVersion => {
                slot.events.splice(0..0, events);
                slot.timers.clear();
            }
        }
    }

    /// The next plugin that has failed in the meantime.
    pub(crate) fn take_failure(&mut self) -> Option<(PluginId, PluginFault)> {
        self.failures.pop_front()
    }

    /// A plugin has failed: it continues, is restarted later, or is quarantined.
    pub(crate) fn fail(&mut self, now: Timestamp, plugin: PluginId, kind: FaultKind) -> Failed {
        let slot = &mut self.slots[plugin.0];
        if kind == FaultKind::Trial {
            slot.state = State::Restarting;
            if slot.swap == Swap::None {
                slot.swap = Swap::Returns;
            }
            return Failed {
                then: "the version before comes back",
                on_failure: FailAction::Yield,
                quarantined: false,
                returns: true,
            };
        }
        if now.since(slot.failed_at) > FORGIVEN_AFTER {
            slot.failures = 0;
        }
        slot.failures += 1;
        slot.failed_at = now;
        let lost = kind != FaultKind::Error;
        let then = if slot.failures > FAILURES_MAX {
            slot.state = State::Quarantined;
            slot.events.clear();
            QUARANTINED
        } else if lost && slot.state == State::Running {
            slot.state = State::Condemned;
            "it will be restarted"
        } else if lost {
            slot.back_off(now);
            "it will be restarted"
        } else {
            "it continues"
        };
        Failed {
            then,
            on_failure: if is_on(Check::AbortByPolicy) {
                slot.setup.on_failure
            } else {
                FailAction::Abort
            },
            quarantined: slot.is_quarantined(),
            returns: false,
        }
    }
}
