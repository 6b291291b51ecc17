//! Missions as folders.

mod plan;
mod station;
