//! Campaigns: simulated missions by the thousand.
//!
//! A [`Plan`] is missions x variants x points x seeds, in one canonical order. A point gives each parameter a value. Nothing of a plan is kept per run: a run is computed from its number, so a plan of a million runs costs as
//! much as one of ten.
//!
//! [`fly`] flies the runs of a plan, or one shard of them, on all cores, and appends a row for each to a journal in the
//! results folder. A campaign that was killed goes on from its journal. [`finish`] writes `runs.parquet` from the
//! journals of one process or of many shards. A row depends on its run alone, and rows stand in canonical order in row
//! groups of a fixed size, so this file has the same bytes however it was made. What depends on the computer, such as
//! times, is in `timing.parquet`.

mod design;
mod error;
mod execute;
mod faults;
mod file;
mod flight;
mod folder;
mod given;
mod journal;
mod manifest;
mod parquet_file;
mod plan;
mod results;
mod row;
mod seeds;
mod shard;
mod slurm;
mod stop;

pub use design::Value;
pub use error::CampaignError;
pub use execute::{Ended, Order, Progress, fly};
pub use faults::{DrawnFaults, Interference, ToldFault};
pub use file::{Better, CampaignFile};
pub use flight::{Crew, Flown, Prepared};
pub use folder::{Folder, RUNS, TIMING};
pub use given::Given;
pub use manifest::Manifest;
pub use parquet_file::{Column, ColumnKind, Sheet, read_columns, read_names};
pub use plan::{Key, Plan, word};
pub use results::{Finished, finish, pending};
pub use seeds::Seeds;
pub use shard::Shard;
pub use slurm::Slurm;
pub use stop::Stop;
