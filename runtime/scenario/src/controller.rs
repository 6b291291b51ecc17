//! The table `[plc]` of `world.toml`: the mock payload controller.

use std::path::Path;

use backseat_mvc::{Mvc, MvcError};
use backseat_plc::{Plc, PlcConfig, PlcError, Pose, Stored};
use backseat_units::Utc;
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
    let tables: Tables = toml::from_str(text).map_err(|error| ScenarioError::World {
        path: path.to_path_buf(),
        source: toml_error(text, &error),
    })?;
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
        heading_deg: truth.heading_deg - vehicle.frame().convergence_deg(truth.position),
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
