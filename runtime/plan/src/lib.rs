//! The front seat's plan as files hold it: the `[[plan]]` tables, their errors, and the path of each behavior.
//!
//! A mission's `plan.toml` and a simulation's `world.toml` hold plans in the same format. This crate reads both, so
//! that the plan that is checked before a dive is the plan that the mock vehicle flies. The crate does not model a
//! vehicle: it checks a plan against [`VehicleLimits`], those of a [`VehicleClass`] or tighter ones.

mod class;
mod element;
mod entry;
mod error;
mod planned;

pub use class::{VehicleClass, VehicleLimits};
pub use element::{Course, PayloadText, PlanElement, PlannedVertical, resolve, with_leads};
pub use entry::{PlaceConfig, PlanEntry, PlanKind};
pub use error::PlanError;
pub use planned::{PlannedBehavior, PlannedPath, planned_behaviors};
