//! Missions on disk: a folder with `mission.toml`, a fence (`fence.geojson`, `fence.plan` or `fence.kml`) and, where the
//! mission names one, the front seat's plan. What goes to sea is read here; `world.toml` beside it is simulation's, and
//! nothing in it keeps a mission from being read.
//!
//! Each file is parsed alone first, so that a fault is told with its line; then `mission.toml` is layered: defaults,
//! the file, the environment (`BACKSEAT__LIMITS__SPEED_MAX_MPS=1.8`), the command line (`--set limits.speed_max_mps=1.8`).
//! The whole that results can be printed, and its hash is in every log.

mod component;
mod error;
mod external;
mod fence;
mod file;
mod mission;
mod plan;
mod predive;
mod renamed;

pub use component::find_component;
pub use error::MissionError;
pub use external::ExternalTable;
pub use fence::FenceTable;
pub use file::{BudgetTable, MissionFile, PlanTable, PluginTable, VehicleTable};
pub use mission::{Layers, Mission};
pub use plan::FrontSeatPlan;
pub use predive::{Dive, beyond_class};
