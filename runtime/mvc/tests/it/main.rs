//! The mock as a payload meets it: sentences in, sentences out, and the truth beside them.

mod aiding;
mod conversation;
mod determinism;
mod dvl;
mod files;
mod inserts;
mod mission;
mod modify;
mod navigation;
mod payload;
mod sensors;
mod sentences;
mod session;
