//! The controller as its clients see it: records in, records out, and the files that it writes.

mod addressing;
mod appendix_c;
mod commands;
mod configuration;
mod determinism;
mod document;
mod faults;
mod hostile;
mod logging;
mod random;
mod records;
mod refusals;
mod rig;
mod run_list;
mod shutdown;
mod slow_clients;
mod subscriptions;
mod time;
