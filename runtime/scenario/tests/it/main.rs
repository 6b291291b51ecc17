//! Scenarios of missions as folders.

mod grid;
mod world;
