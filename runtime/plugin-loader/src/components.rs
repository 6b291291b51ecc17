use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use backseat_core::PluginSetup;
use backseat_core::plugin::Judge;
use backseat_mission::{Mission, PluginTable};
use backseat_plugin_host::{Brief, Budget, Component, Host, HostError, Plugin, Started};

use crate::file::read_component;
use crate::load::{ConfigIn, LoadError, Loaded};

/// Components, compiled once and started for any number of runs, by the names that `component` has in mission files.
///
/// A clone shares the code and may be used on another thread.
#[derive(Clone, Default)]
pub struct Components {
    by_name: BTreeMap<String, Compiled>,
}

#[derive(Clone)]
struct Compiled {
    component: Component,
    /// The path for errors.
    path: PathBuf,
    bytes: Arc<[u8]>,
}

impl Components {
    /// Creates an empty set.
    #[must_use]
    pub fn new() -> Self {
        Self::default()
    }

    /// Finds and compiles the components of a mission, each once, or takes them from the host's cache. Bare names are looked up in `folder` first.
    ///
    /// # Errors
    ///
    /// [`LoadError`] with the plugin and the file.
    pub fn load(host: &Host, mission: &Mission, folder: Option<&Path>) -> Result<Self, LoadError> {
        let mut components = Self::new();
        let paths = mission.components(folder)?;
        for (table, path) in mission.file.plugins.iter().zip(paths) {
            if components.by_name.contains_key(&table.component) {
                continue;
            }
            let bytes = read_component(&path).map_err(|source| LoadError::Read {
                plugin: table.name.clone(),
                path: path.clone(),
                reason: source,
            })?;
            components.compile(host, &table.component, &table.name, path, &bytes)?;
        }
        Ok(components)
    }

    /// Compiles a component from bytes. It replaces a component of the same name; running plugins keep the old one.
    ///
    /// # Errors
    ///
    /// [`LoadError::Host`] if the host refuses it.
    pub fn insert(&mut self, host: &Host, name: &str, bytes: &[u8]) -> Result<(), LoadError> {
        self.compile(host, name, name, PathBuf::from(name), bytes)
    }

    /// Whether there is a component of this name.
    #[must_use]
    pub fn has(&self, name: &str) -> bool {
        self.by_name.contains_key(name)
    }

    /// Compiles a component from the bytes of a file; errors name the plugin that it is for, and the file.
    ///
    /// # Errors
    ///
    /// [`LoadError::Host`] if the host refuses it.
    pub fn insert_file(
        &mut self,
        host: &Host,
        name: &str,
        plugin: &str,
        path: PathBuf,
        bytes: &[u8],
    ) -> Result<(), LoadError> {
        self.compile(host, name, plugin, path, bytes)
    }

    /// Starts all plugins of a mission.
    ///
    /// # Errors
    ///
    /// [`LoadError`] with the plugin and its component.
    pub fn start(&self, mission: &Mission) -> Result<Loaded, LoadError> {
        let mut loaded = Loaded {
            setups: Vec::new(),
            plugins: Vec::new(),
            components: Vec::new(),
            origins: Vec::new(),
        };
        for table in &mission.file.plugins {
            let compiled = self.find(&table.name, &table.component)?;
            let started = compiled.start(table, mission)?;
            loaded.setups.push(PluginSetup {
                name: table.name.clone(),
                description: started.description,
                grants: table.grants.clone(),
                on_failure: table.on_failure,
                limits: table.limits.clone(),
            });
            loaded.plugins.push(started.plugin);
            loaded.components.push((table.name.clone(), compiled.bytes.to_vec()));
            loaded.origins.push(compiled.component.origin());
        }
        Ok(loaded)
    }

    /// Starts one plugin from a component, whichever component its table names. It gets the table's budget and
    /// configuration, and can ask about the fence and limits of `mission`.
    ///
    /// # Errors
    ///
    /// [`LoadError`] with the plugin and the component.
    pub fn start_one(&self, component: &str, table: &PluginTable, mission: &Mission) -> Result<Plugin, LoadError> {
        Ok(self.start_described(component, table, mission)?.plugin)
    }

