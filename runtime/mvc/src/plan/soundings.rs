use backseat_units::{EastNorth, Position};
use backseat_world::World;

use crate::error::MvcError;
use crate::plan::{PlanItem, Shape};
use crate::vehicle::Vertical;

/// How much more water than its least altitude a vehicle needs, metres, to be under water at all.
const ROOM_M: f64 = 0.5;
/// The distance from one checked place to the next, metres. A drawn seabed changes over 20 m or more.
const EVERY_M: f64 = 10.0;
/// The same over a grid, whose cells are often small.
const EVERY_CHARTED_M: f64 = 2.0;
/// The most places that are checked; on a longer plan they are further apart.
const PLACES_MAX: f64 = 1e6;

/// Refuses a plan that leads through water that is too shallow, or off the grid. [`crate::Mvc::with_grid`] documents
/// the rules. `start` is where the vehicle begins, if that is known.
pub(crate) fn check(
    plan: &[PlanItem],
    start: Option<EastNorth>,
    world: &World,
    altitude_min_m: f64,
    charted: bool,
) -> Result<(), MvcError> {
    let mut length_m = 0.0;
    along(plan, start, &mut |_, path| {
        length_m += path.length_m();
        Ok(())
    })?;
    let every_m = if charted { EVERY_CHARTED_M } else { EVERY_M };
    let every_m = every_m.max(length_m / PLACES_MAX);
    along(plan, start, &mut |item, path| {
        let least_m = altitude_min_m + ROOM_M;
        let planned_m = match item.vertical {
            Vertical::Depth(depth_m) => depth_m,
            Vertical::Altitude(_) | Vertical::Pitch(_) | Vertical::Elevator(_) => 0.0,
        };
        let needed_m = least_m.max(planned_m);
        let fault = path.places(every_m).find_map(|at| {
            if !world.seabed().is_known_at(at) {
                Some(beyond_the_grid(world, at))
            } else if world.water_depth_m(at) < needed_m {
                Some(too_shallow(world, at, needed_m, planned_m > least_m))
            } else {
                None
            }
        });
        fault.map_or(Ok(()), |fault| {
            let number = item.element;
            Err(MvcError::Plan { number, fault })
        })
    })
}

/// Refuses a start below the seabed, or off the grid.
pub(crate) fn check_start(start: EastNorth, depth_m: f64, world: &World) -> Result<(), MvcError> {
    if !world.seabed().is_known_at(start) {
        return Err(MvcError::Value {
            key: "start",
            value: place(world, start),
            expected: "a place on the grid of the seabed",
        });
    }
    let water_m = world.water_depth_m(start);
    if depth_m <= water_m {
        return Ok(());
    }
    Err(MvcError::Value {
        key: "start.depth_m",
        value: format!("{depth_m} in {water_m:.2} m of water"),
        expected: "at most the water's depth",
    })
}

fn beyond_the_grid(world: &World, at: EastNorth) -> String {
    format!("it leads off the grid of the seabed at {}", place(world, at))
}

fn place(world: &World, at: EastNorth) -> String {
    let position: Position = world.frame().to_position(at);
    format!(
        "{:.0} m east, {:.0} m north (latitude {:.5}, longitude {:.5})",
        at.east_m,
        at.north_m,
        position.latitude.as_deg(),
        position.longitude.as_deg(),
    )
}

fn too_shallow(world: &World, at: EastNorth, needed_m: f64, planned: bool) -> String {
    format!(
        "the water is {:.2} m deep at {}, expected at least {needed_m:.2} m: {}",
        world.water_depth_m(at),
        place(world, at),
        if planned {
            "the element's depth"
        } else {
            "vehicle.altitude_min_m plus 0.5 m"
        }
    )
}

#[derive(Clone, Copy, Debug)]
enum Path {
    Line(EastNorth, EastNorth),
    Circle(EastNorth, f64),
}

impl Path {
    fn length_m(self) -> f64 {
        match self {
            Self::Line(from, to) => from.distance_m(to),
            Self::Circle(_, radius_m) => core::f64::consts::TAU * radius_m,
        }
    }

    /// Both ends, and places between them that are at most `every_m` apart.
    fn places(self, every_m: f64) -> impl Iterator<Item = EastNorth> {
        let parts = (self.length_m() / every_m).ceil().max(1.0) as u32;
        (0..=parts).map(move |part| {
            let share = f64::from(part) / f64::from(parts);
            match self {
                Self::Line(from, to) => from + (to - from) * share,
                Self::Circle(centre, radius_m) => centre.offset(360.0 * share, radius_m),
            }
        })
    }
}

/// Calls `show` with each path of the plan, in the order of flight. A circle counts as its whole circumference, however
/// much of it is flown.
fn along(
    plan: &[PlanItem],
    start: Option<EastNorth>,
    show: &mut dyn FnMut(&PlanItem, Path) -> Result<(), MvcError>,
) -> Result<(), MvcError> {
    // Where the item before ends; `None` after a setpoint.
    let mut at = start;
    for item in plan {
        let (entry, path, end) = match item.shape.with_leads(item.lead_m) {
            Shape::Waypoint { to } => (to, None, to),
            Shape::Trackline { start, end } => (start, Some(Path::Line(start, end)), end),
            Shape::GpsHit { at: place, .. } => (place, None, place),
            Shape::Trackcircle {
                centre,
                radius_m,
                orbits,
                entry_deg,
            } => {
                let entry_deg = entry_deg.unwrap_or_else(|| at.map_or(0.0, |at| centre.bearing_deg(at)));
                let entry = centre.offset(entry_deg, radius_m);
                let end = centre.offset(entry_deg + 360.0 * orbits, radius_m);
                (entry, Some(Path::Circle(centre, radius_m)), end)
            }
            Shape::Setpoint { .. } => {
                if let Some(at) = at.take() {
                    show(item, Path::Line(at, at))?;
                }
                continue;
            }
            Shape::Command | Shape::Idle => continue,
        };
        show(item, Path::Line(at.unwrap_or(entry), entry))?;
        if let Some(path) = path {
            show(item, path)?;
        }
        at = Some(end);
    }
    Ok(())
}
