//! For each rule one run that breaks exactly this rule, and beside it a run that just keeps it.

mod scenario;

mod control;
mod faults;
mod flaws;
mod gaps;
mod heard;
mod inserts;
mod leases;
mod operator;
mod readers;
mod robustness;
mod services;
mod states;
mod station;
mod truth;
