//! The log of a run.

mod channels;
mod join;
mod log;
mod sample;
mod view;
mod viewer;
