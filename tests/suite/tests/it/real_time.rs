//! Tests in real time. They wait more than they compute, and check the program's timing, so that nothing else may run
//! beside them. `cargo xtask test` runs these tests separately, several at once.

mod clocks;
mod connect;
mod console;
mod disk;
mod dives;
mod external;
mod fly;
mod heard;
mod identifiers;
mod judge;
mod mvc;
mod mvc_orders;
mod mvc_start;
mod operator;
pub(crate) mod pages;
mod plc;
mod replay;
mod sea;
mod service;
mod session;
mod silence;
mod sonar;
mod stall;
mod stuck;
mod swap;
