//! `backseat replay`: the log of a run, core and plugins again from the recorded inputs.

#[cfg(feature = "simulation")]
mod map;

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail, ensure};
use backseat_plugin_loader::{read_component, regular_file};
use backseat_recorder::LogReader;
use backseat_replay::{Config, Configs, Flow, Given, Replay as Playback, ReplayError, Report, Task};
use clap::Args;
use serde_json::json;

use crate::cache::host_with;
use crate::clock::Clock;
use crate::log::{expected_log, whole};
use crate::output::say;
use crate::swap::named_file;

#[derive(Debug, Args)]
pub(crate) struct Replay {
    /// The log, written by `run`, `fly` or `sim --log`
    #[arg(value_name = "DIVE.mcap")]
    pub(crate) log: PathBuf,
    /// Step the component in FILE in place of the plugin NAME, and show what it would have asked for on the same inputs
    #[arg(long = "plugin", value_name = "NAME=FILE", value_parser = named_file)]
    pub(crate) plugins: Vec<(String, PathBuf)>,
    /// A component that flew and that the log has by its hash alone, because it is larger than 8 MiB
    #[arg(long = "component", value_name = "FILE")]
    pub(crate) components: Vec<PathBuf>,
    /// Step the plugin NAME with the config in FILE, TOML, in place of the recorded one
    #[arg(long = "config", value_name = "NAME=FILE.toml", value_parser = named_file)]
    pub(crate) configs: Vec<(String, PathBuf)>,
    /// Step a plugin with another value in its config: plugin.NAME.config.KEY=VALUE
    #[arg(long, value_name = "KEY=VALUE")]
    pub(crate) set: Vec<String>,
    /// Show the first N steps of each plugin that differ
    #[arg(long, value_name = "N", default_value_t = 5)]
    pub(crate) steps: usize,
    /// Draw a map into this file: the recorded track and requests, and in the steps that differ, what was asked for then
    /// and now
    #[cfg(feature = "simulation")]
    #[arg(long, value_name = "FILE.svg")]
    pub(crate) map: Option<PathBuf>,
    /// Open the map when it is drawn
    #[cfg(feature = "simulation")]
    #[arg(long, requires = "map")]
    pub(crate) open: bool,
    /// Compile the plugins, and keep nothing for the next start
    #[arg(long)]
    pub(crate) no_cache: bool,
    /// Print one JSON object on standard output and nothing else
    #[arg(long)]
    pub(crate) json: bool,
}

