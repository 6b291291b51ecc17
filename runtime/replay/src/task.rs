use std::collections::BTreeMap;
use std::io::Read;
use std::path::PathBuf;

use backseat_core::plugin::Description;
use backseat_mission::{Mission, PluginTable, RecordedParts};
use backseat_plugin_loader::ConfigIn;
use backseat_recorder::{LogReader, Run};
use sha2::{Digest, Sha256};

use crate::error::ReplayError;

/// What a log says of its run before its first message.
pub struct Task {
    /// Facts about the run.
    pub run: Run,
    /// The mission that was flown.
    pub mission: Mission,
    /// The plugins that flew, in priority order.
    pub(crate) flown: Vec<Flown>,
    /// The plugins' tables with the changes that were asked for, if there are any.
    pub(crate) changed: Vec<Option<PluginTable>>,
    /// Where these changes come from, in the same order.
    pub(crate) changed_in: Vec<Option<ConfigIn>>,
    /// Components that flew and that the log has by their hash alone, by their SHA-256.
    pub(crate) components: BTreeMap<String, Vec<u8>>,
}

/// A plugin that flew.
pub(crate) struct Flown {
    pub(crate) name: String,
    /// `None` if the log has its hash alone.
    pub(crate) component: Option<Vec<u8>>,
    pub(crate) sha256: String,
    /// `None` in logs of earlier versions.
    pub(crate) description: Option<Description>,
}

/// A component for a plugin.
pub struct Given {
    /// The plugin's name in the mission.
    pub plugin: String,
    /// The file, for messages.
    pub file: String,
    /// The component.
    pub bytes: Vec<u8>,
}

/// Another config for plugins, which are then compared with those that flew.
#[derive(Clone, Copy, Debug, Default)]
pub struct Configs<'a> {
    /// Single keys: `plugin.NAME.config.KEY=VALUE`.
    pub set: &'a [String],
    /// Whole configs.
    pub whole: &'a [Config],
}

/// A whole config for a plugin.
#[derive(Clone, Debug)]
pub struct Config {
    /// The plugin's name in the mission.
    pub plugin: String,
    /// The file, for messages.
    pub file: String,
    /// Its keys, TOML.
    pub text: String,
}

impl Task {
    /// Reads the mission from a log.
    ///
    /// # Errors
    ///
    /// [`ReplayError`] if the log lacks something or has something else than it says, or if a config is not one.
    pub fn of<R: Read>(log: &LogReader<R>, configs: Configs<'_>) -> Result<Self, ReplayError> {
        let set = configs.set;
        let run = log.run().clone();
        let mission_text = attached(log, "mission.toml", Some(&run.mission_sha256))?;
        let fence_text = attached(log, "fence.geojson", Some(&run.fence_sha256))?;
        let fence = match log.fence_as_read() {
            Some((name, data)) => (name, text(name, data)?),
            None => ("fence.geojson", fence_text),
        };
        let plan = match log.plan() {
            Some(data) => Some(text("plan.toml", data)?),
            None => plan_of_earlier(log, mission_text)?,
        };
        let read = |set: &[String]| {
            Mission::recorded(&RecordedParts {
                name: &run.mission,
                mission: mission_text,
                fence,
                plan,
                set,
            })
        };
        let mission = read(&[])?;
        let mut changed = vec![None; mission.file.plugins.len()];
        let mut changed_in = vec![None; mission.file.plugins.len()];
        for one in set {
            let over = read(std::slice::from_ref(one)).map_err(ReplayError::Set)?;
            check_config_only(&mission, &over, one)?;
        }
        if !set.is_empty() {
            let over = read(set).map_err(ReplayError::Set)?;
            for (changed, (now, then)) in changed
                .iter_mut()
                .zip(over.file.plugins.into_iter().zip(&mission.file.plugins))
            {
                *changed = (now != *then).then_some(now);
            }
            for (place, changed) in changed_in.iter_mut().zip(&changed) {
                *place = changed.is_some().then_some(ConfigIn::Set);
            }
        }
        for config in configs.whole {
            let names: Vec<&str> = mission.file.plugins.iter().map(|table| table.name.as_str()).collect();
            let Some(place) = names.iter().position(|name| *name == config.plugin) else {
                return Err(ReplayError::NoPlugin {
                    option: "--config",
                    name: config.plugin.clone(),
                    known: listed(&names),
                });
            };
            match changed_in[place].replace(ConfigIn::File(PathBuf::from(&config.file))) {
                None => {}
                Some(ConfigIn::Set) => {
                    return Err(ReplayError::ConfigAndSet {
                        name: config.plugin.clone(),
                    });
                }
                Some(ConfigIn::File(_) | ConfigIn::Mission { .. }) => {
                    return Err(ReplayError::Twice {
                        option: "--config",
                        name: config.plugin.clone(),
                    });
                }
            }
            let keys = toml::from_str(&config.text).map_err(|error: toml::de::Error| {
                let before = error.span().and_then(|span| config.text.get(..span.start));
                ReplayError::Config {
                    file: config.file.clone(),
                    line: before.map_or(1, |before| before.matches('\n').count() + 1),
                    message: error.message().to_owned(),
                }
            })?;
            let then = &mission.file.plugins[place];
            changed[place] = Some(PluginTable {
                config: keys,
                ..then.clone()
            });
        }
        let flown = mission.file.plugins.iter().map(|table| flown(log, &table.name));
        Ok(Self {
            flown: flown.collect::<Result<_, _>>()?,
            changed,
            changed_in,
            components: BTreeMap::new(),
            run,
            mission,
        })
    }

