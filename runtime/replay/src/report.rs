use std::fmt;

use backseat_recorder::Rate;
use serde::Serialize;

use crate::difference::{Difference, StepDifference};
use crate::drawing::Drawing;

/// What a replay found.
#[derive(Clone, Debug, Serialize)]
pub struct Report {
    /// The mission's name.
    pub mission: String,
    /// The simulation's seed; `None` for a dive.
    pub seed: Option<u64>,
    /// The version of the program that wrote the log.
    pub version: String,
    /// `simulation` or `deployed`.
    pub rate: &'static str,
    /// How much of the run was replayed, seconds.
    pub seconds: f64,
    /// Whether the log has its end. The log of a killed process has none.
    pub complete: bool,
    /// How many processes of the runtime there were: a simulation can kill one and begin another.
    pub processes: u64,
    /// How many inputs core handled.
    pub inputs: u64,
    /// How many outputs were compared.
    pub outputs: u64,
    /// How many of them differ.
    pub outputs_different: u64,
    /// How many steps and restarts ended at the wall-clock limit of the recorded run, or with a panic of its host, and
    /// here without asking a clock.
    pub stops_played: u64,
    /// The plugins, in priority order.
    pub plugins: Vec<PluginReport>,
    /// Whether everything is identical: all outputs of core, and what each plugin returned; of a plugin that takes the
    /// place of another one, what it asked for. `None` if no difference was found, but a part could not be replayed.
    pub identical: Option<bool>,
    /// The first difference in the order of the log.
    pub first_difference: Option<Difference>,
    /// Why the rest of the log was not replayed.
    pub refused: Option<Refused>,
    /// For a picture.
    #[serde(skip)]
    pub drawing: Drawing,
}

/// Why a replay ended before the log.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(tag = "why", rename_all = "kebab-case")]
pub enum Refused {
    /// The disk did not accept records in time.
    Gap {
        /// Since when records are missing, seconds of the run.
        since_s: f64,
        /// Until when.
        until_s: f64,
        /// How many.
        records: u64,
    },
    /// Messages are missing, and the log does not say why: it was edited or damaged.
    Missing {
        /// The first sequence number that is missing.
        from: u32,
        /// The next one that is there.
        until: u32,
        /// When, seconds of the run.
        at_s: f64,
    },
}

/// A version that the operator put in a plugin's place, and whose component is neither in the log nor given.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Absent {
    /// Its SHA-256, hexadecimal.
    pub sha256: String,
    /// When it was to take over, seconds of the run. From then on the plugin's steps could not be compared.
    pub at_s: f64,
}

/// How a plugin fared.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct PluginReport {
    /// Its name in the mission.
    pub name: String,
    /// The component that was stepped.
    pub component: Component,
    /// How many steps were compared.
    pub steps: u64,
    /// How many restarts after a failure were compared.
    pub restarts: u64,
    /// How many versions the operator put in its place.
    pub swaps: u64,
    /// How many of these could not take over, or failed on trial, so that the version before stayed or came back.
    pub swaps_failed: u64,
    /// How many steps and restarts could not be compared, because a simulation had put another plugin in its place, or the
    /// operator a version that is `absent`.
    pub unplayed: u64,
    /// The first version that is not there.
    pub absent: Option<Absent>,
    /// In how many steps and restarts it differs. If it takes the place of another plugin, only what it asks for and
    /// whether it fails count.
    pub different: u64,
    /// How many requests were recorded in the steps that were compared.
    pub requests_recorded: u64,
    /// How many it asked for now.
    pub requests_now: u64,
    /// How often it failed now.
    pub failures: u64,
    /// The first steps that differ, as many as were asked for.
    pub different_steps: Vec<StepDifference>,
}

/// Where a component came from.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Component {
    /// The file that was given; `None` for the one in the log.
    pub file: Option<String>,
    /// Its SHA-256, hexadecimal.
    pub sha256: String,
    /// The SHA-256 of the one that flew.
    pub recorded_sha256: String,
    /// The version that it reports.
    pub version: String,
    /// Whether its config was changed.
    pub config_changed: bool,
    /// Whether it takes the place of another plugin: another component, or another config.
    pub other: bool,
}

impl Refused {
    /// In one line, fit to follow the log's name.
    #[must_use]
    pub fn line(&self) -> String {
        match self {
            Self::Gap {
                since_s,
                until_s,
                records,
            } => format!(
                "{records} records are missing from {since_s:.3} s to {until_s:.3} s, because the disk was too slow: \
                 nothing after that can be replayed"
            ),
            Self::Missing { from, until, at_s } => format!(
                "messages {from} to {} are missing at {at_s:.3} s, so the file was edited or damaged: nothing after that \
                 can be replayed",
                until.wrapping_sub(1)
            ),
        }
    }
}

