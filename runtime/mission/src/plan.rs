//! The front seat's plan from a file: a mission is checked with it before the dive, and BFPLN is compared with it at
//! sea.

use std::path::Path;

use backseat_core::{ExpectedElement, ExpectedPath, ExpectedPlan};
use backseat_plan::{PlanEntry, PlannedBehavior, PlannedPath, VehicleClass, VehicleLimits, planned_behaviors};
use backseat_units::{LocalFrame, Position};
use serde::Deserialize;

use crate::error::MissionError;
use crate::file::PlanTable;
use crate::mission::{read, read_own, toml_error, value};

/// How far the vehicle's plan may differ from the checked one at most, metres; beyond this it is another plan.
const TOLERANCE_MAX_M: f64 = 100.0;

/// A front seat's plan, and the behaviors that this vehicle flies because of it.
#[derive(Clone, Debug, PartialEq)]
pub struct FrontSeatPlan {
    /// The file's text.
    pub text: String,
    /// The behaviors that the plan makes the vehicle fly, in order.
    pub behaviors: Vec<PlannedBehavior>,
    /// How far a position in the vehicle's plan may be from the one here, metres.
    pub tolerance_m: f64,
}

/// A file with a plan only.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct PlanFile {
    origin: Option<Origin>,
    plan: Vec<PlanEntry>,
}

/// The plan of a `world.toml`. Everything else in that file is for simulation and does not matter for a dive.
#[derive(Deserialize)]
struct PlanOfWorld {
    origin: Option<Origin>,
    plan: Vec<PlanEntry>,
}

#[derive(Clone, Copy, Deserialize)]
#[serde(deny_unknown_fields)]
struct Origin {
    latitude_deg: f64,
    longitude_deg: f64,
}

impl From<PlanOfWorld> for PlanFile {
    fn from(PlanOfWorld { origin, plan }: PlanOfWorld) -> Self {
        Self { origin, plan }
    }
}

impl FrontSeatPlan {
    /// Reads a plan from a file with `[[plan]]` alone, or from the `[origin]` and `[[plan]]` of a `world.toml`, and
    /// checks it against what the vehicle can do. Positions in a file without an origin are relative to `origin`.
    ///
    /// # Errors
    ///
    /// [`MissionError`] with the file, and the line or the element.
    pub fn read(path: &Path, vehicle: &VehicleLimits, origin: Option<Position>) -> Result<Self, MissionError> {
        Self::of_text(path, read(path)?, vehicle, origin)
    }

    fn of_text(
        path: &Path,
        text: String,
        vehicle: &VehicleLimits,
        origin: Option<Position>,
    ) -> Result<Self, MissionError> {
        let fault = |message: String| value(path, message);
        let file = if path.file_name().is_some_and(|name| name == "world.toml") {
            toml::from_str::<PlanOfWorld>(&text).map(PlanFile::from)
        } else {
            toml::from_str(&text)
        };
        let file = file.map_err(|error| toml_error(path, &text, &error))?;
        let origin = match (file.origin, origin) {
            (Some(origin), _) => origin.position().map_err(fault)?,
            (None, Some(origin)) => origin,
            (None, None) if file.plan.iter().any(counts_from_origin) => {
                return Err(fault(
                    "no [origin]: expected latitude_deg and longitude_deg, because positions are relative to it"
                        .to_owned(),
                ));
            }
            // Any origin nearby will do, because no position is relative to it.
            (None, None) => near_by(&file.plan).position().map_err(fault)?,
        };
        let behaviors = planned_behaviors(&file.plan, origin, vehicle).map_err(|error| fault(error.to_string()))?;
        Ok(Self {
            text,
            behaviors,
            tolerance_m: PlanTable::default_tolerance_m(),
        })
    }

    /// The BFPLN that the vehicle is expected to send for this plan (SPI 6.20).
    #[must_use]
    pub fn expected(&self) -> ExpectedPlan {
        expected_plan(&self.behaviors, self.tolerance_m)
    }
}

