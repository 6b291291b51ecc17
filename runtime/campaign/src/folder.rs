use std::fs::{self, File};
use std::io::Write as _;
use std::path::{Path, PathBuf};

use crate::error::CampaignError;
use crate::manifest::Manifest;
use crate::shard::Shard;

/// The table of runs in a results folder.
pub const RUNS: &str = "runs.parquet";
/// The table of times in a results folder.
pub const TIMING: &str = "timing.parquet";
const MANIFEST: &str = "manifest.json";
const JOURNALS: &str = "journal";

/// A folder with a campaign's results.
#[derive(Clone, Debug)]
pub struct Folder {
    path: PathBuf,
}

impl Folder {
    /// Opens a results folder for a campaign, and creates it if there is none.
    ///
    /// # Errors
    ///
    /// [`CampaignError::Folder`] if it has results of another campaign, or something that is no campaign's.
    pub fn create(path: &Path, manifest: &Manifest) -> Result<Self, CampaignError> {
        let folder = Self {
            path: path.to_path_buf(),
        };
        if path.is_file() {
            return Err(CampaignError::folder(
                path,
                "is a file: expected a folder for the results",
            ));
        }
        fs::create_dir_all(folder.journals()).map_err(|source| CampaignError::file(path, source))?;
        let file = folder.path.join(MANIFEST);
        if !file.exists() {
            let others = fs::read_dir(path).map_err(|source| CampaignError::file(path, source))?;
            let stranger = others
                .filter_map(Result::ok)
                .map(|entry| entry.file_name().to_string_lossy().into_owned())
                .find(|name| name != JOURNALS && !name.starts_with('.'));
            if let Some(name) = stranger {
                // The folder of journals was made above, and may be somebody else's now.
                fs::remove_dir(folder.journals()).ok();
                return Err(CampaignError::folder(
                    path,
                    format!("has {name} and no {MANIFEST}, so it is not a campaign's: give a new or empty folder"),
                ));
            }
            folder.write_new(&file, manifest)?;
        }
        let there = folder.manifest()?;
        if let Some(difference) = there.difference(manifest) {
            return Err(CampaignError::folder(
                path,
                format!("has results of another campaign: {difference}: give another folder"),
            ));
        }
        // What the report shows, or a comment in the campaign's file. Where the missions are differs between computers.
        if !there.is_written_alike(manifest) {
            folder.replace(&file, manifest)?;
        }
        Ok(folder)
    }

    /// Opens a folder that has results.
    ///
    /// # Errors
    ///
    /// [`CampaignError::Folder`] if it has none.
    pub fn open(path: &Path) -> Result<Self, CampaignError> {
        let folder = Self {
            path: path.to_path_buf(),
        };
        if path.join(MANIFEST).is_file() {
            return Ok(folder);
        }
        let found = if path.is_dir() {
            format!("has no {MANIFEST}")
        } else if path.exists() {
            "is a file".to_owned()
        } else {
            "not found".to_owned()
        };
        Err(CampaignError::folder(
            path,
            format!("{found}: expected a folder that `backseat campaign --out` has written"),
        ))
    }

    /// Its path.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What the campaign is.
    ///
    /// # Errors
    ///
    /// [`CampaignError`] if the manifest cannot be read.
    pub fn manifest(&self) -> Result<Manifest, CampaignError> {
        let path = self.path.join(MANIFEST);
        let text = fs::read_to_string(&path).map_err(|source| CampaignError::file(&path, source))?;
        Manifest::from_json(&text).map_err(|message| CampaignError::folder(&path, message))
    }

    pub(crate) fn journal(&self, shard: Shard) -> PathBuf {
        self.journals().join(format!("{}.journal", shard.name()))
    }

    /// Checks that no journal is of another number of shards: its runs would be flown twice.
    pub(crate) fn is_divided_alike(&self, shard: Shard) -> Result<(), CampaignError> {
        for path in self.all_journals()? {
            let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
            let count = name
                .rsplit_once("-of-")
                .and_then(|(_, count)| count.parse::<u64>().ok());
            if count.is_some_and(|count| count != shard.count()) {
                let count = count.unwrap_or_default();
                let what = if count == 1 {
                    "was flown without shards: leave --shard out".to_owned()
                } else {
                    format!("is flown in {count} shards: give --shard I/{count}, or merge them when all are flown")
                };
                return Err(CampaignError::folder(
                    &self.path,
                    format!("this campaign {what}, or give another folder"),
                ));
            }
        }
        Ok(())
    }

    /// The journals of all shards, by name.
    pub(crate) fn all_journals(&self) -> Result<Vec<PathBuf>, CampaignError> {
        let path = self.journals();
        let entries = match fs::read_dir(&path) {
            Ok(entries) => entries,
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
            Err(source) => return Err(CampaignError::file(&path, source)),
        };
        let mut journals: Vec<PathBuf> = entries
            .filter_map(Result::ok)
            .map(|entry| entry.path())
            .filter(|path| path.extension().is_some_and(|extension| extension == "journal"))
            .collect();
        journals.sort();
        Ok(journals)
    }

    fn journals(&self) -> PathBuf {
        self.path.join(JOURNALS)
    }

    /// Writes the manifest anew. Nobody misses it or sees half of it, because shards may read it meanwhile.
    fn replace(&self, file: &Path, manifest: &Manifest) -> Result<(), CampaignError> {
        let own = self.path.join(format!(".manifest-{}", std::process::id()));
        fs::write(&own, manifest.to_json())
            .and_then(|()| fs::rename(&own, file))
            .map_err(|source| CampaignError::file(file, source))
    }

    /// Removes what a killed process has left half written. Only who is about to write the results may do so.
    pub(crate) fn remove_unfinished(&self) {
        let entries = fs::read_dir(&self.path).into_iter().flatten().filter_map(Result::ok);
        for entry in entries {
            let name = entry.file_name().to_string_lossy().into_owned();
            if [".runs.parquet.", ".timing.parquet.", ".report.html."]
                .iter()
                .any(|start| name.starts_with(start))
            {
                // It does no harm.
                fs::remove_file(entry.path()).ok();
            }
        }
    }

    /// Writes the manifest unless another shard has done so at the same moment. Nobody sees half of it.
    fn write_new(&self, file: &Path, manifest: &Manifest) -> Result<(), CampaignError> {
        let own = self.path.join(format!(".manifest-{}", std::process::id()));
        let failed = |source| CampaignError::file(file, source);
        let mut out = File::create(&own).map_err(failed)?;
        let written = out
            .write_all(manifest.to_json().as_bytes())
            .and_then(|()| out.sync_all())
            .and_then(|()| match fs::hard_link(&own, file) {
                Err(error) if error.kind() == std::io::ErrorKind::AlreadyExists => Ok(()),
                // Some shared file systems have no hard links.
                Err(_) => fs::rename(&own, file),
                Ok(()) => Ok(()),
            });
        fs::remove_file(&own).ok();
        written.map_err(failed)
    }
}
