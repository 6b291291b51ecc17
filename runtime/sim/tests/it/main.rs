//! What a test does to a run from outside.

mod faults;
mod flight;
mod plugins;
mod process;
