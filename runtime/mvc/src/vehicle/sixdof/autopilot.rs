use backseat_units::math::{asin, exp, sin, wrap_180};

use super::SixDof;
use super::actuators::Actuators;
use super::coefficients::{Coefficients, FIN_MAX_DEG, PROPELLER_MAX_RPM};

/// What the autopilot holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Setpoints {
    /// Horizontal.
    pub(crate) steering: Steering,
    /// Vertical.
    pub(crate) vertical: Vertical,
    /// Forward.
    pub(crate) throttle: Throttle,
}

/// How the vehicle is steered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Steering {
    /// Degrees from the frame's north.
    Heading(f64),
    /// The rudder's angle, degrees, positive to starboard; within ±15.
    Rudder(f64),
}

/// How the vehicle is trimmed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Vertical {
    /// Metres.
    Depth(f64),
    /// Depth, metres, and its change, metres a second: for an altitude over a slope.
    MovingDepth(f64, f64),
    /// Degrees, positive nose up.
    Pitch(f64),
    /// The elevator's angle, degrees, positive pitches the nose up; within ±15.
    Elevator(f64),
}

/// How fast the vehicle is driven.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Throttle {
    /// Through the water, metres a second.
    Speed(f64),
    /// The propeller's turns a minute.
    Rpm(f64),
}

/// The limits that the autopilot keeps, whatever the setpoints are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Bounds {
    /// The greatest depth allowed here, metres.
    pub(crate) depth_max_m: f64,
    /// The greatest speed through the water, metres a second.
    pub(crate) speed_max_mps: f64,
    /// The steepest pitch, degrees.
    pub(crate) pitch_max_deg: f64,
    /// The fastest climb and dive, metres a second.
    pub(crate) depth_rate_max_mps: f64,
    /// Depth rate per metre of depth error, per second.
    pub(crate) depth_gain_per_s: f64,
    /// The fastest turn, degrees a second.
    pub(crate) yaw_rate_max_dps: f64,
}

/// Nested control loops (Fossen 2021, chapter 15), where each inner loop is several times as fast as the one around it:
///
/// - heading: a reference model that turns no faster than the rudder can, then PID by pole placement, with the rudder
///   for the turn fed forward;
/// - depth: depth rate from the depth error, pitch from the depth rate, stern plane by PID on pitch, with the righting
///   moment fed forward;
/// - speed: the propeller's turns that hold the speed in straight flight, plus PI.
///
/// The gains follow the speed, as the force of the fins does. An integral does not grow while it would drive a fin
/// against its stop.
#[derive(Clone, Debug, Default)]
pub(crate) struct Autopilot {
    heading: Option<HeadingReference>,
    yaw_integral: f64,
    depth_rate_integral: f64,
    pitch_reference: Option<f64>,
    pitch_integral: f64,
    speed_integral: f64,
}

/// The heading and its rate that the vehicle should have now, radians.
#[derive(Clone, Copy, Debug)]
struct HeadingReference {
    heading: f64,
    rate: f64,
}

/// The least speed in the computation of the fins' force, metres a second. The force grows with the square of the
/// speed.
const AUTHORITY_LEAST_MPS: f64 = 0.5;
/// Rate of turn per rudder angle and speed, per metre. It comes from the steady turn of this model at 10 degrees of
/// rudder and 1.6 to 2.5 m/s: 2.2 to 2.5 degrees a second for each metre a second.
const TURN_PER_M: f64 = 0.235;
/// The fastest demanded turn, degrees a second for each metre a second. It takes two thirds of the rudder; the rest is
/// for corrections.
pub(super) const TURN_MAX_DEG_PER_M: f64 = 2.4;
/// Share of the stern planes that may hold a steady pitch; the rest is for corrections.
const PITCH_SHARE: f64 = 0.8;
/// Rate of turn per heading error, per second.
pub(super) const HEADING_GAIN_PER_S: f64 = 0.3;
const HEADING_LAG_S: f64 = 1.0;
/// The greatest difference between the heading reference and the heading, radians.
const HEADING_LEAD: f64 = 0.25;
const YAW_BANDWIDTH: f64 = 0.6;
const PITCH_BANDWIDTH: f64 = 1.2;
const DAMPING: f64 = 0.9;
/// The fastest change of the pitch reference, radians a second.
pub(super) const PITCH_RATE_MAX: f64 = 0.14;
/// Pitch per metre of depth that the depth rate has fallen short, radians per metre, at 1 m/s.
const DEPTH_RATE_INTEGRAL: f64 = 0.15;
/// The propeller's turns a minute per speed error of 1 m/s, and per metre of its integral.
const RPM_PER_MPS: f64 = 150.0;
const RPM_PER_M: f64 = 40.0;
/// The greatest contributions of the integrals: of a fin in degrees, of pitch in radians, of the propeller in turns a
/// minute.
const FIN_INTEGRAL_MAX_DEG: f64 = 5.0;
const PITCH_INTEGRAL_MAX: f64 = 0.17;
const RPM_INTEGRAL_MAX: f64 = 200.0;

