use core::time::Duration;
use std::collections::VecDeque;

use backseat_units::math::{exp, hypot, sin_cos};
use backseat_units::{EastNorth, Timestamp};

use super::EastNorthRate;
use super::dvl::Dvl;
use super::noise::{Draws, Noise};
use crate::file::{SensorConfig, WithoutLock};
use crate::vehicle::Vehicle;

/// Number of past places of the solution that are kept, one a second. No fix may be older (`age_max_s`).
const HISTORY: usize = 128;
const HISTORY_PERIOD: Duration = Duration::from_secs(1);
/// Half of the points of a circular normal distribution lie within this many of its standard deviations (per axis) of
/// the centre: the square root of 2 ln 2. The accuracy of a fix is given as that radius (SPI 7.21).
const CIRCULAR_ERROR_PROBABLE: f64 = 1.177_41;
/// The least standard deviation of a fix that the vehicle assumes, metres per axis.
const FIX_DEVIATION_MIN_M: f64 = 0.1;

/// Time constant with which the velocity follows that of the DVL or of GPS, seconds. The solution is inertial, so it
/// does not jump when the bottom comes into range.
const AIDED_TAU_S: f64 = 2.0;

/// The navigation solution: dead reckoning with the inertial system and the DVL, corrected by fixes.
///
/// With bottom lock, the velocity is that of the DVL, with its scale error, turned by its misalignment and by the error
/// of the heading. So the error of the position is a share of the distance, plus a random walk. Without lock, the error
/// of the velocity itself is a random walk. The position is the integral of the reported velocity, apart from the walk
/// of the position and from fixes. On the surface, each GPS fix moves the solution to it.
#[derive(Clone, Debug)]
pub(super) struct Solution {
    config: SensorConfig,
    pub(super) at: EastNorth,
    /// Velocity over ground, metres a second.
    pub(super) velocity: EastNorthRate,
    /// The distance that this velocity made in the last step.
    way: EastNorth,
    pub(super) heading_bias_deg: f64,
    /// Sine and cosine of the error of the heading.
    turn: (f64, f64),
    /// The random walk of the position in one step, metres per axis; `velocity_step_mps` is that of the velocity
    /// without lock, metres a second.
    position_step_m: f64,
    velocity_step_mps: f64,
    dt_s: f64,
    /// The error of the velocity.
    velocity_error: EastNorthRate,
    /// The share of the difference to the error of the aiding sensor that the velocity's error loses in a step.
    aid_share: f64,
    /// The current that was measured with the last lock, plus the random walk since then.
    held_current: EastNorthRate,
    error: ErrorModel,
    gps: Gps,
    history: VecDeque<(Timestamp, EastNorth)>,
}

/// The vehicle's estimate of its own error per axis. Fixes are weighed with it.
#[derive(Clone, Copy, Debug)]
struct ErrorModel {
    /// Standard deviation of the error as a share of the distance. The two fields after it are the variances that the
    /// walks of position and velocity add in a step.
    share: f64,
    step_m2: f64,
    velocity_step_m2: f64,
    random_m2: f64,
    systematic_m: f64,
    velocity_m2: f64,
}

/// The GPS receiver.
#[derive(Clone, Debug)]
struct Gps {
    noise: Noise,
    fixes: u64,
    error: EastNorth,
    /// When it has acquired or will acquire satellites, while the antenna is out of the water.
    acquired_at: Option<Timestamp>,
    next_fix: Timestamp,
    used: bool,
    dead: bool,
}

/// The effect of a fix.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum FixOutcome {
    /// The solution has moved by this distance, metres.
    Moved(f64),
    /// The fix is too old: its age, seconds.
    TooOld(f64),
    /// The fix is this far from the solution, metres, beyond the limit of what is likely.
    Outlier { off_m: f64, limit_m: f64 },
}

