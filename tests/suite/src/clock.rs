//! The only clock of the suite.
#![expect(
    clippy::disallowed_methods,
    reason = "the program runs in real time, and so must its observer"
)]

use std::thread::sleep;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};

const LOOK_EVERY: Duration = Duration::from_millis(40);

/// Waits until `look` finds something, and returns it.
///
/// # Panics
///
/// If it has found nothing within the time. The message comes from `failed`, which is called then.
pub fn eventually<T>(within: Duration, mut look: impl FnMut() -> Option<T>, failed: impl FnOnce() -> String) -> T {
    let start = Instant::now();
    loop {
        if let Some(found) = look() {
            return found;
        }
        assert!(start.elapsed() < within, "not within {within:?}: {}", failed());
        sleep(LOOK_EVERY);
    }
}

/// The system's UTC, milliseconds since 1970.
pub(crate) fn utc_millis() -> u64 {
    let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap_or_default();
    u64::try_from(since.as_millis()).unwrap_or(0)
}

/// Waits for a time in which something must not happen.
pub fn settle(duration: Duration) {
    sleep(duration);
}

/// A stopwatch in real time.
#[derive(Clone, Copy, Debug)]
pub struct Stopwatch(Instant);

impl Stopwatch {
    /// Starts a stopwatch.
    #[must_use]
    pub fn start() -> Self {
        Self(Instant::now())
    }

    /// The time since the start.
    #[must_use]
    pub fn elapsed(&self) -> Duration {
        self.0.elapsed()
    }
}
