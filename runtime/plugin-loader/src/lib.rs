//! Loads the plugins of a mission: finds them by `component`, compiles them once, and starts them for any number of
//! runs.
//!
//! A mission says what a plugin may do and use. The host runs plugins and knows nothing of missions. This crate
//! connects the two.

mod components;
mod file;
mod load;

pub use components::Components;
pub use file::{read_component, regular_file};
pub use load::{ConfigIn, LoadError, Loaded, load_plugins};
