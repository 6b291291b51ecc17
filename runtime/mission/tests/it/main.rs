//! Missions as folders.

mod grid;
mod hull;
