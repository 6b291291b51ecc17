//! The log of a run.

mod channels;
mod log;
mod sample;
mod view;
mod viewer;
