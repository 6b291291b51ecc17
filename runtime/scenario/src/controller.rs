//! The table `[plc]` of `world.toml`: the mock payload controller.

use std::path::Path;

use backseat_mvc::{Mvc, MvcError};
use backseat_plc::{Plc, PlcConfig, PlcError, Pose, Reported, Stored};
use backseat_units::math::wrap_360;
use backseat_units::{EastNorth, LocalFrame, Utc};
use backseat_world::World;
use serde::Deserialize;

use crate::error::ScenarioError;
use crate::scenario::Scenario;
use crate::soundings::Soundings;

/// The table, among others that this crate leaves to their readers.
#[derive(Deserialize)]
struct Tables {
    plc: Option<PlcConfig>,
}

impl Scenario {
    /// The mock payload controller that `[plc]` describes; `None` without such a table. `utc` is the true UTC at time
    /// zero, and `stored` what an earlier run left on the controller's disk.
    ///
    /// # Errors
    ///
    /// [`PlcError`] with the line of a stored file that cannot be read. The table itself was checked when it was read.
    pub fn controller(&self, seed: u64, utc: Utc, stored: &Stored) -> Result<Option<Plc>, PlcError> {
        let made = self.plc.as_ref().map(|plc| Plc::new(plc, seed, utc, stored));
        made.transpose()
    }

    /// Where a vehicle is of which there are only the reports of the controller's clients: what they say, and `[start]` for
    /// what they do not say. A position further from the origin than the world's frame goes is not used.
    #[must_use]
    pub fn reported_pose(&self, reported: Option<&Reported>) -> Pose {
        let start = &self.world.start;
        let Some(frame) = self.frame() else {
            return Pose::default();
        };
        let start_at = EastNorth::new(start.east_m, start.north_m);
        let at = reported.and_then(|reported| reported.position);
        let at = at.map(|position| frame.to_local(position));
        let at = at.filter(|at| at.distance_m(EastNorth::default()) <= LocalFrame::RADIUS_M);
        let at = at.unwrap_or(start_at);
        let said = |value: fn(&Reported) -> Option<f64>| reported.and_then(value);
        let true_heading_deg = said(|reported| reported.heading_deg).unwrap_or(start.heading_deg);
        Pose {
            at,
            depth_m: said(|reported| reported.depth_m).unwrap_or(start.depth_m),
            heading_deg: wrap_360(true_heading_deg - frame.convergence_deg(frame.to_position(at))),
            pitch_deg: said(|reported| reported.pitch_deg).unwrap_or(0.0),
            roll_deg: said(|reported| reported.roll_deg).unwrap_or(0.0),
            east_mps: said(|reported| reported.east_mps).unwrap_or(0.0),
            north_mps: said(|reported| reported.north_mps).unwrap_or(0.0),
            down_mps: said(|reported| reported.down_mps).unwrap_or(0.0),
        }
    }

    /// What the controller's sonars hear in the world of this seed, over the scenario's grid.
    ///
    /// # Errors
    ///
    /// [`ScenarioError`] if the world of this seed cannot be drawn.
    pub fn soundings(&self, seed: u64) -> Result<Soundings<World>, ScenarioError> {
        let world = World::with_grid(&self.world.world_config(), seed, self.grid.clone());
        let world = world.map_err(|source| ScenarioError::World {
            path: self.path.clone(),
            source: MvcError::World(source),
        })?;
        Ok(Soundings::new(world, seed))
    }
}

/// Reads the table `[plc]` from the text of `world.toml`; `None` without such a table. Other tables are not looked at.
///
/// # Errors
///
/// [`ScenarioError`] in one line, with the file's path, and the place or the key.
pub fn read_controller(path: &Path, text: &str) -> Result<Option<PlcConfig>, ScenarioError> {
    let tables: Tables = toml::from_str(text).map_err(|error| ScenarioError::world(path, toml_error(text, &error)))?;
    if let Some(plc) = &tables.plc {
        plc.validate().map_err(|source| ScenarioError::Controller {
            path: path.to_path_buf(),
            source,
        })?;
    }
    Ok(tables.plc)
}

/// Where the mock vehicle truly is, for [`Plc::truth`].
#[must_use]
pub fn true_pose(vehicle: &Mvc) -> Pose {
    let truth = vehicle.truth();
    Pose {
        at: truth.local,
        depth_m: truth.depth_m,
        heading_deg: wrap_360(truth.heading_deg - vehicle.frame().convergence_deg(truth.position)),
        pitch_deg: truth.pitch_deg,
        roll_deg: truth.roll_deg,
        east_mps: truth.east_mps,
        north_mps: truth.north_mps,
        down_mps: truth.down_mps,
    }
}

/// The TOML crate's error on one line, as the mock vehicle's reader of this file has it.
fn toml_error(text: &str, error: &toml::de::Error) -> MvcError {
    let start = error.span().map_or(0, |span| span.start).min(text.len());
    let before = text.get(..start).unwrap_or_default();
    let line_start = before.rfind('\n').map_or(0, |at| at + 1);
    let rest = text.get(line_start..).unwrap_or_default();
    MvcError::Toml {
        line: before.matches('\n').count() + 1,
        column: before.get(line_start..).unwrap_or_default().chars().count() + 1,
        message: error.message().split_whitespace().collect::<Vec<_>>().join(" "),
        text: rest
            .lines()
            .next()
            .unwrap_or_default()
            .trim()
            .chars()
            .take(100)
            .collect(),
    }
}
