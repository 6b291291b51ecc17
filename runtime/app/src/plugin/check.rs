use std::path::{Path, PathBuf};

use anyhow::Result;
use backseat_mission::{Layers, Mission};
use backseat_plugin_tools::{Report, Task, ToolError};
use clap::{Args, value_parser};
use serde_json::json;

use super::{read_component, stale, stopwatch};
use crate::cache::host_with;
use crate::output::say;
use crate::plugins::DEADLINE;
use crate::sim::progress_bar;

#[derive(Debug, Args)]
pub(crate) struct Check {
    /// A component, or a plugin's folder with its component
    #[arg(value_name = "DIR|FILE.wasm", default_value = ".")]
    component: PathBuf,
    /// The mission that the plugin is to fly in [default: the folder `mission` beside the component]
    #[arg(long, value_name = "MISSION")]
    mission: Option<PathBuf>,
    /// Which plugin of the mission it is, by its name there [default: the one whose component has this file's name, or
    /// the only one]
    #[arg(long, value_name = "NAME")]
    plugin: Option<String>,
    /// Look in this folder first for other plugins that the mission names without a path
    #[arg(long, value_name = "DIR", value_parser = crate::arguments::folder)]
    plugins: Option<PathBuf>,
    /// How many trials, with the seeds from 1 on
    #[arg(long, default_value_t = 20, value_name = "N", value_parser = value_parser!(u64).range(1..=100_000))]
    seeds: u64,
    /// Set a key of mission.toml, such as limits.speed_max_mps=1.8; overrides the file and the environment
    #[arg(long, value_name = "KEY=VALUE")]
    set: Vec<String>,
    /// Print one JSON object on standard output and nothing else
    #[arg(long)]
    json: bool,
}

pub(super) fn check(arguments: &Check) -> Result<bool> {
    let component = read_component(&arguments.component)?;
    let mission = match &arguments.mission {
        Some(mission) => mission.clone(),
        None => mission_beside(&component.path)?,
    };
    let task = Task {
        component: &component,
        mission: &mission,
        layers: Layers {
            set: arguments.set.clone(),
            environment: true,
        },
        plugin: arguments.plugin.as_deref(),
        plugins: arguments.plugins.as_deref(),
        seeds: arguments.seeds,
        deadline: DEADLINE,
        stopwatch: stopwatch(),
    };
    let progress = progress_bar(arguments.json);
    let report = Report::of(&task, &host_with(true)?, |seed| {
        progress.set_message(format!("trial {seed} of {}", arguments.seeds));
        progress.tick();
    });
    progress.finish_and_clear();
    let mut report = report?;
    report.remarks.extend(stale(&arguments.component)?);
    if arguments.mission.is_none() {
        report
            .remarks
            .extend(not_flown(&component.path, &mission, arguments.plugins.as_deref())?);
    }
    if arguments.json {
        let mut object = serde_json::to_value(&report)?;
        object["passed"] = json!(report.passed());
        say!("{object}");
    } else {
        say!("{report}");
    }
    Ok(report.passed())
}

/// In one line, if the mission beside a component flies another one.
fn not_flown(component: &Path, mission: &Path, plugins: Option<&Path>) -> Result<Option<String>> {
    let layers = Layers {
        set: Vec::new(),
        environment: true,
    };
    let own = component.canonicalize()?;
    let loaded = Mission::load(mission, &layers)?;
    // The paths, and the bare names; where one component is missing there are no bare names.
    let mut named: Vec<PathBuf> = loaded
        .file
        .plugins
        .iter()
        .map(|table| mission.join(&table.component))
        .collect();
    named.extend(loaded.components(plugins).unwrap_or_default());
    if named
        .iter()
        .any(|path| path.canonicalize().is_ok_and(|path| path == own))
    {
        return Ok(None);
    }
    let name = own.file_name().unwrap_or_default().display();
    Ok(Some(format!(
        "{}/mission.toml: no plugin has component = \"../{name}\": the trials flew it, and `sim` and `run` do not",
        mission.display()
    )))
}

/// The mission of the folder that a component is in.
fn mission_beside(component: &Path) -> Result<PathBuf, ToolError> {
    let mission = component.with_file_name("mission");
    if mission.is_dir() {
        Ok(mission)
    } else {
        Err(ToolError::NoMission { path: mission })
    }
}
