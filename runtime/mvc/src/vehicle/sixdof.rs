//! A torpedo with six degrees of freedom: rigid body, added mass, drag, lift, fins and propeller.
//!
//! The equations are Fossen's for a body in an irrotational current, written in the velocity through the water
//! (*Handbook of Marine Craft Hydrodynamics and Motion Control*, 2nd ed., 2021, sections 3.3, 6.3, 8.1 and 8.4.2). The
//! numbers are the published ones of the REMUS 100, in `coefficients`. They describe that vehicle and nobody has
//! compared them with a Bluefin: good for how a small torpedo answers its fins, not for any vehicle's trim.
//!
//! Three layers, each usable by itself:
//! - [`SixDof`]: fins and propeller in, motion out;
//! - [`Autopilot`]: heading, depth, pitch, speed in, fins and propeller out;
//! - [`Piloted`]: both, in the sea that it is in and within a hull's limits: what the mock flies where the world says
//!   `model = "6-dof"`.
//!
//! How much to believe: drag and propulsion are calibrated with measurements on REMUS vehicles, mass and added mass follow
//! from the shape, and the damping is its author's judgement. The turn is the least certain: Prestero's coefficients of
//! an earlier hull, with weight and buoyancy equal, turn in 6 to 9 m at 1.3 m/s with 4 to 12 degrees of rudder, and the
//! model flown here in 19 to 44 m at 1.6 m/s with 15 to 5 degrees.
//!
//! It is integrated at 50 Hz, whatever the vehicle's own step is: a tick of 100 ms is five steps of the body, of its
//! autopilot and of its tail.
//!
//! Axes: the body's are forward, starboard, down; the world's are north, east, down. No trigonometry of attitude
//! angles is in the equations: the attitude is a unit quaternion, and a pitch of 90 degrees is like any other.
//!
//! Deliberately absent: waves, the hull half out of the water, ground effect, fins that stall, a propeller that
//! cavitates.

mod actuators;
mod attitude;
mod autopilot;
mod coefficients;
mod forces;
#[cfg(test)]
mod maneuvers;
mod piloted;
#[cfg(test)]
mod published;

pub(crate) use actuators::Actuators;
pub(crate) use autopilot::{Steering, Throttle};
pub(crate) use piloted::{Helm, Orders, Piloted, Surroundings, Trim, flown};

use backseat_units::EastNorth;
use backseat_units::math::{asin, atan2, wrap_360};

use actuators::Tail;
use attitude::Attitude;
use coefficients::{BUOYANCY_FADES_M, Coefficients};
use forces::{BodyVelocity, acceleration, excess_for_rise};

/// The longest step of the integrator, seconds: 50 Hz.
pub(crate) const STEP_MAX_S: f64 = 0.02;

/// The body, its tail, and how it moves.
#[derive(Clone, Debug)]
pub(crate) struct SixDof {
    coefficients: Coefficients,
    state: State,
    tail: Tail,
    /// Water's velocity of the last step, north, east, down; none before the first.
    water: Option<[f64; 3]>,
    /// By how much buoyancy exceeds weight when submerged, newtons.
    excess_n: f64,
}

/// What is integrated.
#[derive(Clone, Copy, Debug, PartialEq)]
struct State {
    /// North, east, down, metres.
    at: [f64; 3],
    attitude: Attitude,
    /// Through the water.
    velocity: BodyVelocity,
}

/// The change of a state in a second.
#[derive(Clone, Copy, Debug)]
struct Rate {
    at: [f64; 3],
    attitude: [f64; 4],
    velocity: BodyVelocity,
}

impl State {
    fn after(&self, rate: &Rate, dt_s: f64) -> Self {
        let mut next = *self;
        for (value, rate) in next.at.iter_mut().zip(rate.at) {
            *value += rate * dt_s;
        }
        for (value, rate) in next.attitude.0.iter_mut().zip(rate.attitude) {
            *value += rate * dt_s;
        }
        for (value, rate) in next.velocity.iter_mut().zip(rate.velocity) {
            *value += rate * dt_s;
        }
        next
    }
}

impl Rate {
    /// The weighted mean of the four slopes of a Runge-Kutta step.
    fn mean(a: &Self, b: &Self, c: &Self, d: &Self) -> Self {
        fn mean<const N: usize>(a: [f64; N], b: [f64; N], c: [f64; N], d: [f64; N]) -> [f64; N] {
            core::array::from_fn(|i| (a[i] + 2.0 * (b[i] + c[i]) + d[i]) / 6.0)
        }
        Self {
            at: mean(a.at, b.at, c.at, d.at),
            attitude: mean(a.attitude, b.attitude, c.attitude, d.attitude),
            velocity: mean(a.velocity, b.velocity, c.velocity, d.velocity),
        }
    }
}

