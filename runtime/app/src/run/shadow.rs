//! Plugins in the shadow of others (`run --shadow NAME=FILE`): each gets the inputs of the plugin NAME on a thread of its
//! own. What it asks for is judged and logged. Nothing leads from here to core, so nothing of it is ever sent.

use std::path::PathBuf;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::time::Duration;

use anyhow::{Context, Result, bail};
use backseat_core::plugin::{Judge, PluginId, Request, StepInput};
use backseat_lock::sha256;
use backseat_mission::Mission;
use backseat_plugin_host::{Host, Plugin};
use backseat_plugin_loader::{Components, read_component};
use backseat_recorder::{Judged, ShadowStep};
use backseat_units::Timestamp;
use tokio::sync::mpsc::{UnboundedReceiver, UnboundedSender, unbounded_channel};
use tracing::{info, warn};

use crate::aside;
use crate::lock::Allowed;
use crate::plugins::DEADLINE_TICKS;

/// How many steps may wait for a shadow.
const WAITING: usize = 4;
/// A shadow that failed is started again after this.
const BACK_OFF: Duration = Duration::from_secs(1);
/// A shadow that failed more often than this is stepped no more.
const FAILURES_MAX: u64 = 5;

/// The shadows of a run.
#[derive(Default)]
pub(crate) struct Shadows {
    shadows: Vec<Shadow>,
    steps: Option<UnboundedReceiver<(usize, ShadowStep)>>,
}

struct Shadow {
    plugin: PluginId,
    name: String,
    inputs: SyncSender<(Box<StepInput>, u64)>,
    /// Steps that found no room since the last one that did.
    missed: u64,
    counts: Counts,
    /// The last refusal that the screen has shown.
    told: Option<String>,
}

#[derive(Clone, Copy, Debug, Default)]
struct Counts {
    steps: u64,
    missed: u64,
    requests: u64,
    refused: u64,
    failures: u64,
}

impl Shadows {
    /// Compiles and starts these components. With `allowed`, only those.
    ///
    /// # Errors
    /// If one of them cannot be used.
    pub(crate) fn start(
        files: &[(String, PathBuf)],
        host: &Host,
        mission: &Arc<Mission>,
        allowed: Option<&Allowed>,
    ) -> Result<Self> {
        let (sender, steps) = unbounded_channel();
        let mut shadows = Vec::new();
        for (index, (name, file)) in files.iter().enumerate() {
            let option = || format!("--shadow {name}={}", file.display());
            let tables = &mission.file.plugins;
            let Some(place) = tables.iter().position(|table| table.name == *name) else {
                let names: Vec<&str> = tables.iter().map(|table| table.name.as_str()).collect();
                bail!(
                    "{}: no plugin {name} in the mission; its plugins are: {}",
                    option(),
                    names.join(", ")
                );
            };
            let component = read_component(file).with_context(option)?;
            let hash = sha256(&component);
            if let Some(allowed) = allowed {
                allowed.check(name, &hash).with_context(option)?;
            }
            let mut components = Components::new();
            components.insert_file(host, &hash, name, file.clone(), &component)?;
            let started = components.start_described(&hash, &tables[place], mission)?;
            info!(
                "shadow of {name}: version {} ({}); nothing that it asks for is sent",
                started.description.version,
                &hash[..12]
            );
            let mut plugin = started.plugin;
            plugin.set_deadline_ticks(Some(DEADLINE_TICKS));
            let (inputs, receiver) = sync_channel(WAITING);
            let member = Member {
                index,
                name: name.clone(),
                sha256: hash,
                plugin,
                judge: mission.envelope.clone(),
                failures: 0,
                again_at: None,
            };
            let steps = sender.clone();
            aside::spawn(format!("shadow {index}"), move || member.serve(&receiver, &steps))?;
            shadows.push(Shadow {
                plugin: PluginId(place),
                name: name.clone(),
                inputs,
                missed: 0,
                counts: Counts::default(),
                told: None,
            });
        }
        Ok(Self {
            steps: (!shadows.is_empty()).then_some(steps),
            shadows,
        })
    }

    /// Core asks a plugin for a step.
    pub(crate) fn step(&mut self, plugin: PluginId, input: &StepInput) {
        for shadow in self.shadows.iter_mut().filter(|shadow| shadow.plugin == plugin) {
            match shadow.inputs.try_send((Box::new(input.clone()), shadow.missed)) {
                Ok(()) => shadow.missed = 0,
                Err(TrySendError::Full(_) | TrySendError::Disconnected(_)) => shadow.missed += 1,
            }
        }
    }

