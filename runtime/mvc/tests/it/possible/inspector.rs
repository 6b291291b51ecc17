//! The messages of hovering vehicles alone: relative navigation has the motion that BFNVG and BFNVR have.

use backseat_mvc::Activity;
use backseat_units::EastNorth;
use backseat_units::math::{hypot, sin_cos, wrap_180};

use super::Worst;
use super::log::heading_deg;
use super::record::{Flight, Step};

pub(super) fn check(flight: &Flight, exact: bool, worst: &mut Worst) {
    // Without bottom lock the velocity has errors that both messages share.
    ways(flight, if exact { 0.03 } else { 0.15 }, worst);
    if !exact {
        return;
    }
    let mut on_mission_s = 0.0;
    for step in &flight.steps {
        relative(flight, step, worst);
        on_mission_s += flight.dt_s;
        if step.truth.activity == Activity::Suspended {
            on_mission_s = 0.0;
        }
        // A servo returns to its place within 3 s.
        if let Some(servo) = &step.servo
            && on_mission_s > 4.5
        {
            worst.look("log looks down on a mission", servo.dvl_deg + 90.0, 0.001, flight, step);
        }
    }
}

/// Compares BFRNV and BFCNV with BFNVG.
fn relative(flight: &Flight, step: &Step, worst: &mut Worst) {
    let depth_m = step.navigation.depth.as_m();
    if let Some(cartesian) = &step.cartesian {
        worst.look("BFCNV's depth", cartesian.z_m - depth_m, 0.0015, flight, step);
    }
    let Some(relative) = &step.relative else { return };
    worst.look("BFRNV's depth", relative.depth_m - depth_m, 0.0015, flight, step);
    let rolled_deg = relative.roll_deg - step.navigation.roll_deg;
    worst.look("BFRNV's roll", rolled_deg, 0.0015, flight, step);
    if let Some(cartesian) = &step.cartesian {
        let turned_deg = wrap_180(cartesian.heading_deg - relative.heading_deg);
        worst.look("BFRNV's and BFCNV's heading", turned_deg, 0.0015, flight, step);
        worst.look(
            "BFRNV's and BFCNV's place",
            cartesian.y_m - relative.horizontal_m,
            0.0015,
            flight,
            step,
        );
    }
}

/// Checks that the way along x and y is that of BFNVR.
fn ways(flight: &Flight, most_m: f64, worst: &mut Worst) {
    for seconds in [5.0, 20.0] {
        for (first, last, sums) in flight.apart(seconds) {
            let (Some(from), Some(to)) = (&first.cartesian, &last.cartesian) else {
                continue;
            };
            let (sin, cos) = sin_cos((heading_deg(last) - to.heading_deg).to_radians());
            let EastNorth { east_m, north_m } = sums.way;
            let off_x_m = to.x_m - from.x_m - (east_m * sin + north_m * cos);
            let off_y_m = to.y_m - from.y_m - (east_m * cos - north_m * sin);
            worst.look("BFCNV by BFNVR", hypot(off_x_m, off_y_m), most_m, flight, last);
        }
    }
}
