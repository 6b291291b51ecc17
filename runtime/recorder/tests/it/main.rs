//! The log of a run.

mod log;
