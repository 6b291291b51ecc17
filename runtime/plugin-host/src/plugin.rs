use std::sync::Arc;

use backseat_core::Grant;
use backseat_core::plugin::{
    Description, FaultKind, Judge, LogLine, PluginFault, Refusal, Request, Returned, StepInput,
};
use backseat_core::refusal::Reason;

use crate::instance::{CALL_BYTES, Called, FuelOf, Instance, said};
use crate::lines::{self, Lines};
use crate::measures::Measures;
use crate::meter::Meter;
use crate::v0_2_0::bindings::backseat::plugin::mission::Briefing;
use crate::{Brief, Budget, Component, HostError, v0_2_0};

/// The largest snapshot, bytes.
pub(crate) const SNAPSHOT_BYTES: usize = 1 << 20;

/// The text of the fault of a plugin whose host has panicked on the thread that runs it. The plugin is not used again.
pub const PANICKED: &str = "its thread has panicked";
/// The text of [`FaultKind::Deadline`].
pub(crate) const DEADLINE: &str = "ran past its deadline";
/// Fuel for repeating a step that a wall-clock limit ended: more than it can have used by then, because its budget may
/// have no sensible bound.
const STOPPED_FUEL: u64 = 5_000_000_000;
/// Before the text of a snapshot's fault.
pub(crate) const OF_SNAPSHOT: &str = "snapshot: ";

/// A plugin that is running, or has failed and waits to be restarted.
pub struct Plugin {
    component: Component,
    budget: Budget,
    briefing: Briefing,
    judge: Arc<dyn Judge>,
    deadline_ticks: Option<u64>,
    /// `None` after a fault that loses the instance.
    instance: Option<Instance>,
    /// The last step's input as the guest receives it, kept to reuse its allocations.
    input: v0_2_0::Input,
    snapshot: Option<Vec<u8>>,
    lines: Lines,
    measures: Measures,
    meter: Option<Arc<Meter>>,
    inputs_since_snapshot: u64,
    steps_to_snapshot: u32,
}

/// Answers a plugin that is asked for its description only.
struct NoFence;

impl Judge for NoFence {
    fn judge(&self, _: &Request, _: &StepInput) -> Result<f64, Refusal> {
        Err(Refusal::State(Reason::NotInStep))
    }
}

/// A plugin that has been started.
pub struct Started {
    /// The plugin.
    pub plugin: Plugin,
    /// The plugin's description of itself.
    pub description: Description,
    /// The grants without which it cannot work, by its own word; the mission gives them all. Empty for a plugin that was
    /// made for `wit/v0.1.0`, which cannot say.
    pub needs: Vec<Grant>,
    /// The fuel used.
    pub fuel: u64,
    /// The lines that it logged.
    pub log: Vec<LogLine>,
}

/// The result of restarting a plugin.
#[derive(Clone, Debug, PartialEq)]
pub struct Restarted {
    /// The fuel used.
    pub fuel: u64,
    /// The lines that it logged.
    pub log: Vec<LogLine>,
    /// Whether it is running; if not, the fault, a [`FaultKind::Start`].
    pub result: Result<(), PluginFault>,
    /// The number of inputs since the last snapshot, including the fatal one, which the new instance has not seen.
    pub lost_steps: u64,
}

impl Plugin {
    pub(crate) fn start(
        component: Component,
        budget: Budget,
        brief: &Brief<'_>,
        judge: Arc<dyn Judge>,
    ) -> Result<Started, HostError> {
        let (mut instance, described) = begin(&component, &budget, judge.clone())?;
        let v0_2_0::Described { description, needs } = described;
        let name = component.name().to_owned();
        let lacks = |grant: &Grant| !brief.grants.contains(grant);
        let missing: Vec<Grant> = needs.iter().copied().filter(lacks).collect();
        if !missing.is_empty() {
            return Err(HostError::Grants { plugin: name, missing });
        }
        let mut plugin = Self {
            steps_to_snapshot: budget.snapshot_every_steps,
            component,
            briefing: v0_2_0::briefing(brief, &budget),
            budget,
            judge,
            deadline_ticks: None,
            instance: None,
            input: v0_2_0::Input::default(),
            snapshot: None,
            inputs_since_snapshot: 0,
            lines: Lines::default(),
            measures: Measures::default(),
            meter: None,
        };
        let left = plugin.init(&mut instance);
        let log = lines::of_start(instance.take_log());
        let left = left.map_err(|fault| HostError::Start {
            plugin: name,
            fault: with_last_line(fault, &log),
        })?;
        plugin.instance = Some(instance);
        Ok(Started {
            fuel: plugin.budget.fuel_init - left,
            description,
            needs,
            log,
            plugin,
        })
    }

