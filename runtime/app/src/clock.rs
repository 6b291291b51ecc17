//! The only clocks of the project: the program's.
#![expect(clippy::disallowed_methods, reason = "a driver reads clocks and hands the time in")]

use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

use backseat_units::{Timestamp, Utc};

/// Real time since the program's start.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Clock {
    start: Instant,
    utc_at_start: Utc,
}

impl Clock {
    pub(crate) fn start() -> Self {
        let nanos = SystemTime::now()
            .duration_since(UNIX_EPOCH)
            .map_or(0, |since| since.as_nanos());
        let utc_at_start = Utc::from_unix_nanos(u64::try_from(nanos).unwrap_or(0));
        Self {
            start: Instant::now(),
            utc_at_start,
        }
    }

    pub(crate) fn now(&self) -> Timestamp {
        Timestamp::ZERO + self.start.elapsed()
    }

    pub(crate) fn utc_at_start(&self) -> Utc {
        self.utc_at_start
    }

    /// The instant of a time.
    pub(crate) fn instant(&self, at: Timestamp) -> tokio::time::Instant {
        let latest = Duration::from_secs(86_400 * 365);
        (self.start + Duration::from_nanos(at.as_nanos()).min(latest)).into()
    }

    pub(crate) fn elapsed(&self) -> Duration {
        self.start.elapsed()
    }
}

/// Waits, for what is shown to people at a given pace.
pub(crate) fn pause(duration: Duration) {
    std::thread::sleep(duration);
}
