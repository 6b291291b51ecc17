//! Long runs of the mock vehicle: does its memory stay flat, its clock exact, its log whole?
//!
//! [`year`] flies days on a virtual clock as fast as they go, with faults that the seed draws; [`tcp`] serves clients in
//! real time by the program itself. Both end with a report and say what was not as it must be.

#![expect(clippy::disallowed_methods, reason = "a soak run measures itself by the real clock")]

mod memory;
pub mod tcp;
pub mod year;

pub use memory::resident_kib;
