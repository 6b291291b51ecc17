//! Runs plugins: WebAssembly components with budgets, as pure functions of their inputs.
//!
//! A [`Host`] loads a [`Component`], a component starts a [`Plugin`], and a plugin is stepped. Calls are synchronous, one
//! at a time; a deployed runtime gives each plugin a thread. What a plugin does within a call is the same on every
//! machine: it has no clock, no random numbers, no files and no network, NaNs are canonical, relaxed SIMD and threads
//! are off, and its fuel is counted by the instruction. What one does to itself it does to nobody else (safety requirement
//! 006).
//!
//! # What one plugin can take
//! | bound | where | when it is broken |
//! |---|---|---|
//! | fuel of a call | [`Budget`] | `OutOfFuel` |
//! | linear memory in all, 64 instances, 32 tables, 8 memories, 100,000 table elements | [`Budget`] | `Memory`, where it then traps |
//! | bytes that one call passes to the host | 128 KiB a step, 1 MiB a snapshot | `TooMuch`, before anything is allocated for them |
//! | 256 requests a step, 256 bytes a text, 8 frames of 1024 bytes a packet | | `TooMuch` |
//! | 32 log lines a step and a second, twice as many at once, of 256 bytes | | cut; the rest are counted |
//! | 32 MiB a component, 120 s to compile it | [`Host::load_within`] | it is not loaded |
//! | wall clock | [`Plugin::set_deadline_ticks`] | `Deadline` |
//!
//! An instruction is one unit of fuel, a bulk operation one more for each byte, growing the memory 255 and as many for
//! each page, and each import has a fixed price that is charged before it does anything: [`LOG_FUEL`], [`FENCE_FUEL`].
//!
//! # Life cycle
//! After a fault that loses the instance (all but `Error`), [`Plugin::step`] answers `Start` until [`Plugin::restart`]
//! has made a new one: `init`, then `restore` of the last snapshot, which is taken every so many steps. Whether and when
//! to restart is the caller's to decide.

mod budget;
mod error;
mod host;
mod inspection;
mod instance;
mod lines;
mod plugin;
mod v0_1_0;

pub use budget::Budget;
pub use error::HostError;
pub use host::{COMPILE_TIME, COMPONENT_BYTES, Component, Host};
pub use inspection::{Inspection, inspect};
pub use instance::{FENCE_FUEL, LOG_FUEL};
pub use plugin::{Plugin, Restarted, Started};
