//! When things are flown: what the zones that are valid for a time are judged by (safety requirement 002).
//!
//! An insert flies when the vehicle comes to it. Its judgement covers the time from the asking to the latest end that
//! can be told. What delays it beyond that, a lease under which the planned leg grows longer, an insert that interrupts,
//! is met here: one that has not begun by then is judged by the new time, and called back where that does not hold.

use backseat_units::Timestamp;

/// By when an insert was judged to be flown.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
pub(crate) struct Schedule {
    pub(crate) begins_by: Timestamp,
    pub(crate) ends_by: Timestamp,
    pub(crate) lasts_s: f64,
}
