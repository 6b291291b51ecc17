use std::fmt;
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
    #[error("plugin `{plugin}` ({}): {}{}", path.display(), refused.reason(), config_in.as_ref().map_or_else(String::new, ConfigIn::to_string))]
    Host {
        /// The plugin's name in the mission.
        plugin: String,
        /// The component.
        path: PathBuf,
        /// If the plugin refuses its config: where that is.
        config_in: Option<ConfigIn>,
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
    /// A figure of its configuration is not finite.
    #[error("plugin `{plugin}`: config: {key} is {value}, expected a finite number: a plugin gets no other{config_in}")]
    NotFinite {
        /// The plugin's name in the mission.
        plugin: String,
        /// The figure's key.
        key: String,
        /// The figure.
        value: f64,
        /// Where it is.
        config_in: ConfigIn,
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

impl LoadError {
    /// The same, of a plugin whose config comes from elsewhere than its mission.
    #[must_use]
    pub fn with_config_in(mut self, place: ConfigIn) -> Self {
        match &mut self {
            Self::Host {
                config_in: Some(at), ..
            }
            | Self::NotFinite { config_in: at, .. } => *at = place,
            Self::Host { config_in: None, .. }
            | Self::Mission(_)
            | Self::Read { .. }
            | Self::Unknown { .. }
            | Self::Config { .. } => {}
        }
        self
    }
}

/// Where a plugin's config is that was refused.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum ConfigIn {
    /// Under `[plugin.config]` of a mission, or in a `--set` over it.
    Mission {
        /// The mission file.
        file: PathBuf,
        /// The line of the key, if it is known.
        line: Option<usize>,
    },
    /// In a file with nothing else.
    File(PathBuf),
    /// In a `--set`.
    Set,
}

impl fmt::Display for ConfigIn {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Mission { file, line: None } => write!(f, " (in {}, or in --set)", file.display()),
            Self::Mission { file, line: Some(line) } => write!(f, " (in {}, line {line}, or in --set)", file.display()),
            Self::File(file) => write!(f, " (in {})", file.display()),
            Self::Set => write!(f, " (in --set)"),
        }
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