pub(crate) fn replay(arguments: &Replay) -> Result<bool> {
    let loading = Clock::start();
    let mut log = expected_log(LogReader::open(&arguments.log))?;
    whole(&arguments.log, log.run().part)?;
    // An option that is wrong is no fault of the log.
    let refused = |error: ReplayError| {
        if error.is_of_an_option() {
            return anyhow::Error::new(error);
        }
        anyhow::Error::new(error).context(format!("log {} cannot be replayed", arguments.log.display()))
    };
    let whole = arguments.configs.iter().map(|(name, file)| config(name, file));
    let configs = Configs {
        set: &arguments.set,
        whole: &whole.collect::<Result<Vec<_>>>()?,
    };
    let mut task = Task::of(&log, configs).map_err(refused)?;
    let mut flown = Vec::new();
    for file in &arguments.components {
        let bytes = read_component(file).with_context(|| format!("--component {}", file.display()))?;
        flown.push((file, task.add_component(bytes)));
    }
    #[cfg(all(feature = "plugin", feature = "simulation"))]
    for (_, file) in &arguments.plugins {
        if let Some(stale) = crate::plugin::stale_file(file) {
            tracing::warn!("{stale}");
        }
    }
    let given = arguments.plugins.iter().map(|(name, file)| given(name, file));
    let given = given.collect::<Result<_>>()?;
    #[cfg(feature = "simulation")]
    if let Some(path) = &arguments.map {
        crate::map::begin(path)?;
    }
    let mut playback =
        Playback::new(task, &host_with(!arguments.no_cache)?, given, arguments.steps).map_err(refused)?;
    let load_seconds = loading.elapsed().as_secs_f64();
    let playing = Clock::start();
    let mut attached = log.attachments().len();
    while let Some(message) = log.next_message()? {
        for attachment in &log.attachments()[attached..] {
            playback.attach(&attachment.data);
        }
        attached = log.attachments().len();
        if playback.take(message).map_err(refused)? == Flow::Over {
            break;
        }
    }
    for (file, sha256) in flown.iter().filter(|(_, sha256)| !playback.names(sha256)) {
        tracing::warn!(
            "--component {}: it did not fly in this dive (SHA-256 {sha256})",
            file.display()
        );
    }
    #[cfg(feature = "simulation")]
    let envelope = std::sync::Arc::clone(&playback.mission().envelope);
    let report = playback.finish(log.is_complete());
    // Nothing differs in a log without inputs, but nothing was compared either.
    ensure!(
        report.inputs > 0,
        "log {}: the runtime has received nothing in it, so there is nothing to replay",
        arguments.log.display()
    );
    let wall_seconds = playing.elapsed().as_secs_f64();
    #[cfg(feature = "simulation")]
    if let Some(path) = &arguments.map {
        let picture = map::draw(&report, envelope.fence(), &arguments.log);
        crate::map::write(path, &picture)?;
        if arguments.open {
            crate::map::open(path);
        }
    }
    print(arguments, &report, wall_seconds, load_seconds)?;
    if let (None, Some((plugin, absent))) = (report.identical, report.absent().next()) {
        bail!(
            "log {}: plugin {plugin}, at {:.3} s: {absent}; what was compared is identical",
            arguments.log.display(),
            absent.at_s
        );
    }
    match (report.identical, &report.refused) {
        (Some(identical), _) => Ok(identical),
        (None, Some(refused)) => bail!(
            "log {}: {}; what comes before is identical",
            arguments.log.display(),
            refused.line()
        ),
        (None, None) => Ok(false),
    }
}

fn given(name: &str, file: &Path) -> Result<Given> {
    let bytes = read_component(file).with_context(|| format!("--plugin {name}={}", file.display()))?;
    Ok(Given {
        plugin: name.to_owned(),
        file: file.display().to_string(),
        bytes,
    })
}

fn config(name: &str, file: &Path) -> Result<Config> {
    let text = regular_file(file).and_then(|_| std::fs::read_to_string(file));
    let text = text.with_context(|| format!("--config {name}={}", file.display()))?;
    Ok(Config {
        plugin: name.to_owned(),
        file: file.display().to_string(),
        text,
    })
}

fn print(arguments: &Replay, report: &Report, wall_seconds: f64, load_seconds: f64) -> Result<()> {
    let speed = report.seconds / wall_seconds.max(1e-9);
    if arguments.json {
        let mut json = serde_json::to_value(report)?;
        if let Some(json) = json.as_object_mut() {
            json.insert("log".to_owned(), json!(arguments.log.display().to_string()));
            json.insert("wall_seconds".to_owned(), json!(wall_seconds));
            json.insert("load_seconds".to_owned(), json!(load_seconds));
        }
        say!("{json}");
        return Ok(());
    }
    let mut lines = report.lines().into_iter();
    if let Some(first) = lines.next() {
        say!("{}: {first}", arguments.log.display());
    }
    say!("  {speed:.0} x real time ({wall_seconds:.2} s, and {load_seconds:.2} s to load plugins)");
    if report.version != env!("CARGO_PKG_VERSION") {
        say!(
            "  version {} wrote the log, and this is version {}",
            report.version,
            env!("CARGO_PKG_VERSION")
        );
    }
    for line in lines {
        say!("{line}");
    }
    #[cfg(feature = "simulation")]
    if let Some(path) = &arguments.map {
        say!("  map: {}", path.display());
    }
    Ok(())
}
