//! The front seat's plan in a file: what a mission is checked with ashore, and what BFPLN is held against at sea.

use std::path::Path;

use backseat_core::{ExpectedElement, ExpectedPath, ExpectedPlan};
use backseat_mvc::{VehicleConfig, WorldFile};
use backseat_plan::{
    HullClass, PlaceConfig, PlanEntry, PlannedBehavior, PlannedPath, VehicleLimits, planned_behaviors,
};
use backseat_units::Position;
use serde::Deserialize;

use crate::error::MissionError;
use crate::file::PlanTable;
use crate::mission::{read, toml_error, value};

/// A plan may stray by so much from the one that was checked, metres; more is another plan.
const TOLERANCE_MAX_M: f64 = 100.0;

/// A front seat's plan, with what this vehicle does of it.
#[derive(Clone, Debug, PartialEq)]
pub struct FrontSeatPlan {
    /// The file as it is.
    pub text: String,
    /// What it has the vehicle do, in order.
    pub behaviors: Vec<PlannedBehavior>,
    /// How far a place of the vehicle's plan may be from one of this, metres.
    pub tolerance_m: f64,
}

/// A file with nothing but a plan.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PlanFile {
    origin: Option<Origin>,
    plan: Vec<PlanEntry>,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
struct Origin {
    latitude_deg: f64,
    longitude_deg: f64,
}

impl FrontSeatPlan {
    /// Reads a plan from a file: one with `[[plan]]` alone, or a `world.toml`. `class` is the vehicle's, where it is not
    /// to be that of the world.
    ///
    /// # Errors
    /// [`MissionError`] with the file, and the line or the element.
    pub fn read(path: &Path, class: Option<HullClass>, world: Option<&WorldFile>) -> Result<Self, MissionError> {
        let text = read(path)?;
        let fault = |message: String| value(path, message);
        if path.file_name().is_some_and(|name| name == "world.toml") {
            let world = WorldFile::from_toml(&text).map_err(|error| fault(error.to_string()))?;
            return Self::of_world(text, &world, class).map_err(fault);
        }
        let file: PlanFile = toml::from_str(&text).map_err(|error| toml_error(path, &text, &error))?;
        let origin = match (file.origin, world) {
            (Some(origin), _) => Some((origin.latitude_deg, origin.longitude_deg)),
            (None, Some(world)) => Some((world.origin.latitude_deg, world.origin.longitude_deg)),
            (None, None) => None,
        };
        let from_origin =
            |place: Option<PlaceConfig>| place.is_some_and(|place| place.east_m.is_some() || place.north_m.is_some());
        let first = file
            .plan
            .iter()
            .find_map(|entry| entry.at.or(entry.start).or(entry.centre));
        let counts_from = file.plan.iter().any(|entry| {
            [entry.at, entry.start, entry.end, entry.centre]
                .into_iter()
                .any(from_origin)
        });
        let (latitude_deg, longitude_deg) = match origin {
            Some(origin) => origin,
            None if counts_from => {
                return Err(fault(
                    "no [origin]: expected latitude_deg and longitude_deg, places count from it".to_owned(),
                ));
            }
            // Any near by will do: no place counts from it.
            None => first.map_or((0.0, 0.0), |place| {
                (place.latitude_deg.unwrap_or(0.0), place.longitude_deg.unwrap_or(0.0))
            }),
        };
        let origin = Position::from_deg(latitude_deg, longitude_deg)
            .ok()
            .filter(|origin| origin.latitude.as_deg().abs() <= 85.0)
            .ok_or_else(|| {
                fault(format!(
                    "origin is latitude {latitude_deg} longitude {longitude_deg}: expected ±85 and ±180 degrees"
                ))
            })?;
        let vehicle = vehicle(class, world);
        let behaviors = planned_behaviors(&file.plan, origin, &vehicle).map_err(|error| fault(error.to_string()))?;
        Ok(Self {
            text,
            behaviors,
            tolerance_m: PlanTable::default_tolerance_m(),
        })
    }

    /// The plan of a world.
    pub(crate) fn of_world(text: String, world: &WorldFile, class: Option<HullClass>) -> Result<Self, String> {
        let origin = Position::from_deg(world.origin.latitude_deg, world.origin.longitude_deg)
            .map_err(|error| format!("origin: {error}"))?;
        let behaviors = planned_behaviors(&world.plan, origin, &vehicle(class, Some(world)));
        Ok(Self {
            text,
            behaviors: behaviors.map_err(|error| error.to_string())?,
            tolerance_m: PlanTable::default_tolerance_m(),
        })
    }

    /// What BFPLN is expected to say of it (SPI 6.20).
    #[must_use]
    pub fn expected(&self) -> ExpectedPlan {
        let elements = self.behaviors.iter().filter_map(|behavior| {
            let path = match behavior.path {
                PlannedPath::Waypoint { to } => ExpectedPath::Points(vec![to]),
                PlannedPath::Line { start, end } => ExpectedPath::Points(vec![start, end]),
                PlannedPath::Circle { centre, radius_m, .. } => ExpectedPath::Circle { centre, radius_m },
                PlannedPath::Heading { .. } => ExpectedPath::Anywhere,
                PlannedPath::Nowhere => return None,
            };
            Some(ExpectedElement {
                number: behavior.number,
                path,
            })
        });
        ExpectedPlan {
            elements: elements.collect(),
            tolerance_m: self.tolerance_m,
        }
    }
}

/// The vehicle of a class, else the world's, else the usual one.
fn vehicle(class: Option<HullClass>, world: Option<&WorldFile>) -> VehicleLimits {
    let vehicle = world.map(|world| world.vehicle).unwrap_or_default();
    let vehicle = VehicleConfig {
        class: class.unwrap_or(vehicle.class),
        ..vehicle
    };
    vehicle.limits()
}

/// The plan that a mission names.
pub(crate) fn load(
    folder: &Path,
    table: &PlanTable,
    class: Option<HullClass>,
    world: Option<&WorldFile>,
) -> Result<FrontSeatPlan, MissionError> {
    if !(table.tolerance_m > 0.0 && table.tolerance_m <= TOLERANCE_MAX_M) {
        let message = format!(
            "plan.tolerance_m is {}: expected metres above 0 and at most {TOLERANCE_MAX_M}",
            table.tolerance_m
        );
        return Err(value(&folder.join("mission.toml"), message));
    }
    let plan = FrontSeatPlan::read(&folder.join(&table.file), class, world)?;
    Ok(FrontSeatPlan {
        tolerance_m: table.tolerance_m,
        ..plan
    })
}