impl Autopilot {
    /// The orders to fins and propeller, `dt_s` seconds after the last call. A heading, depth or pitch that is not
    /// finite is replaced by the present one, another setpoint by zero.
    #[must_use]
    pub(crate) fn command(&mut self, vehicle: &SixDof, setpoints: &Setpoints, bounds: &Bounds, dt_s: f64) -> Actuators {
        let speed_mps = vehicle.velocity()[0].max(AUTHORITY_LEAST_MPS);
        let setpoints = &setpoints.with_numbers(vehicle);
        Actuators {
            rudder_deg: self.rudder_deg(vehicle, setpoints.steering, bounds, speed_mps, dt_s),
            stern_plane_deg: self.stern_plane_deg(vehicle, setpoints.vertical, bounds, speed_mps, dt_s),
            propeller_rpm: self.propeller_rpm(vehicle, setpoints.throttle, bounds, dt_s),
        }
    }

    fn rudder_deg(&mut self, vehicle: &SixDof, steering: Steering, bounds: &Bounds, speed_mps: f64, dt_s: f64) -> f64 {
        let wanted_deg = match steering {
            Steering::Heading(heading_deg) => heading_deg,
            Steering::Rudder(rudder_deg) => {
                (self.heading, self.yaw_integral) = (None, 0.0);
                return rudder_deg;
            }
        };
        let coefficients = &vehicle.coefficients;
        let heading = vehicle.heading_deg().to_radians();
        let rate = vehicle.attitude_rates_dps().2.to_radians();
        let reference = self.heading.get_or_insert(HeadingReference { heading, rate });
        let rate_max = bounds
            .yaw_rate_max_dps
            .min(TURN_MAX_DEG_PER_M * speed_mps)
            .max(0.0)
            .to_radians();
        let left = wrap_180(wanted_deg - reference.heading.to_degrees()).to_radians();
        let rate_wanted = (HEADING_GAIN_PER_S * left).clamp(-rate_max, rate_max);
        reference.rate += (rate_wanted - reference.rate) * (dt_s / HEADING_LAG_S).min(1.0);
        reference.heading += reference.rate * dt_s;
        let ahead = wrap_180((reference.heading - heading).to_degrees()).to_radians();
        let error = ahead.clamp(-HEADING_LEAD, HEADING_LEAD);
        reference.heading = heading + error;
        let rate_error = reference.rate - rate;
        let inertia = coefficients.mass[5];
        let stiffness = inertia * YAW_BANDWIDTH * YAW_BANDWIDTH;
        let drag = (2.0 * DAMPING * YAW_BANDWIDTH * inertia - coefficients.damping[5]).max(0.0);
        let authority = coefficients.rudder * coefficients.fins_aft_m * speed_mps * speed_mps;
        let forward_deg = (reference.rate / (TURN_PER_M * speed_mps)).to_degrees();
        let correction_deg = ((stiffness * error + drag * rate_error) / authority).to_degrees();
        let integral_deg = (0.1 * YAW_BANDWIDTH * stiffness * error / authority).to_degrees() * dt_s;
        let fin_deg = forward_deg + correction_deg + self.yaw_integral;
        self.yaw_integral = integrated(self.yaw_integral, integral_deg, fin_deg, FIN_MAX_DEG)
            .clamp(-FIN_INTEGRAL_MAX_DEG, FIN_INTEGRAL_MAX_DEG);
        fin_deg.clamp(-FIN_MAX_DEG, FIN_MAX_DEG)
    }

