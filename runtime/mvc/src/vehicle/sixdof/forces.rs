use backseat_units::math::exp;
use nalgebra::{Vector3, Vector6};

use super::actuators::Actuators;
use super::coefficients::{Coefficients, LENGTH_M, STRIPS};

/// Velocity through the water in the body's axes: forward, to starboard, down (metres a second), roll, pitch, yaw
/// (radians a second).
pub(super) type BodyVelocity = Vector6<f64>;

/// Rate of change of the velocity through the water. `down` is the direction down in the body's axes, `tail` the state
/// of the tail, and `excess_n` the buoyancy in excess of the weight, newtons.
///
/// In a constant irrotational current, the equations in the velocity through the water are those of still water (Fossen
/// 2021, section 8.1). So nothing here depends on the current.
pub(super) fn acceleration(
    coefficients: &Coefficients,
    velocity: &BodyVelocity,
    down: Vector3<f64>,
    tail: Actuators,
    excess_n: f64,
) -> BodyVelocity {
    let mut force = BodyVelocity::zeros();
    inertial(coefficients, velocity, &mut force);
    damping(coefficients, velocity, &mut force);
    lift_and_drag(coefficients, velocity, &mut force);
    cross_flow(coefficients, velocity, &mut force);
    restoring(coefficients, down, excess_n, &mut force);
    tail_forces(coefficients, velocity, tail, &mut force);
    divided_by_mass(coefficients, &force)
}

/// Excess of buoyancy over weight with which the vehicle floats up at `rise_mps` while level, newtons. It equals the
/// drag at that speed.
pub(super) fn excess_for_rise(coefficients: &Coefficients, rise_mps: f64) -> f64 {
    let velocity = BodyVelocity::new(0.0, 0.0, -rise_mps.abs(), 0.0, 0.0, 0.0);
    let mut force = BodyVelocity::zeros();
    damping(coefficients, &velocity, &mut force);
    lift_and_drag(coefficients, &velocity, &mut force);
    cross_flow(coefficients, &velocity, &mut force);
    force[2]
}

/// Coriolis and centripetal forces of the body, in the form that does not use the linear velocity (Fossen 2021, section
/// 3.3.1), and of the added mass.
///
/// As published, the terms of the added mass that couple surge, sway and heave with pitch and yaw are left out, among
/// them the Munk moment. Without quadratic damping of the rotation they make the model unstable. The omitted terms are
/// skew-symmetric, so the energy balance stays right.
fn inertial(coefficients: &Coefficients, velocity: &BodyVelocity, force: &mut BodyVelocity) {
    let [u, v, w, p, q, r]: [f64; 6] = (*velocity).into();
    let mass = coefficients.mass_kg;
    let below = coefficients.coupling / mass;
    // Velocity of the centre of gravity (`gu`, `gv`) and of the origin, each in a cross product with the rotation.
    let (gu, gv) = (u + q * below, v - p * below);
    force[0] -= mass * (q * w - r * gv);
    force[1] -= mass * (r * gu - p * w);
    force[2] -= mass * (p * gv - q * gu);
    let (cross_x, cross_y) = (q * w - r * v, r * u - p * w);
    let [ix, iy, iz] = coefficients.inertia;
    force[3] -= -coefficients.coupling * cross_y + (iz - iy) * q * r;
    force[4] -= coefficients.coupling * cross_x + (ix - iz) * p * r;
    force[5] -= (iy - ix) * p * q;
    let [_, ay, az, ap, aq, ar] = coefficients.added;
    force[1] += az * w * p;
    force[2] -= ay * v * p;
    force[3] += (ay - az) * v * w - (ar - aq) * q * r;
    force[4] += (ar - ap) * p * r;
    force[5] -= (aq - ap) * p * q;
}

/// Linear damping. In surge and sway it fades with growing speed, where drag and cross-flow take over.
fn damping(coefficients: &Coefficients, velocity: &BodyVelocity, force: &mut BodyVelocity) {
    let [u, v, w, ..]: [f64; 6] = (*velocity).into();
    let faded = exp(-3.0 * (u * u + v * v + w * w).sqrt());
    for (i, ((force, damping), velocity)) in force.iter_mut().zip(coefficients.damping).zip(velocity).enumerate() {
        let share = if i < 2 { faded } else { 1.0 };
        *force -= share * damping * velocity;
    }
}

