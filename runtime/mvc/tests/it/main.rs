//! The mock as a payload meets it: sentences in, sentences out, and the truth beside them.

mod conversation;
mod determinism;
mod faults;
mod faults_link;
mod faults_plan;
mod files;
mod hovering;
mod hovering_moves;
mod hovering_random;
mod inserts;
mod mission;
mod modify;
mod navigation;
mod payload;
mod sections;
mod session;
