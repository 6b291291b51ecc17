//! The figures of the REMUS 100, and the constants that follow from them.
//!
//! Sources, by the letters that the constants name:
//! - **F**: T. I. Fossen, *Handbook of Marine Craft Hydrodynamics and Motion Control*, 2nd ed., Wiley 2021, section
//!   8.4.2, and the same author's `remus100.m` (Marine Systems Simulator) and `remus100.py` (Python Vehicle Simulator)
//!   as calibrated in 2024.
//! - **A**: B. Allen, W. S. Vorus and T. Prestero, "Propulsion system performance enhancements on REMUS AUVs", OCEANS
//!   2000, pp. 1869-1873.
//! - **P**: T. Prestero, *Verification of a Six-Degree of Freedom Simulation Model for the REMUS Autonomous Underwater
//!   Vehicle*, MSc thesis, MIT and WHOI 2001: an earlier, shorter vehicle. The model does not use it, but the tests
//!   compare with its mass properties.

use core::f64::consts::PI;

use backseat_units::math::ln;

#[cfg(test)]
use super::forces::BodyVelocity;

/// Density of sea water, kg/m3 (F).
pub(super) const RHO_KG_PER_M3: f64 = 1026.0;
/// Acceleration of gravity, m/s2 (F).
const GRAVITY_MPS2: f64 = 9.81;
/// Length of the body, metres (F).
pub(super) const LENGTH_M: f64 = 1.6;
/// Diameter of the body, metres (F).
pub(super) const DIAMETER_M: f64 = 0.19;
/// The factor by which the spheroid in the model is larger than the body, so that it weighs 31.9 kg (F).
const SPHEROID_SCALE: f64 = 1.0096;
/// How far the centre of gravity lies below the centre of buoyancy, which is the origin, metres (F; P has 0.0196).
pub(super) const GRAVITY_BELOW_M: f64 = 0.02;
/// Added moment of inertia in roll as a share of the body's own (F).
const ROLL_ADDED_SHARE: f64 = 0.3;
/// Planform area as a share of length times diameter (F).
const PLANFORM_SHARE: f64 = 0.7;
/// Drag coefficient on the frontal area, of the vehicle with nose, fins and transducers (A, in F).
const FRONTAL_DRAG: f64 = 0.42;
/// Oswald's efficiency in the induced drag (F).
const OSWALD: f64 = 0.7;
/// Hoerner's two-dimensional cross-flow drag coefficient of a section as wide as it is high, interpolated on his curve
/// between the points (0.493, 1.211) and (0.558, 1.084) (F, section 6.4).
pub(super) const CROSS_FLOW_DRAG: f64 = 1.197_653;
/// Strips into which the body is divided for the cross-flow drag (F).
pub(super) const STRIPS: usize = 20;

/// Time constants of the linear damping at low speed, seconds (F).
const SURGE_DAMPING_S: f64 = 20.0;
const SWAY_DAMPING_S: f64 = 20.0;
const YAW_DAMPING_S: f64 = 1.0;
/// Relative damping ratios (F).
const ROLL_DAMPING: f64 = 0.3;
const PITCH_DAMPING: f64 = 0.8;

/// Area of the two fins on one axle, m2, and the derivatives of their lift, per radian (F).
const FINS_M2: f64 = 2.0 * 0.006_65;
const RUDDER_LIFT: f64 = 0.5;
const STERN_PLANE_LIFT: f64 = 0.7;
/// The greatest angle of a fin, degrees (F's autopilot; the hinges allow 20).
pub(super) const FIN_MAX_DEG: f64 = 15.0;
/// Time constant of a fin's servo, seconds (F).
pub(super) const FIN_LAG_S: f64 = 0.1;
/// The fastest turn of a fin, degrees a second. This is not published; it is typical of a small servo under load.
pub(super) const FIN_RATE_MAX_DPS: f64 = 60.0;
/// The greatest number of turns of the propeller a minute (A, F).
pub(super) const PROPELLER_MAX_RPM: f64 = 1525.0;
/// Time constant of the propeller, seconds (F).
pub(super) const PROPELLER_LAG_S: f64 = 1.0;

/// Diameter of the propeller, metres: 5.5 inches (A).
const PROPELLER_M: f64 = 0.14;
/// Share of the thrust that is lost because the body is in front of the propeller (F).
const THRUST_DEDUCTION: f64 = 0.1;
/// Speed of the water at the propeller as a share of the vehicle's (A).
const WAKE: f64 = 0.944;
/// Thrust and torque coefficients at advance number zero and at that of 2.5 m/s and 1525 turns a minute, from the
/// Wageningen series with three blades and an area ratio of 0.718 (F).
const THRUST_AT_REST: f64 = 0.4566;
const THRUST_AT_SPEED: f64 = 0.1798;
const TORQUE_AT_REST: f64 = 0.0700;
const TORQUE_AT_SPEED: f64 = 0.0312;
const ADVANCE_AT_SPEED: f64 = 0.6632;
/// Share of the propeller's torque that acts on the body, fitted to measured roll (F).
const TORQUE_SHARE: f64 = 0.1;

