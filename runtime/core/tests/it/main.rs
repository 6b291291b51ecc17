//! Trials of core against a scripted vehicle, a link that can fail and scripted plugins, in virtual time.
//!
//! Tests that hold a safety requirement bear its number.
#![expect(clippy::unwrap_used, reason = "a test that cannot go on says where")]
#![expect(clippy::wildcard_enum_match_arm, reason = "a test looks for one thing among many")]

mod acoustic;
mod adjustments;
mod arbiter;
mod clock;
mod control;
mod course;
mod day;
mod devices;
mod dive;
mod driver_bounds;
mod drivers;
mod dvl;
mod expected;
mod freshness;
mod geometry;
mod gps;
mod heartbeat;
mod hull;
mod hull_bounds;
mod hull_course;
mod hull_left;
mod hull_random;
mod inserts;
mod integrity;
mod judge;
mod kept;
mod lease;
mod led;
mod ledger;
mod operator;
mod orders;
mod outcomes;
mod plugins;
mod random;
mod recovery;
mod session;
mod silent;
mod successor;
mod taken_up;
mod topside;
mod trial;
mod unheard;
mod vehicle;
mod windows;
