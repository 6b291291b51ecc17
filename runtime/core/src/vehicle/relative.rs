//! Follows a hovering vehicle's relative navigation: BFRNV and BFCNV, each by itself (SPI 6.17, 6.19; safety
//! requirements 008 and 021).

use std::time::Duration;

use backseat_units::{TimeOfDay, Timestamp};

use crate::monitor::limits::Limits;
use crate::mutations::{Check, is_on};
use crate::plugin::{CartesianSample, RelativeSample};
use crate::vehicle::clock::elapsed_nanos;

/// After a jump, relative navigation must be steady for this long (safety requirement 021).
const STEADY_AFTER_JUMP: Duration = Duration::from_secs(10);
/// The first samples after a pause show only that samples come again. They may be old ones that were buffered for us.
const STEADY_AFTER_PAUSE: Duration = Duration::from_millis(500);
/// A BFRNV is invalid if its solution is later than the message that carries it, by more than this.
const AHEAD_MAX_NANOS: i64 = 100_000_000;

/// A sample of one kind.
pub(crate) trait Placed: Copy {
    /// When it was measured, on our clock.
    fn measured(&self) -> Timestamp;
    /// Its three coordinates, metres.
    fn place_m(&self) -> [f64; 3];
}

impl Placed for RelativeSample {
    fn measured(&self) -> Timestamp {
        self.measured
    }

    fn place_m(&self) -> [f64; 3] {
        [self.horizontal_m, self.vertical_m, self.distance_m]
    }
}

impl Placed for CartesianSample {
    fn measured(&self) -> Timestamp {
        self.measured
    }

    fn place_m(&self) -> [f64; 3] {
        [self.x_m, self.y_m, self.z_m]
    }
}

/// The newest sample of one kind, and whether it can be trusted.
#[derive(Debug)]
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub(crate) struct Track<S> {
    age_max: Duration,
    speed_max_mps: f64,
    /// `None` if only plugins use this navigation. Then nothing counts as a jump.
    jump_allowance_m: Option<f64>,
    newest: Option<(S, TimeOfDay)>,
    /// The last sample of an earlier connection.
    before: Option<S>,
    /// Since when samples have come without a pause.
    since: Option<Timestamp>,
    jumped_at: Option<Timestamp>,
}

impl<S: Placed> Track<S> {
    /// Makes a track without a sample. If it is watched, station keeping is judged by it.
    pub(crate) fn new(limits: &Limits, watched: bool) -> Self {
        let station = limits.station.as_ref();
        let station_mps = station.map_or(0.0, |station| station.speed_max_mps.max(station.speed_default_mps));
        Self {
            age_max: station.map_or(Duration::from_secs(1), |station| station.relative_age_max()),
            // The vehicle may be faster on its mission than on its moves.
            speed_max_mps: station_mps.max(limits.speed_max_mps) + limits.current_max_mps,
            jump_allowance_m: station.filter(|_| watched).map(|station| station.jump_allowance_m),
            newest: None,
            before: None,
            since: None,
            jumped_at: None,
        }
    }

    /// A new connection. The vehicle has not moved because of it, so the last sample is kept to find a jump.
    pub(crate) fn reset(&mut self) {
        self.before = self.newest.take().map(|(sample, _)| sample).or(self.before);
        self.since = None;
    }

    /// Whether the solution of a message is newer than the newest one, and its time is possible.
    pub(crate) fn advances(&self, created: TimeOfDay, solution: TimeOfDay) -> bool {
        elapsed_nanos(created, solution) <= AHEAD_MAX_NANOS
            && self.newest.is_none_or(|(_, last)| elapsed_nanos(last, solution) > 0)
    }

    /// Takes a sample for which `advances` is true. Returns by how many metres it has jumped, if it has.
    pub(crate) fn take(&mut self, now: Timestamp, sample: S, solution: TimeOfDay) -> Option<f64> {
        if self.fresh(now).is_none() {
            self.since = Some(now);
        }
        let last = self.newest.map(|(sample, _)| sample).or(self.before.take());
        self.newest = Some((sample, solution));
        let (last, allowance_m) = (last?, self.jump_allowance_m?);
        let elapsed_s = sample.measured().since(last.measured()).as_secs_f64();
        let metres = distance_m(sample.place_m(), last.place_m());
        let follows = metres <= self.speed_max_mps * 1.5 * elapsed_s + allowance_m;
        if follows || !is_on(Check::RelativeJump) {
            return None;
        }
        self.jumped_at = Some(now);
        Some(metres)
    }

