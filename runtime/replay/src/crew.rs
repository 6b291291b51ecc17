//! The plugins of a replay: which component each one is, compiled and started.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::path::PathBuf;

use backseat_core::PluginSetup;
use backseat_core::plugin::{PluginId, Version};
use backseat_mission::Mission;
use backseat_plugin_host::{Host, HostError, Seat};
use backseat_plugin_loader::{Components, ConfigIn, LoadError};

use crate::error::ReplayError;
use crate::member::Member;
use crate::report::{Absent, Component, PluginReport};
use crate::task::{Flown, Given, Task, hash, listed};

/// The plugins of a run.
pub(crate) struct Crew {
    pub(crate) components: Components,
    pub(crate) members: Vec<Member>,
    /// For core, as in the recorded run.
    pub(crate) setups: Vec<PluginSetup>,
    /// The SHA-256 of each component that the log has named so far.
    pub(crate) named: BTreeSet<String>,
}

impl Crew {
    pub(crate) fn new(task: &Task, host: &Host, given: Vec<Given>, steps_max: usize) -> Result<Self, ReplayError> {
        let mut given = by_plugin(task, given)?;
        let mut crew = Self {
            components: Components::new(),
            members: Vec::new(),
            setups: Vec::new(),
            named: task.flown.iter().map(|flown| flown.sha256.clone()).collect(),
        };
        for (place, flown) in task.flown.iter().enumerate() {
            crew.enlist(task, host, place, flown, given.remove(&flown.name), steps_max)?;
        }
        Ok(crew)
    }

    fn enlist(
        &mut self,
        task: &Task,
        host: &Host,
        place: usize,
        flown: &Flown,
        given: Option<Given>,
        steps_max: usize,
    ) -> Result<(), ReplayError> {
        let recorded_table = &task.mission.file.plugins[place];
        let changed = task.changed[place].as_ref();
        let table = changed.unwrap_or(recorded_table);
        let given = given.map(|given| (hash(&given.bytes), given));
        let (component, file) = match &given {
            Some((sha256, given)) => {
                self.compile(host, sha256, &flown.name, PathBuf::from(&given.file), &given.bytes)
                    .map_err(ReplayError::Given)?;
                (sha256.clone(), Some(given.file.clone()))
            }
            None => {
                let Some(bytes) = flown.component.as_ref().or_else(|| task.components.get(&flown.sha256)) else {
                    return Err(ReplayError::ByHashAlone {
                        plugin: flown.name.clone(),
                        sha256: flown.sha256.clone(),
                    });
                };
                let path = PathBuf::from(format!("of the log, components/{}.wasm", flown.name));
                self.compile(host, &flown.sha256, &flown.name, path, bytes)?;
                (flown.sha256.clone(), None)
            }
        };
        let started = self
            .components
            .start_described(&component, table, &task.mission)
            .map_err(|error| explained(error, &flown.name, file.as_deref(), task.changed_in[place].as_ref()))?;
        let description = match &flown.description {
            Some(description) => description.clone(),
            // A log of an earlier version.
            None if component == flown.sha256 => started.description.clone(),
            None => self.describe(task, host, place, flown)?,
        };
        self.setups.push(PluginSetup {
            name: flown.name.clone(),
            description,
            grants: recorded_table.grants.clone(),
            on_failure: recorded_table.on_failure,
            limits: recorded_table.limits.clone(),
        });
        let other = component != flown.sha256 || changed.is_some();
        self.members.push(Member {
            id: PluginId(place),
            table: table.clone(),
            plugin: Some(Seat::new(started.plugin)),
            orders: VecDeque::new(),
            substituted: false,
            lost: false,
            steps_begun: 0,
            stops_played: 0,
            steps_max,
            report: PluginReport {
                name: flown.name.clone(),
                component: Component {
                    file,
                    sha256: component.clone(),
                    recorded_sha256: flown.sha256.clone(),
                    version: started.description.version,
                    config_changed: changed.is_some(),
                    other,
                },
                steps: 0,
                restarts: 0,
                swaps: 0,
                swaps_failed: 0,
                unplayed: 0,
                absent: None,
                different: 0,
                requests_recorded: 0,
                requests_now: 0,
                failures: 0,
                different_steps: Vec::new(),
            },
            component,
        });
        Ok(())
    }