    /// What a plugin says about itself, and the grants that it needs: without `init`, for which it would need a mission.
    pub(crate) fn describe(component: &Component, budget: &Budget) -> Result<(Description, Vec<Grant>), HostError> {
        let (_, described) = begin(component, budget, Arc::new(NoFence))?;
        Ok((described.description, described.needs))
    }

    /// Runs one step. The returned fuel includes the snapshot's, if one was taken. A fault that loses the instance uses
    /// up the whole budget of the call that failed.
    ///
    /// The judge receives the input without its events.
    pub fn step(&mut self, input: &StepInput) -> Returned {
        self.step_until(input, None)
    }

    /// Repeats a step of a recorded run. Like [`Plugin::step`], but if the wall-clock limit of that run ended the step,
    /// this one ends as well: with as many log lines and published values as the recorded one, and the same fault. The
    /// clock is not asked again.
    pub fn step_again(&mut self, input: &StepInput, recorded: &Returned) -> Returned {
        let stop = match &recorded.result {
            Err(fault) if fault.kind == FaultKind::Deadline && fault.text.starts_with(OF_SNAPSHOT) => {
                Some(Stop::InSnapshot)
            }
            Err(fault) if fault.kind == FaultKind::Deadline => Some(Stop::InStep {
                lines: recorded.log.len(),
                values: recorded.measures.len(),
            }),
            Ok(_) | Err(_) => None,
        };
        self.step_until(input, stop)
    }

    fn step_until(&mut self, input: &StepInput, stop: Option<Stop>) -> Returned {
        self.inputs_since_snapshot += 1;
        let Some(instance) = &mut self.instance else {
            let text = "not running: it failed and has not been restarted".to_owned();
            return Returned {
                fuel: 0,
                log: Vec::new(),
                measures: Vec::new(),
                result: Err(PluginFault {
                    kind: FaultKind::Start,
                    text,
                }),
            };
        };
        instance.allow_lines(self.lines.allowed(input.now));
        instance.published().allow(self.measures.allowed(input.now));
        let guest_input = self.input.fill(input);
        instance.set_step(Some(StepInput {
            events: Vec::new(),
            ..*input
        }));
        let begun = self.meter.as_ref().map(|meter| meter.now());
        let fuel_max = match stop {
            Some(Stop::InStep { .. }) => self.budget.fuel_per_step.min(STOPPED_FUEL),
            Some(Stop::InSnapshot) | None => self.budget.fuel_per_step,
        };
        let Called { mut fuel, result } = match stop {
            // Nothing of it can be compared, and the instance is lost.
            Some(Stop::InStep { lines: 0, values: 0 }) => Called {
                fuel: fuel_max,
                result: Err(deadline()),
            },
            Some(Stop::InStep { .. } | Stop::InSnapshot) | None => instance.call(
                (FuelOf::Step, fuel_max),
                CALL_BYTES,
                self.deadline_ticks,
                |exports, store| exports.step(store, guest_input),
            ),
        };
        instance.set_step(None);
        if let (Some(meter), Some(begun)) = (&self.meter, begun) {
            let used = fuel_max.saturating_sub(instance.fuel_left());
            meter.step(begun, used, instance.memory_bytes());
        }
        let mut result = result.and_then(|returned| match returned {
            Ok(requests) => v0_2_0::requests(requests),
            Err(text) => Err(PluginFault {
                kind: FaultKind::Error,
                text: said(&text),
            }),
        });
        if let Some(Stop::InStep { lines, values }) = stop {
            instance.truncate_log(lines);
            instance.published().truncate(values);
            result = Err(deadline());
        }
        if result.as_ref().is_err_and(loses_the_instance) {
            fuel = self.budget.fuel_per_step;
        }
        if result.is_ok() && self.budget.snapshot_every_steps > 0 {
            self.steps_to_snapshot -= 1;
            if self.steps_to_snapshot == 0 {
                self.steps_to_snapshot = self.budget.snapshot_every_steps;
                let taken = match stop {
                    Some(Stop::InSnapshot) => Called {
                        fuel: self.budget.fuel_snapshot,
                        result: Err(deadline()),
                    },
                    Some(Stop::InStep { .. }) | None => instance.call(
                        (FuelOf::Snapshot, self.budget.fuel_snapshot),
                        SNAPSHOT_BYTES,
                        self.deadline_ticks,
                        |exports, store| exports.snapshot(store),
                    ),
                };
                fuel += taken.fuel;
                if let Some(meter) = &self.meter {
                    meter.snapshot(taken.fuel);
                }
                match taken.result {
                    Ok(state) => {
                        self.snapshot = Some(state);
                        self.inputs_since_snapshot = 0;
                    }
                    Err(fault) => {
                        result = Err(PluginFault {
                            text: format!("{OF_SNAPSHOT}{}", fault.text),
                            kind: fault.kind,
                        });
                    }
                }
            }
        }
        let (lines, dropped) = instance.take_log();
        if let Some(meter) = &self.meter {
            meter.dropped(dropped);
        }
        let mut log = self.lines.keep(input.now, (lines, dropped));
        let measures = self.measures.keep(input.now, instance.published(), &mut log);
        if result.as_ref().is_err_and(loses_the_instance) {
            self.instance = None;
        }
        Returned {
            fuel,
            log,
            measures,
            result,
        }
    }

