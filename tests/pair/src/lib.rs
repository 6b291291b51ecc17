//! Core and the mock vehicle connected to each other, on a virtual clock and with a scripted plugin. The tests show how
//! the two sides of the interface work together, without sandbox, socket or mission file.

mod course;
mod dive;

pub use course::{circle, course_plugin, limits, line, modify, place};
pub use dive::{Dive, Setup};
