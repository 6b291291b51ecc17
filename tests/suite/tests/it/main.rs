//! The program as its users meet it, a file a behaviour.

mod clocks;
mod disk;
mod drivers;
mod faults;
mod fence;
mod help;
mod identifiers;
mod mvc;
mod operator;
mod predive;
mod prober;
mod refusals;
mod service;
mod session;
mod silence;
mod sim_faults;
mod simulation;
mod spi;
