//! Logs of simulated runs, replayed.
#![expect(
    clippy::unwrap_used,
    reason = "a test may panic, and so may the functions that it calls"
)]

mod changed;
mod faults;
mod flight;
mod missions;
mod parts;
mod plugins;
mod stops;
