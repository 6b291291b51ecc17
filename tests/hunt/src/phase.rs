//! How a hunted mission is laid out in time, seconds.

use std::time::Duration;

/// Faults come from here on: the session stands.
pub(crate) const FIRST_S: f64 = 30.0;
/// Until here faults come.
pub(crate) const SAFETY_S: f64 = 800.0;
/// Here the last fault is over, and the liveness phase begins.
pub(crate) const CALM_S: f64 = 900.0;
/// So long after that the link must be up again: the longest back-off with its chance, and a refused attempt.
pub(crate) const LINK_WITHIN: Duration = Duration::from_secs(90);
/// Here the operator takes the helm for good: what the front seat does then must come to its end.
pub(crate) const HAND_BACK_S: f64 = 1150.0;
/// Who had control for so long between the two has had its chance to steer.
pub(crate) const CHANCE_S: f64 = 200.0;
/// From here on the flight is over once nothing of ours is open; it is looked at every so often.
pub(crate) const LEAST_S: f64 = 1201.0;
pub(crate) const LOOK_EVERY: Duration = Duration::from_secs(5);
/// A mission that has not ended by now does not end.
pub(crate) const LONGEST_S: f64 = 5400.0;
/// So long after all plugins have trapped none of them steers: a step of each, and the longest that one may take.
pub(crate) const NONE_WITHIN: Duration = Duration::from_secs(4);
