use backseat_units::{EastNorth, LocalFrame, Position, Timestamp};
use serde::Deserialize;

use crate::bottom::Bottom;
use crate::current::{Current, CurrentConfig};
use crate::error::{WorldError, check};
use crate::field::{Field, FieldConfig};
use crate::grid::Grid;
use crate::seabed::{self, Seabed, SeabedConfig};
use crate::seawater;
use crate::sediment::{self, SedimentLayer};
use crate::targets::{Target, TargetConfig, Targets};
use crate::tide::{TideLevel, TideLevelConfig};

/// The `[origin]` section: the origin of the world's frame.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OriginConfig {
    /// WGS84 latitude, degrees, within ±85.
    pub latitude_deg: f64,
    /// WGS84 longitude, degrees, within ±180.
    pub longitude_deg: f64,
}

/// Everything that a world is made from: the sections `[origin]`, `[seabed]`, `[tide]`, `[current]`, `[field]` and
/// `[[targets]]` of `world.toml`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WorldConfig {
    /// The origin of the frame.
    pub origin: OriginConfig,
    /// The seabed.
    #[serde(default)]
    pub seabed: SeabedConfig,
    /// How the water level rises and falls.
    #[serde(default)]
    pub tide: TideLevelConfig,
    /// The current.
    #[serde(default)]
    pub current: CurrentConfig,
    /// Temperature, conductivity and tracer.
    #[serde(default)]
    pub field: FieldConfig,
    /// The objects on the seabed.
    #[serde(default)]
    pub targets: Vec<TargetConfig>,
}

impl WorldConfig {
    /// The frame around the origin.
    ///
    /// # Errors
    /// [`WorldError`] if the origin is not a position on the globe, or is within 5 degrees of a pole.
    pub fn frame(&self) -> Result<LocalFrame, WorldError> {
        let OriginConfig {
            latitude_deg,
            longitude_deg,
        } = self.origin;
        let origin = Position::from_deg(latitude_deg, longitude_deg)?;
        let expected = "within 85 degrees of the equator";
        check(
            latitude_deg.abs() <= 85.0,
            "origin.latitude_deg",
            latitude_deg,
            expected,
        )?;
        Ok(LocalFrame::new(origin))
    }

    /// Checks whether a world can be drawn, as far as that is possible without the grid: it checks the ranges of all
    /// keys. The result does not depend on the seed.
    ///
    /// # Errors
    /// [`WorldError`] as [`World::with_grid`].
    pub fn validate(&self) -> Result<(), WorldError> {
        self.frame()?;
        seabed::validate(&self.seabed)?;
        let seed = 0;
        TideLevel::new(&self.tide, seed)?;
        Current::new(&self.current, seed)?;
        Field::new(&self.field, seed)?;
        Targets::new(&self.targets, seed)?;
        Ok(())
    }
}

/// The sea of one run.
#[derive(Clone, Debug, PartialEq)]
pub struct World {
    frame: LocalFrame,
    seabed: Seabed,
    tide: TideLevel,
    current: Current,
    field: Field,
    targets: Targets,
    bottom: Bottom,
    layers: Vec<SedimentLayer>,
}

impl World {
    /// Draws a world. The same configuration and seed give the same world on every platform.
    ///
    /// # Errors
    /// [`WorldError`] if a value of the configuration is out of range, or if it names a grid, which needs
    /// [`World::with_grid`].
    pub fn new(config: &WorldConfig, seed: u64) -> Result<Self, WorldError> {
        Self::with_grid(config, seed, None)
    }

    /// Draws a world over the grid that `seabed.grid` names in the configuration. The crate opens no file: the caller
    /// reads it and makes the grid with [`Grid::from_bytes`].
    ///
    /// # Errors
    /// [`WorldError`] if a value of the configuration is out of range, if it names a grid and none is passed or the
    /// reverse, or if the grid does not match the configuration: see [`Seabed::with_grid`].
    pub fn with_grid(config: &WorldConfig, seed: u64, grid: Option<Grid>) -> Result<Self, WorldError> {
        let frame = config.frame()?;
        Ok(Self {
            frame,
            seabed: match grid {
                Some(grid) => Seabed::with_grid(&config.seabed, &frame, grid)?,
                None => Seabed::new(&config.seabed, seed)?,
            },
            tide: TideLevel::new(&config.tide, seed)?,
            current: Current::new(&config.current, seed)?,
            field: Field::new(&config.field, seed)?,
            targets: Targets::new(&config.targets, seed)?,
            bottom: Bottom::new(&config.seabed, seed)?,
            layers: sediment::draw(&config.seabed, seed)?,
        })
    }

