//! The times at which inserts are flown, for zones that are valid for a limited time (safety requirement 002).
//!
//! The vehicle flies an insert when it comes to it. The judgement of an insert covers the time from the request to the
//! latest end that core can compute. A lease during a planned leg, or an insert that interrupts, can delay the insert
//! beyond that. If it has not begun by the time that it was judged for, core computes its new end, and cancels it if a
//! zone opens or closes before that.

use backseat_units::Timestamp;

/// The times that an insert was judged for.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
pub(crate) struct Schedule {
    pub(crate) begins_by: Timestamp,
    pub(crate) ends_by: Timestamp,
    pub(crate) lasts_s: f64,
}
