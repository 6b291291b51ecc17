//! `backseat plugin`: the tools of a plugin's author.

mod build;
mod check;
mod inspect;
mod new;
mod test;

use std::path::PathBuf;
use std::sync::Arc;

use anyhow::Result;
use backseat_plugin_tools::{ComponentFile, Project, Stopwatch};
use clap::{Args, Subcommand};

use crate::clock::Clock;
use crate::terminal::tell;

#[derive(Debug, Subcommand)]
pub(crate) enum Plugin {
    /// Make a new plugin in the folder NAME
    ///
    /// The folder has a crate or a Python module with unit tests, and the mission of its test flights. A crate also has a
    /// Cargo.lock with the versions that this program was tested with. The plugin depends on the SDK, which this program
    /// unpacks once for each version into BACKSEAT_KIT [default: backseat/kit in XDG_DATA_HOME, or in ~/.local/share].
    New(new::New),
    /// Build the component of a plugin, DIR/NAME.wasm
    ///
    /// In Rust the same sources give the same component, byte for byte, wherever the folder is, as long as the SDK is at
    /// the same place. It imports nothing of the system (no WASI). For a plugin in Python this program installs
    /// componentize-py and pytest once, if the Python that PYTHON names [default: python3] has not got them.
    Build(Folder),
    /// Run a plugin's unit tests, build it, and fly its mission over some seeds
    ///
    /// The flights are those of `backseat sim DIR/mission`. Exit code: 0 if the unit tests passed, no plugin failed in a
    /// flight, and every flight met the expectations of world.toml, 1 if not, 2 if the plugin cannot be built or flown.
    Test(test::Test),
    /// Show what a component is: hash, size, name, version, imports and exports
    ///
    /// Exit code: 0 if it is a plugin that this program can run, 1 if it is another component, 2 if it is none.
    Inspect(inspect::Inspect),
    /// Write the report that an operator signs off: what a plugin asks for and uses, over simulated trials
    ///
    /// Nothing is built: the report is about the file as it is, and names it by its SHA-256. It has what the component
    /// imports and says about itself, what the mission gives to it, and what it did in the trials: its requests and how
    /// they ended, the grants that it used and lacked, fuel, memory and time of a step, faults, and violations of the
    /// safety rules.
    ///
    /// Exit code: 0 without an objection, 1 with one, 2 if the component or the mission cannot be used.
    Check(check::Check),
}

/// The folder of a plugin.
#[derive(Debug, Args)]
pub(crate) struct Folder {
    /// The plugin's folder, with its Cargo.toml or pyproject.toml
    #[arg(default_value = ".")]
    pub(crate) dir: PathBuf,
}

pub(crate) fn plugin(command: &Plugin) -> Result<bool> {
    match command {
        Plugin::New(arguments) => new::new(arguments),
        Plugin::Build(arguments) => build::build(arguments),
        Plugin::Test(arguments) => test::test(arguments),
        Plugin::Inspect(arguments) => inspect::inspect(arguments),
        Plugin::Check(arguments) => check::check(arguments),
    }
}

/// Reads a component, and says if the sources beside it are newer.
fn read_component(path: &std::path::Path) -> Result<ComponentFile> {
    if let Some(stale) = stale(path)? {
        tell(&stale);
    }
    Ok(ComponentFile::read(path)?)
}

/// In one line, if the component in a plugin's folder is older than its sources. The path of a component says nothing about
/// its sources.
fn stale(path: &std::path::Path) -> Result<Option<String>> {
    if !path.is_dir() {
        return Ok(None);
    }
    let project = Project::open(path)?;
    let component = project.built()?;
    Ok(project.newer_source().map(|source| {
        format!(
            "{} is older than {}: `backseat plugin build` makes it anew",
            component.display(),
            source.display()
        )
    }))
}

/// The same for a component that a mission names, if the folder that it is in is a plugin's whose component it is.
#[cfg(feature = "simulation")]
pub(crate) fn stale_file(component: &std::path::Path) -> Option<String> {
    let here = std::path::Path::new(".");
    let folder = component
        .parent()
        .filter(|folder| !folder.as_os_str().is_empty())
        .unwrap_or(here);
    let project = Project::open(folder).ok()?;
    let same = project.component().canonicalize().ok()? == component.canonicalize().ok()?;
    if same { stale(folder).ok()? } else { None }
}

/// The time since now.
fn stopwatch() -> Stopwatch {
    let clock = Clock::start();
    Arc::new(move || clock.elapsed())
}
