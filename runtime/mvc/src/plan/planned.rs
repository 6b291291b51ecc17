//! A front seat's plan as it will be flown, for whoever checks it ashore.

use core::time::Duration;

use backseat_units::{LocalFrame, Position};

use crate::error::MvcError;
use crate::file::{PlanEntry, VehicleConfig};
use crate::plan::{Shape, resolve};
use crate::vehicle::Vertical;

/// A behavior of a plan, in the order of flight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlannedBehavior {
    /// Behavior number in the dive file, from 1 (SPI 6.9).
    pub number: u32,
    /// The element of the plan's file that it belongs to, from 1.
    pub element: u32,
    /// Where it leads.
    pub path: PlannedPath,
    /// What it holds vertically.
    pub vertical: PlannedVertical,
    /// Through the water, metres a second; 0 where nothing moves.
    pub speed_mps: f64,
    /// It ends by itself after so long.
    pub timeout: Option<Duration>,
}

/// Where a behavior leads.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PlannedPath {
    /// Straight there.
    Waypoint {
        /// Where to.
        to: Position,
    },
    /// To a line's begin, and along it, lead-in and lead-out included.
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
        /// How often round; negative counterclockwise.
        orbits: f64,
        /// Where on it the vehicle begins, degrees clockwise from true north as seen from the centre; the nearest
        /// place where it is absent.
        entry_deg: Option<f64>,
    },
    /// A heading for a time.
    Heading {
        /// Degrees from true north.
        heading_deg: f64,
        /// For so long.
        duration: Duration,
    },
    /// It leads nowhere.
    Nowhere,
}

/// What a behavior holds vertically, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PlannedVertical {
    /// Below the surface.
    Depth(f64),
    /// Above the seabed.
    Altitude(f64),
}

/// The behaviors of a plan whose places count from an origin.
///
/// # Errors
/// [`MvcError::Plan`] names the element that this vehicle cannot fly, or that is written wrong.
pub fn planned_behaviors(
    entries: &[PlanEntry],
    origin: Position,
    vehicle: &VehicleConfig,
) -> Result<Vec<PlannedBehavior>, MvcError> {
    let frame = LocalFrame::new(origin);
    let place = |point| frame.to_position(point);
    let items = resolve(entries, &frame, vehicle)?;
    let behaviors = items.into_iter().map(|item| PlannedBehavior {
        number: item.number,
        element: item.element,
        path: match item.shape.with_leads(item.lead_m) {
            Shape::Waypoint { to } | Shape::GpsHit { at: to, .. } => PlannedPath::Waypoint { to: place(to) },
            Shape::Trackline { start, end } => PlannedPath::Line {
                start: place(start),
                end: place(end),
            },
            Shape::Trackcircle {
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
            Shape::Setpoint { heading_deg, duration } => PlannedPath::Heading { heading_deg, duration },
            Shape::Command | Shape::Idle => PlannedPath::Nowhere,
        },
        vertical: match item.vertical {
            Vertical::Depth(depth_m) => PlannedVertical::Depth(depth_m),
            Vertical::Altitude(altitude_m) => PlannedVertical::Altitude(altitude_m),
            // No plan has one: it could come to any depth.
            Vertical::Pitch(_) | Vertical::Elevator(_) => PlannedVertical::Depth(f64::INFINITY),
        },
        speed_mps: item.speed_mps,
        timeout: item.timeout,
    });
    Ok(behaviors.collect())
}
