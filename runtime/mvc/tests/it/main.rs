//! The mock as a payload meets it: sentences in, sentences out, and the truth beside them.

mod consistency;
mod conversation;
mod determinism;
mod ending;
mod files;
mod gps;
mod inserts;
mod mission;
mod modify;
mod navigation;
mod payload;
mod places;
mod session;
mod told;
