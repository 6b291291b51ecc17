use std::path::{Path, PathBuf};

use backseat_core::PluginSetup;
use backseat_mission::{Mission, MissionError};
use backseat_plugin_host::{Host, HostError, Origin, Plugin};

use crate::components::Components;

/// Why a mission's plugin cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum LoadError {
    /// Its component was not found.
    #[error(transparent)]
    Mission(#[from] MissionError),
    /// Its component cannot be read.
    #[error("plugin `{plugin}`: {}: {reason}", path.display())]
    Read {
        /// The plugin's name in the mission.
        plugin: String,
        /// The component.
        path: PathBuf,
        /// The reason. (Not the `source`, which would be told twice.)
        reason: std::io::Error,
    },
    /// The host refuses it.
    #[error("plugin `{plugin}` ({}): {}{}", path.display(), refused.reason(), place(config_in.as_ref()))]
    Host {
        /// The plugin's name in the mission.
        plugin: String,
        /// The component.
        path: PathBuf,
        /// If the plugin refuses what the mission has under `[plugin.config]`: the mission file, and the line in it.
        config_in: Option<(PathBuf, Option<usize>)>,
        /// The reason.
        refused: Box<HostError>,
    },
    /// Its component was not loaded.
    #[error("plugin `{plugin}`: component `{component}` is not loaded; loaded are: {loaded}")]
    Unknown {
        /// The plugin's name in the mission.
        plugin: String,
        /// Its `component` key.
        component: String,
        /// The loaded components, separated by commas.
        loaded: String,
    },
    /// Its configuration cannot be passed on.
    #[error("plugin `{plugin}`: its config cannot be written as JSON: {message}")]
    Config {
        /// The plugin's name in the mission.
        plugin: String,
        /// The reason.
        message: String,
    },
}

/// Where the config is that was refused.
fn place(config_in: Option<&(PathBuf, Option<usize>)>) -> String {
    match config_in {
        None => String::new(),
        Some((path, None)) => format!(" (in {}, or in --set)", path.display()),
        Some((path, Some(line))) => format!(" (in {}, line {line}, or in --set)", path.display()),
    }
}

/// A mission's plugins, started.
pub struct Loaded {
    /// The setups for core, in priority order.
    pub setups: Vec<PluginSetup>,
    /// The plugins for the driver, in the same order.
    pub plugins: Vec<Plugin>,
    /// The names and bytes of the components, for the log.
    pub components: Vec<(String, Vec<u8>)>,
    /// Where the code of each one comes from, in the same order.
    pub origins: Vec<Origin>,
}

/// Finds, compiles and starts a mission's plugins.
///
/// # Errors
///
/// [`LoadError`] with the plugin and the file.
pub fn load_plugins(host: &Host, mission: &Mission, folder: Option<&Path>) -> Result<Loaded, LoadError> {
    Components::load(host, mission, folder)?.start(mission)
}
