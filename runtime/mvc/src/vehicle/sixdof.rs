//! A torpedo with six degrees of freedom: rigid body, added mass, drag, lift, fins and propeller.
//!
//! The equations are Fossen's for a body in an irrotational current, written in the velocity through the water
//! (*Handbook of Marine Craft Hydrodynamics and Motion Control*, 2nd ed., 2021, sections 3.3, 6.3, 8.1 and 8.4.2). The
//! numbers are the published ones of the REMUS 100, in `coefficients`. They describe that vehicle, and nobody has
//! compared them with a Bluefin. They show how a small torpedo responds to its fins, but not the trim of any vehicle.
//!
//! There are three layers, and each can be used alone:
//! - [`SixDof`]: fins and propeller in, motion out.
//! - [`autopilot::Autopilot`]: heading, depth, pitch and speed in, fins and propeller out.
//! - [`Piloted`]: both, in the sea around it and within a vehicle's limits. The mock flies it if the world has `model =
//!   "6-dof"`.
//!
//! How reliable it is: drag and propulsion are calibrated with measurements on REMUS vehicles, mass and added mass
//! follow from the shape, and the damping is its author's judgement. The turn is the least certain. Prestero's
//! coefficients, for an earlier body with equal weight and buoyancy, give a radius of 6 to 9 m at 1.3 m/s with 4 to 12
//! degrees of rudder. The model used here has 19 to 44 m at 1.6 m/s with 15 to 5 degrees.
//!
//! The equations are integrated at 50 Hz, whatever the step of the mock is: a step of 100 ms is five steps of the body,
//! of its autopilot and of its tail.
//!
//! The body's axes are forward, starboard, down; the world's axes are north, east, down. The attitude is a unit
//! quaternion, so the equations contain no trigonometry of attitude angles, and a pitch of 90 degrees is like any
//! other.
//!
//! Deliberately absent: waves, a body half out of the water, ground effect, stalling fins, a cavitating propeller.

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
use nalgebra::{Quaternion, Vector3};

use actuators::Tail;
use attitude::Attitude;
use coefficients::{BUOYANCY_FADES_M, Coefficients};
use forces::{BodyVelocity, acceleration, excess_for_rise};

/// The longest step of the integrator, seconds: 50 Hz.
pub(crate) const STEP_MAX_S: f64 = 0.02;

/// The body, its tail, and its motion.
#[derive(Clone, Debug)]
pub(crate) struct SixDof {
    coefficients: Coefficients,
    state: State,
    tail: Tail,
    /// Velocity of the water in the last step: north, east, down; `None` before the first step.
    water: Option<Vector3<f64>>,
    /// By how much buoyancy exceeds weight when submerged, newtons.
    excess_n: f64,
}

/// The integrated state.
#[derive(Clone, Copy, Debug, PartialEq)]
struct State {
    /// North, east, down, metres.
    at: Vector3<f64>,
    attitude: Attitude,
    /// Velocity through the water.
    velocity: BodyVelocity,
}

/// The change of a state per second.
#[derive(Clone, Copy, Debug)]
struct Rate {
    at: Vector3<f64>,
    attitude: Quaternion<f64>,
    velocity: BodyVelocity,
}

impl State {
    fn after(&self, rate: &Rate, dt_s: f64) -> Self {
        Self {
            at: self.at + rate.at * dt_s,
            attitude: Attitude(self.attitude.0 + rate.attitude * dt_s),
            velocity: self.velocity + rate.velocity * dt_s,
        }
    }
}

impl Rate {
    /// The weighted mean of the four slopes of a Runge-Kutta step.
    fn mean(a: &Self, b: &Self, c: &Self, d: &Self) -> Self {
        Self {
            at: (a.at + (b.at + c.at) * 2.0 + d.at) / 6.0,
            attitude: (a.attitude + (b.attitude + c.attitude) * 2.0 + d.attitude) / 6.0,
            velocity: (a.velocity + (b.velocity + c.velocity) * 2.0 + d.velocity) / 6.0,
        }
    }
}

impl SixDof {
    /// A vehicle at rest in the water and level. Its buoyancy exceeds its weight by `excess_n` newtons.
    #[must_use]
    pub(crate) fn new(at: EastNorth, depth_m: f64, heading_deg: f64, excess_n: f64) -> Self {
        Self {
            coefficients: Coefficients::remus_100(),
            state: State {
                at: Vector3::new(at.north_m, at.east_m, depth_m.max(0.0)),
                attitude: Attitude::level(heading_deg.to_radians()),
                velocity: BodyVelocity::zeros(),
            },
            tail: Tail::default(),
            water: None,
            excess_n,
        }
    }

