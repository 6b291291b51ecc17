//! Trials of core against a scripted vehicle, a link that can fail and scripted plugins, in virtual time.
//!
//! The name of a test of a safety requirement has the requirement's number.
#![expect(clippy::unwrap_used, reason = "a panic fails the test")]
#![expect(clippy::wildcard_enum_match_arm, reason = "a test looks for one thing among many")]
mod acoustic;
mod adjustments;
mod admission;
mod arbiter;
mod cancelled;
mod clock;
mod control;
mod course;
mod damaged_answers;
mod day;
mod devices;
mod dive;
mod dvl;
mod expected;
mod external;
mod external_bounds;
mod freshness;
mod geometry;
mod gps;
mod heartbeat;
mod inserts;
mod integrity;
mod judge;
mod lease;
mod ledger;
mod loss;
mod operator;
mod orders;
mod others;
mod outcomes;
mod plugins;
mod previous_run;
mod random;
mod recovery;
mod scene;
mod session;
mod silent;
mod sonar;
mod station;
mod station_bounds;
mod station_course;
mod station_left;
mod station_random;
mod swap;
mod taken_up;
mod topside;
mod trial;
mod unheard;
mod unreadable;
mod vehicle;
mod ways;
mod windows;
