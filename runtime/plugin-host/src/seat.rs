use std::collections::BTreeSet;

use backseat_core::Restarted;
use backseat_core::plugin::{
    Event, FaultKind, PluginFault, Refusal, Request, RequestState, Returned, Rule, StepInput, Version,
};

use crate::plugin::{DEADLINE, OF_SNAPSHOT, Plugin};

/// The place of a plugin in a mission. The operator can put another version there between two steps: it takes over the
/// state of the one before by `snapshot` and `restore`, and is on trial for some steps. If it fails in them, or is refused
/// something, the version before it comes back, with the state that it had.
pub struct Seat {
    plugin: Plugin,
    candidate: Option<Candidate>,
    trial: Option<Trial>,
    passed: Option<Version>,
}

/// A version that takes over at the next restart.
struct Candidate {
    plugin: Plugin,
    version: Version,
}

/// What is known of the version that is on trial.
struct Trial {
    /// The version before it, as it was when it was replaced.
    before: Plugin,
    version: Version,
    steps_left: u32,
    /// How many inputs the version before has not seen.
    inputs: u64,
    /// The tags of its own requests.
    asked: BTreeSet<u64>,
}

/// What the next restart of a seat does.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NextRestart {
    /// Begins the plugin again.
    Begins,
    /// Puts the version in its place that was offered.
    TakesOver,
    /// Brings back the version before the one on trial.
    BringsBack,
}

/// What a recorded run has returned, which this one repeats.
enum Again<'a> {
    No,
    Step(&'a Returned),
    Restart(&'a Restarted),
}

impl Seat {
    /// A seat with a plugin that has been started.
    #[must_use]
    pub const fn new(plugin: Plugin) -> Self {
        Self {
            plugin,
            candidate: None,
            trial: None,
            passed: None,
        }
    }

    /// The plugin that is stepped now.
    #[must_use]
    pub const fn plugin(&self) -> &Plugin {
        &self.plugin
    }

    /// Has this version, which has been started, take over at the next [`Seat::restart`].
    pub fn offer(&mut self, plugin: Plugin, version: Version) {
        self.candidate = Some(Candidate { plugin, version });
    }

    /// What the next [`Seat::restart`] does.
    #[must_use]
    pub const fn next_restart(&self) -> NextRestart {
        match (&self.candidate, &self.trial) {
            (Some(_), _) => NextRestart::TakesOver,
            (None, Some(_)) => NextRestart::BringsBack,
            (None, None) => NextRestart::Begins,
        }
    }

    /// The version that has just passed its trial.
    pub fn take_passed(&mut self) -> Option<Version> {
        self.passed.take()
    }

    /// Runs one step, as [`Plugin::step`]. If a version on trial fails in it, or learns that it was refused something,
    /// the result is a fault of the kind `Trial`, and the next restart brings back the version before it.
    pub fn step(&mut self, input: &StepInput) -> Returned {
        self.do_step(input, &Again::No)
    }

    /// Repeats a step of a recorded run, as [`Plugin::step_again`].
    pub fn step_again(&mut self, input: &StepInput, recorded: &Returned) -> Returned {
        self.do_step(input, &Again::Step(recorded))
    }

    fn do_step(&mut self, input: &StepInput, again: &Again<'_>) -> Returned {
        let Some(trial) = &mut self.trial else {
            return stepped(&mut self.plugin, input, again);
        };
        trial.inputs += 1;
        if let Some(refusal) = trial.refused(input) {
            return Returned {
                fuel: 0,
                log: Vec::new(),
                measures: Vec::new(),
                result: Err(trial.fault(&format!("refused: {refusal}"))),
            };
        }
        let returned = stepped(&mut self.plugin, input, again);
        match &returned.result {
            Ok(requests) => {
                trial.asked.extend(requests.iter().filter_map(Request::tag));
                trial.steps_left -= 1;
                if trial.steps_left == 0 {
                    self.passed = self.trial.take().map(|trial| trial.version);
                }
                returned
            }
            Err(fault) => Returned {
                result: Err(trial.fault(&fault.text)),
                ..returned
            },
        }
    }

    /// Restarts the plugin, as [`Plugin::restart`]; or puts the version in its place that was offered, or the version
    /// before one that is on trial.
    ///
    /// If the version that was offered cannot take over and the present one can go on, the result is a fault of the kind
    /// `Trial`, and nothing has changed.
    pub fn restart(&mut self) -> Restarted {
        self.do_restart(&Again::No)
    }

    /// Repeats a restart of a recorded run, as [`Plugin::restart_again`].
    pub fn restart_again(&mut self, recorded: &Restarted) -> Restarted {
        self.do_restart(&Again::Restart(recorded))
    }

    fn do_restart(&mut self, again: &Again<'_>) -> Restarted {
        if let Some(candidate) = self.candidate.take() {
            return self.swap(candidate, again);
        }
        if let Some(Trial { before, inputs, .. }) = self.trial.take() {
            self.plugin = before;
            self.plugin.miss(inputs);
        }
        restarted(&mut self.plugin, again)
    }

    fn swap(&mut self, candidate: Candidate, again: &Again<'_>) -> Restarted {
        let Candidate { mut plugin, version } = candidate;
        let stops = match again {
            Again::Restart(recorded) => recorded.lost_steps > 0,
            Again::No | Again::Step(_) => false,
        };
        let fuel = self.plugin.hand_over(&mut plugin, stops);
        let mut taken = restarted(&mut plugin, again);
        taken.fuel += fuel;
        match &mut taken.result {
            Ok(()) => {
                let before = std::mem::replace(&mut self.plugin, plugin);
                self.trial = (version.trial_steps > 0).then(|| Trial {
                    before,
                    steps_left: version.trial_steps,
                    version,
                    inputs: 0,
                    asked: BTreeSet::new(),
                });
            }
            Err(fault) if self.plugin.is_running() => fault.kind = FaultKind::Trial,
            Err(_) => {}
        }
        taken
    }
}

impl Trial {
    /// The first refusal of its own requests that the input tells of.
    fn refused<'a>(&self, input: &'a StepInput) -> Option<&'a Refusal> {
        input.events.iter().find_map(|event| {
            let Event::Outcome {
                tag,
                state: RequestState::Rejected(refusal),
            } = event
            else {
                return None;
            };
            (self.asked.contains(tag) && is_its_own(refusal.rule())).then_some(refusal)
        })
    }

    fn fault(&self, text: &str) -> PluginFault {
        PluginFault {
            kind: FaultKind::Trial,
            text: format!("{}{text}", self.prefix()),
        }
    }

    fn prefix(&self) -> String {
        format!("version {} on trial: ", self.version.version)
    }
}