    fn stern_plane_deg(
        &mut self,
        vehicle: &SixDof,
        vertical: Vertical,
        bounds: &Bounds,
        speed_mps: f64,
        dt_s: f64,
    ) -> f64 {
        let pitch_max = steepest_rad(&vehicle.coefficients, bounds, speed_mps);
        // The steepest dive from here that still levels out above the greatest depth.
        let floor_mps = bounds.depth_gain_per_s * (bounds.depth_max_m - vehicle.depth_m());
        let floor_pitch = pitch_for(floor_mps, speed_mps).clamp(-pitch_max, pitch_max);
        let (depth_m, moving_mps) = match vertical {
            Vertical::Depth(depth_m) => (depth_m, 0.0),
            Vertical::MovingDepth(depth_m, rate_mps) => (depth_m, rate_mps),
            Vertical::Pitch(pitch_deg) => {
                self.depth_rate_integral = 0.0;
                let pitch = pitch_deg.to_radians().clamp(-pitch_max, pitch_max).max(floor_pitch);
                return self.hold_pitch(vehicle, pitch, speed_mps, dt_s);
            }
            Vertical::Elevator(elevator_deg) => {
                let nose_down_deg = held_deg(vehicle, floor_pitch, 0.0, speed_mps);
                let nose_up_deg = held_deg(vehicle, pitch_max, 0.0, speed_mps);
                *self = Self {
                    heading: self.heading,
                    yaw_integral: self.yaw_integral,
                    speed_integral: self.speed_integral,
                    ..Self::default()
                };
                return (-elevator_deg).max(nose_up_deg).min(nose_down_deg);
            }
        };
        let most_mps = bounds.depth_rate_max_mps;
        let rate_mps = (bounds.depth_gain_per_s * (depth_m.max(0.0) - vehicle.depth_m()) + moving_mps)
            .min(floor_mps)
            .clamp(-most_mps, most_mps);
        let missed_mps = rate_mps - vehicle.ground_velocity().2;
        let pitch = pitch_for(rate_mps, speed_mps) - self.depth_rate_integral;
        let more = DEPTH_RATE_INTEGRAL / speed_mps * missed_mps * dt_s;
        // At the surface only the demand itself may point upwards. Otherwise the integral would keep the nose up for
        // ever.
        let afloat = vehicle.depth_m() <= 0.0 && more < 0.0;
        if !afloat {
            self.depth_rate_integral = integrated(self.depth_rate_integral, more, -pitch, pitch_max)
                .clamp(-PITCH_INTEGRAL_MAX, PITCH_INTEGRAL_MAX);
        }
        self.hold_pitch(vehicle, pitch.clamp(-pitch_max, pitch_max), speed_mps, dt_s)
    }

    fn hold_pitch(&mut self, vehicle: &SixDof, pitch: f64, speed_mps: f64, dt_s: f64) -> f64 {
        let now = vehicle.pitch_deg().to_radians();
        let reference = self.pitch_reference.get_or_insert(now);
        let most = PITCH_RATE_MAX * dt_s;
        let change = (pitch - *reference).clamp(-most, most);
        *reference += change;
        let (reference, rate) = (*reference, change / dt_s);
        let fin_deg = held_deg(vehicle, reference, rate, speed_mps) + self.pitch_integral;
        let stiffness = vehicle.coefficients.mass[4] * PITCH_BANDWIDTH * PITCH_BANDWIDTH;
        let more_deg =
            (0.1 * PITCH_BANDWIDTH * stiffness * (now - reference) / stern_authority(vehicle, speed_mps)).to_degrees();
        self.pitch_integral = integrated(self.pitch_integral, more_deg * dt_s, fin_deg, FIN_MAX_DEG)
            .clamp(-FIN_INTEGRAL_MAX_DEG, FIN_INTEGRAL_MAX_DEG);
        fin_deg.clamp(-FIN_MAX_DEG, FIN_MAX_DEG)
    }

    fn propeller_rpm(&mut self, vehicle: &SixDof, throttle: Throttle, bounds: &Bounds, dt_s: f64) -> f64 {
        let coefficients = &vehicle.coefficients;
        let rpm_max = rpm_for(coefficients, bounds.speed_max_mps).min(PROPELLER_MAX_RPM);
        let wanted_mps = match throttle {
            Throttle::Speed(speed_mps) => speed_mps.clamp(0.0, bounds.speed_max_mps),
            Throttle::Rpm(rpm) => {
                self.speed_integral = 0.0;
                return rpm.clamp(0.0, rpm_max);
            }
        };
        let error_mps = wanted_mps - vehicle.velocity()[0];
        let rpm = rpm_for(coefficients, wanted_mps) + RPM_PER_MPS * error_mps + self.speed_integral;
        // The integral compensates for the drag of fins and pitch. It does not act while the vehicle accelerates.
        if error_mps.abs() < 0.1 {
            self.speed_integral = integrated(
                self.speed_integral,
                RPM_PER_M * error_mps * dt_s,
                rpm,
                PROPELLER_MAX_RPM,
            )
            .clamp(-RPM_INTEGRAL_MAX, RPM_INTEGRAL_MAX);
        }
        rpm.clamp(0.0, PROPELLER_MAX_RPM)
    }
}

