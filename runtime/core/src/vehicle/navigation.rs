use std::time::Duration;

use backseat_spi::{Navigation, PositionQuality, VelocityAndRates};
use backseat_units::{EastNorth, LocalFrame, TimeOfDay, Timestamp, Utc, utm_convergence_deg};

use crate::ended::EndCause;
use crate::monitor::envelope::{APART_MAX, BottomLock, bottom_lock};
use crate::monitor::limits::Limits;
use crate::mutations::{Check, is_on};
use crate::plugin::NavigationSample;
use crate::vehicle::clock::{Trip, VehicleClock, elapsed_nanos};
use crate::vehicle::integrity::{Flaw, Integrity};

/// After a jump, navigation must be steady for this long (safety requirement 021).
const STEADY_AFTER_JUMP: Duration = Duration::from_secs(10);
/// On a new connection, the first samples may be old ones that were buffered for us.
const STEADY_AFTER_CONNECT: Duration = Duration::from_millis(500);
/// A jump is farther than the vehicle can move, plus this.
const JUMP_ALLOWANCE_M: f64 = 10.0;
/// A BFNVG and a BFNVR belong to one sample if they were written no further apart than this.
const OF_ONE_TIME_NANOS: u64 = 500_000_000;
/// A bottom lock shows the water depth at its place for this long.
const LOCK_LASTS: Duration = Duration::from_secs(5);

/// How a new solution relates to the one before it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Change {
    /// The vehicle can have come here from the last one.
    Follows,
    /// It is farther from the last one than the vehicle can have come.
    Jumped(Jump),
}

/// A jump of navigation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Jump {
    pub(crate) metres: f64,
    /// Where the vehicle was before.
    pub(crate) from: EastNorth,
    /// How long ago that was, seconds.
    pub(crate) elapsed_s: f64,
}

/// Follows the vehicle's navigation: pairs BFNVG with its BFNVR, computes its age, and finds its jumps.
#[derive(Debug)]
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub(crate) struct Tracker {
    #[cfg_attr(feature = "explore", serde(skip))]
    frame: LocalFrame,
    age_max: Duration,
    speed_max_mps: f64,
    clock: VehicleClock,
    newest: Option<Newest>,
    integrity: Integrity,
    /// The newest flaw of navigation, until `take_flaw` takes it.
    flaw: Option<Flaw>,
    /// The time of the last solution whose velocities came.
    completed: Option<TimeOfDay>,
    /// When the first sample came whose velocities are still missing. This is by our own clock, so it stays if the
    /// vehicle's is set.
    incomplete_since: Option<Timestamp>,
    lock: Option<(BottomLock, Timestamp)>,
    /// Since when navigation has been steady; `None` before the first sample of this connection, and after stale
    /// navigation.
    steady_since: Option<Timestamp>,
    /// Where the vehicle was by the last sample of the earlier connection, or of its clock before that was set, and
    /// when that sample came.
    before: Option<(EastNorth, Timestamp)>,
    jumped_at: Option<Timestamp>,
}

#[derive(Clone, Copy, Debug)]
#[cfg_attr(feature = "explore", derive(serde::Serialize))]
struct Newest {
    sample: NavigationSample,
    /// When it came.
    received: Timestamp,
    /// Whether the vehicle's clock was known then, and with it the time of the solution.
    has_age: bool,
    /// Whether its velocities have come.
    complete: bool,
    written: TimeOfDay,
    solution: TimeOfDay,
}

impl Tracker {
    pub(crate) fn new(frame: LocalFrame, limits: &Limits) -> Self {
        Self {
            frame,
            age_max: limits.navigation_age_max(),
            speed_max_mps: limits.speed_max_mps.max(3.0) + limits.current_max_mps,
            clock: VehicleClock::default(),
            newest: None,
            integrity: Integrity::new(limits),
            flaw: None,
            completed: None,
            incomplete_since: None,
            lock: None,
            steady_since: None,
            before: None,
            jumped_at: None,
        }
    }

    /// A new connection. No navigation of the old one counts any more, but the vehicle has not moved because of it, and
    /// its clock is the same. If core learnt the clock anew, a link that delays everything from its first byte would
    /// look like a clock that is slow.
    pub(crate) fn reset(&mut self) {
        self.leave_newest();
        self.incomplete_since = None;
        self.lock = None;
        self.steady_since = None;
    }

