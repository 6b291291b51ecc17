//! The speed tables, which `cargo xtask bench` prints.
//!
//! The machine that measures is shared and noisy, so every row has a floor: the least that the work can cost, written
//! by hand in the benchmark and measured in the same run, both in turn. The ratio is what counts. Nothing here is a
//! test.

pub mod by_hand;
mod measure;

pub use measure::{HEADER, Stages, best_stages, in_turn, row};
