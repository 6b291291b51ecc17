use backseat_units::EastNorth;

use super::autopilot::{
    Autopilot, Bounds, HEADING_GAIN_PER_S, PITCH_RATE_MAX, Setpoints, Steering, TURN_MAX_DEG_PER_M, Throttle, Vertical,
};
use super::coefficients::{FIN_MAX_DEG, PROPELLER_MAX_RPM};
use super::{Actuators, STEP_MAX_S, SixDof};
use crate::vehicle::performance::Performance;

/// What moves the vehicle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Helm {
    /// Held in place, before its mission.
    Held,
    /// Under its autopilot.
    Under(Orders),
    /// Nothing moves it: fins amidships, propeller stopped. It drifts and floats up.
    Adrift,
}

/// What the autopilot must hold, as a mission gives it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Orders {
    /// Horizontal.
    pub(crate) steering: Steering,
    /// Vertical.
    pub(crate) trim: Trim,
    /// Forward.
    pub(crate) throttle: Throttle,
}

/// The vertical order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Trim {
    /// Metres below the surface.
    Depth(f64),
    /// Metres above the seabed.
    Altitude(f64),
    /// Degrees, positive nose up.
    Pitch(f64),
    /// The elevator's angle, degrees, positive pitches the nose up; within ±15.
    Elevator(f64),
}

/// The sea at the vehicle's position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Surroundings {
    /// Depth of the water, metres; may be infinite.
    pub(crate) water_depth_m: f64,
    /// Gradient of that depth, metres per metre, east and north.
    pub(crate) gradient: EastNorth,
    /// Velocity of the water, east, north, down, metres a second.
    pub(crate) current: (f64, f64, f64),
}

/// Position, attitude and motion of the vehicle, for sensors and the judge of a run.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Motion {
    /// Position in the world's frame.
    pub(crate) at: EastNorth,
    /// Metres, never negative.
    pub(crate) depth_m: f64,
    /// Degrees from the frame's north, in [0, 360).
    pub(crate) heading_deg: f64,
    /// Speed through the water, forward, metres a second.
    pub(crate) surge_mps: f64,
    /// Speed through the water, to starboard, metres a second.
    pub(crate) sway_mps: f64,
    /// Depth rate, metres a second, positive down.
    pub(crate) heave_mps: f64,
    /// Rate of the heading, degrees a second.
    pub(crate) yaw_rate_dps: f64,
    /// Degrees, positive nose up.
    pub(crate) pitch_deg: f64,
    /// Degrees a second.
    pub(crate) pitch_rate_dps: f64,
    /// Degrees, positive to starboard.
    pub(crate) roll_deg: f64,
    /// Degrees a second.
    pub(crate) roll_rate_dps: f64,
    /// Velocity over ground, east and north, metres a second.
    pub(crate) ground: (f64, f64),
    /// Whether it lies on the seabed.
    pub(crate) grounded: bool,
    /// State of fins and propeller.
    pub(crate) tail: Actuators,
    /// Orders to fins and propeller.
    pub(crate) ordered: Actuators,
}

/// A body, its autopilot, and the limits that it keeps, whatever the orders are.
#[derive(Clone, Debug)]
pub(crate) struct Piloted {
    performance: Performance,
    altitude_min_m: f64,
    body: SixDof,
    autopilot: Autopilot,
    ordered: Actuators,
    /// As a share of the class's buoyant rise.
    rise_share: f64,
    held: bool,
    grounded: bool,
}

/// The least speed at which this body steers and holds its depth, metres a second. Below about 0.7, the force of the
/// stern planes lifts it more than the pitch that they cause brings it down, and its buoyancy adds to that.
const STEERAGE_MPS: f64 = 1.0;
/// Its greatest speed, metres a second: a little less than the propeller can give in a straight line.
const FASTEST_MPS: f64 = 2.4;
/// How far below the speed limit the autopilot stays, metres a second, because the speed varies a little when the pitch
/// changes.
const SPEED_RESERVE_MPS: f64 = 0.03;
/// Turns of its propeller a minute for each metre a second. Published: 2.5 m/s at 1525.
const RPM_PER_MPS: f64 = PROPELLER_MAX_RPM / 2.5;
/// How far ahead the vehicle takes the slope of the seabed into account, seconds.
const LOOK_AHEAD_S: f64 = 10.0;
/// The distance that the vehicle keeps from its greatest depth and its least altitude, because a diving body does not
/// stop at once: metres for each metre a second of its depth rate.
const LEVEL_OUT_S: f64 = 1.0;