    /// The vehicle is told where it is. What it reports from now on is in another frame, however near it looks, and
    /// must be steady again.
    pub(crate) fn unsettle(&mut self, now: Timestamp) {
        self.jumped_at = Some(now);
    }

    /// The newest sample while it is fresh.
    pub(crate) fn fresh(&self, now: Timestamp) -> Option<S> {
        let (sample, _) = self.newest?;
        (now.since(sample.measured()) <= self.age_max || !is_on(Check::RelativeFresh)).then_some(sample)
    }

    /// The same sample, if it has been steady for long enough to rely on it.
    pub(crate) fn steady(&self, now: Timestamp) -> Option<S> {
        let steady = self.since.is_some_and(|since| now.since(since) >= STEADY_AFTER_PAUSE)
            && self
                .jumped_at
                .is_none_or(|jumped| now.since(jumped) >= STEADY_AFTER_JUMP);
        self.fresh(now).filter(|_| steady)
    }

    /// When the newest sample becomes stale.
    pub(crate) fn stale_at(&self) -> Option<Timestamp> {
        let (sample, _) = self.newest?;
        Some(sample.measured() + self.age_max + Duration::from_nanos(1))
    }
}

fn distance_m(a: [f64; 3], b: [f64; 3]) -> f64 {
    let squares: f64 = a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum();
    squares.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample(millis: u64, x_m: f64) -> CartesianSample {
        CartesianSample {
            measured: Timestamp::from_millis(millis),
            x_m,
            y_m: 0.0,
            z_m: 0.0,
            heading_deg: 0.0,
        }
    }

    fn at(millis: u64) -> TimeOfDay {
        TimeOfDay::MIDNIGHT + Duration::from_millis(millis)
    }

    fn track() -> Track<CartesianSample> {
        Track {
            age_max: Duration::from_secs(1),
            speed_max_mps: 1.0,
            jump_allowance_m: Some(2.0),
            newest: None,
            before: None,
            since: None,
            jumped_at: None,
        }
    }

    #[test]
    fn an_unchanged_solution_ages_and_one_later_than_its_message_is_invalid() {
        let mut track = track();
        track.take(Timestamp::ZERO, sample(0, 0.0), at(0));
        assert!(!track.advances(at(500), at(0)));
        assert!(track.advances(at(500), at(500)));
        assert!(!track.advances(at(500), at(5000)));
        assert!(track.fresh(Timestamp::from_millis(1000)).is_some());
        assert!(track.fresh(Timestamp::from_millis(1001)).is_none());
    }

    #[test]
    fn it_is_steady_half_a_second_after_a_pause_and_ten_after_a_jump() {
        let mut track = track();
        let mut steady = Vec::new();
        for millis in (0..15_000).step_by(100) {
            let now = Timestamp::from_millis(millis);
            // 2 m and a way of 0.15 m are allowed from one sample to the next.
            let x_m = if millis < 2000 { 0.0 } else { 2.2 };
            let jumped = track.take(now, sample(millis, x_m), at(millis));
            assert_eq!(jumped.is_some(), millis == 2000);
            if track.steady(now).is_some() {
                steady.push(millis);
            }
        }
        let expected: Vec<u64> = (500..2000).chain(12_000..15_000).step_by(100).collect();
        assert_eq!(steady, expected);
    }

    #[test]
    fn after_a_reset_it_must_be_steady_again_however_near_it_looks() {
        let mut track = track();
        for millis in (0..=1000).step_by(100) {
            track.take(Timestamp::from_millis(millis), sample(millis, 0.0), at(millis));
        }
        let now = Timestamp::from_secs(1);
        assert!(track.steady(now).is_some());
        track.unsettle(now);
        assert!(track.steady(now).is_none() && track.fresh(now).is_some());
    }

    #[test]
    fn nan_counts_as_a_jump() {
        let mut track = track();
        track.take(Timestamp::ZERO, sample(0, 0.0), at(0));
        assert!(
            track
                .take(Timestamp::from_millis(100), sample(100, f64::NAN), at(100))
                .is_some()
        );
    }

    #[test]
    fn a_jump_across_a_new_connection_is_found() {
        let mut track = track();
        track.take(Timestamp::ZERO, sample(0, 0.0), at(0));
        track.reset();
        assert!(track.fresh(Timestamp::ZERO).is_none());
        let now = Timestamp::from_secs(2);
        assert!(track.take(now, sample(2000, 20.0), at(2000)).is_some());
    }
}