/// Depth over which the buoyancy in excess of the weight grows from zero to its full value, metres: one diameter. The
/// model has no body that floats half out of the water; this lets the vehicle come to rest at the surface.
pub(super) const BUOYANCY_FADES_M: f64 = DIAMETER_M;

/// The constants of the equations of motion, computed once.
///
/// Mass and inertia are about the origin, the centre of buoyancy. The body is symmetric and its centre of gravity is on
/// the vertical axis. So the mass matrix couples surge with pitch and sway with roll, and neither heave nor yaw with
/// anything.
#[derive(Clone, Copy, Debug)]
pub(super) struct Coefficients {
    pub(super) mass_kg: f64,
    pub(super) weight_n: f64,
    /// Inertia of the rigid body about the origin, kg m2: roll, pitch, yaw.
    pub(super) inertia: [f64; 3],
    /// Added mass and inertia: surge, sway, heave, roll, pitch, yaw.
    pub(super) added: [f64; 6],
    /// Diagonal of the whole mass matrix.
    pub(super) mass: [f64; 6],
    /// Mass times the distance of its centre below the origin, kg m: the only coupling in the mass matrix.
    pub(super) coupling: f64,
    /// Determinants of the two coupled blocks: surge with pitch, sway with roll.
    pub(super) surge_pitch: f64,
    pub(super) sway_roll: f64,
    /// Linear damping.
    pub(super) damping: [f64; 6],
    /// Half density times planform area.
    pub(super) half_rho_planform: f64,
    /// Drag coefficient without lift, relative to the planform area.
    pub(super) parasitic_drag: f64,
    /// Derivative of the body's lift coefficient, per radian, relative to the planform area.
    pub(super) lift: f64,
    /// Induced drag coefficient for a lift coefficient of one.
    pub(super) induced_drag: f64,
    /// Cross-flow drag of a strip, newtons for a squared speed of 1 m2/s2.
    pub(super) strip: f64,
    /// Lift of the fins for an angle of one radian and a squared speed of 1 m2/s2, newtons.
    pub(super) rudder: f64,
    pub(super) stern_plane: f64,
    /// Distance of the fins aft of the origin, metres.
    pub(super) fins_aft_m: f64,
    pub(super) propeller: Propeller,
}

/// Thrust and torque on the body. Each is a constant times turns^2, minus another (`_lost`) times turns times speed.
#[derive(Clone, Copy, Debug)]
pub(super) struct Propeller {
    pub(super) thrust: f64,
    pub(super) thrust_lost: f64,
    pub(super) torque: f64,
    pub(super) torque_lost: f64,
}

