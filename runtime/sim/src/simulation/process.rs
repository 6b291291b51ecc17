use std::sync::Arc;
use std::time::Duration;

use backseat_core::plugin::{NavigationSample, PluginId, Returned, StepInput, Version};
use backseat_core::{Core, Envelope, Input, Operator, Reservation, Restarted, Settings, Start};
use backseat_plugin_host::{Plugin, Seat};
use backseat_plugin_loader::Loaded;
use backseat_sonar_bridge::Bridge;
use backseat_units::{Position, Timestamp};

use crate::simulation::sonars::Client;

/// A unit of fuel takes a nanosecond, which is close to what a present-day processor needs.
const FUEL_PER_SECOND: u64 = 1_000_000_000;

/// A process of the runtime: everything that is gone when it is killed.
pub(super) struct Process {
    pub(super) core: Core,
    /// The client of the sonars, if the mission has any.
    pub(super) client: Option<Client>,
    /// When it began. Its own clock counts from there.
    epoch: Timestamp,
    plugins: Vec<Slot>,
    answers: Vec<(Timestamp, PluginId, Answer)>,
    pub(super) connect_at: Option<Timestamp>,
    pub(super) reserved: Option<Reservation>,
    pub(super) reset: bool,
    /// Its connection is open, as far as it knows.
    pub(super) linked: bool,
    pub(super) stopped: Option<Stopped>,
    recorded_navigation: Option<Timestamp>,
}

/// A plugin, and the other plugin that stands in for it.
struct Slot {
    plugin: Seat,
    understudy: Option<Seat>,
}

/// A plugin's answer that is under way.
pub(super) enum Answer {
    Returned(Returned),
    Restarted(Restarted),
}

/// What waits for a process that a signal has stopped.
pub(super) struct Stopped {
    pub(super) until: Timestamp,
    /// Bytes that the operating system has taken from the connection.
    pub(super) piled: Vec<u8>,
    pub(super) acts: Vec<Operator>,
    /// The connection has ended.
    pub(super) reset: bool,
}

/// The process that follows one that was killed.
pub(super) struct Successor {
    pub(super) at: Timestamp,
    pub(super) loaded: Loaded,
    pub(super) clock_step_ns: i64,
}

/// When a process has something to do.
#[derive(Default)]
pub(super) struct Due {
    pub(super) answer: Option<Timestamp>,
    pub(super) connect: Option<Timestamp>,
    /// Core's timers, or the end of a stop.
    pub(super) wakes: Option<Timestamp>,
    /// The client of the sonars has something to do.
    pub(super) client: Option<Timestamp>,
}

impl Process {
    pub(super) fn new(
        epoch: Timestamp,
        settings: Settings,
        envelope: Arc<Envelope>,
        loaded: Loaded,
        start: Start,
        bridge: Option<Bridge>,
    ) -> Self {
        let slot = |plugin| Slot {
            plugin: Seat::new(plugin),
            understudy: None,
        };
        Self {
            core: Core::new(settings, envelope, loaded.setups, start),
            client: bridge.map(Client::new),
            epoch,
            plugins: loaded.plugins.into_iter().map(slot).collect(),
            answers: Vec::new(),
            connect_at: None,
            reserved: None,
            reset: false,
            linked: false,
            stopped: None,
            recorded_navigation: None,
        }
    }

    pub(super) fn due(&self) -> Due {
        if let Some(stopped) = &self.stopped {
            return Due {
                wakes: Some(stopped.until),
                ..Due::default()
            };
        }
        Due {
            answer: self.answers.iter().map(|(at, _, _)| *at).min(),
            connect: self.connect_at,
            wakes: self
                .core
                .poll_timeout()
                .map(|at| self.epoch + at.since(Timestamp::ZERO)),
            client: self
                .client
                .as_ref()
                .and_then(Client::due)
                .map(|at| self.epoch + at.since(Timestamp::ZERO)),
        }
    }

    /// A time of the run on the process's own clock.
    pub(super) fn own_time(&self, now: Timestamp) -> Timestamp {
        Timestamp::ZERO + now.since(self.epoch)
    }

