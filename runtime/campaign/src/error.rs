use std::io;
use std::path::{Path, PathBuf};

use backseat_mission::MissionError;
use backseat_plugin_loader::LoadError;
use backseat_scenario::ScenarioError;
use backseat_sim::SimError;

/// Why a campaign cannot be flown, merged or read. The message is one line: what, where, what to do.
#[derive(Debug, thiserror::Error)]
pub enum CampaignError {
    /// A file or folder cannot be read or written.
    #[error("{}: {source}", path.display())]
    File {
        /// Its path.
        path: PathBuf,
        /// The reason.
        source: io::Error,
    },
    /// The campaign's file is not valid TOML, or has an unknown key.
    #[error("{}:{line}: {message}", path.display())]
    Toml {
        /// The file.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// What was found, and what was expected.
        message: String,
    },
    /// A value of the campaign's file that its key does not allow.
    #[error("{}: {message}", path.display())]
    Value {
        /// The file.
        path: PathBuf,
        /// Key, value, and what was expected.
        message: String,
    },
    /// A mission cannot be read.
    #[error(transparent)]
    Mission(#[from] MissionError),
    /// A mission's scenario cannot be read.
    #[error(transparent)]
    Scenario(#[from] ScenarioError),
    /// A plugin cannot be loaded.
    #[error(transparent)]
    Load(#[from] LoadError),
    /// A run cannot be simulated.
    #[error(transparent)]
    Simulation(#[from] SimError),
    /// A results folder cannot be used.
    #[error("{}: {message}", path.display())]
    Folder {
        /// The folder, or a file in it.
        path: PathBuf,
        /// What is wrong with it, and what to do.
        message: String,
    },
    /// A mission's files are not those with which the campaign began.
    #[error("{}: changed or gone while the campaign flies: restore its files, and the same command goes on", path.display())]
    Changed {
        /// The mission's folder.
        path: PathBuf,
    },
    /// An option has an invalid value.
    #[error("{0}")]
    Option(String),
}

impl CampaignError {
    pub(crate) fn file(path: &Path, source: io::Error) -> Self {
        Self::File {
            path: path.to_path_buf(),
            source,
        }
    }

    pub(crate) fn value(path: &Path, message: impl Into<String>) -> Self {
        Self::Value {
            path: path.to_path_buf(),
            message: message.into(),
        }
    }

    pub(crate) fn folder(path: &Path, message: impl Into<String>) -> Self {
        Self::Folder {
            path: path.to_path_buf(),
            message: message.into(),
        }
    }
}
