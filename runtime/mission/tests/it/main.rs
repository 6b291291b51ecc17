//! Missions as folders.

mod plan;
mod renamed;
mod station;
