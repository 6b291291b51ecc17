//! The log and the picture of a run.

mod log;
mod picture;
