use std::path::Path;

use anyhow::Result;
use backseat_mission::{Layers, Mission};
use backseat_plugin_loader::Components;
use backseat_plugin_tools::{Flights, Kit, Project, unit_tests};
use backseat_scenario::Scenario;
use backseat_sim::Report;
use clap::Args;
use clap::value_parser;

use super::Folder;
use super::build::build_project;
use crate::cache::host_with;
use crate::output::say;
use crate::terminal::tell;

#[derive(Debug, Args)]
pub(crate) struct Test {
    #[command(flatten)]
    folder: Folder,
    /// How many flights, with the seeds from 1 on
    #[arg(long, default_value_t = 5, value_name = "N", value_parser = value_parser!(u64).range(1..=100_000))]
    seeds: u64,
}

pub(super) fn test(arguments: &Test) -> Result<bool> {
    let project = Project::open(&arguments.folder.dir)?;
    // A mission with a mistake is told before the tests and the build, which take longer.
    let folder = project.mission();
    let layers = Layers {
        set: Vec::new(),
        environment: true,
    };
    let mission = Mission::load(&folder, &layers)?;
    let scenario = Scenario::load(&mission)?;
    let kit = Kit::ready()?;
    if !unit_tests(&project, &kit, &tell)? {
        say!("the unit tests failed, so nothing was built and flown");
        return Ok(false);
    }
    build_project(&project, &kit)?;
    let flown = fly(&project, &mission, &scenario, arguments.seeds)?;
    say!(
        "{}: unit tests passed, {} of {} flights met what is expected",
        project.name(),
        flown,
        arguments.seeds
    );
    Ok(flown == arguments.seeds)
}

/// Flies the project's mission. Returns how many flights met what is expected.
fn fly(project: &Project, mission: &Mission, scenario: &Scenario, seeds: u64) -> Result<u64> {
    let paths = mission.components(None)?;
    project.require_flown(&paths)?;
    let components = Components::load(&host_with(true)?, mission, None)?;
    let flights = Flights {
        mission,
        scenario,
        components: &components,
    };
    let mut good = 0;
    for seed in 1..=seeds {
        let report = flights.fly(seed)?;
        say!("{}", line(&project.mission(), &report));
        good += u64::from(faults(&report).is_empty());
    }
    Ok(good)
}

/// A flight in a line.
fn line(folder: &Path, report: &Report) -> String {
    let Report {
        seed,
        outcome,
        requests,
        ..
    } = report;
    let mut text = format!(
        "{}, seed {seed}: {outcome} after {:.1} min; requests: {requests}",
        folder.display(),
        report.sim_seconds / 60.0
    );
    let faults = faults(report);
    if faults.is_empty() {
        text.push_str("; all expectations met");
    } else {
        text.push_str(&format!("; NOT MET: {}", faults.join("; ")));
    }
    text
}

/// What was expected and did not happen, and what nobody has to state as expected: that no plugin fails.
fn faults(report: &Report) -> Vec<String> {
    let failures = report.plugin_first_failures.iter();
    let failed = failures.map(|(plugin, first)| {
        let how_often = match report.plugin_failures.get(plugin) {
            Some(count) if *count > 1 => format!("{count} times, first"),
            _ => "once,".to_owned(),
        };
        format!(
            "plugin {plugin} failed {how_often} at {:.1} s: {}",
            first.at_s, first.text
        )
    });
    failed.chain(report.unmet.iter().cloned()).collect()
}
