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
use crate::set::with_sets;

/// The name of the file in a mission's folder.
const WORLD: &str = "world.toml";

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
        Self::load_with(mission, &[])
    }

    /// Reads the scenario of a mission with keys set: `world.KEY=VALUE` each. [`Scenario::text`] has them.
    ///
    /// # Errors
    ///
    /// [`ScenarioError`] in one line, with file and place, or with the setting; also if the mission has no scenario.
    pub fn load_with(mission: &Mission, sets: &[String]) -> Result<Self, ScenarioError> {
        let path = world_path(mission);
        if !path.is_file() {
            return Err(ScenarioError::NoWorld { path });
        }
        if sets.is_empty() {
            return Self::read(path);
        }
        let text = read_text(&path)?;
        // Without the settings first, so that an error of the file is reported with its line.
        WorldFile::from_toml(&text).map_err(|source| ScenarioError::world(&path, source))?;
        let text = with_sets(&text, sets)?;
        Self::of_text(path, text).map_err(|error| {
            let of_grid = matches!(
                error,
                ScenarioError::Read { .. } | ScenarioError::Grid { .. } | ScenarioError::GridSize { .. }
            );
            if of_grid {
                return error;
            }
            ScenarioError::Set {
                set: sets.join(" --set "),
                message: without_line(&error),
            }
        })
    }

    /// Reads the scenario of a mission, if it has one.
    ///
    /// # Errors
    ///
    /// [`ScenarioError`] in one line, with file and place.
    pub fn find(mission: &Mission) -> Result<Option<Self>, ScenarioError> {
        let path = world_path(mission);
        if path.is_file() {
            Self::read(path).map(Some)
        } else {
            Ok(None)
        }
    }

    /// Reads a scenario without a mission: `place` is a folder with `world.toml`, or such a file under any name. Files
    /// that it names are beside it.
    ///
    /// # Errors
    ///
    /// [`ScenarioError`] in one line, with file and place; also if there is neither such a folder nor such a file.
    pub fn open(place: &Path) -> Result<Self, ScenarioError> {
        let path = if place.is_dir() {
            place.join(WORLD)
        } else {
            place.to_path_buf()
        };
        let is_mission = path.file_name().is_some_and(|name| name == "mission.toml");
        if path.is_file() && !is_mission {
            return Self::read(path);
        }
        Err(ScenarioError::NoPlace {
            path: place.to_path_buf(),
            found: if is_mission {
                "a mission's file"
            } else if place.is_dir() {
                "a folder without world.toml"
            } else {
                "nothing there"
            },
        })
    }

    fn read(path: PathBuf) -> Result<Self, ScenarioError> {
        let text = read_text(&path)?;
        Self::of_text(path, text)
    }

    fn of_text(path: PathBuf, text: String) -> Result<Self, ScenarioError> {
        let world = WorldFile::from_toml(&text).map_err(|source| ScenarioError::world(&path, source))?;
        let plc = read_controller(&path, &text)?;
        let grid = match &world.seabed.grid {
            Some(grid) => Some(read_grid(&path.with_file_name(grid))?),
            None => None,
        };
        Ok(Self {
            world,
            plc,
            path,
            text,
            grid,
        })
    }

    /// A name for this scenario: that of its folder, or that of its file if this is not `world.toml`.
    #[must_use]
    pub fn name(&self) -> String {
        let is_world = self.path.file_name().is_some_and(|name| name == WORLD);
        let folder = self.path.canonicalize().ok();
        let folder = folder.as_deref().and_then(Path::parent).and_then(Path::file_name);
        let name = if is_world { folder } else { self.path.file_stem() };
        name.map_or_else(|| WORLD.to_owned(), |name| name.to_string_lossy().into_owned())
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

fn read_text(path: &Path) -> Result<String, ScenarioError> {
    std::fs::read_to_string(path).map_err(|source| ScenarioError::Read {
        path: path.to_path_buf(),
        source,
    })
}

/// An error without its line, which is one of the text with the settings, and not one of the file.
fn without_line(error: &ScenarioError) -> String {
    let text = error.to_string();
    let ScenarioError::World { path, source } = error else {
        return text;
    };
    let MvcError::Toml { message, .. } = source else {
        return text;
    };
    format!("{}: {message}", path.display())
}

fn world_path(mission: &Mission) -> PathBuf {
    mission.folder.join(WORLD)
}