    /// The next step that a shadow has done; waits for ever where there is none.
    pub(crate) async fn next(&mut self) -> ShadowStep {
        if let Some(steps) = &mut self.steps {
            if let Some((index, step)) = steps.recv().await {
                self.shadows[index].tell(&step);
                return step;
            }
            // All their threads have ended.
            self.steps = None;
        }
        std::future::pending().await
    }

    /// Sums up what they did.
    pub(crate) fn sum_up(&self) {
        for Shadow {
            name, counts, missed, ..
        } in &self.shadows
        {
            let Counts {
                steps,
                missed: before,
                requests,
                refused,
                failures,
            } = counts;
            info!(
                "shadow of {name}: {steps} steps, {requests} requests of which {refused} would be refused, {failures} \
                 failures, {} steps missed; nothing was sent",
                before + missed
            );
        }
    }
}

impl Shadow {
    /// Counts a step, and shows on the screen what somebody should see now.
    fn tell(&mut self, step: &ShadowStep) {
        let name = &self.name;
        self.counts.steps += 1;
        self.counts.missed += step.missed;
        self.counts.requests += step.requests.len() as u64;
        for line in &step.log {
            info!("shadow of {name} says: {}", line.text);
        }
        if let Some(fault) = &step.fault {
            self.counts.failures += 1;
            let then = if self.counts.failures > FAILURES_MAX {
                "it is stepped no more"
            } else {
                "it will be restarted"
            };
            warn!("shadow of {name} failed ({:?}): {}; {then}", fault.kind, fault.text);
        }
        for refusal in step.judged.iter().filter_map(|judged| judged.refusal.as_ref()) {
            self.counts.refused += 1;
            // As with plugins, a request that is refused again and again is reported once.
            let rule = refusal.split(':').next().unwrap_or_default();
            if self.told.as_deref() != Some(rule) {
                self.told = Some(rule.to_owned());
                warn!("shadow of {name}: would be rejected: {refusal}");
            }
        }
    }
}

/// A shadow on its thread.
struct Member {
    index: usize,
    name: String,
    sha256: String,
    plugin: Plugin,
    judge: Arc<backseat_core::Envelope>,
    failures: u64,
    /// It waits until then before it is started again.
    again_at: Option<Timestamp>,
}

impl Member {
    fn serve(mut self, inputs: &Receiver<(Box<StepInput>, u64)>, steps: &UnboundedSender<(usize, ShadowStep)>) {
        let mut missed = 0;
        while let Ok((input, before)) = inputs.recv() {
            missed += before;
            if self.failures > FAILURES_MAX || self.again_at.is_some_and(|at| input.now < at) {
                missed += 1;
                continue;
            }
            let step = self.step(&input, std::mem::take(&mut missed));
            if steps.send((self.index, step)).is_err() {
                return;
            }
        }
    }

    fn step(&mut self, input: &StepInput, missed: u64) -> ShadowStep {
        let mut done = ShadowStep {
            plugin: self.name.clone(),
            sha256: self.sha256.clone(),
            step_s: input.now.as_secs_f64(),
            fuel: 0,
            log: Vec::new(),
            requests: Vec::new(),
            judged: Vec::new(),
            fault: None,
            missed,
        };
        if self.again_at.take().is_some() && !self.plugin.is_running() {
            let restarted = self.plugin.restart();
            done.log = restarted.log;
            done.fault = restarted.result.err();
        }
        if done.fault.is_none() {
            let returned = self.plugin.step(input);
            done.fuel = returned.fuel;
            done.log.extend(returned.log);
            match returned.result {
                Ok(requests) => {
                    done.judged = requests.iter().map(|request| self.judged(request, input)).collect();
                    done.requests = requests;
                }
                Err(fault) => done.fault = Some(fault),
            }
        }
        if done.fault.is_some() {
            self.failures += 1;
            self.again_at = Some(input.now + BACK_OFF);
        }
        done
    }

    fn judged(&self, request: &Request, input: &StepInput) -> Judged {
        match self.judge.judge(request, input) {
            Ok(clearance_m) => Judged {
                allowed: true,
                // What has no geometry has the largest clearance.
                clearance_m: (clearance_m < f64::MAX).then_some(clearance_m),
                refusal: None,
            },
            Err(refusal) => Judged {
                allowed: false,
                clearance_m: None,
                refusal: Some(refusal.to_string()),
            },
        }
    }
}
