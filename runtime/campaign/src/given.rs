use std::path::{Path, PathBuf};

use crate::error::CampaignError;
use crate::file::CampaignFile;
use crate::flight::Crew;
use crate::folder::Folder;
use crate::manifest::{Manifest, Sources};
use crate::plan::Plan;
use crate::seeds::Seeds;

/// The seeds of a mission that is flown without a campaign's file, if none are given.
const SEEDS: &str = "1..100";

/// A campaign as a user gives it: a campaign's file or a mission's folder, and what is said beside it.
#[derive(Clone, Debug)]
pub struct Given {
    /// What it flies.
    pub plan: Plan,
    text: String,
    seeds: Option<Seeds>,
    set: Vec<String>,
    folder: PathBuf,
}

impl Given {
    /// Reads a campaign's file, or makes a campaign of a mission's folder. `seeds` replace those of the file, and `set` are
    /// further `KEY=VALUE` of every run.
    ///
    /// # Errors
    ///
    /// [`CampaignError`] with the file, and the line or the key.
    pub fn read(path: &Path, seeds: Option<Seeds>, set: &[String]) -> Result<Self, CampaignError> {
        let (mut file, text, folder) = if path.is_dir() {
            let default = SEEDS.parse().map_err(CampaignError::Option)?;
            let file = CampaignFile::of_mission(path.to_path_buf(), default);
            let mission = toml::Value::String(path.display().to_string());
            let text = format!("missions = [{mission}]\nseeds = \"{SEEDS}\"\n");
            (file, text, PathBuf::new())
        } else if path.file_name().is_some_and(|name| name == "mission.toml") && path.is_file() {
            return Err(CampaignError::folder(
                path,
                format!(
                    "is a mission: give its folder, {}, or a campaign's file",
                    path.parent()
                        .filter(|parent| !parent.as_os_str().is_empty())
                        .unwrap_or(Path::new("."))
                        .display()
                ),
            ));
        } else if path.is_file() {
            let file = CampaignFile::read(path)?;
            let text = std::fs::read_to_string(path).map_err(|source| CampaignError::file(path, source))?;
            (file, text, path.parent().map(Path::to_path_buf).unwrap_or_default())
        } else {
            return Err(CampaignError::folder(
                path,
                "not found: expected a campaign's file or a mission's folder",
            ));
        };
        if let Some(seeds) = &seeds {
            file.seeds = seeds.clone();
        }
        let plan = Plan::new(&file, path, &folder, set)?;
        let folder = if folder.as_os_str().is_empty() {
            Path::new(".")
        } else {
            &folder
        };
        Ok(Self {
            plan,
            text,
            seeds,
            set: set.to_vec(),
            folder: std::path::absolute(folder).map_err(|source| CampaignError::file(folder, source))?,
        })
    }

    /// Reads everything that the campaign needs once, and opens its results folder.
    ///
    /// # Errors
    ///
    /// [`CampaignError`] of a mission, of a plugin or of the folder.
    pub fn open(&self, crew: &Crew, out: &Path, version: &str) -> Result<Folder, CampaignError> {
        let sources = Sources {
            campaign: &self.text,
            seeds: self.seeds.as_ref(),
            set: &self.set,
            folder: &self.folder,
        };
        Folder::create(out, &Manifest::new(&self.plan, crew, &sources, version)?)
    }
}