/// Lift and drag of the body in its vertical plane, as of a wing of low aspect ratio (Beard and McLain 2012, chapter
/// 4).
///
/// The published model uses the angle of attack a itself. This one uses sin a cos a, which is the same within 1 % up to
/// 7 degrees, and zero at 90 degrees, where a lift that grows with the angle makes no sense. So a level vehicle that
/// floats up is not driven forward.
fn lift_and_drag(coefficients: &Coefficients, velocity: &BodyVelocity, force: &mut BodyVelocity) {
    let [u, v, w, ..]: [f64; 6] = (*velocity).into();
    let in_plane2 = u * u + w * w;
    if in_plane2 < 1e-12 {
        return;
    }
    let in_plane = in_plane2.sqrt();
    let (sin, cos) = (w / in_plane, u / in_plane);
    let lift = coefficients.lift * sin * cos;
    let drag = coefficients.parasitic_drag + coefficients.induced_drag * lift * lift;
    let pressure = coefficients.half_rho_planform * (in_plane2 + v * v);
    force[0] += pressure * (sin * lift - cos * drag);
    force[2] -= pressure * (sin * drag + cos * lift);
}

/// Drag of the water that flows across the body, in strips (Fossen 2021, section 6.4). It acts in the horizontal plane
/// and, because the body is round, in the same way in the vertical plane.
fn cross_flow(coefficients: &Coefficients, velocity: &BodyVelocity, force: &mut BodyVelocity) {
    let [_, v, w, _, q, r]: [f64; 6] = (*velocity).into();
    let (mut sway, mut heave, mut pitch, mut yaw) = (0.0, 0.0, 0.0, 0.0);
    for i in 0..STRIPS {
        let x = LENGTH_M * ((i as f64 + 0.5) / STRIPS as f64 - 0.5);
        let (across, through) = (v + x * r, w - x * q);
        let (across, through) = (across.abs() * across, through.abs() * through);
        sway += across;
        yaw += x * across;
        heave += through;
        pitch += x * through;
    }
    force[1] -= coefficients.strip * sway;
    force[2] -= coefficients.strip * heave;
    force[4] += coefficients.strip * pitch;
    force[5] -= coefficients.strip * yaw;
}

fn restoring(coefficients: &Coefficients, down: Vector3<f64>, excess_n: f64, force: &mut BodyVelocity) {
    for (force, down) in force.iter_mut().zip(&down) {
        *force -= excess_n * down;
    }
    let righting = coefficients.righting_nm();
    force[3] -= righting * down.y;
    force[4] += righting * down.x;
}

fn tail_forces(coefficients: &Coefficients, velocity: &BodyVelocity, tail: Actuators, force: &mut BodyVelocity) {
    let [u, v, w, ..]: [f64; 6] = (*velocity).into();
    let turns = tail.propeller_rpm / 60.0;
    let propeller = coefficients.propeller;
    let speed = (u * u + v * v + w * w).sqrt();
    // As published, braking does not depend on the advance.
    let lost = if turns > 0.0 { turns * speed } else { 0.0 };
    force[0] += propeller.thrust * turns.abs() * turns - propeller.thrust_lost * lost;
    force[3] += propeller.torque * turns.abs() * turns - propeller.torque_lost * lost;
    let (rudder, stern_plane) = (tail.rudder_deg.to_radians(), tail.stern_plane_deg.to_radians());
    let across = coefficients.rudder * (u * u + v * v) * rudder;
    let up = coefficients.stern_plane * (u * u + w * w) * stern_plane;
    force[0] -= across * rudder + up * stern_plane;
    force[1] -= across;
    force[2] -= up;
    force[4] -= coefficients.fins_aft_m * up;
    force[5] += coefficients.fins_aft_m * across;
}

/// Multiplies by the inverse of the mass matrix in closed form. By symmetry, the 36 elements reduce to two blocks of 2
/// by 2 and two single elements.
fn divided_by_mass(coefficients: &Coefficients, force: &BodyVelocity) -> BodyVelocity {
    let [x, y, z, k, m, n]: [f64; 6] = (*force).into();
    let [mx, my, mz, mk, mm, mn] = coefficients.mass;
    let c = coefficients.coupling;
    BodyVelocity::new(
        (mm * x - c * m) / coefficients.surge_pitch,
        (mk * y + c * k) / coefficients.sway_roll,
        z / mz,
        (my * k + c * y) / coefficients.sway_roll,
        (mx * m - c * x) / coefficients.surge_pitch,
        n / mn,
    )
}