    /// Compiles a component, if it is not compiled yet.
    fn compile(
        &mut self,
        host: &Host,
        sha256: &str,
        plugin: &str,
        path: PathBuf,
        bytes: &[u8],
    ) -> Result<(), LoadError> {
        if !self.components.has(sha256) {
            self.components.insert_file(host, sha256, plugin, path, bytes)?;
        }
        Ok(())
    }

    /// Has a version take a plugin's place at its next restart. If its component is not there, the plugin is not stepped any
    /// more.
    pub(crate) fn swap(
        &mut self,
        host: &Host,
        plugin: PluginId,
        (version, at_s): (Version, f64),
        attached: &BTreeMap<String, Vec<u8>>,
        mission: &Mission,
    ) -> Result<(), ReplayError> {
        let Some(member) = self.members.get_mut(plugin.0) else {
            return Ok(());
        };
        member.report.swaps += 1;
        self.named.insert(version.sha256.clone());
        if member.report.component.other {
            // Another plugin is stepped in its place in this replay. It hands its state to itself, as the versions did.
            let ready = self.components.start_one(&member.component, &member.table, mission)?;
            member.offer(ready, version);
            return Ok(());
        }
        if member.lost {
            return Ok(());
        }
        let sha256 = version.sha256.clone();
        if !self.components.has(&sha256) {
            let Some(bytes) = attached.get(&sha256) else {
                member.lost = true;
                member.report.absent.get_or_insert(Absent { sha256, at_s });
                return Ok(());
            };
            let path = PathBuf::from(format!("of the log, components/{sha256}.wasm"));
            self.components
                .insert_file(host, &sha256, &member.report.name, path, bytes)?;
        }
        let ready = self.components.start_one(&sha256, &member.table, mission)?;
        member.offer(ready, version);
        Ok(())
    }

    /// What the component that flew says about itself.
    fn describe(
        &mut self,
        task: &Task,
        host: &Host,
        place: usize,
        flown: &Flown,
    ) -> Result<backseat_core::plugin::Description, ReplayError> {
        let Some(bytes) = &flown.component else {
            return Err(ReplayError::Undescribed {
                plugin: flown.name.clone(),
                sha256: flown.sha256.clone(),
            });
        };
        let path = PathBuf::from(format!("of the log, components/{}.wasm", flown.name));
        self.compile(host, &flown.sha256, &flown.name, path, bytes)?;
        let table = &task.mission.file.plugins[place];
        let started = self.components.start_described(&flown.sha256, table, &task.mission)?;
        Ok(started.description)
    }
}

/// Why a plugin cannot be started, in the words of a replay: its grants are those of the run, and its config may be another.
fn explained(error: LoadError, plugin: &str, file: Option<&str>, changed_in: Option<&ConfigIn>) -> ReplayError {
    if let (LoadError::Host { refused, .. }, Some(file)) = (&error, file)
        && let HostError::Grants { missing, .. } = &**refused
    {
        let names: Vec<String> = missing.iter().map(|grant| format!("`{}`", grant.name())).collect();
        return ReplayError::NotGranted {
            plugin: plugin.to_owned(),
            file: file.to_owned(),
            missing: names.join(" and "),
        };
    }
    match changed_in {
        Some(place) => ReplayError::Given(error.with_config_in(place.clone())),
        None if file.is_some() => ReplayError::Given(error),
        None => error.into(),
    }
}

fn by_plugin(task: &Task, given: Vec<Given>) -> Result<BTreeMap<String, Given>, ReplayError> {
    let mut by_plugin = BTreeMap::new();
    for one in given {
        let name = one.plugin.clone();
        if !task.flown.iter().any(|flown| flown.name == name) {
            let names = task.names();
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            return Err(ReplayError::NoPlugin {
                option: "--plugin",
                name,
                known: listed(&names),
            });
        }
        if by_plugin.insert(name.clone(), one).is_some() {
            return Err(ReplayError::Twice {
                option: "--plugin",
                name,
            });
        }
    }
    Ok(by_plugin)
}
