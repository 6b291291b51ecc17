//! Missions on disk: a folder with `mission.toml`, a fence (`fence.geojson`, `fence.plan` or `fence.kml`) and, if the
//! mission names one, the front seat's plan. This crate reads what goes to sea. `world.toml` in the same folder is for
//! simulation only, and an error in it does not prevent a mission from being read.
//!
//! Each file is first parsed on its own, so that an error is reported with its line. Then the layers of `mission.toml`
//! are merged: defaults, the file, the environment (`BACKSEAT__LIMITS__SPEED_MAX_MPS=1.8`), the command line (`--set
//! limits.speed_max_mps=1.8`). The result can be printed, and its hash is in every log.

mod component;
mod error;
mod external;
mod fence;
mod file;
mod mission;
mod place;
mod plan;
mod predive;
mod set;
mod sonar;
mod unknown;

pub use component::find_component;
pub use error::MissionError;
pub use external::ExternalTable;
pub use fence::{FenceTable, Origin};
pub use file::{BudgetTable, MissionFile, PlanTable, PluginTable, VehicleTable};
pub use mission::{Layers, Mission, RecordedParts};
pub use plan::{FrontSeatPlan, expected_plan, first_difference};
pub use predive::{Dive, beyond_class};
pub use unknown::with_suggestion;