/// Whether a request is refused for what it asks for, and not for the state of the vehicle or the runtime.
const fn is_its_own(rule: Rule) -> bool {
    match rule {
        Rule::KeepIn
        | Rule::KeepOut
        | Rule::Depth
        | Rule::Altitude
        | Rule::Surfacing
        | Rule::Time
        | Rule::Station
        | Rule::Limit
        | Rule::Grant
        | Rule::Rate
        | Rule::Cap
        | Rule::Tag
        | Rule::Text
        | Rule::Layout => true,
        Rule::Control
        | Rule::Recovery
        | Rule::Navigation
        | Rule::Plan
        | Rule::Priority
        | Rule::Interrupt
        | Rule::Identifier
        | Rule::Doubt
        | Rule::GpsHit
        | Rule::Window
        | Rule::Pause
        | Rule::Heard
        | Rule::Plugin
        | Rule::State => false,
    }
}

fn stepped(plugin: &mut Plugin, input: &StepInput, again: &Again<'_>) -> Returned {
    let Again::Step(recorded) = again else {
        return plugin.step(input);
    };
    // The fault of a version on trial has its text after a prefix.
    let stop = recorded
        .result
        .as_ref()
        .err()
        .filter(|fault| fault.kind == FaultKind::Trial);
    let stop = stop.filter(|fault| fault.text.ends_with(DEADLINE));
    let Some(stop) = stop else {
        return plugin.step_again(input, recorded);
    };
    let in_snapshot = format!("{OF_SNAPSHOT}{DEADLINE}");
    let text = if stop.text.ends_with(&in_snapshot) {
        in_snapshot
    } else {
        DEADLINE.to_owned()
    };
    let recorded = Returned {
        result: Err(PluginFault {
            kind: FaultKind::Deadline,
            text,
        }),
        ..(*recorded).clone()
    };
    plugin.step_again(input, &recorded)
}

fn restarted(plugin: &mut Plugin, again: &Again<'_>) -> Restarted {
    let now = match again {
        Again::Restart(recorded) => plugin.restart_again(&recorded.result),
        Again::No | Again::Step(_) => plugin.restart(),
    };
    Restarted {
        fuel: now.fuel,
        lost_steps: now.lost_steps,
        result: now.result,
    }
}