impl SixDof {
    /// A vehicle at rest in the water, level, its buoyancy `excess_n` newtons over its weight.
    #[must_use]
    pub(crate) fn new(at: EastNorth, depth_m: f64, heading_deg: f64, excess_n: f64) -> Self {
        Self {
            coefficients: Coefficients::remus_100(),
            state: State {
                at: [at.north_m, at.east_m, depth_m.max(0.0)],
                attitude: Attitude::level(heading_deg.to_radians()),
                velocity: [0.0; 6],
            },
            tail: Tail::default(),
            water: None,
            excess_n,
        }
    }

    /// As [`SixDof::new`], with the buoyancy that floats it up level at `rise_mps`.
    #[must_use]
    pub(crate) fn rising_at(at: EastNorth, depth_m: f64, heading_deg: f64, rise_mps: f64) -> Self {
        let mut vehicle = Self::new(at, depth_m, heading_deg, 0.0);
        vehicle.excess_n = excess_for_rise(&vehicle.coefficients, rise_mps);
        vehicle
    }

    /// Moves by `dt_s` seconds with the tail ordered to `command` and the water moving at `current` (east, north, down;
    /// metres a second). Steps longer than [`STEP_MAX_S`] are divided. A time that is not positive and finite moves nothing.
    ///
    /// The integrator is the classical Runge-Kutta one of fourth order: at 50 Hz its error is far below that of the
    /// coefficients (the fastest motion, roll, turns 6 rad/s), where semi-implicit Euler is off by centimetres a minute
    /// in a turn. The tail's lag is solved exactly and its mean over the step drives the body.
    pub(crate) fn step(&mut self, command: Actuators, current: (f64, f64, f64), dt_s: f64) {
        if !dt_s.is_finite() || dt_s <= 0.0 {
            return;
        }
        self.carry_over(current);
        let steps = (dt_s / STEP_MAX_S - 1e-9).ceil().max(1.0);
        let part_s = dt_s / steps;
        for _ in 0..steps as u32 {
            let tail = self.tail.step(command, part_s);
            self.integrate(tail, part_s);
        }
    }

    /// Stops it over ground where it is, its tail too. What lets it go finds it at rest there, and the water in motion.
    pub(crate) fn hold(&mut self) {
        self.state.velocity = [0.0; 6];
        self.state.attitude = Attitude::level(self.state.attitude.heading_rad());
        self.tail = Tail::default();
        self.water = Some([0.0; 3]);
    }

    /// Puts it on a seabed at `water_depth_m` if it is below that. Whether it is there.
    pub(crate) fn ground_at(&mut self, water_depth_m: f64) -> bool {
        let grounded = self.state.at[2] >= water_depth_m;
        if grounded {
            self.state.at[2] = water_depth_m.max(0.0);
            self.stop_vertical(|down_mps| down_mps > 0.0);
        }
        grounded
    }

    /// Where it is in the world's frame.
    #[must_use]
    pub(crate) fn at(&self) -> EastNorth {
        EastNorth::new(self.state.at[1], self.state.at[0])
    }

    /// Depth, metres, never negative.
    #[must_use]
    pub(crate) fn depth_m(&self) -> f64 {
        self.state.at[2]
    }

    /// Degrees from the frame's north, in [0, 360).
    #[must_use]
    pub(crate) fn heading_deg(&self) -> f64 {
        wrap_360(self.state.attitude.heading_rad().to_degrees())
    }

    /// Degrees, positive nose up.
    #[must_use]
    pub(crate) fn pitch_deg(&self) -> f64 {
        asin((-self.state.attitude.down()[0]).clamp(-1.0, 1.0)).to_degrees()
    }

    /// Degrees, positive to starboard.
    #[must_use]
    pub(crate) fn roll_deg(&self) -> f64 {
        let [_, y, z] = self.state.attitude.down();
        atan2(y, z).to_degrees()
    }

    /// Velocity through the water: forward, to starboard, down (metres a second), roll, pitch, yaw (radians a second).
    #[must_use]
    pub(crate) fn velocity(&self) -> [f64; 6] {
        self.state.velocity
    }

    /// Velocity over ground: east, north, down, metres a second.
    #[must_use]
    pub(crate) fn ground_velocity(&self) -> (f64, f64, f64) {
        let [u, v, w, ..] = self.state.velocity;
        let [north, east, down] = self.state.attitude.to_world([u, v, w]);
        let [water_north, water_east, water_down] = self.water.unwrap_or_default();
        (east + water_east, north + water_north, down + water_down)
    }

