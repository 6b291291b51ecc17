//! The mock as a payload meets it: sentences in, sentences out, and the truth beside them.

mod conversation;
mod determinism;
mod faults;
mod faults_link;
mod faults_plan;
mod files;
mod hostile;
mod inserts;
mod logging;
mod mission;
mod modify;
mod navigation;
mod payload;
mod roles;
mod session;
