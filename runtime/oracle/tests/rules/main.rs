//! One run for each rule that breaks exactly it, and beside it the run that just keeps it.

mod scenario;

mod control;
mod inserts;
mod leases;
mod robustness;
mod truth;