    /// As [`SixDof::new`], with the buoyancy with which it floats up at `rise_mps` while level.
    #[must_use]
    pub(crate) fn rising_at(at: EastNorth, depth_m: f64, heading_deg: f64, rise_mps: f64) -> Self {
        let mut vehicle = Self::new(at, depth_m, heading_deg, 0.0);
        vehicle.excess_n = excess_for_rise(&vehicle.coefficients, rise_mps);
        vehicle
    }

    /// Moves by `dt_s` seconds, with `command` as the order to the tail and `current` as the velocity of the water
    /// (east, north, down; metres a second). Steps longer than [`STEP_MAX_S`] are divided. A time that is not positive
    /// and finite has no effect.
    ///
    /// The integrator is the classical Runge-Kutta method of fourth order. At 50 Hz its error is far below that of the
    /// coefficients (the fastest motion, roll, has 6 rad/s); semi-implicit Euler is off by centimetres a minute in a
    /// turn. The tail's lag is solved exactly, and its mean over the step drives the body.
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

    /// Stops the body and its tail. It is then at rest over ground, and when it is released the water moves past it.
    pub(crate) fn stay(&mut self) {
        self.state.velocity = BodyVelocity::zeros();
        self.state.attitude = Attitude::level(self.state.attitude.heading_rad());
        self.tail = Tail::default();
        self.water = Some(Vector3::zeros());
    }

    /// Puts it on a seabed at `water_depth_m` if it is below that. Returns whether it is on the seabed.
    pub(crate) fn ground_at(&mut self, water_depth_m: f64) -> bool {
        let grounded = self.state.at.z >= water_depth_m;
        if grounded {
            self.state.at.z = water_depth_m.max(0.0);
            self.stop_vertical(|down_mps| down_mps > 0.0);
        }
        grounded
    }

    /// Its position in the world's frame.
    #[must_use]
    pub(crate) fn at(&self) -> EastNorth {
        EastNorth::new(self.state.at.y, self.state.at.x)
    }

    /// Depth, metres, never negative.
    #[must_use]
    pub(crate) fn depth_m(&self) -> f64 {
        self.state.at.z
    }

    /// Degrees from the frame's north, in [0, 360).
    #[must_use]
    pub(crate) fn heading_deg(&self) -> f64 {
        wrap_360(self.state.attitude.heading_rad().to_degrees())
    }

    /// Degrees, positive nose up.
    #[must_use]
    pub(crate) fn pitch_deg(&self) -> f64 {
        asin((-self.state.attitude.down().x).clamp(-1.0, 1.0)).to_degrees()
    }

    /// Degrees, positive to starboard.
    #[must_use]
    pub(crate) fn roll_deg(&self) -> f64 {
        let down = self.state.attitude.down();
        atan2(down.y, down.z).to_degrees()
    }

    /// Velocity through the water: forward, to starboard, down (metres a second), roll, pitch, yaw (radians a second).
    #[must_use]
    pub(crate) fn velocity(&self) -> [f64; 6] {
        self.state.velocity.into()
    }

    /// Velocity over ground: east, north, down, metres a second.
    #[must_use]
    pub(crate) fn ground_velocity(&self) -> (f64, f64, f64) {
        let ground = self.state.attitude.to_world(linear(&self.state.velocity)) + self.water.unwrap_or_default();
        (ground.y, ground.x, ground.z)
    }

    /// Rates of roll, pitch and heading, degrees a second.
    #[must_use]
    pub(crate) fn attitude_rates_dps(&self) -> (f64, f64, f64) {
        let [.., p, q, r] = self.velocity();
        let [sin_pitch, y, z]: [f64; 3] = self.state.attitude.down().into();
        // Sine and cosine of roll, each times the cosine of pitch.
        let cos2 = (y * y + z * z).max(COS2_PITCH_LEAST);
        let cos = cos2.sqrt();
        let yaw = (q * y + r * z) / cos2;
        let pitch = (q * z - r * y) / cos;
        let roll = p - sin_pitch * yaw;
        (roll.to_degrees(), pitch.to_degrees(), yaw.to_degrees())
    }

