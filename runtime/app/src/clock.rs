//! The project's only clocks. Every other crate is given the time.
#![expect(
    clippy::disallowed_methods,
    reason = "a driver reads clocks and passes the time to core"
)]

#[cfg_attr(
    not(feature = "simulation"),
    expect(dead_code, reason = "at sea time has one pace: only `fly` has another")
)]
mod pace;

use std::io;
use std::time::{Duration, SystemTime, UNIX_EPOCH};

use backseat_units::{Timestamp, Utc};
use rustix::time::{ClockId, clock_gettime};
use tokio::runtime::{Builder, Runtime};
use tokio::time::Instant;

use crate::clock::pace::Pace;

/// Runs on while the system is suspended, as the vehicle does. ([`std::time::Instant`] stops on Linux during
/// suspension: after an hour's sleep a lease would look as young as before it.)
#[cfg(any(target_os = "linux", target_os = "android"))]
const CLOCK: ClockId = ClockId::Boottime;
#[cfg(not(any(target_os = "linux", target_os = "android")))]
const CLOCK: ClockId = ClockId::Monotonic;

/// The time since the program's start: real time, or the time of a [`Pace`].
#[derive(Clone, Copy, Debug)]
pub(crate) struct Clock {
    /// As [`CLOCK`] or the pace counts it.
    start: Duration,
    utc_at_start: Utc,
    pace: Option<&'static Pace>,
}

fn read() -> Duration {
    // The clock is never negative, so the default is never used.
    Duration::try_from(clock_gettime(CLOCK)).unwrap_or_default()
}

fn utc() -> Utc {
    let nanos = SystemTime::now()
        .duration_since(UNIX_EPOCH)
        .map_or(0, |since| since.as_nanos());
    Utc::from_unix_nanos(u64::try_from(nanos).unwrap_or(0))
}

impl Clock {
    pub(crate) fn start() -> Self {
        Self {
            start: read(),
            utc_at_start: utc(),
            pace: None,
        }
    }

    /// A clock that goes up to `times` as fast as real time, from this UTC on. Everything that works by it must say so
    /// ([`Self::working`], [`Self::runtime`]) and wait by it ([`Self::sleep_until`]).
    #[cfg(feature = "simulation")]
    pub(crate) fn paced(times: f64, utc_at_start: Utc) -> Self {
        Self {
            start: Duration::ZERO,
            utc_at_start,
            // One for a program: it lives as long as the copies of this clock in all threads.
            pace: Some(Box::leak(Box::new(Pace::new(times, read)))),
        }
    }

    /// The same clock, from now on.
    #[cfg(feature = "simulation")]
    pub(crate) fn restarted(&self) -> Self {
        Self {
            start: self.read(),
            ..*self
        }
    }

    fn read(&self) -> Duration {
        self.pace.map_or_else(read, Pace::elapsed)
    }

    pub(crate) fn now(&self) -> Timestamp {
        Timestamp::ZERO + self.elapsed()
    }

    pub(crate) fn utc_at_start(&self) -> Utc {
        self.utc_at_start
    }

    /// How far the system's UTC has been set since the start, nanoseconds; positive where it was set forward. The UTC of
    /// a pace is its own, and nobody sets it.
    pub(crate) fn utc_set_nanos(&self) -> i64 {
        if self.pace.is_some() {
            return 0;
        }
        let kept = u128::from(self.utc_at_start.as_unix_nanos()) + self.elapsed().as_nanos();
        let nanos = i128::from(utc().as_unix_nanos()) - i128::try_from(kept).unwrap_or(0);
        i64::try_from(nanos).unwrap_or(0)
    }

    /// The `Instant` for a timestamp, at most a year from now.
    pub(crate) fn instant(&self, at: Timestamp) -> Instant {
        let latest = Duration::from_secs(86_400 * 365);
        let wait = Duration::from_nanos(at.as_nanos())
            .saturating_sub(self.elapsed())
            .min(latest);
        Instant::now() + self.pace.map_or(wait, |pace| pace.real(wait))
    }

    /// Sleeps until a timestamp.
    pub(crate) async fn sleep_until(&self, at: Timestamp) {
        let Some(pace) = self.pace else {
            return tokio::time::sleep_until(self.instant(at)).await;
        };
        let wake = self.start.saturating_add(Duration::from_nanos(at.as_nanos()));
        let _promise = Promise(pace, pace.promise(wake));
        while self.now() < at {
            tokio::time::sleep_until(self.instant(at)).await;
        }
    }

    /// Says that something computes beside the runtimes, until the value is dropped.
    pub(crate) fn working(&self) -> Working {
        if let Some(pace) = self.pace {
            pace.work();
        }
        Working(self.pace)
    }

    /// A runtime of one thread, to which this clock listens: it says when it works and when it waits.
    pub(crate) fn runtime(&self) -> io::Result<Runtime> {
        let mut builder = Builder::new_current_thread();
        if let Some(pace) = self.pace {
            builder.on_thread_park(|| pace.rest()).on_thread_unpark(|| pace.work());
        }
        builder.enable_all().build()
    }

    /// Runs a future in a runtime of [`Self::runtime`] to its end.
    pub(crate) fn block_on<T>(&self, runtime: &Runtime, future: impl Future<Output = T>) -> T {
        let _working = self.working();
        runtime.block_on(future)
    }

    pub(crate) fn elapsed(&self) -> Duration {
        self.read().saturating_sub(self.start)
    }
}

/// Something computes. Under a pace its time passes as in life.
#[derive(Debug)]
pub(crate) struct Working(Option<&'static Pace>);

impl Drop for Working {
    fn drop(&mut self) {
        if let Some(pace) = self.0 {
            pace.rest();
        }
    }
}

/// Somebody sleeps.
struct Promise(&'static Pace, u64);

impl Drop for Promise {
    fn drop(&mut self) {
        self.0.kept(self.1);
    }
}

/// Sleeps, so that output for people appears at a given pace.
pub(crate) fn pause(duration: Duration) {
    std::thread::sleep(duration);
}
