//! What runs against the clock: it waits more than it computes, and holds the program to its times, so that nothing else
//! may run beside it. `cargo xtask test` runs these tests apart, several at once.

mod clocks;
mod connect;
mod disk;
mod external;
mod heard;
mod identifiers;
mod judge;
mod mvc;
mod operator;
mod pages;
mod sea;
mod service;
mod session;
mod silence;
mod stall;
mod stuck;
