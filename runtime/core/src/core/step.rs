//! The plugins' steps, and what happens when a plugin fails (safety requirement 006).

use super::Core;
use crate::io::{Note, Output, Restarted};
use crate::monitor::limits::FailAction;
use crate::order::{Condition, Order};
use crate::plugin::slots::{Due, Failed, Instance, Step};
use crate::plugin::{Event, FaultKind, PluginFault, PluginId, Returned, StepInput, Version};

impl Core {
    /// Steps every plugin that is due: with navigation, at its period; without, when such a step is overdue.
    pub(super) fn step_due(&mut self, with_navigation: bool) {
        for plugin in self.cx.plugins.ids() {
            match self.cx.plugins.due(self.cx.now, plugin, with_navigation) {
                Some(Due::Step) => self.invoke(plugin),
                Some(Due::Restart) => self.cx.outbox.push(Output::Restart(plugin)),
                None => {}
            }
        }
    }

    fn invoke(&mut self, plugin: PluginId) {
        let cx = &mut self.cx;
        let clocks = cx.outlook().clocks();
        let input = StepInput {
            now: cx.now,
            utc: clocks.utc,
            clocks_apart: clocks.apart,
            navigation: cx.vehicle.navigation.fresh(cx.now).copied(),
            relative: cx.vehicle.relative.fresh(cx.now),
            cartesian: cx.vehicle.cartesian.fresh(cx.now),
            control: cx.control.granted,
            events: cx.plugins.begin_step(cx.now, plugin),
        };
        cx.outbox.push(Output::Invoke(plugin, input));
    }

    /// A step has returned with what the plugin asks for.
    pub(super) fn returned(&mut self, plugin: PluginId, returned: Returned) {
        for line in returned.log {
            self.cx.note(Note::PluginLog { plugin, line });
        }
        for measure in returned.measures {
            self.cx.note(Note::PluginMeasure { plugin, measure });
        }
        match self.cx.plugins.returned(self.cx.now, plugin) {
            Step::Counts => {}
            Step::Dropped => return,
        }
        match returned.result {
            Ok(requests) => {
                for request in requests {
                    // If the plugin has failed because of the events of these requests, the rest are dropped.
                    if !self.cx.plugins.is_idle(plugin) {
                        break;
                    }
                    self.ask(plugin, &request);
                    if core::mem::take(&mut self.cx.link.wants_beat) {
                        self.session.beat(&mut self.cx);
                    }
                    self.fail_plugins();
                }
            }
            Err(fault) => self.failed(plugin, fault),
        }
        self.begin_swap(plugin);
        if self.cx.plugins.is_overdue(plugin) {
            self.invoke(plugin);
        }
    }

    /// The operator puts another version in a plugin's place. It takes over between two steps; the plugin's requests and
    /// its lease stay.
    pub(super) fn swap(&mut self, plugin: PluginId, version: Version) {
        if self.cx.plugins.want_swap(plugin) {
            self.cx.note(Note::PluginSwap { plugin, to: version });
            self.begin_swap(plugin);
        }
    }

    fn begin_swap(&mut self, plugin: PluginId) {
        if self.cx.plugins.begin_swap(plugin) {
            self.cx.outbox.push(Output::Restart(plugin));
        }
    }

    /// A new instance of a plugin has started, or has failed to.
    pub(super) fn restarted(&mut self, plugin: PluginId, restarted: Restarted) {
        let Some(instance) = self.cx.plugins.restarted(plugin) else {
            return;
        };
        let cx = &mut self.cx;
        match restarted.result {
            Ok(()) => {
                cx.note(match instance {
                    Instance::Same | Instance::Before => Note::PluginRestarted { plugin },
                    Instance::OtherVersion => Note::PluginSwapped { plugin },
                });
                let own = cx.ledger.iter().filter(|(_, entry)| entry.owner == plugin);
                let event = Event::Restored {
                    lost_steps: restarted.lost_steps,
                    open: own.map(|(_, entry)| entry.tag).collect(),
                };
                let control = Event::Control(cx.control.granted);
                cx.plugins.begin_instance(plugin, instance, [event, control]);
                if instance == Instance::Before {
                    self.invoke(plugin);
                }
            }
            Err(fault) if fault.kind == FaultKind::Trial => {
                let PluginFault { text, .. } = fault;
                cx.note(Note::PluginNotSwapped { plugin, text });
            }
            Err(fault) => {
                // Whatever kind of fault it reports, there is no instance.
                let kind = FaultKind::Start;
                self.failed(plugin, PluginFault { kind, ..fault });
            }
        }
        self.begin_swap(plugin);
    }

    /// Handles the plugins that have failed while core was doing something else.
    pub(super) fn fail_plugins(&mut self) {
        while let Some((plugin, fault)) = self.cx.plugins.take_failure() {
            self.failed(plugin, fault);
        }
    }

    /// A plugin has failed: it no longer steers, core does what the mission's `on_failure` says, and the plugin is
    /// restarted later or not at all. The other plugins do not notice it.
    fn failed(&mut self, plugin: PluginId, fault: PluginFault) {
        let Self {
            cx,
            capabilities,
            orders,
            ..
        } = self;
        let Failed {
            then,
            on_failure,
            quarantined,
            returns,
        } = cx.plugins.fail(cx.now, plugin, fault.kind);
        cx.note(Note::PluginFailed { plugin, fault, then });
        capabilities.plugin_failed(cx, plugin);
        if returns {
            cx.outbox.push(Output::Restart(plugin));
        }
        match on_failure {
            FailAction::Yield => {}
            FailAction::Cancel => {
                capabilities.inserts.take_back_judged(cx, Some(plugin));
            }
            FailAction::Abort => {
                capabilities.inserts.take_back_judged(cx, Some(plugin));
                let order = Order::Abort {
                    text: "a plugin failed".to_owned(),
                    errors: true,
                };
                orders.order_in_advance(cx, capabilities, &order);
            }
        }
        if quarantined {
            orders.carry_out(cx, capabilities, |policy| {
                matches!(policy.when, Condition::PluginQuarantined)
            });
        }
    }
}