    pub(super) fn handle(&mut self, now: Timestamp, input: Input<'_>) {
        match input {
            Input::LinkUp => self.linked = true,
            Input::LinkDown => self.linked = false,
            Input::Received(_)
            | Input::Returned(..)
            | Input::Restarted(..)
            | Input::Swap(..)
            | Input::Operator(_)
            | Input::External(..)
            | Input::Reserved(_)
            | Input::Sonar(_)
            | Input::UtcSet(_)
            | Input::Timeout => {}
        }
        let own = self.own_time(now);
        self.core.handle(own, input);
    }

    /// Removes and returns the answer that is due first. Of several that are due at once, the oldest.
    pub(super) fn next_answer(&mut self) -> Option<(PluginId, Answer)> {
        let first = self.answers.iter().enumerate().min_by_key(|(_, (at, _, _))| *at)?.0;
        let (_, plugin, answer) = self.answers.remove(first);
        Some((plugin, answer))
    }

    pub(super) fn step(&mut self, now: Timestamp, plugin: PluginId, input: &StepInput) {
        let returned = self.plugins[plugin.0].flown().step(input);
        let at = now + Duration::from_nanos(returned.fuel * (1_000_000_000 / FUEL_PER_SECOND));
        self.answers.push((at, plugin, Answer::Returned(returned)));
    }

    pub(super) fn restart(&mut self, now: Timestamp, plugin: PluginId) {
        let restarted = self.plugins[plugin.0].flown().restart();
        let at = now + Duration::from_nanos(restarted.fuel * (1_000_000_000 / FUEL_PER_SECOND));
        self.answers.push((at, plugin, Answer::Restarted(restarted)));
    }

    pub(super) fn substitute(&mut self, plugin: PluginId, understudy: Option<Plugin>) {
        if let Some(slot) = self.plugins.get_mut(plugin.0) {
            slot.understudy = understudy.map(Seat::new);
        }
    }

    /// Whether another plugin stands in for this one.
    pub(super) fn has_understudy(&self, plugin: PluginId) -> bool {
        let slot = self.plugins.get(plugin.0);
        slot.is_some_and(|slot| slot.understudy.is_some())
    }

    /// Has a version take a plugin's place at its next restart.
    pub(super) fn offer(&mut self, plugin: PluginId, ready: Plugin, version: Version) {
        if let Some(slot) = self.plugins.get_mut(plugin.0) {
            slot.plugin.offer(ready, version);
        }
    }

    /// A signal stops the process, with the threads of its plugins, until `until`.
    pub(super) fn stop(&mut self, now: Timestamp, until: Timestamp) {
        let stopped_until = self.stopped.as_ref().map_or(now, |stopped| stopped.until);
        let longer = until.since(stopped_until);
        for (at, _, _) in &mut self.answers {
            *at = *at + longer;
        }
        let stopped = self.stopped.get_or_insert_with(|| Stopped {
            until,
            piled: Vec::new(),
            acts: Vec::new(),
            reset: false,
        });
        stopped.until = stopped.until.max(until);
    }

    /// Whether core has asked to be woken by now.
    pub(super) fn is_due(&self, now: Timestamp) -> bool {
        let own = self.own_time(now);
        self.core.poll_timeout().is_some_and(|at| at <= own)
    }

    /// The monitor's newest navigation, if it has changed since the last call.
    pub(super) fn new_navigation(&mut self) -> Option<&NavigationSample> {
        let sample = self.core.navigation()?;
        if self.recorded_navigation == Some(sample.solution) {
            return None;
        }
        self.recorded_navigation = Some(sample.solution);
        Some(sample)
    }

    pub(super) fn position(&self) -> Option<Position> {
        self.core.navigation().map(|navigation| navigation.position)
    }
}

impl Slot {
    /// The plugin that answers now: its understudy, if there is one.
    fn flown(&mut self) -> &mut Seat {
        self.understudy.as_mut().unwrap_or(&mut self.plugin)
    }
}