/// The smallest radius of a turn, metres: with hard rudder from full speed, while the speed drops. A steady turn has 19
/// m and more.
const TURN_RADIUS_M: f64 = 13.0;

/// The performance of a vehicle with this body: the limits of its class, as far as the body reaches them.
///
/// Plans and requests must be judged by these: below 1 m/s the vehicle does not hold its depth, and it turns with two
/// thirds of its rudder. The model is not for hovering vehicles.
#[must_use]
pub(crate) fn flown(performance: &Performance) -> Performance {
    let speed_max_mps = performance.speed_max_mps.min(FASTEST_MPS);
    let speed_min_mps = performance.speed_min_mps.max(STEERAGE_MPS).min(speed_max_mps);
    Performance {
        speed_min_mps,
        speed_max_mps,
        yaw_rate_max_dps: performance.yaw_rate_max_dps.min(TURN_MAX_DEG_PER_M * speed_max_mps),
        turn_radius_m: TURN_RADIUS_M,
        pitch_rate_max_dps: PITCH_RATE_MAX.to_degrees(),
        yaw_gain_per_s: performance.yaw_gain_per_s.min(HEADING_GAIN_PER_S),
        yaw_tau_s: performance.yaw_tau_s.max(2.0),
        rpm_per_mps: RPM_PER_MPS,
        fin_max_deg: FIN_MAX_DEG,
        hovers: false,
        ..*performance
    }
}

impl Piloted {
    /// At rest, with the limits of `performance` as far as the body reaches them ([`flown`]), and with its least
    /// altitude, metres.
    #[must_use]
    pub(crate) fn new(
        performance: &Performance,
        altitude_min_m: f64,
        at: EastNorth,
        depth_m: f64,
        heading_deg: f64,
    ) -> Self {
        let mut body = SixDof::rising_at(at, depth_m, heading_deg, performance.buoyant_rise_mps);
        body.stay();
        Self {
            performance: flown(performance),
            altitude_min_m,
            body,
            autopilot: Autopilot::default(),
            ordered: Actuators::default(),
            rise_share: 1.0,
            held: true,
            grounded: false,
        }
    }

    /// The limits that it keeps.
    #[cfg(test)]
    pub(crate) const fn performance(&self) -> &Performance {
        &self.performance
    }

    /// Sets how fast it floats up when adrift, as a share of the class's buoyant rise; with a negative one it sinks.
    /// Under way the autopilot has to compensate for it.
    pub(crate) fn float_at(&mut self, rise_share: f64) {
        if rise_share.to_bits() != self.rise_share.to_bits() {
            self.rise_share = rise_share;
            self.body.float_at(self.performance.buoyant_rise_mps * rise_share);
        }
    }

    /// Puts it on a seabed at `water_depth_m` if it is below that. Returns whether it is on the seabed, and its depth.
    pub(crate) fn ground_at(&mut self, water_depth_m: f64) -> (bool, f64) {
        self.grounded = self.body.ground_at(water_depth_m);
        (self.grounded, self.body.depth_m())
    }

    /// One step of `dt_s` seconds. Within it, the autopilot steers at 50 Hz or more. The surroundings are those at the
    /// begin of the step.
    pub(crate) fn drive(&mut self, helm: &Helm, around: &Surroundings, dt_s: f64) {
        if !dt_s.is_finite() || dt_s <= 0.0 {
            return;
        }
        match helm {
            Helm::Held => {
                if !self.held {
                    self.body.stay();
                    self.autopilot = Autopilot::default();
                    self.ordered = Actuators::default();
                }
                self.held = true;
                self.grounded = self.body.ground_at(around.water_depth_m);
            }
            Helm::Adrift => {
                self.held = false;
                self.autopilot = Autopilot::default();
                self.ordered = Actuators::default();
                self.body.step(self.ordered, around.current, dt_s);
                self.grounded = self.body.ground_at(around.water_depth_m);
            }
            Helm::Under(orders) => {
                self.held = false;
                let steps = (dt_s / STEP_MAX_S - 1e-9).ceil().max(1.0);
                let part_s = dt_s / steps;
                for i in 0..steps as u32 {
                    let water_depth_m = self.water_depth_after(around, f64::from(i) * part_s);
                    let (setpoints, bounds) = self.within_limits(orders, around, water_depth_m);
                    let command = self.autopilot.command(&self.body, &setpoints, &bounds, part_s);
                    self.ordered = command.limited();
                    self.body.step(command, around.current, part_s);
                    self.grounded = self.body.ground_at(water_depth_m);
                }
            }
        }
    }

