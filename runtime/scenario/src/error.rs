use std::path::PathBuf;

use backseat_mission::MissionError;
use backseat_mvc::MvcError;
use backseat_world::WorldError;

/// A scenario that cannot be used. Always one line: file, place, what was expected.
#[derive(Debug, thiserror::Error)]
pub enum ScenarioError {
    /// There is none.
    #[error("{}: not there: a mission needs its world to be simulated", path.display())]
    NoWorld {
        /// Where `world.toml` would be.
        path: PathBuf,
    },
    /// A file that cannot be read.
    #[error("{}: {source}", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// `world.toml` or a plan of faults is wrong.
    #[error("{}: {source}", path.display())]
    World {
        /// The file.
        path: PathBuf,
        /// Where, what, and what was expected.
        source: MvcError,
    },
    /// A seabed's grid is none.
    #[error("{}: {source}", path.display())]
    Grid {
        /// The file.
        path: PathBuf,
        /// The line or tag.
        source: WorldError,
    },
    /// A seabed's grid that is too large to be read.
    #[error("{}: the file is over {bytes_max} bytes, expected at most that", path.display())]
    GridSize {
        /// The file.
        path: PathBuf,
        /// The most that is read.
        bytes_max: u64,
    },
    /// A file of the front seat's plan.
    #[error(transparent)]
    Plan(#[from] MissionError),
}