    /// The next sample is the first again, except that it is compared with the last place.
    fn leave_newest(&mut self) {
        self.forget_window();
        let last = self.newest.take();
        // The place is kept with the time when it came: the time of its solution depends on the vehicle's clock, which
        // may have been set.
        self.before = last.map(|last| (last.sample.local, last.received)).or(self.before);
    }

    /// The timestamp of any message may name a leap second.
    pub(crate) fn heard(&mut self, now: Timestamp, utc: Utc, written: TimeOfDay) {
        self.clock.heard(now, utc, written);
    }

    /// A round trip has measured the clocks. Returns by how much the vehicle's clock was set against ours, nanoseconds,
    /// if it was. Then navigation must become steady again (safety requirement 023).
    pub(crate) fn measured(&mut self, trip: Trip, utc: Utc, written: TimeOfDay) -> Option<i64> {
        let step = self.clock.measure(trip, utc, written)?;
        if !is_on(Check::ClockStep) {
            return None;
        }
        self.jumped_at = Some(trip.received);
        // The time of the newest solution is by the old clock. By the new one it may be in the future.
        self.leave_newest();
        Some(step)
    }

    /// By how much our clock and the vehicle's differ. `None` if the vehicle's is not known, or if they differ by more
    /// than [`APART_MAX`]. Ours may have been set since the start, by `set_nanos` nanoseconds.
    pub(crate) fn clocks_apart(&self, now: Timestamp, set_nanos: i64) -> Option<Duration> {
        self.clock.apart(now, set_nanos).filter(|apart| *apart <= APART_MAX)
    }

    pub(crate) fn clock(&self) -> &VehicleClock {
        &self.clock
    }

    /// Takes a BFNVG. Until its BFNVR comes, its velocities are those of the last sample. Returns `None` if its
    /// solution is not newer than the last one's.
    pub(crate) fn position(&mut self, now: Timestamp, utc: Utc, message: &Navigation) -> Option<Change> {
        self.clock.heard(now, utc, message.created);
        let age = if is_on(Check::NavigationAge) {
            self.clock.age(now, utc, message.solution)
        } else {
            Some(Duration::ZERO)
        };
        let solution = now - age.unwrap_or_default();
        let local = self.frame.to_local(message.position);
        let mut jump = None;
        let mut velocity = (0.0, 0.0, 0.0, 0.0);
        if let Some(last) = &self.newest {
            let elapsed_nanos = elapsed_nanos(last.solution, message.solution);
            if elapsed_nanos <= 0 {
                return None;
            }
            // The time by our own clock counts too, if it is shorter: the fix that moved the vehicle's position may
            // also have set its clock (SPI 2).
            let elapsed_s = solution.since(last.sample.solution).as_secs_f64();
            jump = self.jump(last.sample.local, elapsed_s.min(elapsed_nanos as f64 / 1e9), local);
            let sample = &last.sample;
            velocity = (sample.east_mps, sample.north_mps, sample.down_mps, sample.yaw_rate_dps);
        }
        if let Some((place, at)) = self.before.take() {
            jump = self.jump(place, now.since(at).as_secs_f64(), local).or(jump);
        }
        if jump.is_some() {
            self.jumped_at = Some(now);
            self.forget_window();
        }
        let without = now.since(*self.incomplete_since.get_or_insert(now));
        if without > self.integrity.velocity_gap_max() && is_on(Check::VelocityPresent) {
            let text = format!("none for {:.1} s", without.as_secs_f64());
            self.flaw = Some(Flaw {
                what: EndCause::VelocitiesMissing,
                text,
            });
            self.jumped_at = Some(now);
        }
        if self.steady_since.is_none() {
            self.steady_since = Some(now);
        }
        let sample = NavigationSample {
            solution,
            position: message.position,
            local,
            depth: message.depth,
            altitude: message.altitude,
            heading: message.heading.to_true(utm_convergence_deg(message.position)),
            roll_deg: message.roll_deg,
            pitch_deg: message.pitch_deg,
            east_mps: velocity.0,
            north_mps: velocity.1,
            down_mps: velocity.2,
            yaw_rate_dps: velocity.3,
            gps: message.quality == PositionQuality::Gps,
        };
        if let Some(lock) = bottom_lock(&sample) {
            self.lock = Some((lock, now));
        }
        self.newest = Some(Newest {
            sample,
            received: now,
            has_age: age.is_some(),
            complete: false,
            written: message.created,
            solution: message.solution,
        });
        Some(jump.map_or(Change::Follows, Change::Jumped))
    }

