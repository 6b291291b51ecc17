//! Core and the mock vehicle against each other, on a virtual clock and with a scripted plugin: what the two sides of
//! the interface make of each other, before any sandbox, socket or mission file.

mod course;
mod dive;

pub use course::{circle, course_plugin, limits, line, modify, place};
pub use dive::{Dive, Setup};
