//! Trials of the bridge with the mock payload controller, in virtual time.
#![expect(clippy::unwrap_used, reason = "a panic fails the test")]
#![expect(clippy::wildcard_enum_match_arm, reason = "a test looks for one thing among many")]

mod controller;