    /// Restarts the plugin: creates an instance, calls `init`, and `restore` if there is a snapshot. The plugin may
    /// still be running.
    pub fn restart(&mut self) -> Restarted {
        self.instance = None;
        self.steps_to_snapshot = self.budget.snapshot_every_steps;
        let (mut log, mut left) = (Vec::new(), 0);
        let result = self.instantiate().and_then(|mut instance| {
            let started = self
                .init(&mut instance)
                .and_then(|fuel| self.restore(&mut instance, fuel));
            log = lines::of_start(instance.take_log());
            left = started?;
            Ok(instance)
        });
        let result = match result {
            Ok(instance) => {
                self.instance = Some(instance);
                Ok(())
            }
            Err(fault) => Err(PluginFault {
                kind: FaultKind::Start,
                ..with_last_line(fault, &log)
            }),
        };
        Restarted {
            fuel: self.budget.fuel_init - left,
            log,
            result,
            lost_steps: self.inputs_since_snapshot,
        }
    }

    /// Repeats a restart of a recorded run. Like [`Plugin::restart`], but if the wall-clock limit of that run ended it,
    /// this one fails in the same way.
    pub fn restart_again(&mut self, recorded: &Result<(), PluginFault>) -> Restarted {
        if !recorded.as_ref().is_err_and(|fault| fault.text == DEADLINE) {
            return self.restart();
        }
        self.instance = None;
        self.steps_to_snapshot = self.budget.snapshot_every_steps;
        Restarted {
            fuel: self.budget.fuel_init,
            log: Vec::new(),
            result: Err(PluginFault {
                kind: FaultKind::Start,
                ..deadline()
            }),
            lost_steps: self.inputs_since_snapshot,
        }
    }

    /// Hands its state to a version that takes its place: what it says of its state now, or its last snapshot if it is
    /// not running or does not answer. Returns the fuel used. `stops` repeats a recorded run in which the wall-clock limit
    /// ended the snapshot.
    pub(crate) fn hand_over(&mut self, to: &mut Self, stops: bool) -> u64 {
        let mut fuel = 0;
        if let Some(instance) = &mut self.instance {
            let taken = if stops && self.inputs_since_snapshot > 0 {
                Called {
                    fuel: self.budget.fuel_snapshot,
                    result: Err(deadline()),
                }
            } else {
                instance.call(
                    (FuelOf::Snapshot, self.budget.fuel_snapshot),
                    SNAPSHOT_BYTES,
                    self.deadline_ticks,
                    |exports, store| exports.snapshot(store),
                )
            };
            fuel = taken.fuel;
            match taken.result {
                Ok(state) => {
                    self.snapshot = Some(state);
                    self.inputs_since_snapshot = 0;
                }
                Err(fault) if loses_the_instance(&fault) => self.instance = None,
                Err(_) => {}
            }
        }
        to.snapshot.clone_from(&self.snapshot);
        to.inputs_since_snapshot = self.inputs_since_snapshot;
        fuel
    }

    /// Notes that it has not seen this many inputs, because another version was in its place.
    pub(crate) fn miss(&mut self, inputs: u64) {
        self.inputs_since_snapshot += inputs;
    }