impl Coefficients {
    pub(super) fn remus_100() -> Self {
        let (a, b) = (0.5 * SPHEROID_SCALE * LENGTH_M, 0.5 * SPHEROID_SCALE * DIAMETER_M);
        let mass_kg = 4.0 / 3.0 * PI * RHO_KG_PER_M3 * a * b * b;
        // A spheroid of uniform density.
        let (roll, pitch) = (0.4 * mass_kg * b * b, 0.2 * mass_kg * (a * a + b * b));
        // Lamb's k-factors of a prolate spheroid (Imlay 1961; F).
        let e2 = 1.0 - (b / a) * (b / a);
        let e = e2.sqrt();
        let logarithm = ln((1.0 + e) / (1.0 - e));
        let alpha = 2.0 * (1.0 - e2) / (e2 * e) * (0.5 * logarithm - e);
        let beta = 1.0 / e2 - (1.0 - e2) / (2.0 * e2 * e) * logarithm;
        let along = alpha / (2.0 - alpha);
        let across = beta / (2.0 - beta);
        let turning = e2 * e2 * (beta - alpha) / ((2.0 - e2) * (2.0 * e2 - (2.0 - e2) * (beta - alpha)));
        let added = [
            mass_kg * along,
            mass_kg * across,
            mass_kg * across,
            ROLL_ADDED_SHARE * roll,
            turning * pitch,
            turning * pitch,
        ];
        let shift = mass_kg * GRAVITY_BELOW_M * GRAVITY_BELOW_M;
        let inertia = [roll + shift, pitch + shift, pitch];
        let mass = [
            mass_kg + added[0],
            mass_kg + added[1],
            mass_kg + added[2],
            inertia[0] + added[3],
            inertia[1] + added[4],
            inertia[2] + added[5],
        ];
        let coupling = mass_kg * GRAVITY_BELOW_M;
        let weight_n = mass_kg * GRAVITY_MPS2;
        let righting = weight_n * GRAVITY_BELOW_M;
        let planform_m2 = PLANFORM_SHARE * LENGTH_M * DIAMETER_M;
        let aspect = DIAMETER_M * DIAMETER_M / planform_m2;
        let diameters = PROPELLER_M * PROPELLER_M * PROPELLER_M;
        let thrust = (1.0 - THRUST_DEDUCTION) * RHO_KG_PER_M3 * diameters * PROPELLER_M;
        let torque = TORQUE_SHARE * RHO_KG_PER_M3 * diameters * PROPELLER_M * PROPELLER_M;
        let advance = WAKE / PROPELLER_M / ADVANCE_AT_SPEED;
        Self {
            mass_kg,
            weight_n,
            inertia,
            added,
            mass,
            coupling,
            surge_pitch: mass[0] * mass[4] - coupling * coupling,
            sway_roll: mass[1] * mass[3] - coupling * coupling,
            damping: [
                mass[0] / SURGE_DAMPING_S,
                mass[1] / SWAY_DAMPING_S,
                mass[2] / SWAY_DAMPING_S,
                2.0 * ROLL_DAMPING * (righting * mass[3]).sqrt(),
                2.0 * PITCH_DAMPING * (righting * mass[4]).sqrt(),
                mass[5] / YAW_DAMPING_S,
            ],
            half_rho_planform: 0.5 * RHO_KG_PER_M3 * planform_m2,
            parasitic_drag: FRONTAL_DRAG * PI * b * b / planform_m2,
            lift: PI * aspect / (1.0 + (1.0 + 0.25 * aspect * aspect).sqrt()),
            induced_drag: 1.0 / (PI * OSWALD * aspect),
            strip: 0.5 * RHO_KG_PER_M3 * DIAMETER_M * CROSS_FLOW_DRAG * LENGTH_M / STRIPS as f64,
            rudder: 0.5 * RHO_KG_PER_M3 * FINS_M2 * RUDDER_LIFT,
            stern_plane: 0.5 * RHO_KG_PER_M3 * FINS_M2 * STERN_PLANE_LIFT,
            fins_aft_m: a,
            propeller: Propeller {
                thrust: thrust * THRUST_AT_REST,
                thrust_lost: thrust * (THRUST_AT_REST - THRUST_AT_SPEED) * advance,
                torque: torque * TORQUE_AT_REST,
                torque_lost: torque * (TORQUE_AT_REST - TORQUE_AT_SPEED) * advance,
            },
        }
    }

    /// The righting moment at an inclination of 90 degrees, newton metres.
    pub(super) fn righting_nm(&self) -> f64 {
        self.weight_n * GRAVITY_BELOW_M
    }

    /// Kinetic energy through the water, joules.
    #[cfg(test)]
    pub(super) fn kinetic_j(&self, velocity: &BodyVelocity) -> f64 {
        let [u, v, _, p, q, _]: [f64; 6] = (*velocity).into();
        let diagonal: f64 = self
            .mass
            .iter()
            .zip(velocity)
            .map(|(mass, rate)| mass * rate * rate)
            .sum();
        0.5 * diagonal + self.coupling * (u * q - v * p)
    }

    /// Potential energy of the centre of gravity, joules; `down_z` is the cosine of the inclination from upright.
    #[cfg(test)]
    pub(super) fn righting_j(&self, down_z: f64) -> f64 {
        self.righting_nm() * (1.0 - down_z)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Fossen's function prints 31.9 kg. Prestero's thesis (tables of the final coefficients) has measured or estimated
    /// values for his shorter vehicle: mass 30.5 kg, added mass 0.93 kg in surge and 35.5 kg in sway, inertia 3.45 kg
    /// m2 in pitch with 4.88 added, 0.177 kg m2 in roll with 0.0704 added. These are two derivations for the same body.
    /// They agree within a sixth for translation and pitch, and within a third for roll, where Fossen assumes a
    /// spheroid.
    #[test]
    fn mass_agrees_with_both_publications() {
        let coefficients = Coefficients::remus_100();
        assert!((coefficients.mass_kg - 31.9).abs() < 0.05, "{}", coefficients.mass_kg);
        let thesis = [
            30.48 + 0.93,
            30.48 + 35.5,
            30.48 + 35.5,
            0.177 + 0.0704,
            3.45 + 4.88,
            3.45 + 4.88,
        ];
        for (i, (mass, thesis)) in coefficients.mass.into_iter().zip(thesis).enumerate() {
            let limit = if i == 3 { 0.34 } else { 0.17 };
            assert!((mass / thesis - 1.0).abs() < limit, "{i}: {mass} {thesis}");
        }
    }
}