    /// Its position, attitude and motion. While it is held, its velocity is zero.
    #[must_use]
    pub(crate) fn motion(&self) -> Motion {
        let (east_mps, north_mps, down_mps) = if self.held {
            (0.0, 0.0, 0.0)
        } else {
            self.body.ground_velocity()
        };
        let [surge_mps, sway_mps, ..] = self.body.velocity();
        let (roll_rate_dps, pitch_rate_dps, yaw_rate_dps) = self.body.attitude_rates_dps();
        Motion {
            at: self.body.at(),
            depth_m: self.body.depth_m(),
            heading_deg: self.body.heading_deg(),
            surge_mps,
            sway_mps,
            heave_mps: down_mps,
            yaw_rate_dps,
            pitch_deg: self.body.pitch_deg(),
            pitch_rate_dps,
            roll_deg: self.body.roll_deg(),
            roll_rate_dps,
            ground: (east_mps, north_mps),
            grounded: self.grounded,
            tail: self.body.tail(),
            ordered: self.ordered,
        }
    }

    /// The water depth some seconds into the step, computed with the slope at the begin of the step.
    fn water_depth_after(&self, around: &Surroundings, seconds: f64) -> f64 {
        around.water_depth_m + seconds * self.deepening_mps(around)
    }

    /// How fast the water depth under the vehicle grows.
    fn deepening_mps(&self, around: &Surroundings) -> f64 {
        let (east_mps, north_mps, _) = self.body.ground_velocity();
        east_mps * around.gradient.east_m + north_mps * around.gradient.north_m
    }

    fn within_limits(&self, orders: &Orders, around: &Surroundings, water_depth_m: f64) -> (Setpoints, Bounds) {
        let performance = &self.performance;
        let deepening_mps = self.deepening_mps(around);
        let floor_m = water_depth_m + (LOOK_AHEAD_S * deepening_mps).min(0.0) - self.altitude_min_m;
        let deepest_m = performance.depth_max_m.min(floor_m);
        let sinking_mps = self.body.ground_velocity().2.max(0.0);
        let bounds = Bounds {
            depth_max_m: (deepest_m - LEVEL_OUT_S * sinking_mps).max(0.0),
            speed_max_mps: performance.speed_max_mps - SPEED_RESERVE_MPS,
            pitch_max_deg: performance.pitch_max_deg,
            depth_rate_max_mps: performance.depth_rate_max_mps,
            depth_gain_per_s: performance.depth_gain_per_s,
            yaw_rate_max_dps: performance.yaw_rate_max_dps,
        };
        let vertical = match orders.trim {
            Trim::Depth(depth_m) => Vertical::Depth(depth_m),
            Trim::Altitude(altitude_m) => Vertical::MovingDepth(water_depth_m - altitude_m, deepening_mps),
            Trim::Pitch(pitch_deg) => Vertical::Pitch(pitch_deg),
            Trim::Elevator(elevator_deg) => Vertical::Elevator(elevator_deg),
        };
        let throttle = match orders.throttle {
            Throttle::Speed(speed_mps) => {
                Throttle::Speed(speed_mps.clamp(performance.speed_min_mps, performance.speed_max_mps))
            }
            Throttle::Rpm(rpm) => Throttle::Rpm(rpm),
        };
        let setpoints = Setpoints {
            steering: orders.steering,
            vertical,
            throttle,
        };
        (setpoints, bounds)
    }
}
