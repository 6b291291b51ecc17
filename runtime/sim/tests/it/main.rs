//! What is done to a run from outside.

mod faults;
mod flight;
mod plugins;
mod process;
