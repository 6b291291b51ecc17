use std::path::{Path, PathBuf};

use backseat_mission::{MissionError, with_suggestion};
use backseat_mvc::MvcError;
use backseat_plc::PlcError;
use backseat_world::WorldError;

/// A scenario that cannot be used. The message is one line: the file, the place in it, what was expected.
#[derive(Debug, thiserror::Error)]
pub enum ScenarioError {
    /// The mission has no scenario.
    #[error("{}: not found: to be simulated, a mission needs this file", path.display())]
    NoWorld {
        /// Where `world.toml` should be.
        path: PathBuf,
    },
    /// A key of `world.toml` cannot be set from outside.
    #[error("--set {set}: {message}")]
    Set {
        /// `KEY=VALUE`.
        set: String,
        /// The reason, and what was expected.
        message: String,
    },
    /// There is no scenario at a place that was named.
    #[error("{}: {found}: expected a folder with world.toml, or the path of a world.toml", path.display())]
    NoPlace {
        /// The place.
        path: PathBuf,
        /// What is there instead.
        found: &'static str,
    },
    /// A file cannot be read.
    #[error("{}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The reason.
        source: std::io::Error,
    },
    /// `world.toml` or a file of faults is invalid.
    #[error("{}: {source}", path.display())]
    World {
        /// The file.
        path: PathBuf,
        /// The place, the error, and what was expected.
        source: MvcError,
    },
    /// A value of the table `[plc]` is invalid.
    #[error("{}: {source}", path.display())]
    Controller {
        /// The file.
        path: PathBuf,
        /// The key, what was found and what was expected.
        source: PlcError,
    },
    /// A seabed's grid is invalid.
    #[error("{}: {source}", path.display())]
    Grid {
        /// The file.
        path: PathBuf,
        /// The line or tag.
        source: WorldError,
    },
    /// A seabed's grid is too large to be read.
    #[error("{}: the file is larger than the limit of {bytes_max} bytes", path.display())]
    GridSize {
        /// The file.
        path: PathBuf,
        /// The largest size that is read.
        bytes_max: u64,
    },
    /// The file of the front seat's plan is invalid.
    #[error(transparent)]
    Plan(#[from] MissionError),
}

impl ScenarioError {
    /// An error in `world.toml` or a file of faults. An unknown key gets the name that it resembles.
    pub(crate) fn world(path: &Path, mut source: MvcError) -> Self {
        if let MvcError::Toml { message, .. } = &mut source {
            *message = with_suggestion(message);
        }
        Self::World {
            path: path.to_path_buf(),
            source,
        }
    }
}
