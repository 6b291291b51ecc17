//! Missions as folders.

mod hull;
mod plan;
