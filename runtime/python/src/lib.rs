//! The Python package `backseat`: what a study needs of the program, without a process for each run.
//!
//! [`simulate`] flies a mission as `backseat sim` does, [`campaign`] flies many runs as `backseat campaign` does, [`decode`] and [`encode`] read and write sentences of the
//! Standard Payload Interface, and [`table`], [`trajectory`] and [`describe`] read the log of a run. All of it is plain
//! Rust. With the feature `module`, which only Maturin turns on, `module.rs` makes it an extension module of Python;
//! `python/backseat` beside it is what users import.

mod campaign;
mod error;
mod log;
#[cfg(feature = "module")]
mod module;
mod simulation;
mod spi;

pub use campaign::{Campaign, campaign};
pub use error::Error;
pub use log::{describe, table, trajectory};
pub use simulation::{Flight, simulate};
pub use spi::{catalogue, decode, encode};