impl Setpoints {
    fn with_numbers(mut self, vehicle: &SixDof) -> Self {
        let or = |value: &mut f64, now: f64| {
            if !value.is_finite() {
                *value = now;
            }
        };
        match &mut self.steering {
            Steering::Heading(heading_deg) => or(heading_deg, vehicle.heading_deg()),
            Steering::Rudder(rudder_deg) => or(rudder_deg, 0.0),
        }
        match &mut self.vertical {
            Vertical::Depth(depth_m) => or(depth_m, vehicle.depth_m()),
            Vertical::MovingDepth(depth_m, rate_mps) => {
                or(depth_m, vehicle.depth_m());
                or(rate_mps, 0.0);
            }
            Vertical::Pitch(pitch_deg) => or(pitch_deg, vehicle.pitch_deg()),
            Vertical::Elevator(elevator_deg) => or(elevator_deg, 0.0),
        }
        match &mut self.throttle {
            Throttle::Speed(speed_mps) => or(speed_mps, 0.0),
            Throttle::Rpm(rpm) => or(rpm, 0.0),
        }
        self
    }
}

/// Adds to an integral, unless `output` is at its stop and the addition would push it further.
fn integrated(integral: f64, more: f64, output: f64, most: f64) -> f64 {
    let against = output.abs() >= most && output * more > 0.0;
    if against { integral } else { integral + more }
}

/// The pitch for a depth rate, radians, positive nose up.
fn pitch_for(depth_rate_mps: f64, speed_mps: f64) -> f64 {
    asin((-depth_rate_mps / speed_mps).clamp(-1.0, 1.0))
}

/// The steepest pitch that the stern planes can hold against the righting moment at a speed, and that the bounds allow.
fn steepest_rad(coefficients: &Coefficients, bounds: &Bounds, speed_mps: f64) -> f64 {
    let moment = coefficients.stern_plane * coefficients.fins_aft_m * speed_mps * speed_mps * FIN_MAX_DEG.to_radians();
    let by_fins = asin((PITCH_SHARE * moment / coefficients.righting_nm()).min(1.0));
    by_fins.min(bounds.pitch_max_deg.to_radians()).max(0.0)
}

/// Stern plane angle for a pitch and its rate, without the integral, degrees.
fn held_deg(vehicle: &SixDof, pitch: f64, rate: f64, speed_mps: f64) -> f64 {
    let coefficients = &vehicle.coefficients;
    let now = vehicle.pitch_deg().to_radians();
    let rate_now = vehicle.attitude_rates_dps().1.to_radians();
    let inertia = coefficients.mass[4];
    let stiffness = (inertia * PITCH_BANDWIDTH * PITCH_BANDWIDTH - coefficients.righting_nm()).max(0.0);
    let drag = (2.0 * DAMPING * PITCH_BANDWIDTH * inertia - coefficients.damping[4]).max(0.0);
    let nose_up_nm = coefficients.righting_nm() * sin(pitch)
        + coefficients.damping[4] * rate
        + stiffness * (pitch - now)
        + drag * (rate - rate_now);
    -(nose_up_nm / stern_authority(vehicle, speed_mps)).to_degrees()
}

/// Moment of the stern planes per radian, newton metres.
fn stern_authority(vehicle: &SixDof, speed_mps: f64) -> f64 {
    vehicle.coefficients.stern_plane * vehicle.coefficients.fins_aft_m * speed_mps * speed_mps
}

/// The propeller's turns a minute that hold a speed in straight flight, where thrust equals drag.
pub(super) fn rpm_for(coefficients: &Coefficients, speed_mps: f64) -> f64 {
    let drag = coefficients.half_rho_planform * coefficients.parasitic_drag * speed_mps * speed_mps
        + coefficients.damping[0] * exp(-3.0 * speed_mps) * speed_mps;
    let propeller = coefficients.propeller;
    let lost = propeller.thrust_lost * speed_mps;
    60.0 * (lost + (lost * lost + 4.0 * propeller.thrust * drag).sqrt()) / (2.0 * propeller.thrust)
}
