use core::time::Duration;
use std::collections::VecDeque;

use backseat_units::Timestamp;

/// Converts a list of seconds after the start to timestamps.
pub(super) fn times(seconds: &[f64]) -> VecDeque<Timestamp> {
    seconds
        .iter()
        .map(|s| Timestamp::ZERO + Duration::from_secs_f64(*s))
        .collect()
}
