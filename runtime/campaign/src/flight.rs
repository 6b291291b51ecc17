use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use backseat_mission::{Layers, Mission};
use backseat_mvc::Mvc;
use backseat_plugin_host::Host;
use backseat_plugin_loader::{Components, LoadError};
use backseat_scenario::Scenario;
use backseat_sim::{Report, Simulation, Trace};
use sha2::{Digest as _, Sha256};

use crate::error::CampaignError;
use crate::faults::DrawnFaults;
use crate::plan::{Key, Plan};
use crate::row::Row;
use crate::stop::Stop;

/// The simulation looks this often, in events, whether it shall stop.
const LOOK_EVERY: u32 = 4096;

/// The compiled plugins of all missions of a campaign, shared by its threads.
pub struct Crew {
    host: Host,
    folder: Option<PathBuf>,
    /// By the mission's folder: its files when they were first read.
    seen: Mutex<BTreeMap<PathBuf, Fingerprint>>,
    /// By the mission's folder and the components that it names.
    compiled: Mutex<BTreeMap<(PathBuf, Vec<String>), Components>>,
}

/// A mission in its scenario, with what a campaign has set, ready to be flown with any seed.
pub struct Prepared {
    /// The mission.
    pub mission: Mission,
    /// The scenario.
    pub scenario: Scenario,
    components: Components,
    faults: Option<DrawnFaults>,
}

/// A run that was flown.
pub struct Flown {
    /// Its report. The caller's clock is not in it.
    pub report: Report,
    /// Its track.
    pub trace: Trace,
    /// The mock vehicle at its end.
    pub mvc: Mvc,
}

impl Crew {
    /// `folder` is looked at first for components that a mission names without a path.
    #[must_use]
    pub const fn new(host: Host, folder: Option<PathBuf>) -> Self {
        Self {
            host,
            folder,
            seen: Mutex::new(BTreeMap::new()),
            compiled: Mutex::new(BTreeMap::new()),
        }
    }

    /// Reads the mission of a run with its settings, and compiles its plugins unless another run has.
    ///
    /// # Errors
    ///
    /// [`CampaignError`] of the mission, the scenario or a plugin; [`CampaignError::Changed`] if the mission's files are not
    /// those of the first run.
    pub fn prepare(&self, plan: &Plan, key: &Key) -> Result<Prepared, CampaignError> {
        let place = plan.place(key);
        self.is_unchanged(&place)?;
        let prepared = self.prepare_unchecked(plan, key);
        // Also if it changed while it was read, or cannot be read because it is gone.
        self.is_unchanged(&place)?;
        prepared
    }

    /// Checks that a mission's files are those that were there first.
    fn is_unchanged(&self, folder: &Path) -> Result<(), CampaignError> {
        let now = Fingerprint::of(folder);
        let mut seen = self.seen.lock().unwrap_or_else(PoisonError::into_inner);
        if *seen.entry(folder.to_path_buf()).or_insert_with(|| now.clone()) == now {
            return Ok(());
        }
        Err(CampaignError::Changed {
            path: folder.to_path_buf(),
        })
    }

    fn prepare_unchecked(&self, plan: &Plan, key: &Key) -> Result<Prepared, CampaignError> {
        let (mission_sets, world_sets) = plan.sets(key);
        let layers = Layers {
            set: mission_sets,
            // A campaign must not depend on the environment of the computer that flies it.
            environment: false,
        };
        let mission = Mission::load(&plan.place(key), &layers)?;
        let scenario = Scenario::load_with(&mission, &world_sets)?;
        let components = self.components(&mission)?;
        Ok(Prepared {
            mission,
            scenario,
            components,
            faults: plan.faults(),
        })
    }

    fn components(&self, mission: &Mission) -> Result<Components, LoadError> {
        let names = mission.file.plugins.iter().map(|plugin| plugin.component.clone());
        let place = (mission.folder.clone(), names.collect());
        let mut compiled = self.compiled.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(components) = compiled.get(&place) {
            return Ok(components.clone());
        }
        let components = Components::load(&self.host, mission, self.folder.as_deref())?;
        compiled.insert(place, components.clone());
        Ok(components)
    }

    /// Where the components of a mission are, in the order of its plugins.
    pub(crate) fn paths(&self, mission: &Mission) -> Result<Vec<PathBuf>, CampaignError> {
        Ok(mission.components(self.folder.as_deref())?)
    }

