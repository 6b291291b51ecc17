//! Compares the Doppler log with BFNVG and BFNVR, and that of a hovering vehicle with its servo, for flights whose
//! navigation is exact.

use backseat_units::math::{cos, sin, sin_cos};
use backseat_units::utm_convergence_deg;

use super::Worst;
use super::record::{Flight, Step};

/// The ship of `mission.rs`: half of its length, its draft, metres.
const HALF_LENGTH_M: f64 = 15.0;
const DRAFT_M: f64 = 5.0;

/// The direction of a beam of the log: 30 degrees from its axis. When the log looks down, the beams point 45 degrees to
/// both sides of ahead and of aft.
fn beam(number: usize, look_deg: f64) -> [f64; 3] {
    let azimuth = (45.0 + 90.0 * number as f64).to_radians();
    let [x, y, z] = [0.5 * cos(azimuth), 0.5 * sin(azimuth), cos(30.0_f64.to_radians())];
    let (sin, cos) = sin_cos((look_deg + 90.0).to_radians());
    [x * cos + z * sin, y, z * cos - x * sin]
}

/// Turns a vector from the vehicle's axes into a level frame that has the vehicle's heading.
fn level([x, y, z]: [f64; 3], step: &Step) -> [f64; 3] {
    let (sin, cos) = sin_cos(step.navigation.roll_deg.to_radians());
    let (y, z) = (y * cos - z * sin, y * sin + z * cos);
    let (sin, cos) = sin_cos(step.navigation.pitch_deg.to_radians());
    [x * cos + z * sin, y, z * cos - x * sin]
}

/// The heading from true north, which is the frame's north here. BFNVG counts from grid north.
pub(super) fn heading_deg(step: &Step) -> f64 {
    step.navigation.heading.as_deg() + utm_convergence_deg(step.navigation.position)
}

pub(super) fn check(flight: &Flight, worst: &mut Worst) {
    for step in &flight.steps {
        check_step(flight, step, worst);
    }
}

fn check_step(flight: &Flight, step: &Step, worst: &mut Worst) {
    let Some(dvl) = &step.dvl else { return };
    let (sin, cos) = sin_cos(heading_deg(step).to_radians());
    let (east, north) = (step.velocity.east_mps, step.velocity.north_mps);
    let told = [
        north * cos + east * sin,
        east * cos - north * sin,
        step.velocity.down_mps,
    ];
    if let [Some(x), Some(y), Some(z)] = dvl.velocity_mps {
        for (measured, told) in level([x, y, z], step).into_iter().zip(told) {
            worst.look("log's velocity", measured - told, 0.004, flight, step);
        }
    }
    // Torpedoes have no servo, and BFDV2 has axes instead of beams.
    let (Some(beams), Some(servo)) = (&step.beams, &step.servo) else {
        return;
    };
    for number in 0..4 {
        let along = level(beam(number, servo.dvl_deg), step);
        if let Some(measured) = beams.velocity_mps[number] {
            let told: f64 = along.iter().zip(told).map(|(way, mps)| way * mps).sum();
            worst.look("log's beams", measured - told, 0.003, flight, step);
        }
        let (Some(range_m), Some(relative)) = (dvl.ranges_m[number], &step.relative) else {
            continue;
        };
        // The beam ends on the inspected side of the ship, or on the bottom.
        let (sin, cos) = sin_cos(relative.heading_deg.to_radians());
        let towards_m = range_m * (along[0] * cos - along[1] * sin);
        let aside_m = relative.horizontal_m + range_m * (along[0] * sin + along[1] * cos);
        let down_m = range_m * along[2];
        let on_side = aside_m.abs() < HALF_LENGTH_M - 0.1 && relative.depth_m + down_m < DRAFT_M - 0.1;
        if servo.dvl_deg > -1.0 && on_side && relative.distance_m > 0.0 {
            worst.look(
                "log's range to the ship",
                towards_m - relative.distance_m,
                0.08,
                flight,
                step,
            );
        }
        // In front of the ship's side, a beam of a log that looks down ends on the bottom.
        if let Some(altitude) = step.navigation.altitude
            && servo.dvl_deg < -89.0
            && relative.depth_m + down_m > DRAFT_M + 0.1
        {
            worst.look(
                "log's range to the bottom",
                down_m - altitude.as_m(),
                0.35,
                flight,
                step,
            );
        }
    }
}
