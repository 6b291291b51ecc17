//! Long runs: of the mock vehicle, whether its memory stays flat, its clock exact and its log whole; of the runtime,
//! whether the vehicle has its helm again in time, whatever happens to the process.
//!
//! [`year`] flies days on a virtual clock as fast as they go, with faults that the seed draws; [`tcp`] serves clients in
//! real time by the program itself; [`kills`] kills, stops and cuts off the runtime in real time; [`beside`] has a bad plugin beside a good one;
//! [`stuck`] has terminals and disks that are slow, stuck, full or gone around the runtime. Each ends with a report
//! and says what was not as it must be.

#![expect(clippy::disallowed_methods, reason = "a soak run measures itself by the real clock")]

pub mod beside;
pub mod kills;
mod memory;
pub mod stuck;
pub mod tcp;
pub mod year;

pub use memory::resident_kib;