    /// The SHA-256 of each component of a mission, by its plugin's name.
    ///
    /// # Errors
    ///
    /// [`CampaignError`] with the plugin and its file.
    pub(crate) fn hashes(&self, mission: &Mission) -> Result<BTreeMap<String, String>, CampaignError> {
        let paths = self.paths(mission)?;
        let plugins = mission.file.plugins.iter().zip(paths);
        plugins
            .map(|(plugin, path)| Ok((plugin.name.clone(), hash_file(&path)?)))
            .collect()
    }
}

/// What tells two states of a mission's folder apart: for each file its content or, if it is large, its size and time.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Fingerprint(Vec<(std::ffi::OsString, String)>);

impl Fingerprint {
    fn of(folder: &Path) -> Self {
        /// Files of missions that people write are smaller.
        const SMALL: u64 = 1 << 20;
        let entries = std::fs::read_dir(folder).into_iter().flatten().filter_map(Result::ok);
        let mut files: Vec<_> = entries
            .filter_map(|entry| {
                let about = std::fs::metadata(entry.path())
                    .ok()
                    .filter(std::fs::Metadata::is_file)?;
                let state = if about.len() <= SMALL {
                    hash_file(&entry.path()).ok()?
                } else {
                    format!("{} {:?}", about.len(), about.modified().ok())
                };
                Some((entry.file_name(), state))
            })
            .collect();
        files.sort();
        Self(files)
    }
}

pub(crate) fn hash_file(path: &Path) -> Result<String, CampaignError> {
    let bytes = std::fs::read(path).map_err(|source| CampaignError::file(path, source))?;
    Ok(hash(&bytes))
}

pub(crate) fn hash(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

impl Prepared {
    /// Makes the simulation of a seed, without faults that the campaign draws.
    ///
    /// # Errors
    ///
    /// [`CampaignError`] of a plugin or of this seed's world.
    pub fn simulation(&self, seed: u64) -> Result<Simulation, CampaignError> {
        let loaded = self.components.start(&self.mission)?;
        Ok(Simulation::new(&self.mission, &self.scenario, seed, loaded, None)?)
    }

    /// Flies a seed to its end; `None` if it was stopped before.
    ///
    /// # Errors
    ///
    /// [`CampaignError`] of a plugin or of this seed's world.
    pub fn fly(&self, seed: u64, stop: &Stop) -> Result<Option<Flown>, CampaignError> {
        let mut simulation = self.simulation(seed)?;
        let mut interference = self.faults.map(|faults| faults.draw(seed));
        if let Some(interference) = &interference {
            simulation.set_faults(interference.plan().clone());
        }
        let mut events = 0u32;
        loop {
            let goes_on = match &mut interference {
                Some(interference) => interference.advance(&mut simulation, || -> Result<_, CampaignError> {
                    Ok(self.components.start(&self.mission)?)
                })?,
                None => simulation.advance()?,
            };
            if !goes_on {
                break;
            }
            events = events.wrapping_add(1);
            if events.is_multiple_of(LOOK_EVERY) && stop.is_set() {
                return Ok(None);
            }
        }
        let now = simulation.now();
        let (mut report, trace, mvc) = simulation.finish()?;
        report.faults += interference.map_or(0, |interference| interference.begun(now));
        Ok(Some(Flown { report, trace, mvc }))
    }
}

/// Flies one run; a panic in it is a run that could not be flown. `None` if it was stopped before its end.
pub(crate) fn fly_row(prepared: &Result<Prepared, CampaignError>, plan: &Plan, key: &Key, stop: &Stop) -> Option<Row> {
    let prepared = match prepared {
        Ok(prepared) => prepared,
        Err(error) => return Some(not_flown(plan, key, &error.to_string())),
    };
    match catch_unwind(AssertUnwindSafe(|| prepared.fly(key.seed, stop))) {
        Ok(Ok(Some(flown))) => {
            let mut row = Row::of(&flown.report);
            row.text("replay", &plan.replay(key));
            Some(row)
        }
        Ok(Ok(None)) => None,
        Ok(Err(error)) => Some(not_flown(plan, key, &error.to_string())),
        Err(panic) => {
            let text = panic
                .downcast_ref::<String>()
                .map(String::as_str)
                .or_else(|| panic.downcast_ref::<&str>().copied())
                .unwrap_or("without a message");
            Some(not_flown(plan, key, &format!("a panic of the simulation: {text}")))
        }
    }
}

fn not_flown(plan: &Plan, key: &Key, reason: &str) -> Row {
    let mut row = Row::not_flown(&reason.replace('\n', " "));
    row.text("replay", &plan.replay(key));
    row
}