    /// Sets the wall-clock backstop of a deployed run: how many calls of [`crate::Host::increment_epoch`] a call of the
    /// plugin may last before it ends with [`FaultKind::Deadline`]. `None`, the default, means no limit.
    pub fn set_deadline_ticks(&mut self, ticks: Option<u64>) {
        self.deadline_ticks = ticks;
    }

    /// Measures every later step. `None`, the default, measures nothing and takes no time.
    pub fn set_meter(&mut self, meter: Option<Arc<Meter>>) {
        self.meter = meter;
    }

    /// Whether it can be stepped; if not, it must be restarted.
    #[must_use]
    pub fn is_running(&self) -> bool {
        self.instance.is_some()
    }

    fn instantiate(&self) -> Result<Instance, PluginFault> {
        let fuel = self.budget.fuel_init;
        Instance::new(
            &self.component,
            &self.budget,
            self.judge.clone(),
            fuel,
            self.deadline_ticks,
        )
    }

    /// Calls `init` on the remaining fuel, and returns what is left.
    fn init(&self, instance: &mut Instance) -> Result<u64, PluginFault> {
        let called = instance.call_on(CALL_BYTES, self.deadline_ticks, |exports, store| {
            exports.init(store, &self.briefing)
        });
        called.result?.map_err(|text| PluginFault {
            kind: FaultKind::Start,
            text: said(&text),
        })?;
        Ok(instance.fuel_left())
    }

    /// Calls `restore` if there is a snapshot, on the remaining fuel, and returns what is left.
    fn restore(&self, instance: &mut Instance, fuel: u64) -> Result<u64, PluginFault> {
        let Some(snapshot) = &self.snapshot else {
            return Ok(fuel);
        };
        let called = instance.call_on(CALL_BYTES, self.deadline_ticks, |exports, store| {
            exports.restore(store, snapshot)
        });
        let of_restore = |text: &str| format!("restore: {text}");
        let returned = called.result.map_err(|fault| PluginFault {
            text: match fault.kind == FaultKind::Deadline {
                // By these words a replay knows it.
                true => fault.text,
                false => of_restore(&fault.text),
            },
            ..fault
        })?;
        returned.map_err(|text| PluginFault {
            kind: FaultKind::Start,
            text: of_restore(&said(&text)),
        })?;
        Ok(instance.fuel_left())
    }
}

/// Creates an instance and calls `describe`.
fn begin(
    component: &Component,
    budget: &Budget,
    judge: Arc<dyn Judge>,
) -> Result<(Instance, v0_2_0::Described), HostError> {
    let name = || component.name().to_owned();
    let start = |fault| HostError::Start { plugin: name(), fault };
    let instance = Instance::new(component, budget, judge, budget.fuel_init, None);
    let mut instance = instance.map_err(|fault| {
        if fault.kind == FaultKind::Start {
            HostError::Interface {
                plugin: name(),
                interface: component.interface().name(),
                reason: fault.text,
            }
        } else {
            start(fault)
        }
    })?;
    let described = instance.call_on(CALL_BYTES, None, |exports, store| exports.describe(store));
    let described = described
        .result
        .map_err(|fault| start(with_last_line(fault, &lines::of_start(instance.take_log()))))?;
    let described = v0_2_0::description(described).map_err(|(what, expected)| HostError::Description {
        plugin: name(),
        what,
        expected,
    })?;
    Ok((instance, described))
}

/// What ended in a recorded run when its wall-clock limit was reached.
#[derive(Clone, Copy)]
enum Stop {
    /// The step, after so many log lines and published values.
    InStep { lines: usize, values: usize },
    /// The snapshot after it.
    InSnapshot,
}

/// The wall-clock limit was reached.
fn deadline() -> PluginFault {
    PluginFault {
        kind: FaultKind::Deadline,
        text: DEADLINE.to_owned(),
    }
}

fn loses_the_instance(fault: &PluginFault) -> bool {
    fault.kind != FaultKind::Error
}

/// Adds the last line that the plugin logged, because a trap gives no reason and that line often does.
fn with_last_line(fault: PluginFault, log: &[LogLine]) -> PluginFault {
    match log.last() {
        Some(line) if fault.kind == FaultKind::Trap => PluginFault {
            text: format!("{}; it logged: {}", fault.text, line.text),
            ..fault
        },
        Some(_) | None => fault,
    }
}
