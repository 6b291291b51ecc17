//! The mock as a payload meets it: sentences in, sentences out, and the truth beside them.

mod acoustic;
mod adjustment;
mod conversation;
mod determinism;
mod dvl_trigger;
mod fields;
mod files;
mod inserts;
mod mission;
mod modify;
mod navigation;
mod payload;
mod power;
mod services;
mod session;
mod silence;
mod topside;
