use core::fmt::Write;

use crate::event::{ModifyHorizontal, ModifySpeed, ModifyValues, ModifyVertical};
use crate::vehicle::performance::Performance;

/// What the vehicle does not fly of a modify because it is beyond its safe operating parameters (SPI 7.12), in words;
/// empty if it flies all of it.
///
/// The seabed counts at the place where the vehicle is now.
pub(super) fn clipped(
    values: &ModifyValues,
    performance: &Performance,
    altitude_min_m: f64,
    water_depth_m: f64,
) -> String {
    let mut words = Words::default();
    match values.horizontal {
        Some(ModifyHorizontal::Rudder(deg)) => {
            words.clip("rudder", deg, -performance.fin_max_deg, performance.fin_max_deg, "deg");
        }
        Some(ModifyHorizontal::Heading(_)) | None => {}
    }
    match values.vertical {
        None => {}
        Some(ModifyVertical::Depth(metres)) => {
            let floor_m = (water_depth_m - altitude_min_m).max(0.0);
            words.clip("depth", metres, 0.0, performance.depth_max_m.min(floor_m), "m");
        }
        Some(ModifyVertical::Altitude(metres)) => {
            words.clip(
                "altitude",
                metres,
                altitude_min_m,
                water_depth_m.max(altitude_min_m),
                "m",
            );
        }
        Some(ModifyVertical::Pitch(deg)) => {
            words.clip(
                "pitch",
                deg,
                -performance.pitch_max_deg,
                performance.pitch_max_deg,
                "deg",
            );
        }
        Some(ModifyVertical::Elevator(deg)) => {
            words.clip(
                "elevator",
                deg,
                -performance.fin_max_deg,
                performance.fin_max_deg,
                "deg",
            );
        }
    }
    // A speed of 0 stops the thruster. It is flown as it was asked for.
    let (least_mps, most_mps) = (performance.speed_min_mps, performance.speed_max_mps);
    match values.speed {
        Some(ModifySpeed::MetresPerSecond(mps)) if mps != 0.0 => words.clip("speed", mps, least_mps, most_mps, "m/s"),
        Some(ModifySpeed::Rpm(rpm)) if rpm != 0.0 => {
            let per_mps = performance.rpm_per_mps;
            words.clip("speed", rpm, least_mps * per_mps, most_mps * per_mps, "rpm");
        }
        Some(ModifySpeed::MetresPerSecond(_) | ModifySpeed::Rpm(_)) | None => {}
    }
    words.0
}

/// The text of an acknowledgement, which may not contain commas.
#[derive(Default)]
struct Words(String);

impl Words {
    fn clip(&mut self, name: &str, asked: f64, least: f64, most: f64, unit: &str) {
        let flown = asked.max(least).min(most);
        if flown.to_bits() == asked.to_bits() {
            return;
        }
        let separator = if self.0.is_empty() { "" } else { "; " };
        write!(self.0, "{separator}{name} {asked} {unit} clipped to {flown:.1} {unit}")
            .expect("a string takes every text");
    }
}
