//! Missions as folders.

mod origin;
mod plan;
mod recorded;
mod renamed;
mod station;
