//! The mock as a payload meets it: sentences in, sentences out, and the truth beside them.

mod acoustic;
mod adjustment;
mod conversation;
mod determinism;
mod dvl_trigger;
mod faults;
mod faults_link;
mod faults_plan;
mod fields;
mod files;
mod hovering;
mod hovering_moves;
mod hovering_random;
mod inserts;
mod mission;
mod modify;
mod navigation;
mod payload;
mod power;
mod sections;
mod services;
mod session;
mod silence;
mod topside;
