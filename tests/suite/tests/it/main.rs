//! The program as its users meet it, a file a behaviour.

mod drivers;
mod faults;
mod fence;
mod help;
mod identifiers;
mod mvc;
mod operator;
mod prober;
mod refusals;
mod session;
mod silence;
mod sim_faults;
mod simulation;
mod spi;
