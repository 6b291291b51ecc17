use std::path::{Path, PathBuf};

use backseat_mission::{FrontSeatPlan, Mission};
use backseat_mvc::{Mvc, MvcError, VehicleConfig, WorldFile};
use backseat_plan::VehicleLimits;
use backseat_plc::PlcConfig;
use backseat_units::{EastNorth, LocalFrame, Position};
use backseat_world::Grid;

use crate::controller::read_controller;
use crate::error::ScenarioError;
use crate::grid::read_grid;

/// The world in which a mission is simulated.
#[derive(Clone, Debug)]
pub struct Scenario {
    /// The contents of `world.toml`, but for the table `[plc]`.
    pub world: WorldFile,
    /// The table `[plc]`, if `world.toml` has one.
    pub plc: Option<PlcConfig>,
    /// The path of `world.toml`.
    pub path: PathBuf,
    /// The text of `world.toml`.
    pub text: String,
    /// The seabed's grid, if `world.toml` names one; clones share it.
    pub grid: Option<Grid>,
}

impl Scenario {
    /// Reads the scenario of a mission.
    ///
    /// # Errors
    ///
    /// [`ScenarioError`] in one line, with file and place; also if the mission has no scenario.
    pub fn load(mission: &Mission) -> Result<Self, ScenarioError> {
        let path = world_path(mission);
        Self::find(mission)?.ok_or(ScenarioError::NoWorld { path })
    }

    /// Reads the scenario of a mission, if it has one.
    ///
    /// # Errors
    ///
    /// [`ScenarioError`] in one line, with file and place.
    pub fn find(mission: &Mission) -> Result<Option<Self>, ScenarioError> {
        let path = world_path(mission);
        if !path.is_file() {
            return Ok(None);
        }
        let text = std::fs::read_to_string(&path).map_err(|source| ScenarioError::Read {
            path: path.clone(),
            source,
        })?;
        let world = WorldFile::from_toml(&text).map_err(|source| ScenarioError::world(&path, source))?;
        let plc = read_controller(&path, &text)?;
        let grid = match &world.seabed.grid {
            Some(grid) => Some(read_grid(&mission.folder.join(grid))?),
            None => None,
        };
        Ok(Some(Self {
            world,
            plc,
            path,
            text,
            grid,
        }))
    }

    /// The mock vehicle in the world of this seed, over the scenario's grid.
    ///
    /// # Errors
    ///
    /// [`MvcError`] if the plan cannot be flown in the world of this seed: see [`Mvc::with_grid`].
    pub fn vehicle(&self, seed: u64) -> Result<Mvc, MvcError> {
        Mvc::with_grid(&self.world, seed, self.grid.clone())
    }

    /// The vehicle of `world.toml`; if the mission names a class, of that class.
    #[must_use]
    pub fn vehicle_of(&self, mission: &Mission) -> VehicleConfig {
        VehicleConfig {
            class: mission.file.vehicle.class.unwrap_or(self.world.vehicle.class),
            ..self.world.vehicle
        }
    }

    /// The plan that the front seat flies: that of `file`, else the mission's `[plan]`, else that of `world.toml`. It
    /// is checked against this scenario's vehicle. Positions of a plan without an origin are relative to this world's
    /// origin.
    ///
    /// # Errors
    ///
    /// [`ScenarioError`] with the file, and the line or the element.
    pub fn plan(&self, mission: &Mission, file: Option<&Path>) -> Result<FrontSeatPlan, ScenarioError> {
        let named = mission.file.plan.as_ref().map(|plan| mission.folder.join(&plan.file));
        let path = file.or(named.as_deref()).unwrap_or(&self.path);
        let limits: VehicleLimits = self.vehicle_of(mission).limits();
        Ok(FrontSeatPlan::read(path, &limits, self.origin())?)
    }

    /// Where the vehicle begins; `None` if the origin is not a valid position.
    #[must_use]
    pub fn start(&self) -> Option<Position> {
        let frame = self.frame()?;
        Some(frame.to_position(EastNorth::new(self.world.start.east_m, self.world.start.north_m)))
    }

    /// The world's frame; `None` if the origin is not a valid position.
    pub(crate) fn frame(&self) -> Option<LocalFrame> {
        self.origin().map(LocalFrame::new)
    }

    fn origin(&self) -> Option<Position> {
        Position::from_deg(self.world.origin.latitude_deg, self.world.origin.longitude_deg).ok()
    }
}

fn world_path(mission: &Mission) -> PathBuf {
    mission.folder.join("world.toml")
}
