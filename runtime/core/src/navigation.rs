use std::time::Duration;

use backseat_spi::{Navigation, PositionQuality, VelocityAndRates};
use backseat_units::{EastNorth, LocalFrame, TimeOfDay, Timestamp, Utc, utm_convergence_deg};

use crate::clock::{VehicleClock, elapsed_nanos};
use crate::envelope::{APART_MAX, BottomLock, bottom_lock};
use crate::limits::Limits;
use crate::plugin::NavigationSample;
use crate::switches::{Check, is_on};

/// After a jump, navigation must be steady for this long (safety requirement 021).
const STEADY_AFTER_JUMP: Duration = Duration::from_secs(10);
/// On a new connection the first samples may be what was buffered for us, and on the first one they only show how the
/// clocks lie.
const STEADY_AFTER_CONNECT: Duration = Duration::from_millis(500);
/// A jump is more than the vehicle can move, and this.
const JUMP_ALLOWANCE_M: f64 = 10.0;
/// A bottom lock speaks of its place for this long.
const LOCK_LASTS: Duration = Duration::from_secs(5);

/// What a new solution is to the tracker.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Change {
    /// It follows from the last one.
    Follows,
    /// It is further from the last one than the vehicle can have come.
    Jumped(Jump),
}

/// How navigation jumped.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Jump {
    pub(crate) metres: f64,
    /// Where the vehicle was before.
    pub(crate) from: EastNorth,
    /// How long that was ago.
    pub(crate) elapsed_s: f64,
}

/// Follows the vehicle's navigation: pairs BFNVG with its BFNVR, counts its age, and sees it jump.
#[derive(Debug)]
pub(crate) struct Tracker {
    frame: LocalFrame,
    age_max: Duration,
    speed_max_mps: f64,
    clock: VehicleClock,
    clock_is_wrong: bool,
    newest: Option<Newest>,
    lock: Option<(BottomLock, Timestamp)>,
    /// Since when it has been steady; `None` before the first sample of this connection.
    steady_since: Option<Timestamp>,
    /// Where it was when it was last heard of on the connection before, and when that was.
    before: Option<(EastNorth, Timestamp)>,
    jumped_at: Option<Timestamp>,
}

#[derive(Clone, Copy, Debug)]
struct Newest {
    sample: NavigationSample,
    /// When it came.
    received: Timestamp,
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
            clock_is_wrong: false,
            newest: None,
            lock: None,
            steady_since: None,
            before: None,
            jumped_at: None,
        }
    }

    /// A new connection: nothing of the old one's navigation holds, but the vehicle is not elsewhere for it, and its
    /// clock is the same. Learnt anew, a link that holds everything up from its first byte on would look like a clock
    /// that is behind.
    pub(crate) fn reset(&mut self) {
        if core::mem::take(&mut self.clock_is_wrong) {
            self.clock = VehicleClock::default();
        }
        let last = self.newest.take();
        // The time of its solution hangs on the vehicle's clock, which may have been set.
        self.before = last.map(|last| (last.sample.local, last.received)).or(self.before);
        self.lock = None;
        self.steady_since = None;
    }

    /// The vehicle's clock has been set, or we have been wrong about it: the next connection learns it anew.
    pub(crate) fn doubt_clock(&mut self) {
        self.clock_is_wrong = true;
    }

    /// Any message's timestamp tells of the clocks.
    pub(crate) fn heard(&mut self, now: Timestamp, utc: Utc, written: TimeOfDay) {
        self.clock.observe(now, utc, written);
    }

    /// By how much our clock and the vehicle's differ, where the vehicle's can be believed and that is little enough for
    /// both to tell the time.
    pub(crate) fn clocks_apart(&self, now: Timestamp) -> Option<Duration> {
        self.clock
            .apart(now)
            .filter(|apart| !self.clock_is_wrong && *apart <= APART_MAX)
    }

    pub(crate) fn clock(&self) -> &VehicleClock {
        &self.clock
    }

    /// A BFNVG. Velocities are those of the last sample until its BFNVR comes. Returns `None` where its solution is
    /// not newer than the last one's.
    pub(crate) fn position(&mut self, now: Timestamp, utc: Utc, message: &Navigation) -> Option<Change> {
        self.clock.observe(now, utc, message.created);
        self.clock.observe(now, utc, message.solution);
        let mut age = self.clock.age(now, utc, message.solution).unwrap_or(Duration::MAX);
        if !is_on(Check::NavigationAge) {
            age = Duration::ZERO;
        }
        let solution = now - age;
        let local = self.frame.to_local(message.position);
        let mut jump = None;
        let mut velocity = (0.0, 0.0, 0.0, 0.0);
        if let Some(last) = &self.newest {
            let elapsed_nanos = elapsed_nanos(last.solution, message.solution);
            if elapsed_nanos <= 0 {
                return None;
            }
            // By our own clock too: the vehicle's may have been set by the fix that moved its position (SPI 2).
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
            written: message.created,
            solution: message.solution,
        });
        Some(jump.map_or(Change::Follows, Change::Jumped))
    }

    /// A BFNVR. True where it completes the newest BFNVG.
    pub(crate) fn velocity(&mut self, message: &VelocityAndRates) -> bool {
        let Some(newest) = &mut self.newest else { return false };
        newest.sample.east_mps = message.east_mps;
        newest.sample.north_mps = message.north_mps;
        newest.sample.down_mps = message.down_mps;
        newest.sample.yaw_rate_dps = message.yaw_rate_dps;
        newest.written == message.created
    }

    /// When the newest sample was written, by the vehicle's clock.
    pub(crate) fn written(&self) -> Option<TimeOfDay> {
        self.newest.as_ref().map(|newest| newest.written)
    }

    /// The newest sample, however old.
    pub(crate) fn newest(&self) -> Option<&NavigationSample> {
        self.newest.as_ref().map(|newest| &newest.sample)
    }

    /// The newest sample while it is fresh (safety requirement 008).
    pub(crate) fn fresh(&self, now: Timestamp) -> Option<&NavigationSample> {
        let sample = self.newest()?;
        (now.since(sample.solution) <= self.age_max || !is_on(Check::NavigationFresh)).then_some(sample)
    }

    /// Navigation is stale: what comes after it must be steady again before it counts, or control would come and go
    /// with every sample of a navigation that is just as old as may be.
    pub(crate) fn unsettle(&mut self) {
        self.steady_since = None;
    }

    /// The vehicle is told where it is, or what its frame is: what it says from now on is another frame's (safety
    /// requirement 021).
    pub(crate) fn frame_reset(&mut self, now: Timestamp) {
        self.jumped_at = Some(now);
    }

    /// When the newest sample will have become stale.
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

    /// Whether the vehicle cannot have come from one place to another in that time.
    fn jump(&self, from: EastNorth, elapsed_s: f64, here: EastNorth) -> Option<Jump> {
        let metres = here.distance_m(from);
        let farthest_m = self.speed_max_mps * 1.5 * elapsed_s + JUMP_ALLOWANCE_M;
        (metres > farthest_m && is_on(Check::Jump)).then_some(Jump {
            metres,
            from,
            elapsed_s,
        })
    }

    /// The last bottom lock, while it is young.
    pub(crate) fn bottom_lock(&self, now: Timestamp) -> Option<BottomLock> {
        let (lock, at) = self.lock?;
        (now.since(at) <= LOCK_LASTS).then_some(lock)
    }
}