impl Solution {
    pub(super) fn new(config: &SensorConfig, dt_s: f64, vehicle: &Vehicle, seed: u64) -> Self {
        let mut constant = Noise::new(seed, "inertial").reading(0);
        let heading_bias_deg = constant.normal(config.ins.heading_bias_deg);
        let gps_noise = Noise::new(seed, "gps");
        let mut first = gps_noise.reading(0);
        // The last fix before the run. A dive from the surface begins with its error.
        let error = EastNorth::new(first.gaussian(), first.gaussian()) * config.gps.error_m;
        let surfaced = vehicle.motion().depth_m < config.gps.antenna_depth_m;
        let position_step_m = config.position_drift_m_per_sqrt_h * (dt_s / 3600.0).sqrt();
        let velocity_step_mps = config.ins.velocity_walk_mps_per_sqrt_s * dt_s.sqrt();
        let misalignment_rad = config.dvl.misalignment_deg.to_radians();
        let turned_rad = hypot(config.ins.heading_bias_deg.to_radians(), misalignment_rad);
        Self {
            config: *config,
            at: vehicle.motion().at + error,
            velocity: (0.0, 0.0),
            way: EastNorth::default(),
            heading_bias_deg,
            turn: sin_cos(heading_bias_deg.to_radians()),
            position_step_m,
            velocity_step_mps,
            dt_s,
            velocity_error: (0.0, 0.0),
            aid_share: dt_s / (AIDED_TAU_S + dt_s),
            held_current: vehicle.motion().current,
            error: ErrorModel {
                share: hypot(config.dvl.scale_error, turned_rad),
                step_m2: position_step_m * position_step_m,
                velocity_step_m2: velocity_step_mps * velocity_step_mps,
                random_m2: config.gps.error_m * config.gps.error_m,
                systematic_m: 0.0,
                velocity_m2: 0.0,
            },
            gps: Gps {
                noise: gps_noise,
                fixes: 0,
                error,
                acquired_at: surfaced.then_some(Timestamp::ZERO),
                next_fix: Timestamp::ZERO,
                used: surfaced,
                dead: false,
            },
            history: VecDeque::with_capacity(HISTORY),
        }
    }

    /// Whether the solution uses GPS.
    pub(super) const fn has_gps(&self) -> bool {
        self.gps.used
    }

    pub(super) const fn kill_gps(&mut self, dead: bool) {
        self.gps.dead = dead;
    }

    /// One step: adds the vehicle's motion, as its sensors measure it.
    pub(super) fn step(&mut self, vehicle: &Vehicle, dvl: &Dvl, sound_ratio: f64, now: Timestamp, draws: &mut Draws) {
        let before = self.velocity;
        let ground = vehicle.motion().ground;
        let through_water = self.turned((
            ground.0 - vehicle.motion().current.0,
            ground.1 - vehicle.motion().current.1,
        ));
        let position_walk = EastNorth::new(draws.gaussian(), draws.gaussian()) * self.position_step_m;
        if dvl.lock || self.gps.used {
            let aided = if dvl.lock {
                self.turned(dvl.measured(ground, sound_ratio))
            } else {
                ground
            };
            let error = &mut self.velocity_error;
            error.0 += (aided.0 - ground.0 - error.0) * self.aid_share;
            error.1 += (aided.1 - ground.1 - error.1) * self.aid_share;
            self.velocity = (ground.0 + error.0, ground.1 + error.1);
            self.held_current = (self.velocity.0 - through_water.0, self.velocity.1 - through_water.1);
            self.error.velocity_m2 = 0.0;
        } else {
            let walk = (
                draws.normal(self.velocity_step_mps),
                draws.normal(self.velocity_step_mps),
            );
            match self.config.ins.without_lock {
                WithoutLock::Inertial => {
                    self.velocity_error.0 += walk.0;
                    self.velocity_error.1 += walk.1;
                }
                WithoutLock::Water => {
                    self.held_current.0 += walk.0;
                    self.held_current.1 += walk.1;
                    self.velocity_error = (
                        through_water.0 + self.held_current.0 - ground.0,
                        through_water.1 + self.held_current.1 - ground.1,
                    );
                }
            }
            self.velocity = (ground.0 + self.velocity_error.0, ground.1 + self.velocity_error.1);
            self.error.velocity_m2 += self.error.velocity_step_m2;
        }
        let way = EastNorth::new(before.0 + self.velocity.0, before.1 + self.velocity.1) * (0.5 * self.dt_s);
        self.way = way;
        self.at = self.at + way + position_walk;
        self.error.random_m2 += self.error.step_m2;
        let per_s = self.error.velocity_m2.sqrt() + self.error.share * hypot(self.velocity.0, self.velocity.1);
        self.error.systematic_m += per_s * self.dt_s;
        self.receive_gps(vehicle, now);
        if self
            .history
            .back()
            .is_none_or(|(last, _)| now >= *last + HISTORY_PERIOD)
        {
            if self.history.len() == HISTORY {
                self.history.pop_front();
            }
            self.history.push_back((now, self.at));
        }
    }