    /// The present state of fins and propeller, which lags behind the orders.
    #[must_use]
    pub(crate) fn tail(&self) -> Actuators {
        self.tail.now()
    }

    /// Sets the buoyancy with which it floats up at `rise_mps` while level and submerged; with a negative one it sinks.
    pub(crate) fn float_at(&mut self, rise_mps: f64) {
        self.excess_n = excess_for_rise(&self.coefficients, rise_mps).copysign(rise_mps);
    }

    /// Kinetic energy through the water, including added mass, plus the potential energy of righting, joules.
    #[cfg(test)]
    pub(crate) fn energy_j(&self) -> f64 {
        self.coefficients.kinetic_j(&self.state.velocity) + self.coefficients.righting_j(self.state.attitude.down().z)
    }

    fn integrate(&mut self, tail: Actuators, dt_s: f64) {
        let a = self.rate(&self.state, tail);
        let b = self.rate(&self.state.after(&a, 0.5 * dt_s), tail);
        let c = self.rate(&self.state.after(&b, 0.5 * dt_s), tail);
        let d = self.rate(&self.state.after(&c, dt_s), tail);
        self.state = self.state.after(&Rate::mean(&a, &b, &c, &d), dt_s);
        self.state.attitude.normalize();
        let turned = self.state.attitude.0.coords.iter_mut().take(3);
        for value in self.state.velocity.iter_mut().chain(turned) {
            if value.abs() < AT_REST {
                *value = 0.0;
            }
        }
        if self.state.at.z < 0.0 {
            self.state.at.z = 0.0;
            self.stop_vertical(|down_mps| down_mps < 0.0);
        }
    }

    fn rate(&self, state: &State, tail: Actuators) -> Rate {
        let water = self.water.unwrap_or_default();
        let [.., p, q, r]: [f64; 6] = state.velocity.into();
        let excess_n = self.excess_n * (state.at.z / BUOYANCY_FADES_M).clamp(0.0, 1.0);
        Rate {
            at: state.attitude.to_world(linear(&state.velocity)) + water,
            attitude: state.attitude.rate(Vector3::new(p, q, r)),
            velocity: acceleration(
                &self.coefficients,
                &state.velocity,
                state.attitude.down(),
                tail,
                excess_n,
            ),
        }
    }

    /// If the water's velocity changes, the vehicle's inertia keeps its velocity over ground at first. A current that
    /// is not finite is ignored, and the one before stays. The part of a change beyond [`THROUGH_MAX_MPS`] moves the
    /// vehicle at once.
    fn carry_over(&mut self, current: (f64, f64, f64)) {
        let water = Vector3::new(current.1, current.0, current.2);
        if water.iter().any(|value| !value.is_finite()) {
            return;
        }
        if let Some(before) = self.water {
            let mut through = self.state.velocity.fixed_rows_mut::<3>(0);
            through -= self.state.attitude.to_body(water - before);
            let through_mps = through.norm();
            if through_mps > THROUGH_MAX_MPS {
                through *= THROUGH_MAX_MPS / through_mps;
            }
        }
        self.water = Some(water);
    }

    /// Removes the vertical part of its velocity over ground if `stops` returns true for it.
    fn stop_vertical(&mut self, stops: impl Fn(f64) -> bool) {
        let (_, _, down_mps) = self.ground_velocity();
        if stops(down_mps) {
            let change = self.state.attitude.to_body(Vector3::new(0.0, 0.0, down_mps));
            let mut through = self.state.velocity.fixed_rows_mut::<3>(0);
            through -= change;
        }
    }
}

/// The linear part of a velocity.
fn linear(velocity: &BodyVelocity) -> Vector3<f64> {
    velocity.fixed_rows::<3>(0).into_owned()
}

/// The greatest speed through the water, metres a second: three times its own greatest speed. There cross-flow drag
/// acts within 1/50 s, and steps at 50 Hz cannot follow a flow of more than about twice that speed.
const THROUGH_MAX_MPS: f64 = 8.0;

/// A value below this is set to zero. It is too small to matter in any unit, but a lag would turn it into a subnormal
/// number, and a processor needs a hundred times as long for arithmetic with those.
const AT_REST: f64 = 1e-30;

/// The least square of the cosine of pitch in the rates of roll and heading: beyond a pitch of 87 degrees they are
/// bounded and not exact.
const COS2_PITCH_LEAST: f64 = 0.0027;
