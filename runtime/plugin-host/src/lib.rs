//! Runs plugins: WebAssembly components with budgets, as pure functions of their inputs.
//!
//! A [`Host`] loads a [`Component`], a component starts a [`Plugin`], and a plugin is stepped. Calls are synchronous, one
//! at a time; a deployed runtime gives each plugin a thread. Within a call a plugin behaves the same on every machine: it
//! has no clock, no random numbers, no files and no network, NaNs are canonical, relaxed SIMD and threads are off, and
//! fuel is counted for each instruction. A plugin that misbehaves harms no other plugin (safety requirement 006).
//!
//! # Limits of a plugin
//! | limit | where | when it is exceeded |
//! |---|---|---|
//! | fuel of a call | [`Budget`] | `OutOfFuel` |
//! | linear memory in total, 64 instances, 32 tables, 8 memories, 100,000 table elements | [`Budget`] | `Memory`, if the plugin then traps |
//! | bytes that one call passes to the host | 128 KiB for a step, 1 MiB for a snapshot | `TooMuch`, before anything is allocated for them |
//! | 256 requests in a step, 256 bytes in a text, 8 frames of 1024 bytes in a packet | | `TooMuch` |
//! | 32 log lines in a step and in a second, with a burst of twice as many, each of 256 bytes and one line | | lines are cut or dropped; dropped lines are counted |
//! | 64 published values in a second, with a burst of twice as many, under 64 names | | values are dropped; a log line counts them and says why |
//! | 32 MiB for a component, 120 s to compile it | [`Host::load_within`] | it is not loaded |
//! | wall clock | [`Plugin::set_deadline_ticks`] | `Deadline` |
//!
//! An instruction costs one unit of fuel, and a bulk operation one more for each byte. Growing the memory costs 255 units,
//! and 255 more for each page. Each import has a fixed price, which is charged before it does anything: [`LOG_FUEL`],
//! [`FENCE_FUEL`], [`PUBLISH_FUEL`].
//!
//! # Cache
//! A host with a [`Cache`] loads what an earlier process has compiled, in milliseconds, and only if this user wrote it.
//!
//! # Life cycle
//! After a fault that loses the instance (all but `Error`), [`Plugin::step`] returns `Start` until [`Plugin::restart`] has
//! created a new instance: it calls `init`, then `restore` with the last snapshot. Snapshots are taken at the interval of
//! the budget. The caller decides whether and when to restart.

mod allowance;
mod brief;
mod budget;
mod cache;
mod error;
mod host;
mod inspection;
mod instance;
mod interface;
mod lines;
mod measures;
mod meter;
mod plugin;
mod seat;
mod v0_1_0;
mod v0_2_0;

pub use brief::Brief;
pub use budget::Budget;
pub use cache::{Cache, Notice, PATIENCE, ROOM_BYTES};
pub use error::HostError;
pub use host::{COMPILE_TIME, COMPONENT_BYTES, Component, Host, Origin};
pub use inspection::check_form;
pub use instance::{FENCE_FUEL, LOG_FUEL, PUBLISH_FUEL};
pub use interface::Interface;
pub use meter::{Meter, Stopwatch, Usage};
pub use plugin::{PANICKED, Plugin, Restarted, Started};
pub use seat::{NextRestart, Seat};