/// The BFPLN that the vehicle is expected to send for these behaviors (SPI 6.20).
#[must_use]
pub fn expected_plan(behaviors: &[PlannedBehavior], tolerance_m: f64) -> ExpectedPlan {
    let elements = behaviors.iter().filter_map(|behavior| {
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
        tolerance_m,
    }
}

/// The first element in which a vehicle's plan is not the expected one; positions may be apart by `tolerance_m`. A vehicle
/// with that plan is not steered.
#[must_use]
pub fn first_difference(expected: &ExpectedPlan, plan: &ExpectedPlan, frame: &LocalFrame) -> Option<String> {
    let near = |one: &Position, other: &Position| {
        let apart_m = frame.to_local(*one).distance_m(frame.to_local(*other));
        apart_m <= expected.tolerance_m
    };
    let same = |one: &ExpectedElement, other: &ExpectedElement| {
        one.number == other.number
            && match (&one.path, &other.path) {
                (ExpectedPath::Points(ones), ExpectedPath::Points(others)) => {
                    ones.len() == others.len() && ones.iter().zip(others).all(|(one, other)| near(one, other))
                }
                (
                    ExpectedPath::Circle { centre, radius_m },
                    ExpectedPath::Circle {
                        centre: other,
                        radius_m: other_m,
                    },
                ) => near(centre, other) && (radius_m - other_m).abs() <= expected.tolerance_m,
                (ExpectedPath::Anywhere, ExpectedPath::Anywhere) => true,
                _ => false,
            }
    };
    let (wanted, has) = (expected.elements.len(), plan.elements.len());
    if wanted != has {
        return Some(format!("{has} elements, expected {wanted}"));
    }
    let mut pairs = expected.elements.iter().zip(&plan.elements);
    let other = pairs.find(|(one, other)| !same(one, other))?.0;
    Some(format!("element {}", other.number))
}

impl Origin {
    fn position(self) -> Result<Position, String> {
        let Self {
            latitude_deg,
            longitude_deg,
        } = self;
        Position::from_deg(latitude_deg, longitude_deg)
            .ok()
            .filter(|origin| origin.latitude.as_deg().abs() <= 85.0)
            .ok_or_else(|| {
                format!("origin is latitude {latitude_deg} longitude {longitude_deg}: expected latitude within ±85 and longitude within ±180 degrees")
            })
    }
}

/// Whether a position of an element is given in metres.
fn counts_from_origin(entry: &PlanEntry) -> bool {
    [entry.at, entry.start, entry.end, entry.centre]
        .into_iter()
        .flatten()
        .any(|place| place.east_m.is_some() || place.north_m.is_some())
}

/// The first position of a plan that is given by latitude and longitude.
fn near_by(plan: &[PlanEntry]) -> Origin {
    let first = plan.iter().find_map(|entry| entry.at.or(entry.start).or(entry.centre));
    Origin {
        latitude_deg: first.and_then(|place| place.latitude_deg).unwrap_or(0.0),
        longitude_deg: first.and_then(|place| place.longitude_deg).unwrap_or(0.0),
    }
}

/// Reads the plan that a mission names.
pub(crate) fn load(
    folder: &Path,
    table: &PlanTable,
    class: Option<VehicleClass>,
) -> Result<FrontSeatPlan, MissionError> {
    check_tolerance(folder, table)?;
    let path = folder.join(&table.file);
    let text = read_own(&path).map_err(|error| {
        let MissionError::Read { source, .. } = error else {
            return error;
        };
        let why = format!(
            "plan.file is {:?}: cannot read {}: {source}",
            table.file,
            path.display()
        );
        value(&folder.join("mission.toml"), why)
    })?;
    of_text(folder, table, class, text)
}

fn check_tolerance(folder: &Path, table: &PlanTable) -> Result<(), MissionError> {
    if !(table.tolerance_m > 0.0 && table.tolerance_m <= TOLERANCE_MAX_M) {
        let message = format!(
            "plan.tolerance_m is {}: expected metres above 0 and at most {TOLERANCE_MAX_M}",
            table.tolerance_m
        );
        return Err(value(&folder.join("mission.toml"), message));
    }
    Ok(())
}

/// The plan that a mission names, from the text of its file.
pub(crate) fn of_text(
    folder: &Path,
    table: &PlanTable,
    class: Option<VehicleClass>,
    text: String,
) -> Result<FrontSeatPlan, MissionError> {
    check_tolerance(folder, table)?;
    let vehicle = class.map_or_else(VehicleLimits::of_any_class, VehicleClass::limits);
    let plan = FrontSeatPlan::of_text(&folder.join(&table.file), text, &vehicle, None)?;
    Ok(FrontSeatPlan {
        tolerance_m: table.tolerance_m,
        ..plan
    })
}
