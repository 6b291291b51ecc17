use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use backseat_mission::{Layers, Mission};
use backseat_scenario::Scenario;
use serde::{Deserialize, Serialize};

use crate::error::CampaignError;
use crate::file::CampaignFile;
use crate::flight::{Crew, hash, hash_file};
use crate::plan::{Key, Outline, Plan};
use crate::seeds::Seeds;

/// The version of the files in a results folder.
const FORMAT: u32 = 1;
/// The most points that are looked at for components that a parameter names.
const POINTS_MAX: u64 = 4096;

/// What a campaign is: its file, its missions and components by hash, and the program's version. Results with different
/// manifests do not belong together.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Manifest {
    /// The version of the files in this folder.
    pub format: u32,
    /// The program's version.
    pub version: String,
    /// The text of the campaign's file; for a campaign of one mission the file that says the same.
    pub campaign: String,
    /// The seeds, if they were given beside the file.
    pub seeds: Option<String>,
    /// `KEY=VALUE` that were given beside the file.
    pub set: Vec<String>,
    /// What the file says, resolved.
    outline: Outline,
    /// By mission: the SHA-256 of its files.
    missions: BTreeMap<String, MissionHashes>,
    /// By mission, variant and plugin: the SHA-256 of its component.
    components: BTreeMap<String, String>,
    /// The folder to which the missions' paths are relative. Results of several computers differ in it.
    pub folder: PathBuf,
    /// The folder in which plugins were found that a mission names without a path. Results of several computers differ in
    /// it.
    #[serde(default)]
    pub plugins: Option<PathBuf>,
}

/// The SHA-256 of what a mission is made of.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct MissionHashes {
    /// `mission.toml` resolved, the fence, and the plan that it names.
    mission: String,
    /// `world.toml`.
    world: String,
    /// The seabed's grid, if there is one.
    grid: Option<String>,
}

/// What was given to make a plan.
pub(crate) struct Sources<'a> {
    /// The text of the campaign's file.
    pub(crate) campaign: &'a str,
    /// Seeds that replace those of the file.
    pub(crate) seeds: Option<&'a Seeds>,
    /// Further `KEY=VALUE`.
    pub(crate) set: &'a [String],
    /// The folder to which missions are relative.
    pub(crate) folder: &'a Path,
}

impl Manifest {
    /// Describes a plan, and reads everything that it needs once.
    ///
    /// # Errors
    ///
    /// [`CampaignError`] of a mission or a plugin that cannot be read. With parameters, a mission must be readable at one
    /// of their first points at least.
    pub(crate) fn new(plan: &Plan, crew: &Crew, sources: &Sources<'_>, version: &str) -> Result<Self, CampaignError> {
        let mut missions = BTreeMap::new();
        let mut components = BTreeMap::new();
        let mut plugins = None;
        let step = plan.runs_of_point();
        let names_components = plan.parameters().any(|key| key.ends_with(".component"));
        let mut run = 0;
        while let Some(key) = plan.key(run) {
            let name = plan.mission(&key).display().to_string();
            if !missions.contains_key(&name) {
                missions.insert(name.clone(), MissionHashes::of(plan, &key)?);
            }
            if key.point == 0 {
                usable_point(plan, crew, key)?;
            }
            if plugins.is_none() {
                plugins = folder_of_plugins(plan, crew, &key);
            }
            if key.point == 0 || (names_components && key.point < POINTS_MAX) {
                for (plugin, hash) in component_hashes(plan, crew, &key)? {
                    let variant = plan.variant(&key);
                    components.insert([name.as_str(), variant, &plugin, &hash[..8]].join("/"), hash);
                }
            }
            // Straight to the next variant if no point names a component.
            run = if names_components {
                run + step
            } else {
                run + step * plan.points()
            };
        }
        Ok(Self {
            format: FORMAT,
            version: version.to_owned(),
            campaign: sources.campaign.to_owned(),
            seeds: sources.seeds.map(ToString::to_string),
            set: sources.set.to_vec(),
            outline: plan.outline(),
            missions,
            components,
            folder: sources.folder.to_path_buf(),
            plugins,
        })
    }

    /// The plan again, with its missions in a folder.
    ///
    /// # Errors
    ///
    /// [`CampaignError`] if the manifest was written by another version.
    pub fn plan(&self, within: &Path) -> Result<Plan, CampaignError> {
        let path = within.join("manifest.json");
        let mut file: CampaignFile = toml::from_str(&self.campaign)
            .map_err(|error| CampaignError::folder(&path, error.message().replace('\n', " ")))?;
        if let Some(seeds) = &self.seeds {
            file.seeds = seeds.parse().map_err(|message| CampaignError::folder(&path, message))?;
        }
        let plan = Plan::new(&file, &path, &self.folder, &self.set)?;
        if plan.outline() != self.outline {
            return Err(CampaignError::folder(
                &path,
                "its campaign does not give the runs that it lists: it was changed",
            ));
        }
        Ok(plan)
    }

