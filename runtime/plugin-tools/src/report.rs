mod judgement;
mod page;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Duration;

use backseat_core::plugin::{Description, PluginId};
use backseat_core::{FailAction, Grant};
use backseat_mission::{BudgetTable, Layers, Mission, PluginTable};
use backseat_oracle::Violation;
use backseat_plugin_host::{Budget, COMPILE_TIME, COMPONENT_BYTES, Host, HostError, Stopwatch, Usage};
use backseat_plugin_loader::{Components, LoadError, read_component};
use backseat_scenario::Scenario;
use serde::Serialize;

use crate::component::ComponentFile;
use crate::error::{ToolError, of_file};
use crate::tally::{Fault, KindTally, Tally};
use crate::trial::Flights;

/// What is to be reported.
pub struct Task<'a> {
    /// The component.
    pub component: &'a ComponentFile,
    /// The mission's folder.
    pub mission: &'a Path,
    /// The layers over its `mission.toml`.
    pub layers: Layers,
    /// Which plugin of the mission it is, by name; `None` if that is clear.
    pub plugin: Option<&'a str>,
    /// Where the mission's other plugins are looked for first.
    pub plugins: Option<&'a Path>,
    /// The number of trials, with the seeds from 1 on.
    pub seeds: u64,
    /// The wall-clock limit of a step at sea.
    pub deadline: Duration,
    /// For compilation and steps.
    pub stopwatch: Stopwatch,
}

/// The report on a plugin that an operator reads before signing it off.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// The component's file.
    pub file: PathBuf,
    /// SHA-256 of its content, hexadecimal. What goes to sea must have the same.
    pub sha256: String,
    /// Its size, and the largest that is loaded.
    pub size_bytes: Used<usize>,
    /// How long it took to compile on this computer, and the longest time allowed, seconds.
    pub compile_seconds: Used<f64>,
    /// The versions of `backseat:plugin` that it was built against.
    pub interface: Vec<String>,
    /// What it imports, as its file says.
    pub imports: Vec<String>,
    /// Its imports of WASI; none, or it would not have been compiled.
    pub wasi: Vec<String>,
    /// What it says about itself.
    #[serde(serialize_with = "crate::component::description")]
    pub description: Option<Description>,
    /// The grants without which it cannot work, by its own word. The mission gives them all, or it would not start.
    pub needs: Vec<Grant>,
    /// What the mission gives to it.
    pub mission: OfMission,
    /// The trials.
    pub trials: Trials,
    /// What became of its requests, by kind.
    pub requests: BTreeMap<String, KindTally>,
    /// Grants of the mission that it used.
    pub grants_used: Vec<Grant>,
    /// Grants of the mission that it did not use.
    pub grants_unused: Vec<Grant>,
    /// Grants that it lacked, and how many requests were lost for that.
    pub grants_lacked: BTreeMap<Grant, u64>,
    /// What it used of its budget.
    pub headroom: Headroom,
    /// How it failed.
    pub faults: Vec<Fault>,
    /// How many of its log lines were dropped, because there were too many.
    pub log_lines_dropped: u64,
    /// What the oracle found in the trials.
    pub violations: Vec<TrialFault<Violation>>,
    /// Why it should not go to sea with this mission.
    pub objections: Vec<String>,
    /// What else an operator should know.
    pub remarks: Vec<String>,
}

/// What a mission gives to a plugin.
#[derive(Clone, Debug, Serialize)]
pub struct OfMission {
    /// The mission's folder.
    pub folder: PathBuf,
    /// SHA-256 of its files, hexadecimal.
    pub sha256: String,
    /// The plugin's name in it.
    pub plugin: String,
    /// What the plugin may ask for.
    pub grants: Vec<Grant>,
    /// What the runtime does when the plugin fails.
    pub on_failure: FailAction,
    /// Its configuration.
    pub config: toml::Table,
}

/// The trials of a report.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Trials {
    /// How many, with the seeds from 1 on.
    pub flown: u64,
    /// Simulated time in all of them, seconds.
    pub sim_seconds: f64,
    /// How the missions ended: `completed`, `aborted` or `overran`, and how often.
    pub outcomes: BTreeMap<&'static str, u64>,
    /// Time with control in all of them, seconds.
    pub control_seconds: u64,
    /// Expectations of `world.toml` that did not hold.
    pub unmet: Vec<TrialFault<String>>,
}