    /// The frame of all coordinates of this world.
    #[must_use]
    pub const fn frame(&self) -> &LocalFrame {
        &self.frame
    }

    /// The seabed.
    #[must_use]
    pub const fn seabed(&self) -> &Seabed {
        &self.seabed
    }

    /// Water depth at the mean level, metres, as on a chart.
    #[must_use]
    pub fn water_depth_m(&self, at: EastNorth) -> f64 {
        self.seabed.water_depth_m(at)
    }

    /// The gradient of the depth: metres of depth per metre, east and north.
    #[must_use]
    pub fn gradient(&self, at: EastNorth) -> EastNorth {
        self.seabed.gradient(at)
    }

    /// Velocity of the water, metres a second east and north.
    #[must_use]
    pub fn current_at(&self, at: EastNorth, depth_m: f64, time: Timestamp) -> (f64, f64) {
        let (east, north) = self.current.at(at, depth_m, time);
        if !self.current.feels_the_bed() {
            return (east, north);
        }
        let left = self.current.near_bed(self.seabed.water_depth_m(at) - depth_m);
        (east * left, north * left)
    }

    /// Height of the water over its mean level, metres: high water is positive.
    #[must_use]
    pub fn tide_m(&self, time: Timestamp) -> f64 {
        self.tide.at_m(time)
    }

    /// Water depth at a time, metres: the depth on the chart plus the tide, never below 0.
    #[must_use]
    pub fn water_depth_at_m(&self, at: EastNorth, time: Timestamp) -> f64 {
        (self.water_depth_m(at) + self.tide_m(time)).max(0.0)
    }

    /// Temperature, degrees Celsius.
    #[must_use]
    pub fn temperature_c(&self, at: EastNorth, depth_m: f64, time: Timestamp) -> f64 {
        self.field.temperature_c(at, depth_m, time)
    }

    /// Conductivity in situ, microsiemens a centimetre.
    #[must_use]
    pub fn conductivity_us_per_cm(&self, at: EastNorth, depth_m: f64, time: Timestamp) -> f64 {
        self.field.conductivity_us_per_cm(at, depth_m, time)
    }

    /// Pressure of the sea at a depth, decibars, without atmospheric pressure: see [`seawater::pressure_dbar`].
    #[must_use]
    pub fn pressure_dbar(&self, depth_m: f64) -> f64 {
        seawater::pressure_dbar(depth_m, self.frame.origin().latitude.as_deg())
    }

    /// Practical salinity, from conductivity, temperature and pressure: see [`seawater::salinity`].
    #[must_use]
    pub fn salinity(&self, at: EastNorth, depth_m: f64, time: Timestamp) -> f64 {
        let conductivity = self.conductivity_us_per_cm(at, depth_m, time);
        let temperature_c = self.temperature_c(at, depth_m, time);
        seawater::salinity(conductivity, temperature_c, self.pressure_dbar(depth_m))
    }

    /// Speed of sound, metres a second: see [`seawater::sound_speed_mps`].
    #[must_use]
    pub fn sound_speed_mps(&self, at: EastNorth, depth_m: f64, time: Timestamp) -> f64 {
        let conductivity = self.conductivity_us_per_cm(at, depth_m, time);
        let temperature_c = self.temperature_c(at, depth_m, time);
        let pressure_dbar = self.pressure_dbar(depth_m);
        let salinity = seawater::salinity(conductivity, temperature_c, pressure_dbar);
        seawater::sound_speed_mps(salinity, temperature_c, pressure_dbar)
    }

    /// Concentration of the tracer that plumes and filaments carry, in the unit of the configuration.
    #[must_use]
    pub fn concentration(&self, at: EastNorth, depth_m: f64, time: Timestamp) -> f64 {
        self.field.concentration(at, depth_m, time)
    }

    /// The place where the plumes add most, see [`Field::maximum`]. `None` if no plume adds anything.
    #[must_use]
    pub fn field_maximum(&self) -> Option<EastNorth> {
        self.field.maximum()
    }

