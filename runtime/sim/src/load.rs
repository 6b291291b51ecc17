use std::path::{Path, PathBuf};
use std::sync::Arc;

use backseat_core::PluginSetup;
use backseat_core::plugin::Judge;
use backseat_mission::{Mission, MissionError};
use backseat_plugin_host::{Budget, Host, HostError, Plugin};

/// A mission's plugin that cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum LoadError {
    /// Its component is nowhere.
    #[error(transparent)]
    Mission(#[from] MissionError),
    /// Its component cannot be read.
    #[error("plugin `{plugin}`: {}: {source}", path.display())]
    Read {
        /// The plugin's name in the mission.
        plugin: String,
        /// The component.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The host refuses it.
    #[error("plugin `{plugin}` ({}): {source}", path.display())]
    Host {
        /// The plugin's name in the mission.
        plugin: String,
        /// The component.
        path: PathBuf,
        /// Why.
        source: HostError,
    },
    /// Its configuration cannot be handed over.
    #[error("plugin `{plugin}`: its config cannot be written as JSON: {message}")]
    Config {
        /// The plugin's name in the mission.
        plugin: String,
        /// Why.
        message: String,
    },
}

/// A mission's plugins, started.
pub struct Loaded {
    /// For core, in priority order.
    pub setups: Vec<PluginSetup>,
    /// For the driver, in the same order.
    pub plugins: Vec<Plugin>,
    /// Names and bytes of the components, for the log.
    pub components: Vec<(String, Vec<u8>)>,
}

/// Finds, compiles and starts a mission's plugins.
///
/// # Errors
/// [`LoadError`] names the plugin and the file.
pub fn load_plugins(host: &Host, mission: &Mission, folder: Option<&Path>) -> Result<Loaded, LoadError> {
    let paths = mission.components(folder)?;
    let mut loaded = Loaded {
        setups: Vec::new(),
        plugins: Vec::new(),
        components: Vec::new(),
    };
    for (table, path) in mission.file.plugins.iter().zip(paths) {
        let plugin = &table.name;
        let bytes = std::fs::read(&path).map_err(|source| LoadError::Read {
            plugin: plugin.clone(),
            path: path.clone(),
            source,
        })?;
        let refused = |source| LoadError::Host {
            plugin: plugin.clone(),
            path: path.clone(),
            source,
        };
        let component = host.load(plugin, &bytes).map_err(refused)?;
        let budget = Budget {
            fuel_per_step: table.budget.fuel_per_step,
            memory_bytes: table.budget.memory_mib as usize * 1024 * 1024,
            ..Budget::default()
        };
        let config = serde_json::to_string(&table.config).map_err(|error| LoadError::Config {
            plugin: plugin.clone(),
            message: error.to_string(),
        })?;
        let judge: Arc<dyn Judge> = mission.envelope.clone();
        let started = component.start(budget, &config, judge).map_err(refused)?;
        loaded.setups.push(PluginSetup {
            name: plugin.clone(),
            description: started.description,
            grants: table.grants.clone(),
            on_failure: table.on_failure,
            limits: table.limits.clone(),
        });
        loaded.plugins.push(started.plugin);
        loaded.components.push((plugin.clone(), bytes));
    }
    Ok(loaded)
}
