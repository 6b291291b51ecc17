//! A front seat's plan as it will be flown, for checks before a dive.

use core::time::Duration;

use backseat_units::{LocalFrame, Position};

use crate::class::VehicleLimits;
use crate::element::{Course, PlannedVertical, resolve, with_leads};
use crate::entry::PlanEntry;
use crate::error::PlanError;

/// A behavior of a plan, in the order of flight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlannedBehavior {
    /// Behavior number in the dive file, from 1 (SPI 6.9).
    pub number: u32,
    /// The element of the plan's file that it belongs to, from 1.
    pub element: u32,
    /// The path.
    pub path: PlannedPath,
    /// The vertical setpoint.
    pub vertical: PlannedVertical,
    /// Speed through the water, metres a second; 0 if the vehicle does not move.
    pub speed_mps: f64,
    /// The behavior ends by itself after this time.
    pub timeout: Option<Duration>,
}

/// The path of a behavior.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PlannedPath {
    /// Straight to a point.
    Waypoint {
        /// The destination.
        to: Position,
    },
    /// To the beginning of a line and along it, including lead-in and lead-out.
    Line {
        /// Where the lead-in begins.
        start: Position,
        /// Where the lead-out ends.
        end: Position,
    },
    /// To a circle and around it.
    Circle {
        /// Its centre.
        centre: Position,
        /// Its radius, metres.
        radius_m: f64,
        /// The number of rounds; negative is counterclockwise.
        orbits: f64,
        /// Where on the circle the vehicle begins, degrees clockwise from true north as seen from the centre; the
        /// nearest point if missing.
        entry_deg: Option<f64>,
    },
    /// A heading for some time.
    Heading {
        /// Degrees from true north.
        heading_deg: f64,
        /// The time.
        duration: Duration,
    },
    /// No path.
    Nowhere,
}

/// The behaviors of a plan whose positions are relative to an origin.
///
/// # Errors
///
/// [`PlanError`] with the element that is invalid or that this vehicle cannot fly.
pub fn planned_behaviors(
    entries: &[PlanEntry],
    origin: Position,
    vehicle: &VehicleLimits,
) -> Result<Vec<PlannedBehavior>, PlanError> {
    let frame = LocalFrame::new(origin);
    let place = |point| frame.to_position(point);
    let items = resolve(entries, &frame, vehicle)?;
    let behaviors = items.into_iter().map(|item| PlannedBehavior {
        number: item.number,
        element: item.element,
        path: match item.course {
            Course::Waypoint { to } => PlannedPath::Waypoint { to: place(to) },
            Course::Trackline { start, end } => {
                let (start, end) = with_leads(start, end, item.lead_m);
                PlannedPath::Line {
                    start: place(start),
                    end: place(end),
                }
            }
            Course::Trackcircle {
                centre,
                radius_m,
                orbits,
                entry_deg,
            } => PlannedPath::Circle {
                centre: place(centre),
                radius_m,
                orbits,
                entry_deg: entry_deg.map(|entry_deg| entry_deg + frame.convergence_deg(place(centre))),
            },
            Course::Setpoint { heading_deg, duration } => PlannedPath::Heading { heading_deg, duration },
            Course::Command => PlannedPath::Nowhere,
        },
        vertical: item.vertical,
        speed_mps: item.speed_mps,
        timeout: item.timeout,
    });
    Ok(behaviors.collect())
}

#[cfg(test)]
mod tests {
    use serde::Deserialize;

    use super::*;
    use crate::class::VehicleClass;

    #[derive(Deserialize)]
    struct File {
        plan: Vec<PlanEntry>,
    }

    fn read(text: &str, vehicle: &VehicleLimits) -> Result<Vec<PlannedBehavior>, PlanError> {
        let file: File = toml::from_str(text).expect("a plan as in a file");
        planned_behaviors(&file.plan, Position::from_deg(42.0, -70.0).expect("at sea"), vehicle)
    }

    const LINE: &str = "[[plan]]\nkind = \"trackline\"\nstart = { east_m = 0, north_m = 0 }\n\
                        end = { east_m = 100, north_m = 0 }\nlead_in_m = 20\nseparate_transit = true\n\
                        depth_m = 8\nspeed_mps = 1.5\n";

    #[test]
    fn a_line_is_told_with_its_leads_and_the_way_to_it() {
        let behaviors = read(LINE, &VehicleClass::TwelveInch.limits()).expect("it can be flown");
        let [way, line] = &behaviors[..] else {
            panic!("two behaviors: {behaviors:?}");
        };
        assert_eq!((way.number, way.element, line.number, line.element), (1, 1, 2, 1));
        let PlannedPath::Line { start, end } = line.path else {
            panic!("a line: {line:?}");
        };
        assert_eq!(way.path, PlannedPath::Waypoint { to: start });
        let frame = LocalFrame::new(Position::from_deg(42.0, -70.0).expect("at sea"));
        assert!((frame.to_local(start).distance_m(frame.to_local(end)) - 140.0).abs() < 1e-6);
    }

    #[test]
    fn what_a_vehicle_cannot_fly_is_told_with_the_element() {
        let error = |text: &str, vehicle: &VehicleLimits| read(text, vehicle).expect_err("a fault").to_string();
        assert_eq!(
            error(LINE, &VehicleClass::Hovering.limits()),
            "plan element 1: speed_mps is 1.5, expected 0.05 to 0.75"
        );
        let deep = LINE.replace("depth_m = 8", "depth_m = 300");
        assert_eq!(
            error(&deep, &VehicleClass::NineInch.limits()),
            "plan element 1: depth_m is 300, expected 0 to 200"
        );
        assert!(read(&deep, &VehicleLimits::of_any_class()).is_ok());
        assert_eq!(
            error("plan = []", &VehicleLimits::of_any_class()),
            "plan is 0 elements, expected 1 to 10000 elements"
        );
    }
}