    /// As [`Components::start_one`], with what the plugin says about itself.
    ///
    /// # Errors
    ///
    /// [`LoadError`] with the plugin and the component.
    pub fn start_described(
        &self,
        component: &str,
        table: &PluginTable,
        mission: &Mission,
    ) -> Result<Started, LoadError> {
        self.find(&table.name, component)?.start(table, mission)
    }

    fn compile(&mut self, host: &Host, name: &str, plugin: &str, path: PathBuf, bytes: &[u8]) -> Result<(), LoadError> {
        let component = host
            .load(plugin, bytes)
            .map_err(|source| refused(plugin, &path, source))?;
        let compiled = Compiled {
            component,
            path,
            bytes: bytes.into(),
        };
        self.by_name.insert(name.to_owned(), compiled);
        Ok(())
    }

    fn find(&self, plugin: &str, component: &str) -> Result<&Compiled, LoadError> {
        self.by_name.get(component).ok_or_else(|| LoadError::Unknown {
            plugin: plugin.to_owned(),
            component: component.to_owned(),
            loaded: self.by_name.keys().cloned().collect::<Vec<_>>().join(", "),
        })
    }
}

impl Compiled {
    fn start(&self, table: &PluginTable, mission: &Mission) -> Result<Started, LoadError> {
        let budget = Budget {
            fuel_per_step: table.budget.fuel_per_step,
            memory_bytes: table.budget.memory_mib as usize * 1024 * 1024,
            ..Budget::default()
        };
        if let Some((key, value)) = not_finite(&table.config) {
            let config_in = config_place(mission, &table.name, key.split('.').next().unwrap_or(&key));
            return Err(LoadError::NotFinite {
                plugin: table.name.clone(),
                key,
                value,
                config_in,
            });
        }
        let config = serde_json::to_string(&table.config).map_err(|error| LoadError::Config {
            plugin: table.name.clone(),
            message: error.to_string(),
        })?;
        let brief = Brief {
            config_json: &config,
            grants: &table.grants,
            fence: mission.envelope.fence(),
            limits: mission.envelope.limits(),
        };
        let judge: Arc<dyn Judge> = mission.envelope.clone();
        self.component.start(budget, &brief, judge).map_err(|source| {
            let refused_config = if let HostError::Start { fault, .. } = &source {
                fault.text.strip_prefix("config")
            } else {
                None
            };
            LoadError::Host {
                plugin: table.name.clone(),
                path: self.path.clone(),
                config_in: refused_config.map(|reason| config_place(mission, &table.name, reason)),
                refused: Box::new(source),
            }
        })
    }
}

/// The first figure of a config that is not finite, with its key, as in `legs[2].speed_mps`. JSON, in which a plugin gets its
/// config, would have `null` for it.
fn not_finite(config: &toml::Table) -> Option<(String, f64)> {
    fn in_value(value: &toml::Value) -> Option<(String, f64)> {
        match value {
            toml::Value::Float(figure) => (!figure.is_finite()).then(|| (String::new(), *figure)),
            toml::Value::Table(table) => not_finite(table).map(|(key, figure)| (format!(".{key}"), figure)),
            toml::Value::Array(values) => values
                .iter()
                .enumerate()
                .find_map(|(index, value)| in_value(value).map(|(key, figure)| (format!("[{index}]{key}"), figure))),
            toml::Value::String(_) | toml::Value::Integer(_) | toml::Value::Boolean(_) | toml::Value::Datetime(_) => {
                None
            }
        }
    }
    config
        .iter()
        .find_map(|(name, value)| in_value(value).map(|(key, figure)| (format!("{name}{key}"), figure)))
}

/// The mission file, and the line of the key that the reason of a refused config begins with, as in
/// `: contour_m: expected…`, or that it quotes, as in ``: unknown key `contur_m` ``.
fn config_place(mission: &Mission, plugin: &str, reason: &str) -> ConfigIn {
    let begin = reason
        .trim_start_matches([':', ' '])
        .split([':', '['])
        .next()
        .unwrap_or("");
    let key = begin.split('`').nth(1).unwrap_or(begin);
    ConfigIn::Mission {
        file: mission.folder.join("mission.toml"),
        line: mission.config_line(plugin, key),
    }
}

fn refused(plugin: &str, path: &Path, source: HostError) -> LoadError {
    LoadError::Host {
        plugin: plugin.to_owned(),
        path: path.to_owned(),
        config_in: None,
        refused: Box::new(source),
    }
}
