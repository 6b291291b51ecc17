//! The plugins of a mission: found where `component` says, compiled once, and started for as many runs as there are.
//!
//! A mission says what a plugin may do and use; the host runs it and knows no mission. Between them is this.

mod components;
mod load;

pub use components::Components;
pub use load::{LoadError, Loaded, load_plugins};