/// Something that is wrong in one trial.
#[derive(Clone, Debug, Serialize)]
pub struct TrialFault<T> {
    /// Its seed.
    pub seed: u64,
    /// What.
    pub what: T,
}

/// The most that was used of something in a trial, and what the budget allows.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Used<T> {
    /// The most that was used.
    pub most: T,
    /// The limit.
    pub limit: T,
}

/// What a plugin used of its budget.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Headroom {
    /// Steps in all trials.
    pub steps: u64,
    /// Fuel of a step.
    pub step_fuel: Used<u64>,
    /// Fuel of a snapshot.
    pub snapshot_fuel: Used<u64>,
    /// Linear memory.
    pub memory_bytes: Used<usize>,
    /// Time of a step on this computer, seconds.
    pub step_seconds: Used<f64>,
    /// The mean time of a step on this computer, seconds.
    pub step_seconds_mean: f64,
}

impl Report {
    /// Compiles the component anew, flies the trials, and reports. `progress` is called before each trial with its
    /// seed.
    ///
    /// # Errors
    ///
    /// [`ToolError`] in one line if the component is no plugin, or the mission cannot be flown with it.
    pub fn of(task: &Task<'_>, host: &Host, mut progress: impl FnMut(u64)) -> Result<Self, ToolError> {
        let component = task.component;
        refuse_foreign_imports(component)?;
        let mut mission = Mission::load(task.mission, &task.layers)?;
        let index = plugin_of(&mission, task)?;
        let hash = mission.hash();
        let path = std::path::absolute(&component.path).map_err(of_file(&component.path))?;
        mission.file.plugins[index].component = path.display().to_string();
        let table = mission.file.plugins[index].clone();
        let scenario = Scenario::load(&mission)?;

        let mut components = Components::new();
        let begun = (task.stopwatch)();
        components.insert_file(
            &host.clone().with_cache(None),
            &table.component,
            &table.name,
            component.path.clone(),
            &component.bytes,
        )?;
        let compiled = (task.stopwatch)().saturating_sub(begun);
        load_others(&mut components, host, &mission, task.plugins)?;
        let started = components.start_described(&table.component, &table, &mission)?;
        let (description, needs) = (started.description, started.needs);

        let plugin = PluginId(index);
        let mut tally = Tally::new(plugin);
        let mut usage = Usage::default();
        let mut trials = Trials::default();
        let mut violations = Vec::new();
        let flights = Flights {
            mission: &mission,
            scenario: &scenario,
            components: &components,
        };
        for seed in 1..=task.seeds {
            progress(seed);
            let trial = flights.measure(seed, task.stopwatch.clone(), &mut tally, plugin)?;
            usage = usage.and(trial.usage);
            violations.extend(trial.report.violations.iter().map(|violation| TrialFault {
                seed,
                what: violation.clone(),
            }));
            trials.add(seed, &trial.report);
            // The simulation knows the panic that led to a trap.
            if let Some(first) = trial.report.plugin_first_failures.get(&table.name) {
                let mut same = tally
                    .faults
                    .iter_mut()
                    .filter(|fault| fault.seed == seed && fault.at_s == first.at_s);
                if let Some(fault) = same.next() {
                    fault.text.clone_from(&first.text);
                }
            }
        }
        let mut report = Self {
            file: component.path.clone(),
            sha256: component.sha256.clone(),
            size_bytes: Used {
                most: component.bytes.len(),
                limit: COMPONENT_BYTES,
            },
            compile_seconds: Used {
                most: compiled.as_secs_f64(),
                limit: COMPILE_TIME.as_secs_f64(),
            },
            interface: component.interface.versions(),
            imports: component.interface.imports.clone(),
            wasi: component.interface.wasi().into_iter().map(str::to_owned).collect(),
            description: Some(description),
            needs,
            mission: OfMission {
                folder: task.mission.to_path_buf(),
                sha256: hash,
                plugin: table.name.clone(),
                grants: table.grants.clone(),
                on_failure: table.on_failure,
                config: table.config.clone(),
            },
            trials,
            grants_used: with(&table, |grant| tally.needs.contains_key(grant)),
            grants_unused: with(&table, |grant| !tally.needs.contains_key(grant)),
            grants_lacked: tally
                .needs
                .iter()
                .filter(|(grant, _)| !table.grants.contains(grant))
                .map(|(grant, count)| (*grant, *count))
                .collect(),
            requests: tally.kinds,
            headroom: Headroom::of(&usage, table.budget, task.deadline),
            faults: tally.faults,
            log_lines_dropped: usage.lines_dropped,
            violations,
            objections: Vec::new(),
            remarks: Vec::new(),
        };
        report.judge();
        Ok(report)
    }

