//! What the host does with plugins, good and bad: real components, built from `plugins/`.

#![expect(
    clippy::unwrap_used,
    reason = "the lint knows only test functions as tests, not what they call"
)]

mod admission;
mod bounds;
mod determinism;
mod faults;
mod fixture;
mod life_cycle;
mod round_trip;
