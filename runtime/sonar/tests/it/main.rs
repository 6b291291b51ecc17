//! Trials of the client against a scripted payload controller, in virtual time.
#![expect(clippy::unwrap_used, reason = "a panic fails the test")]
#![expect(clippy::wildcard_enum_match_arm, reason = "a test looks for one thing among many")]

mod alarms;
mod answers;
mod connection;
mod controller;
mod flood;
mod garbage;
mod imagery;
mod logging;
mod navigation;
mod quiet;
mod random;
mod sensors;
mod settings;
mod shutdown;
mod status;
mod trial;