    /// Whether there is no objection.
    #[must_use]
    pub fn passed(&self) -> bool {
        self.objections.is_empty()
    }
}

impl Trials {
    fn add(&mut self, seed: u64, report: &backseat_sim::Report) {
        self.flown += 1;
        self.sim_seconds += report.sim_seconds;
        *self.outcomes.entry(report.outcome).or_default() += 1;
        let windows = report.control.windows.iter();
        self.control_seconds += windows
            .map(|window| window.until_s.saturating_sub(window.from_s))
            .sum::<u64>();
        self.unmet.extend(report.unmet.iter().map(|unmet| TrialFault {
            seed,
            what: unmet.clone(),
        }));
    }
}

impl Headroom {
    fn of(usage: &Usage, budget: BudgetTable, deadline: Duration) -> Self {
        let steps = f64::from(u32::try_from(usage.steps.max(1)).unwrap_or(u32::MAX));
        Self {
            steps: usage.steps,
            step_fuel: Used {
                most: usage.step_fuel_max,
                limit: budget.fuel_per_step,
            },
            snapshot_fuel: Used {
                most: usage.snapshot_fuel_max,
                limit: Budget::default().fuel_snapshot,
            },
            memory_bytes: Used {
                most: usage.memory_bytes_max,
                limit: budget.memory_mib as usize * 1024 * 1024,
            },
            step_seconds: Used {
                most: usage.step_time_max.as_secs_f64(),
                limit: deadline.as_secs_f64(),
            },
            step_seconds_mean: usage.step_time_total.as_secs_f64() / steps,
        }
    }
}

/// The grants of a plugin for which this holds.
fn with(table: &PluginTable, holds: impl Fn(&Grant) -> bool) -> Vec<Grant> {
    table.grants.iter().copied().filter(holds).collect()
}

/// Refuses a component that imports more than our interfaces before it is compiled.
fn refuse_foreign_imports(component: &ComponentFile) -> Result<(), ToolError> {
    let foreign = component
        .interface
        .imports
        .iter()
        .find(|import| !import.starts_with("backseat:plugin/"));
    match foreign {
        Some(import) => Err(ToolError::Component(HostError::Import {
            plugin: component.path.display().to_string(),
            import: import.clone(),
            allowed: "interfaces of backseat:plugin",
        })),
        None => Ok(()),
    }
}

/// Which of the mission's plugins the component is: the one that was named, the one whose component has this file's
/// name, or the only one.
fn plugin_of(mission: &Mission, task: &Task<'_>) -> Result<usize, ToolError> {
    let tables = &mission.file.plugins;
    let names = || tables.iter().map(|table| table.name.clone()).collect();
    if let Some(name) = task.plugin {
        let found = tables.iter().position(|table| table.name == name);
        return found.ok_or_else(|| ToolError::NoPlugin {
            mission: task.mission.to_path_buf(),
            name: name.to_owned(),
            plugins: names(),
        });
    }
    let stem = |path: &Path| path.file_stem().map(std::ffi::OsStr::to_os_string);
    let own = stem(&task.component.path);
    let mut same = tables
        .iter()
        .enumerate()
        .filter(|(_, table)| stem(Path::new(&table.component)) == own);
    match (same.next(), same.next(), tables.as_slice()) {
        (Some((index, _)), None, _) => Ok(index),
        (None, None, [_]) => Ok(0),
        (Some(_) | None, Some(_) | None, _) => Err(ToolError::Which {
            mission: task.mission.to_path_buf(),
            plugins: names(),
            component: task.component.path.display().to_string(),
        }),
    }
}

/// Loads the other plugins of the mission.
fn load_others(
    components: &mut Components,
    host: &Host,
    mission: &Mission,
    folder: Option<&Path>,
) -> Result<(), ToolError> {
    for (table, path) in mission.file.plugins.iter().zip(mission.components(folder)?) {
        if components.has(&table.component) {
            continue;
        }
        let bytes = read_component(&path).map_err(|source| LoadError::Read {
            plugin: table.name.clone(),
            path: path.clone(),
            reason: source,
        })?;
        components.insert_file(host, &table.component, &table.name, path, &bytes)?;
    }
    Ok(())
}
