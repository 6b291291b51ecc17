//! Long runs. For the mock vehicle they check that its memory stays flat, its clock exact and its log complete; for the
//! runtime, that the vehicle steers itself again in time, whatever happens to the process.
//!
//! [`year`] flies days on a virtual clock as fast as possible, with faults that the seed draws. [`tcp`] serves clients
//! in real time with the program itself. [`kills`] kills, stops and cuts off the runtime in real time. [`beside`] runs
//! a faulty plugin beside a good one. [`replays`] replays simulated dives with faults. [`slurm`] flies a campaign on
//! a real Slurm. [`stuck`] runs the runtime with terminals and disks that are slow, stuck, full or closed. Each ends with a report, which lists everything that is not as required.

#![expect(clippy::disallowed_methods, reason = "a soak run measures itself by the real clock")]

pub mod beside;
pub mod kills;
mod memory;
pub mod replays;
pub mod slurm;
pub mod stuck;
pub mod tcp;
pub mod year;

pub use memory::resident_kib;
