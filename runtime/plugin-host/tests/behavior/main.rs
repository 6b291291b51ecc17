//! What the host does with good and bad plugins: real components, built from `plugins/`.

#![expect(
    clippy::unwrap_used,
    reason = "the lint exempts test functions only, not the functions that they call"
)]

mod admission;
mod bounds;
mod cache;
mod determinism;
mod faults;
mod fixture;
mod interface;
mod life_cycle;
mod meter;
mod round_trip;
mod seat;