    /// The sources of the filaments, in the order of the configuration.
    pub fn filament_sources(&self) -> impl Iterator<Item = EastNorth> {
        self.field.sources()
    }

    /// The objects on the seabed, sorted from west to east, for a simulated sidescan sonar or sub-bottom profiler. They
    /// have no other effect: they change neither the water depth nor the vehicle's motion.
    #[must_use]
    pub fn targets(&self) -> &[Target] {
        self.targets.all()
    }

    /// The targets whose middle lies within `radius_m` metres of a place, sorted from west to east.
    pub fn targets_near(&self, at: EastNorth, radius_m: f64) -> impl Iterator<Item = &Target> {
        self.targets.near(at, radius_m)
    }

    /// What the seabed is made of, for a simulated sonar.
    #[must_use]
    pub const fn bottom(&self) -> &Bottom {
        &self.bottom
    }

    /// The layers below the seabed, sorted by their mean depths, for a simulated sub-bottom profiler.
    #[must_use]
    pub fn sediment_layers(&self) -> &[SedimentLayer] {
        &self.layers
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "
        [origin]
        latitude_deg = 42.3
        longitude_deg = -70.9
        [seabed]
        depth_m = [40, 60]
        banks = 2
        [current]
        speed_mps = [0.0, 0.4]
        rotation_h = 12.42
        [[field.plumes]]
        east_m = [-300, 300]
        north_m = [-300, 300]
        sigma_m = 150
        temperature_c = 3.0
    ";

    #[test]
    fn configuration_and_seed_determine_a_world() {
        let config: WorldConfig = toml::from_str(TEXT).unwrap();
        let one = World::new(&config, 5).unwrap();
        assert_eq!(one, World::new(&config, 5).unwrap());
        assert_ne!(one, World::new(&config, 6).unwrap());
        assert!(one.field_maximum().is_some());
    }

    #[test]
    fn the_sea_follows_its_equations() {
        let text = "
            [origin]
            latitude_deg = 42.3
            longitude_deg = -70.9
            [seabed]
            depth_m = 50
            slope = 0
            meanders = 0
            [tide]
            amplitude_m = 2
            [current]
            speed_mps = 0.4
            towards_deg = 90
            bottom_boundary_m = 4
            [field]
            temperature_c = 15
            conductivity_us_per_cm = 42914
            [[field.plumes]]
            east_m = 0
            north_m = 0
            sigma_m = 100
            tracer = 8
            [[targets]]
            east_m = 0
            north_m = 20
        ";
        let config: WorldConfig = toml::from_str(text).unwrap();
        config.validate().unwrap();
        let world = World::new(&config, 1).unwrap();
        let (here, now) = (EastNorth::default(), Timestamp::ZERO);
        assert!((world.salinity(here, 0.0, now) - 35.0).abs() < 0.01);
        assert!((world.sound_speed_mps(here, 0.0, now) - 1506.7).abs() < 0.1);
        assert!(world.sound_speed_mps(here, 1000.0, now) > 1522.0);
        assert_eq!(world.concentration(here, 0.0, now), 8.0);
        assert_eq!(
            (world.water_depth_m(here), world.water_depth_at_m(here, now)),
            (50.0, 52.0)
        );
        assert_eq!((world.targets().len(), world.targets_near(here, 10.0).count()), (1, 0));
        // At 1/128 of the boundary layer half of the current is left; at the bed nothing is.
        let (east, _) = world.current_at(here, 50.0 - 4.0 / 128.0, now);
        assert!((east - 0.2).abs() < 1e-9);
        assert_eq!(world.current_at(here, 50.0, now), (0.0, 0.0));
        assert!((world.current_at(here, 46.0, now).0 - 0.4).abs() < 1e-9);
    }

    #[test]
    fn unknown_keys_and_impossible_values_are_refused() {
        let wrong = TEXT.replace("banks = 2", "bank = 2");
        let message = toml::from_str::<WorldConfig>(&wrong).unwrap_err().to_string();
        assert!(message.contains("unknown field `bank`"), "{message}");
        let wrong = TEXT.replace("42.3", "95.0");
        assert!(World::new(&toml::from_str(&wrong).unwrap(), 1).is_err());
    }
}
