use std::fmt;
use std::ops::{Add, Sub};
use std::time::Duration;

/// A moment of the run: nanoseconds since its start.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) struct Moment(u64);

impl Moment {
    /// The start of the run.
    pub(crate) const ZERO: Self = Self(0);

    pub(crate) const fn from_nanos(nanos: u64) -> Self {
        Self(nanos)
    }

    pub(crate) const fn as_nanos(self) -> u64 {
        self.0
    }

    /// The time since an earlier moment; zero if that moment is not earlier.
    pub(crate) const fn since(self, earlier: Self) -> Duration {
        Duration::from_nanos(self.0.saturating_sub(earlier.0))
    }
}

/// A later moment, at most the last one that can be counted.
impl Add<Duration> for Moment {
    type Output = Self;

    fn add(self, later: Duration) -> Self {
        Self(self.0.saturating_add(nanos(later)))
    }
}

/// An earlier moment, at the earliest the start of the run.
impl Sub<Duration> for Moment {
    type Output = Self;

    fn sub(self, earlier: Duration) -> Self {
        Self(self.0.saturating_sub(nanos(earlier)))
    }
}

fn nanos(duration: Duration) -> u64 {
    u64::try_from(duration.as_nanos()).unwrap_or(u64::MAX)
}

impl fmt::Display for Moment {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{:.3} s", self.0 as f64 / 1e9)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arithmetic_stays_within_the_run() {
        let second = Moment::from_nanos(1_000_000_000);
        assert_eq!(second + Duration::from_millis(1), Moment::from_nanos(1_001_000_000));
        assert_eq!(second + Duration::MAX, Moment::from_nanos(u64::MAX));
        assert_eq!(second - Duration::from_secs(2), Moment::ZERO);
        assert_eq!(second.since(Moment::ZERO), Duration::from_secs(1));
        assert_eq!(Moment::ZERO.since(second), Duration::ZERO);
        assert_eq!((second + Duration::from_micros(1499)).to_string(), "1.001 s");
    }
}