    /// Rates of roll, pitch and heading, degrees a second.
    #[must_use]
    pub(crate) fn attitude_rates_dps(&self) -> (f64, f64, f64) {
        let [.., p, q, r] = self.state.velocity;
        let [sin_pitch, y, z] = self.state.attitude.down();
        // Sine and cosine of roll, each times the cosine of pitch.
        let cos2 = (y * y + z * z).max(COS2_PITCH_LEAST);
        let cos = cos2.sqrt();
        let yaw = (q * y + r * z) / cos2;
        let pitch = (q * z - r * y) / cos;
        let roll = p - sin_pitch * yaw;
        (roll.to_degrees(), pitch.to_degrees(), yaw.to_degrees())
    }

    /// Where the fins and the propeller are now, which lags what was ordered.
    #[must_use]
    pub(crate) fn tail(&self) -> Actuators {
        self.tail.now()
    }

    /// As floats it up level at `rise_mps` when submerged; negative sinks.
    pub(crate) fn float_at(&mut self, rise_mps: f64) {
        self.excess_n = excess_for_rise(&self.coefficients, rise_mps).copysign(rise_mps);
    }

    /// Kinetic energy through the water, added mass included, and of righting, joules.
    #[cfg(test)]
    pub(crate) fn energy_j(&self) -> f64 {
        self.coefficients.kinetic_j(&self.state.velocity) + self.coefficients.righting_j(self.state.attitude.down()[2])
    }

    fn integrate(&mut self, tail: Actuators, dt_s: f64) {
        let a = self.rate(&self.state, tail);
        let b = self.rate(&self.state.after(&a, 0.5 * dt_s), tail);
        let c = self.rate(&self.state.after(&b, 0.5 * dt_s), tail);
        let d = self.rate(&self.state.after(&c, dt_s), tail);
        self.state = self.state.after(&Rate::mean(&a, &b, &c, &d), dt_s);
        self.state.attitude.normalize();
        let [_, x, y, z] = &mut self.state.attitude.0;
        for value in self.state.velocity.iter_mut().chain([x, y, z]) {
            if value.abs() < AT_REST {
                *value = 0.0;
            }
        }
        if self.state.at[2] < 0.0 {
            self.state.at[2] = 0.0;
            self.stop_vertical(|down_mps| down_mps < 0.0);
        }
    }

    fn rate(&self, state: &State, tail: Actuators) -> Rate {
        let [u, v, w, p, q, r] = state.velocity;
        let water = self.water.unwrap_or_default();
        let through = state.attitude.to_world([u, v, w]);
        let excess_n = self.excess_n * (state.at[2] / BUOYANCY_FADES_M).clamp(0.0, 1.0);
        Rate {
            at: core::array::from_fn(|i| through[i] + water[i]),
            attitude: state.attitude.rate([p, q, r]),
            velocity: acceleration(
                &self.coefficients,
                &state.velocity,
                state.attitude.down(),
                tail,
                excess_n,
            ),
        }
    }

    /// Where the water's motion changes, the vehicle's own inertia keeps its velocity over ground. A current that is no
    /// number is the one of before; past [`THROUGH_MAX_MPS`] the change carries the vehicle at once.
    fn carry_over(&mut self, current: (f64, f64, f64)) {
        let water = [current.1, current.0, current.2];
        if water.iter().any(|value| !value.is_finite()) {
            return;
        }
        if let Some(before) = self.water {
            let change = self
                .state
                .attitude
                .to_body(core::array::from_fn(|i| water[i] - before[i]));
            for (velocity, change) in self.state.velocity.iter_mut().zip(change) {
                *velocity -= change;
            }
            let [u, v, w, ..] = self.state.velocity;
            let through_mps = (u * u + v * v + w * w).sqrt();
            if through_mps > THROUGH_MAX_MPS {
                for velocity in &mut self.state.velocity[..3] {
                    *velocity *= THROUGH_MAX_MPS / through_mps;
                }
            }
        }
        self.water = Some(water);
    }

    /// Takes out the vertical part of its velocity over ground where `stops` says so.
    fn stop_vertical(&mut self, stops: impl Fn(f64) -> bool) {
        let (_, _, down_mps) = self.ground_velocity();
        if stops(down_mps) {
            let change = self.state.attitude.to_body([0.0, 0.0, down_mps]);
            for (velocity, change) in self.state.velocity.iter_mut().zip(change) {
                *velocity -= change;
            }
        }
    }
}

/// The fastest through the water, metres a second: three times what it can swim. Cross-flow drag brakes in 1/50 s there,
/// and a faster flow than about twice that is more than a step at 50 Hz can follow.
const THROUGH_MAX_MPS: f64 = 8.0;

/// What a lag has brought down to this moves nothing any more, in any unit. Left to itself it becomes a subnormal number,
/// and every sum with those takes a processor a hundred times as long.
const AT_REST: f64 = 1e-30;

/// Square of the cosine of pitch under which the rates of roll and heading are not followed further: 87 degrees.
const COS2_PITCH_LEAST: f64 = 0.0027;
