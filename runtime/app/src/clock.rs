//! The project's only clocks. Every other crate is given the time.
#![expect(
    clippy::disallowed_methods,
    reason = "a driver reads clocks and passes the time to core"
)]

use std::time::{Duration, SystemTime, UNIX_EPOCH};

use backseat_units::{Timestamp, Utc};
use rustix::time::{ClockId, clock_gettime};
use tokio::time::Instant;

/// Runs on while the system is suspended, as the vehicle does. ([`std::time::Instant`] stops on Linux during
/// suspension: after an hour's sleep a lease would look as young as before it.)
#[cfg(any(target_os = "linux", target_os = "android"))]
const CLOCK: ClockId = ClockId::Boottime;
#[cfg(not(any(target_os = "linux", target_os = "android")))]
const CLOCK: ClockId = ClockId::Monotonic;

/// Real time since the program's start.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Clock {
    /// As [`CLOCK`] counts it.
    start: Duration,
    utc_at_start: Utc,
}

fn read() -> Duration {
    // The clock is never negative, so the default is never used.
    Duration::try_from(clock_gettime(CLOCK)).unwrap_or_default()
}

impl Clock {
    pub(crate) fn start() -> Self {
        let nanos = SystemTime::now()
            .duration_since(UNIX_EPOCH)
            .map_or(0, |since| since.as_nanos());
        let utc_at_start = Utc::from_unix_nanos(u64::try_from(nanos).unwrap_or(0));
        Self {
            start: read(),
            utc_at_start,
        }
    }

    pub(crate) fn now(&self) -> Timestamp {
        Timestamp::ZERO + self.elapsed()
    }

    pub(crate) fn utc_at_start(&self) -> Utc {
        self.utc_at_start
    }

    /// How far the system's UTC has been set since the start, nanoseconds; positive where it was set forward.
    pub(crate) fn utc_set_nanos(&self) -> i64 {
        let nanos = SystemTime::now()
            .duration_since(UNIX_EPOCH)
            .map_or(0, |since| since.as_nanos());
        let kept = u128::from(self.utc_at_start.as_unix_nanos()) + self.elapsed().as_nanos();
        let nanos = i128::try_from(nanos).unwrap_or(0) - i128::try_from(kept).unwrap_or(0);
        i64::try_from(nanos).unwrap_or(0)
    }

    /// The `Instant` for a timestamp, at most a year from now.
    pub(crate) fn instant(&self, at: Timestamp) -> Instant {
        let latest = Duration::from_secs(86_400 * 365);
        Instant::now()
            + Duration::from_nanos(at.as_nanos())
                .saturating_sub(self.elapsed())
                .min(latest)
    }

    pub(crate) fn elapsed(&self) -> Duration {
        read().saturating_sub(self.start)
    }
}

/// Sleeps, so that output for people appears at a given pace.
pub(crate) fn pause(duration: Duration) {
    std::thread::sleep(duration);
}
