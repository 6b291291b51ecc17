use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::item::PACE_MAX;

/// How fast a simulation goes, which people at the console can change. A clone is another handle to the same pace.
#[derive(Clone, Debug)]
pub struct Pace(Arc<AtomicU64>);

impl Pace {
    /// Begins with a multiple of real time; `None` is as fast as can be.
    #[must_use]
    pub fn new(times: Option<f64>) -> Self {
        let times = times.map_or(PACE_MAX, |times| times.min(PACE_MAX));
        Self(Arc::new(AtomicU64::new(times.to_bits())))
    }

    /// The multiple of real time now: 0 stands, and [`f64::INFINITY`] is as fast as can be.
    #[must_use]
    pub fn times(&self) -> f64 {
        let times = self.told();
        if times >= PACE_MAX { f64::INFINITY } else { times }
    }

    /// The same for the page, which calls 10,000 as fast as can be.
    pub(crate) fn told(&self) -> f64 {
        f64::from_bits(self.0.load(Ordering::Relaxed))
    }

    /// Changes it, unless it is less than 0 or no number.
    pub(crate) fn set(&self, times: f64) -> bool {
        let valid = times >= 0.0;
        if valid {
            self.0.store(times.min(PACE_MAX).to_bits(), Ordering::Relaxed);
        }
        valid
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pace_is_a_number_from_0_to_as_fast_as_can_be() {
        let pace = Pace::new(Some(20.0));
        assert_eq!((pace.times(), Pace::new(None).times()), (20.0, f64::INFINITY));
        assert!(!pace.set(-1.0) && !pace.set(f64::NAN));
        assert_eq!(pace.times(), 20.0);
        assert!(pace.set(0.0));
        assert_eq!(pace.times(), 0.0);
        assert!(pace.set(1e9));
        assert_eq!((pace.times(), pace.told()), (f64::INFINITY, PACE_MAX));
    }
}
