//! Trials of core against a scripted vehicle, a link that can fail and scripted plugins, in virtual time.
//!
//! Tests that hold a safety requirement bear its number.

mod control;
mod course;
mod freshness;
mod geometry;
mod inserts;
mod lease;
mod ledger;
mod operator;
mod plugins;
mod random;
mod session;
mod trial;
mod vehicle;
