//! The program as its users see it, one file for each behavior.

mod cache;
mod campaign;
mod doctor;
mod examples;
mod explain;
mod faults;
mod fence;
mod help;
mod lock;
mod log_export;
mod log_judge;
mod log_report;
mod older_plugin;
mod plugin;
mod predive;
mod prober;
mod real_time;
mod refusals;
mod replay;
#[cfg(test)]
mod s7k;
mod sea;
mod sim_faults;
mod simulation;
mod sonar;
mod spi;
mod viewers;
mod warnings;
