use backseat_units::{EastNorth, LocalFrame, Position, Timestamp};
use serde::Deserialize;

use crate::current::{Current, CurrentConfig};
use crate::error::{WorldError, check};
use crate::field::{Field, FieldConfig};
use crate::grid::Grid;
use crate::seabed::{Seabed, SeabedConfig};

/// The `[origin]` section: where the world's frame has its zero.
#[derive(Clone, Copy, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OriginConfig {
    /// WGS84 latitude, degrees, within ±85.
    pub latitude_deg: f64,
    /// WGS84 longitude, degrees, within ±180.
    pub longitude_deg: f64,
}

/// All that a world is made from: the sections `[origin]`, `[seabed]`, `[current]` and `[field]` of `world.toml`.
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WorldConfig {
    /// Where the frame has its zero.
    pub origin: OriginConfig,
    /// The seabed.
    #[serde(default)]
    pub seabed: SeabedConfig,
    /// The current.
    #[serde(default)]
    pub current: CurrentConfig,
    /// Temperature and conductivity.
    #[serde(default)]
    pub field: FieldConfig,
}

impl WorldConfig {
    /// The frame about the origin.
    ///
    /// # Errors
    /// [`WorldError`] where the origin is not on the globe or within 5 degrees of a pole.
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
}

/// The sea of one run.
#[derive(Clone, Debug, PartialEq)]
pub struct World {
    frame: LocalFrame,
    seabed: Seabed,
    current: Current,
    field: Field,
}

impl World {
    /// Draws a world: the same configuration and seed give the same one on every platform.
    ///
    /// # Errors
    /// [`WorldError`] where the configuration leaves its ranges, or names a grid: that takes [`World::with_grid`].
    pub fn new(config: &WorldConfig, seed: u64) -> Result<Self, WorldError> {
        Self::with_grid(config, seed, None)
    }

    /// Draws a world over the grid that the configuration's `seabed.grid` names. The crate opens no file: the caller
    /// reads it and makes the grid by [`Grid::from_bytes`].
    ///
    /// # Errors
    /// [`WorldError`] where the configuration leaves its ranges, names a grid and none is given or the other way
    /// round, or where the grid does not fit it: see [`Seabed::with_grid`].
    pub fn with_grid(config: &WorldConfig, seed: u64, grid: Option<Grid>) -> Result<Self, WorldError> {
        let frame = config.frame()?;
        Ok(Self {
            frame,
            seabed: match grid {
                Some(grid) => Seabed::with_grid(&config.seabed, &frame, grid)?,
                None => Seabed::new(&config.seabed, seed)?,
            },
            current: Current::new(&config.current, seed)?,
            field: Field::new(&config.field, seed)?,
        })
    }

    /// The frame that all of this world is given in.
    #[must_use]
    pub const fn frame(&self) -> &LocalFrame {
        &self.frame
    }

    /// The seabed.
    #[must_use]
    pub const fn seabed(&self) -> &Seabed {
        &self.seabed
    }

    /// Water depth, metres.
    #[must_use]
    pub fn water_depth_m(&self, at: EastNorth) -> f64 {
        self.seabed.water_depth_m(at)
    }

    /// The way down and how steep: metres deeper a metre, east and north.
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

    /// Temperature, degrees Celsius. The fields of today stand still; the time is there for those that will not.
    #[must_use]
    pub fn temperature_c(&self, at: EastNorth, depth_m: f64, _time: Timestamp) -> f64 {
        self.field.temperature_c(at, depth_m)
    }

    /// Conductivity, microsiemens a centimetre.
    #[must_use]
    pub fn conductivity_us_per_cm(&self, at: EastNorth, depth_m: f64, _time: Timestamp) -> f64 {
        self.field.conductivity_us_per_cm(at, depth_m)
    }

    /// Where the plumes add most: see [`Field::maximum`]. None without a plume.
    #[must_use]
    pub fn field_maximum(&self) -> Option<EastNorth> {
        self.field.maximum()
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
    fn a_world_is_its_configuration_and_its_seed() {
        let config: WorldConfig = toml::from_str(TEXT).unwrap();
        let one = World::new(&config, 5).unwrap();
        assert_eq!(one, World::new(&config, 5).unwrap());
        assert_ne!(one, World::new(&config, 6).unwrap());
        assert!(one.field_maximum().is_some());
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