impl fmt::Display for Absent {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "the operator put a version in its place that the log has by its hash alone, because it is large: give the file \
             with --component FILE (SHA-256 {})",
            self.sha256
        )
    }
}

impl Report {
    /// The plugins of which a version is not there, with that version.
    pub fn absent(&self) -> impl Iterator<Item = (&str, &Absent)> {
        self.plugins
            .iter()
            .filter_map(|plugin| Some((plugin.name.as_str(), plugin.absent.as_ref()?)))
    }

    /// In lines for people, with the first differences.
    #[must_use]
    pub fn lines(&self) -> Vec<String> {
        let seed = self.seed.map_or_else(String::new, |seed| format!(", seed {seed}"));
        let cut = if self.complete || self.refused.is_some() {
            ""
        } else {
            ", cut short: the process was killed, or its disk was full; the log is replayed as far as it goes"
        };
        let mut lines = vec![format!("{}{seed}, {:.1} min{cut}", self.mission, self.seconds / 60.0)];
        if self.processes > 1 {
            lines.push(format!("  {} processes, each from its start", self.processes));
        }
        lines.push(match self.outputs_different {
            0 => format!(
                "  core: {} outputs of {} inputs, all identical",
                self.outputs, self.inputs
            ),
            different => format!(
                "  core: {different} of {} outputs of {} inputs differ",
                self.outputs, self.inputs
            ),
        });
        lines.extend(self.plugins.iter().map(|plugin| format!("  {}", plugin.line())));
        if self.stops_played > 0 {
            lines.push(format!(
                "  {} calls of plugins ended where the clock of the run had ended them",
                self.stops_played
            ));
        }
        if let Some(refused) = &self.refused {
            lines.push(format!("  {}", refused.line()));
        }
        if let Some(first) = &self.first_difference {
            let mut first_lines = first.lines().into_iter();
            if let Some(line) = first_lines.next() {
                lines.push(format!("  first difference: {line}"));
            }
            lines.extend(first_lines.map(|line| format!("  {line}")));
        }
        for plugin in &self.plugins {
            let shown = plugin
                .different_steps
                .iter()
                .filter(|step| match &self.first_difference {
                    Some(Difference::Step(first)) => first != *step,
                    _ => true,
                });
            for step in shown {
                lines.extend(step.lines().into_iter().map(|line| format!("  {line}")));
            }
        }
        lines.push(match self.identical {
            Some(true) => "  identical".to_owned(),
            Some(false) => "  not identical".to_owned(),
            None => "  identical as far as it was replayed".to_owned(),
        });
        lines
    }
}

impl PluginReport {
    fn line(&self) -> String {
        let Self {
            name,
            component,
            steps,
            restarts,
            swaps,
            swaps_failed,
            different,
            ..
        } = self;
        let from = match &component.file {
            Some(file) => format!(" ({file}, version {})", component.version),
            None => String::new(),
        };
        let config = if component.config_changed {
            " with another config"
        } else {
            ""
        };
        let mut line = format!("{name}{from}{config}: {steps} steps");
        if *restarts > 0 {
            line.push_str(&format!(", restarts: {restarts}"));
        }
        if *swaps > 0 {
            line.push_str(&format!(", swaps: {swaps}"));
        }
        if *swaps_failed > 0 {
            line.push_str(&format!(" ({swaps_failed} failed)"));
        }
        match (component.other, different) {
            (false, 0) => line.push_str(", all identical"),
            (true, 0) => line.push_str(", and it asks for the same in each"),
            (_, different) => line.push_str(&format!(", {different} differ")),
        }
        if component.other || *different > 0 {
            line.push_str(&format!(
                "; {} requests recorded, {} now",
                self.requests_recorded, self.requests_now
            ));
        }
        if component.other && self.failures > 0 {
            line.push_str(&format!("; it failed {} times", self.failures));
        }
        if let Some(absent) = &self.absent {
            line.push_str(&format!("; not compared from {:.3} s on: {absent}", absent.at_s));
        } else if self.unplayed > 0 {
            line.push_str(&format!(
                "; {} steps of another plugin that stood in for it are not in the log",
                self.unplayed
            ));
        }
        line
    }
}

/// The rate's name in a report.
pub(crate) const fn rate_name(rate: Rate) -> &'static str {
    match rate {
        Rate::Simulation => "simulation",
        Rate::Deployed => "deployed",
    }
}
