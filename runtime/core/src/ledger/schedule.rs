//! When inserts are flown, which zones that are valid for a limited time are compared with (safety requirement 002).
//!
//! The vehicle flies an insert when it comes to it. The judgement of an insert covers the time from the request to the
//! latest end that core can compute. A lease during a planned leg, or an insert that interrupts, can delay the insert
//! beyond that. If it has not begun by the time that it was judged for, core judges it for the new time, and cancels it
//! if it is no longer allowed.

use backseat_units::Timestamp;

/// The times that an insert was judged for.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
pub(crate) struct Schedule {
    pub(crate) begins_by: Timestamp,
    pub(crate) ends_by: Timestamp,
    pub(crate) lasts_s: f64,
}