    /// Takes a component that flew and that the log has by its hash alone: one with which the run began, or one that the
    /// operator put in a plugin's place. Returns its SHA-256.
    pub fn add_component(&mut self, bytes: Vec<u8>) -> String {
        let sha256 = hash(&bytes);
        self.components.insert(sha256.clone(), bytes);
        sha256
    }

    pub(crate) fn names(&self) -> Vec<String> {
        self.flown.iter().map(|flown| flown.name.clone()).collect()
    }
}

fn flown<R: Read>(log: &LogReader<R>, name: &str) -> Result<Flown, ReplayError> {
    let attachment = || format!("components/{name}.wasm");
    let Some(sha256) = log.component_sha256(name) else {
        return Err(ReplayError::Attachment { name: attachment() });
    };
    let component = log.component(name);
    if component.is_none() && log.is_cut() {
        return Err(ReplayError::Cut { name: attachment() });
    }
    if component.is_some_and(|component| hash(component) != sha256) {
        return Err(ReplayError::Hash { name: attachment() });
    }
    Ok(Flown {
        name: name.to_owned(),
        component: component.map(<[u8]>::to_vec),
        sha256: sha256.to_owned(),
        description: log.description(name),
    })
}

/// The plan of a log that has none attached: a simulation's world may have it.
fn plan_of_earlier<'a, R: Read>(log: &'a LogReader<R>, mission: &str) -> Result<Option<&'a str>, ReplayError> {
    let file = backseat_mission::MissionFile::from_toml("mission.toml", mission)?;
    let Some(plan) = file.plan else { return Ok(None) };
    match log.attachment("world.toml") {
        Some(world) if plan.file == "world.toml" => text("world.toml", world).map(Some),
        Some(_) | None => Err(ReplayError::Plan { file: plan.file }),
    }
}

/// Checks that a setting changes the config of plugins and nothing else.
fn check_config_only(mission: &Mission, over: &Mission, set: &str) -> Result<(), ReplayError> {
    let mut file = over.file.clone();
    for (plugin, then) in file.plugins.iter_mut().zip(&mission.file.plugins) {
        plugin.config.clone_from(&then.config);
    }
    if file == mission.file && set.starts_with("plugin.") {
        Ok(())
    } else {
        Err(ReplayError::Setting { set: set.to_owned() })
    }
}

/// A text that must be attached.
fn attached<'a, R: Read>(log: &'a LogReader<R>, name: &str, sha256: Option<&str>) -> Result<&'a str, ReplayError> {
    let data = log.attachment(name).ok_or_else(|| match log.is_cut() {
        true => ReplayError::Cut { name: name.to_owned() },
        false => ReplayError::Attachment { name: name.to_owned() },
    })?;
    if sha256.is_some_and(|sha256| hash(data) != sha256) {
        return Err(ReplayError::Hash { name: name.to_owned() });
    }
    text(name, data)
}

fn text<'a>(name: &str, data: &'a [u8]) -> Result<&'a str, ReplayError> {
    std::str::from_utf8(data).map_err(|_| ReplayError::Text { name: name.to_owned() })
}

/// Names in a message.
pub(crate) fn listed(names: &[&str]) -> String {
    if names.is_empty() {
        "none".to_owned()
    } else {
        names.join(", ")
    }
}

/// SHA-256, hexadecimal.
pub(crate) fn hash(data: &[u8]) -> String {
    Sha256::digest(data).iter().map(|byte| format!("{byte:02x}")).collect()
}