    /// The SHA-256 of everything that the results depend on.
    #[must_use]
    pub fn identity(&self) -> String {
        // The outline has everything of the campaign's file that decides a run.
        let mut same = self.clone();
        same.folder = PathBuf::new();
        same.plugins = None;
        same.campaign.clear();
        same.seeds = None;
        same.set.clear();
        hash(same.to_json().as_bytes())
    }

    /// Whether the campaign's file and what was said beside it are the same, to the letter.
    pub(crate) fn is_written_alike(&self, other: &Self) -> bool {
        (&self.campaign, &self.seeds, &self.set) == (&other.campaign, &other.seeds, &other.set)
    }

    /// In what another manifest differs, in words; `None` if their results belong together.
    #[must_use]
    pub fn difference(&self, other: &Self) -> Option<String> {
        if self.identity() == other.identity() {
            return None;
        }
        if self.version != other.version {
            return Some(format!(
                "backseat {} wrote it, and this is {}",
                self.version, other.version
            ));
        }
        let changed = |ours: &BTreeMap<String, String>, theirs: &BTreeMap<String, String>| {
            let keys = ours.keys().chain(theirs.keys());
            keys.into_iter().find(|key| ours.get(*key) != theirs.get(*key)).cloned()
        };
        if self.outline.missions != other.outline.missions {
            return Some(format!("its missions are {}", self.outline.missions.join(", ")));
        }
        if self.outline.seeds != other.outline.seeds {
            return Some(format!("its seeds are {}", self.outline.seeds));
        }
        if self.outline != other.outline {
            return Some("its variants, parameters, faults or --set are others".to_owned());
        }
        for (name, hashes) in &self.missions {
            let Some(theirs) = other.missions.get(name) else {
                continue;
            };
            if hashes.mission != theirs.mission {
                return Some(format!("mission.toml, the fence or the plan of {name} has changed"));
            }
            if hashes != theirs {
                return Some(format!("world.toml of {name}, or its grid, has changed"));
            }
        }
        if let Some(component) = changed(&self.components, &other.components) {
            let component = component.rsplit_once('/').map_or(component.as_str(), |(name, _)| name);
            return Some(format!("the component of {} has changed", component.replace("//", "/")));
        }
        Some("its manifest differs".to_owned())
    }

    pub(crate) fn to_json(&self) -> String {
        // Nothing in it can fail to be written as JSON.
        serde_json::to_string_pretty(self).unwrap_or_default() + "\n"
    }

    pub(crate) fn from_json(text: &str) -> Result<Self, String> {
        let format = serde_json::from_str::<serde_json::Value>(text)
            .map_err(|error| format!("{error}: expected what `backseat campaign` writes"))?["format"]
            .as_u64();
        if format != Some(u64::from(FORMAT)) {
            return Err(format!(
                "its format is {}, and this program reads {FORMAT}",
                format.map_or_else(|| "missing".to_owned(), |format| format.to_string())
            ));
        }
        serde_json::from_str(text).map_err(|error| error.to_string())
    }
}

impl MissionHashes {
    fn of(plan: &Plan, key: &Key) -> Result<Self, CampaignError> {
        let mission = Mission::load(&plan.place(key), &Layers::default())?;
        let scenario = Scenario::load(&mission)?;
        let grid = scenario.world.seabed.grid.as_ref();
        let grid = grid
            .map(|grid| hash_file(&scenario.path.with_file_name(grid)))
            .transpose()?;
        Ok(Self {
            mission: mission.hash(),
            world: hash(scenario.text.as_bytes()),
            grid,
        })
    }
}

fn component_hashes(plan: &Plan, crew: &Crew, key: &Key) -> Result<BTreeMap<String, String>, CampaignError> {
    let layers = Layers {
        set: plan.sets(key).0,
        environment: false,
    };
    match Mission::load(&plan.place(key), &layers) {
        Ok(mission) => crew.hashes(&mission),
        // A point at which the mission cannot be read is a row of the results.
        Err(_) => Ok(BTreeMap::new()),
    }
}

/// The folder in which a run's first plugin without a path was found.
fn folder_of_plugins(plan: &Plan, crew: &Crew, key: &Key) -> Option<PathBuf> {
    let layers = Layers {
        set: plan.sets(key).0,
        environment: false,
    };
    let mission = Mission::load(&plan.place(key), &layers).ok()?;
    let found = crew.paths(&mission).ok()?;
    let mut named = mission.file.plugins.iter().zip(found);
    let (_, path) = named.find(|(plugin, _)| !plugin.component.contains('/') && !plugin.component.contains('.'))?;
    std::path::absolute(path.parent()?).ok()
}

/// Checks that one of the first points can be flown at all: a key that no file has fails at all of them.
fn usable_point(plan: &Plan, crew: &Crew, first: Key) -> Result<(), CampaignError> {
    const TRIED: u64 = 32;
    let mut error = None;
    for point in 0..plan.points().min(TRIED) {
        let Some(key) = plan.key(first.run + point * plan.runs_of_point()) else {
            break;
        };
        let tried = crew
            .prepare(plan, &key)
            .and_then(|prepared| prepared.simulation(key.seed));
        match tried {
            Ok(_) => return Ok(()),
            Err(failed) => error = error.or(Some(failed)),
        }
    }
    error.map_or(Ok(()), Err)
}
