//! Missions as folders.

mod plan;
mod recorded;
mod renamed;
mod station;
