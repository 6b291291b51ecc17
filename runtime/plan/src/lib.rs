//! The front seat's plan as files have it: the `[[plan]]` tables, what is wrong with them, and where each behavior leads.
//!
//! A mission's `plan.toml` and a simulation's `world.toml` write a plan alike. This crate reads it for both, so that what
//! is checked ashore is what the mock vehicle flies. It knows no vehicle: a plan is held against [`VehicleLimits`], those
//! of a [`VehicleClass`] or tighter ones.

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
