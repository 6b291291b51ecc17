//! The phases of a hunted mission, in seconds.

use std::time::Duration;

/// Faults begin from here on, when the session is established.
pub(crate) const FIRST_S: f64 = 30.0;
/// No fault begins after this.
pub(crate) const SAFETY_S: f64 = 800.0;
/// The last fault has ended, and the liveness phase begins.
pub(crate) const CALM_S: f64 = 900.0;
/// The time from then until the link must be up again: the longest back-off with its random part, and a refused
/// attempt.
pub(crate) const LINK_WITHIN: Duration = Duration::from_secs(90);
/// The operator holds for good, and the current behavior of the front seat must come to its end.
pub(crate) const HAND_BACK_S: f64 = 1150.0;
/// A runtime that had control for this long between the two had enough time to steer.
pub(crate) const CHANCE_S: f64 = 200.0;
/// From here on the flight ends when none of our requests is open, which is checked at this interval.
pub(crate) const LEAST_S: f64 = 1201.0;
pub(crate) const LOOK_EVERY: Duration = Duration::from_secs(5);
/// A mission that has not ended by now will not end.
pub(crate) const LONGEST_S: f64 = 5400.0;
/// The time after which no plugin steers once all have trapped: one step of each, with the longest time that it may
/// take.
pub(crate) const NONE_WITHIN: Duration = Duration::from_secs(4);