    /// The solution uses GPS from the first fix after the antenna has come up until the antenna goes down.
    fn receive_gps(&mut self, vehicle: &Vehicle, now: Timestamp) {
        let config = self.config.gps;
        if vehicle.motion().depth_m >= config.antenna_depth_m || self.gps.dead {
            (self.gps.acquired_at, self.gps.used) = (None, false);
            return;
        }
        let acquired_at = *self
            .gps
            .acquired_at
            .get_or_insert(now + Duration::from_secs_f64(config.acquisition_s));
        if now < acquired_at || now < self.gps.next_fix {
            return;
        }
        self.gps.next_fix = now + Duration::from_secs_f64(config.period_s);
        self.gps.fixes += 1;
        let mut draws = self.gps.noise.reading(self.gps.fixes);
        // A first-order Gauss-Markov process. Its spread does not depend on the rate of fixes.
        let kept = if config.correlation_s > 0.0 {
            exp(-config.period_s / config.correlation_s)
        } else {
            0.0
        };
        let fresh = EastNorth::new(draws.gaussian(), draws.gaussian()) * config.error_m;
        self.gps.error = self.gps.error * kept + fresh * (1.0 - kept * kept).sqrt();
        self.gps.used = true;
        self.move_by(vehicle.motion().at + self.gps.error - self.at);
        self.error.random_m2 = config.error_m * config.error_m;
        (self.error.systematic_m, self.error.velocity_m2) = (0.0, 0.0);
    }

    /// Moves the solution and its history.
    pub(super) fn move_by(&mut self, way: EastNorth) {
        self.at = self.at + way;
        for (_, at) in &mut self.history {
            *at = *at + way;
        }
    }

    /// Applies a payload's fix of where the vehicle was `age_s` seconds ago, with a circular error probable of
    /// `error_m`. It is one step of a Kalman filter of the position; a forced fix moves the solution by the whole
    /// difference (SPI 7.21).
    pub(super) fn fix(
        &mut self,
        now: Timestamp,
        place: EastNorth,
        error_m: f64,
        age_s: f64,
        force: bool,
    ) -> FixOutcome {
        let config = self.config.fixes;
        if age_s > config.age_max_s {
            return FixOutcome::TooOld(age_s);
        }
        let off = place - self.at_time(now, age_s);
        let off_m = hypot(off.east_m, off.north_m);
        let deviation_m = (error_m / CIRCULAR_ERROR_PROBABLE).max(FIX_DEVIATION_MIN_M) + age_s * config.age_error_mps;
        let (fix_m2, own_m2) = (deviation_m * deviation_m, self.error.variance_m2());
        let limit_m = config.outlier_sigma * (fix_m2 + own_m2).sqrt();
        if force {
            self.move_by(off);
            self.error.random_m2 = fix_m2;
            self.error.systematic_m = 0.0;
            return FixOutcome::Moved(off_m);
        }
        if off_m > limit_m {
            return FixOutcome::Outlier { off_m, limit_m };
        }
        let gain = own_m2 / (own_m2 + fix_m2);
        self.move_by(off * gain);
        self.error.random_m2 *= 1.0 - gain;
        self.error.systematic_m *= (1.0 - gain).sqrt();
        FixOutcome::Moved(off_m * gain)
    }

    /// Where the solution was `age_s` seconds ago, interpolated between the places of the history.
    fn at_time(&self, now: Timestamp, age_s: f64) -> EastNorth {
        let (mut later_s, mut later) = (0.0, self.at);
        for (time, at) in self.history.iter().rev() {
            let earlier_s = now.since(*time).as_secs_f64();
            if earlier_s >= age_s && earlier_s > later_s {
                let share = ((age_s - later_s) / (earlier_s - later_s)).clamp(0.0, 1.0);
                return later + (*at - later) * share;
            }
            (later_s, later) = (earlier_s, *at);
        }
        later
    }

    /// The distance of the last step without the error of the heading, as the DVL measures it along the vehicle's axes.
    pub(super) fn own_way(&self) -> EastNorth {
        let (sin, cos) = self.turn;
        let EastNorth { east_m, north_m } = self.way;
        EastNorth::new(east_m * cos - north_m * sin, north_m * cos + east_m * sin)
    }

    fn turned(&self, (east, north): EastNorthRate) -> EastNorthRate {
        let (sin, cos) = self.turn;
        (east * cos + north * sin, north * cos - east * sin)
    }
}

impl ErrorModel {
    fn variance_m2(&self) -> f64 {
        self.random_m2 + self.systematic_m * self.systematic_m
    }
}