    /// Takes a BFNVR. If it was written more than half a second before or after the newest BFNVG, it says nothing about
    /// that sample. Returns true if both have the same time.
    /// A second one for the same sample changes its velocities, so the limits of speed apply to each.
    pub(crate) fn velocity(&mut self, now: Timestamp, message: &VelocityAndRates) -> bool {
        let Some(newest) = &mut self.newest else { return false };
        let apart = message.created.nanos_since(newest.written).unsigned_abs();
        if apart > OF_ONE_TIME_NANOS && is_on(Check::VelocityPresent) {
            return false;
        }
        newest.sample.east_mps = message.east_mps;
        newest.sample.north_mps = message.north_mps;
        newest.sample.down_mps = message.down_mps;
        newest.sample.yaw_rate_dps = message.yaw_rate_dps;
        let flaw = if core::mem::replace(&mut newest.complete, true) {
            self.integrity.too_fast(message)
        } else {
            let (solution, sample) = (newest.solution, newest.sample);
            self.complete(solution, &sample, message)
        };
        if flaw.is_some() && is_on(Check::NavigationTrue) {
            self.flaw = flaw;
            self.jumped_at = Some(now);
        }
        apart == 0
    }

    /// Compares a sample that has its velocities with those before it.
    fn complete(&mut self, solution: TimeOfDay, sample: &NavigationSample, message: &VelocityAndRates) -> Option<Flaw> {
        self.incomplete_since = None;
        let before = self.completed.replace(solution);
        let elapsed_s = before.map_or(0.0, |before| elapsed_nanos(before, solution) as f64 / 1e9);
        self.integrity.follow(sample, message, elapsed_s)
    }

    /// The flaw that navigation has shown since this was last called, if any (safety requirement 024).
    pub(crate) fn take_flaw(&mut self) -> Option<Flaw> {
        self.flaw.take()
    }

    fn forget_window(&mut self) {
        self.integrity.forget();
        self.completed = None;
    }

    /// When the newest sample was written, by the vehicle's clock.
    pub(crate) fn written(&self) -> Option<TimeOfDay> {
        self.newest.as_ref().map(|newest| newest.written)
    }

    /// The newest sample, however old.
    pub(crate) fn newest(&self) -> Option<&NavigationSample> {
        self.newest.as_ref().map(|newest| &newest.sample)
    }

    /// The newest sample while it is fresh (safety requirement 008): its age is known, and not over the mission's limit.
    pub(crate) fn fresh(&self, now: Timestamp) -> Option<&NavigationSample> {
        let newest = self.newest.as_ref()?;
        let fresh = newest.has_age && now.since(newest.sample.solution) <= self.age_max;
        (fresh || !is_on(Check::NavigationFresh)).then_some(&newest.sample)
    }

    /// Navigation is stale. What comes next must be steady again before it counts. Otherwise control would come and go
    /// with every sample of a navigation whose age is just at the limit.
    pub(crate) fn unsettle(&mut self) {
        self.steady_since = None;
    }

    /// The vehicle is told where it is, or what its frame is. What it reports from now on is in another frame (safety
    /// requirement 021).
    pub(crate) fn frame_reset(&mut self, now: Timestamp) {
        self.forget_window();
        self.jumped_at = Some(now);
    }

    /// When the newest sample becomes stale.
    pub(crate) fn stale_at(&self) -> Option<Timestamp> {
        self.newest()
            .map(|sample| sample.solution + self.age_max + Duration::from_nanos(1))
    }

    /// Whether navigation has been steady for long enough since the connection or its last jump.
    pub(crate) fn steady(&self, now: Timestamp) -> bool {
        self.steady_since
            .is_some_and(|since| now.since(since) >= STEADY_AFTER_CONNECT)
            && self
                .jumped_at
                .is_none_or(|jumped| now.since(jumped) >= STEADY_AFTER_JUMP)
    }

    /// The jump from one place to another, if the vehicle cannot have come so far in that time.
    fn jump(&self, from: EastNorth, elapsed_s: f64, here: EastNorth) -> Option<Jump> {
        let metres = here.distance_m(from);
        let farthest_m = self.speed_max_mps * 1.5 * elapsed_s + JUMP_ALLOWANCE_M;
        (metres > farthest_m && is_on(Check::Jump)).then_some(Jump {
            metres,
            from,
            elapsed_s,
        })
    }

    /// The last bottom lock, while it counts.
    pub(crate) fn bottom_lock(&self, now: Timestamp) -> Option<BottomLock> {
        let (lock, at) = self.lock?;
        (now.since(at) <= LOCK_LASTS).then_some(lock)
    }
}
