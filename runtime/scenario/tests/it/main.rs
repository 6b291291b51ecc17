//! Scenarios of missions as folders.
#![expect(clippy::unwrap_used, reason = "a failed unwrap in a test shows where")]

mod controller;
mod dive;
mod grid;
mod world;
