//! A pace other than life's, for `fly`: the time in which everybody waits is shortened, and the time in which somebody
//! computes is not.
//!
//! All parts of one program share one [`Pace`]. While every part waits, its time passes faster than real time. While a
//! part computes (an event loop that is awake, a plugin in its step), or while a loop should have been woken and has not
//! been yet, it passes as in life. So whatever is in time at life's speed is in time at every speed, and on a machine
//! that is too slow for a speed the mission takes longer and nothing else changes. What was lost to computing is made up
//! for by faster waits, within bounds.

use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

/// A wait is faster than the pace by this at most, to make up for what was lost.
const FASTER: f64 = 8.0;
/// What was lost longer ago than this is not made up for, real time.
const MADE_UP_WITHIN: Duration = Duration::from_millis(500);

/// A shared time, which starts at zero.
#[derive(Debug)]
pub(crate) struct Pace {
    times: f64,
    read: fn() -> Duration,
    state: Mutex<State>,
}

#[derive(Debug)]
struct State {
    /// The real time until which `time` is counted.
    real: Duration,
    time: Duration,
    /// How far `time` is behind the pace.
    behind: Duration,
    /// How many parts compute.
    working: usize,
    /// When the waiting parts are to be woken, each with its number.
    promises: Vec<(u64, Duration)>,
    last: u64,
}

impl Pace {
    /// A time that passes up to `times` as fast as the real time that `read` returns.
    pub(crate) fn new(times: f64, read: fn() -> Duration) -> Self {
        Self {
            times,
            read,
            state: Mutex::new(State {
                real: read(),
                time: Duration::ZERO,
                behind: Duration::ZERO,
                working: 0,
                promises: Vec::new(),
                last: 0,
            }),
        }
    }

    pub(crate) fn elapsed(&self) -> Duration {
        self.counted().time
    }

    /// The real time that a wait takes in which nobody computes.
    pub(crate) fn real(&self, wait: Duration) -> Duration {
        let behind = self.counted().behind;
        self.waited(wait, behind)
    }

    /// The real time of a wait that begins so far behind the pace: what was lost is made up for first.
    fn waited(&self, wait: Duration, behind: Duration) -> Duration {
        let hurried = behind.mul_f64(FASTER / (FASTER - 1.0));
        match wait.checked_sub(hurried) {
            Some(rest) => hurried.div_f64(FASTER * self.times) + rest.div_f64(self.times),
            None => wait.div_f64(FASTER * self.times),
        }
    }

    /// The wait that takes this real time.
    fn wait(&self, real: Duration, behind: Duration) -> Duration {
        let hurried = behind.div_f64((FASTER - 1.0) * self.times);
        match real.checked_sub(hurried) {
            Some(rest) => hurried.mul_f64(FASTER * self.times) + rest.mul_f64(self.times),
            None => real.mul_f64(FASTER * self.times),
        }
    }

    /// A part begins to compute.
    pub(crate) fn work(&self) {
        self.counted().working += 1;
    }

    /// A part waits again.
    pub(crate) fn rest(&self) {
        let mut state = self.counted();
        state.working = state.working.saturating_sub(1);
    }

    /// A part is to be woken at this time. Returns the number of the promise.
    pub(crate) fn promise(&self, at: Duration) -> u64 {
        let mut state = self.counted();
        state.last += 1;
        let number = state.last;
        state.promises.push((number, at));
        number
    }

    /// The part is awake, or waits for something else.
    pub(crate) fn kept(&self, number: u64) {
        self.counted().promises.retain(|(other, _)| *other != number);
    }

    /// The state with the time counted until now. Every change of the state begins with it.
    fn counted(&self) -> MutexGuard<'_, State> {
        // The state is whole after each line that changes it.
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        let now = (self.read)().max(state.real);
        let passed = now - state.real;
        state.real = now;
        let counted = if state.working > 0 || self.times <= 1.0 {
            passed.mul_f64(self.times.min(1.0))
        } else {
            let next = state.promises.iter().map(|(_, at)| *at).min();
            let next = next.map(|next| next.saturating_sub(state.time));
            let late = next.and_then(|next| Some((next, passed.checked_sub(self.waited(next, state.behind))?)));
            match late {
                Some((next, late)) => next + late,
                None => self.wait(passed, state.behind),
            }
        };
        state.time += counted;
        let behind = (state.behind + passed.mul_f64(self.times)).saturating_sub(counted);
        state.behind = behind.min(MADE_UP_WITHIN.mul_f64(self.times));
        state
    }
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::*;

    thread_local! {
        static REAL_MS: Cell<u64> = const { Cell::new(0) };
    }

    fn real() -> Duration {
        Duration::from_millis(REAL_MS.get())
    }

    fn pass(ms: u64) {
        REAL_MS.set(REAL_MS.get() + ms);
    }

    fn near(pace: &Pace, ms: u64) -> bool {
        pace.elapsed().abs_diff(Duration::from_millis(ms)) < Duration::from_micros(10)
    }

    #[test]
    fn waiting_is_short_and_computing_takes_as_long_as_in_life() {
        let pace = Pace::new(20.0, real);
        pass(50);
        assert!(near(&pace, 1000), "all wait: {:?}", pace.elapsed());
        pace.work();
        pass(30);
        assert!(near(&pace, 1030), "somebody computes: {:?}", pace.elapsed());
        pace.work();
        pass(30);
        pace.rest();
        pass(40);
        assert!(near(&pace, 1100), "one of two still does: {:?}", pace.elapsed());
        pace.rest();
        pass(10);
        assert!(
            near(&pace, 1100 + 10 * 160),
            "all wait again, and hurry: {:?}",
            pace.elapsed()
        );
        pass(90);
        assert!(near(&pace, 20 * 250), "all is made up for: {:?}", pace.elapsed());
        assert_eq!(pace.real(Duration::from_secs(20)), Duration::from_secs(1));
    }

    #[test]
    fn who_is_woken_late_is_not_later_than_in_life() {
        let pace = Pace::new(20.0, real);
        let first = pace.promise(Duration::from_millis(100));
        let second = pace.promise(Duration::from_millis(10_000));
        pass(5);
        assert!(near(&pace, 100), "in time: {:?}", pace.elapsed());
        pass(7);
        assert!(near(&pace, 107), "7 ms late, as in life: {:?}", pace.elapsed());
        pace.kept(first);
        pass(1);
        assert!(
            near(&pace, 20 * 13),
            "on to the next, in a hurry, and no longer late: {:?}",
            pace.elapsed()
        );
        pass(1000);
        let late = pace.elapsed().saturating_sub(Duration::from_secs(10));
        assert!(late < Duration::from_secs(1), "{late:?}");
        pace.kept(second);
    }

    #[test]
    fn what_was_lost_long_ago_is_not_made_up_for() {
        let pace = Pace::new(20.0, real);
        pace.work();
        pass(60_000);
        pace.rest();
        pace.elapsed();
        let before = pace.elapsed();
        pass(10_000);
        let made_up = pace.elapsed() - before - Duration::from_secs(200);
        assert!(made_up < Duration::from_secs(11), "{made_up:?}");
    }

    #[test]
    fn slower_than_life_everything_is_slow() {
        let pace = Pace::new(0.5, real);
        pace.work();
        pass(100);
        pace.rest();
        pass(100);
        assert!(near(&pace, 100), "{:?}", pace.elapsed());
    }
}
