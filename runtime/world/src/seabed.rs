mod chart;
mod shelf;

use std::path::PathBuf;

use backseat_units::{EastNorth, LocalFrame};
use serde::Deserialize;

use chart::Chart;
use shelf::Shelf;

use crate::bottom::{self, BottomClass, PatchConfig};
use crate::error::{WorldError, agree, check};
use crate::grid::{Grid, GridFrame, GridPositive};
use crate::sediment::{self, SedimentLayerConfig};
use crate::span::Span;

/// The `[seabed]` section: either a shelf that slopes in one direction, with meanders and banks drawn by the seed, or a
/// grid.
///
/// The slopes of the meanders add up to at most `meander_slope`. If that is less than `slope`, the meanders bend the
/// depth contours but never close one, so a vehicle can follow a contour without end.
///
/// What the seabed is made of and what lies below it matter to sonars alone, see [`PatchConfig`] and
/// [`SedimentLayerConfig`]. They have streams of their own, so they change no depth.
///
/// With a `grid`, the depth comes from the file. The keys of the shelf are then rejected, but `depth_min_m` and
/// `depth_max_m` still bound the depth. Outside the grid, the depth is that of the nearest cell at its edge.
///
/// ```
/// let config: backseat_world::SeabedConfig = toml::from_str(r#"
/// grid = "harbour.asc"
/// grid_frame = "geographic"
/// grid_positive = "up"
/// grid_nodata_depth_m = 3.0
/// "#)?;
/// assert!(config.grid.is_some());
/// # Ok::<(), toml::de::Error>(())
/// ```
#[derive(Clone, Debug, PartialEq, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SeabedConfig {
    /// Water depth at the origin without meanders and banks, metres, 0.1 to 6000.
    pub depth_m: Span,
    /// Slope of the shelf, metres of depth per metre, 0 to 0.5.
    pub slope: Span,
    /// The direction in which the depth grows, degrees clockwise from the frame's north.
    pub downslope_deg: Span,
    /// Number of meanders, 0 to 16.
    pub meanders: u32,
    /// The greatest slope that all meanders together may add, metres per metre, 0 to 0.5.
    pub meander_slope: f64,
    /// Wavelength of a meander, metres, 50 to 100000.
    pub meander_wavelength_m: Span,
    /// Number of banks, 0 to 16.
    pub banks: u32,
    /// Height of a bank over the shelf, metres, 0 to 1000.
    pub bank_height_m: Span,
    /// Radius of a bank (one standard deviation), metres, 20 to 20000.
    pub bank_radius_m: Span,
    /// Banks lie this far east of the origin, metres.
    pub bank_east_m: Span,
    /// Banks lie this far north of the origin, metres.
    pub bank_north_m: Span,
    /// The least water depth anywhere, metres, above 0 and below `depth_max_m`.
    pub depth_min_m: f64,
    /// The greatest water depth anywhere, metres, at most 12000.
    pub depth_max_m: f64,
    /// The file of a grid, ESRI ASCII or GeoTIFF; a relative path starts at the folder of the configuration. The code
    /// that reads the configuration must read the file, see [`World::with_grid`](crate::World::with_grid).
    pub grid: Option<PathBuf>,
    /// What the grid's coordinates are; metres in the world's frame unless given.
    pub grid_frame: Option<GridFrame>,
    /// What the grid's values are; depths unless given.
    pub grid_positive: Option<GridPositive>,
    /// The depth of cells without data, metres, 0 to 12000; without this key, a grid with such cells is rejected.
    pub grid_nodata_depth_m: Option<f64>,
    /// What the seabed is made of where no patch lies; sand unless given.
    pub bottom: BottomClass,
    /// The backscatter there, decibels, -60 to 0; that of the class unless given.
    pub backscatter_db: Option<Span>,
    /// Patches of seabed of another class, for sonars.
    pub patches: Vec<PatchConfig>,
    /// Layers below the seabed, for sub-bottom profilers; at most 16.
    pub layers: Vec<SedimentLayerConfig>,
}

impl Default for SeabedConfig {
    fn default() -> Self {
        Self {
            depth_m: Span::fixed(60.0),
            slope: Span::between(0.03, 0.045),
            downslope_deg: Span::between(0.0, 360.0),
            meanders: 4,
            meander_slope: 0.012,
            meander_wavelength_m: Span::between(400.0, 2000.0),
            banks: 0,
            bank_height_m: Span::between(3.0, 10.0),
            bank_radius_m: Span::between(100.0, 300.0),
            bank_east_m: Span::between(-1000.0, 1000.0),
            bank_north_m: Span::between(-1000.0, 1000.0),
            depth_min_m: 2.0,
            depth_max_m: 6000.0,
            grid: None,
            grid_frame: None,
            grid_positive: None,
            grid_nodata_depth_m: None,
            bottom: BottomClass::default(),
            backscatter_db: None,
            patches: Vec::new(),
            layers: Vec::new(),
        }
    }
}

/// The seabed, drawn by a seed or taken from a grid.
#[derive(Clone, Debug, PartialEq)]
pub struct Seabed {
    shape: Shape,
    depth_min_m: f64,
    depth_max_m: f64,
}

#[derive(Clone, Debug, PartialEq)]
enum Shape {
    Shelf(Shelf),
    Chart(Chart),
}

impl Seabed {
    /// Draws a seabed without a grid.
    ///
    /// # Errors
    /// [`WorldError`] if a value of the configuration is out of range, or if it names a grid.
    pub fn new(config: &SeabedConfig, seed: u64) -> Result<Self, WorldError> {
        validate(config)?;
        if let Some(path) = &config.grid {
            return Err(WorldError::GridNotGiven {
                path: path.display().to_string(),
            });
        }
        Ok(Self::of(Shape::Shelf(Shelf::new(config, seed)), config))
    }

    /// Places a grid in the frame of a world. It does not depend on a seed.
    ///
    /// # Errors
    /// [`WorldError`] if a value of the configuration is out of range, if it names no grid, if a cell has no data and
    /// `grid_nodata_depth_m` is not given, if the coordinates that the grid declares are not those of `grid_frame`, or
    /// if the whole grid is more than 50 km from the origin.
    pub fn with_grid(config: &SeabedConfig, frame: &LocalFrame, grid: Grid) -> Result<Self, WorldError> {
        validate(config)?;
        agree(config.grid.is_some(), "seabed.grid", "the name of the grid's file")?;
        Ok(Self::of(Shape::Chart(Chart::new(config, frame, grid)?), config))
    }

    fn of(shape: Shape, config: &SeabedConfig) -> Self {
        Self {
            shape,
            depth_min_m: config.depth_min_m,
            depth_max_m: config.depth_max_m,
        }
    }

    /// Water depth, metres.
    #[must_use]
    pub fn water_depth_m(&self, at: EastNorth) -> f64 {
        self.depth_and_gradient(at).0
    }

    /// Whether the depth at a place is drawn or comes from the grid. Outside a grid it does not: there it is the depth
    /// of the nearest cell at the grid's edge.
    #[must_use]
    pub fn is_known_at(&self, at: EastNorth) -> bool {
        match &self.shape {
            Shape::Shelf(_) => true,
            Shape::Chart(chart) => chart.covers(at),
        }
    }

    /// The gradient of the depth: metres of depth per metre, east and north.
    #[must_use]
    pub fn gradient(&self, at: EastNorth) -> EastNorth {
        self.depth_and_gradient(at).1
    }

    /// Water depth in metres and its gradient in one pass.
    #[must_use]
    pub fn depth_and_gradient(&self, at: EastNorth) -> (f64, EastNorth) {
        let (depth_m, gradient) = match &self.shape {
            Shape::Shelf(shelf) => shelf.depth_and_gradient(at),
            Shape::Chart(chart) => chart.depth_and_gradient(at),
        };
        if depth_m < self.depth_min_m {
            (self.depth_min_m, EastNorth::default())
        } else if depth_m > self.depth_max_m {
            (self.depth_max_m, EastNorth::default())
        } else {
            (depth_m, gradient)
        }
    }
}

/// Checks everything except the content of the grid.
pub(crate) fn validate(config: &SeabedConfig) -> Result<(), WorldError> {
    validate_grid(config)?;
    bottom::validate(config)?;
    sediment::validate(config)?;
    config.depth_m.within(0.1, 6000.0, "seabed.depth_m", "0.1 to 6000 m")?;
    config.slope.within(0.0, 0.5, "seabed.slope", "0 to 0.5")?;
    config
        .downslope_deg
        .within(-360.0, 720.0, "seabed.downslope_deg", "-360 to 720 degrees")?;
    check(
        config.meanders <= 16,
        "seabed.meanders",
        f64::from(config.meanders),
        "at most 16",
    )?;
    let meander_slope_ok = (0.0..=0.5).contains(&config.meander_slope);
    check(
        meander_slope_ok,
        "seabed.meander_slope",
        config.meander_slope,
        "0 to 0.5",
    )?;
    config
        .meander_wavelength_m
        .within(50.0, 100_000.0, "seabed.meander_wavelength_m", "50 to 100000 m")?;
    check(
        config.banks <= 16,
        "seabed.banks",
        f64::from(config.banks),
        "at most 16",
    )?;
    config
        .bank_height_m
        .within(0.0, 1000.0, "seabed.bank_height_m", "0 to 1000 m")?;
    config
        .bank_radius_m
        .within(20.0, 20_000.0, "seabed.bank_radius_m", "20 to 20000 m")?;
    config
        .bank_east_m
        .within(-50_000.0, 50_000.0, "seabed.bank_east_m", "within 50 km of the origin")?;
    config
        .bank_north_m
        .within(-50_000.0, 50_000.0, "seabed.bank_north_m", "within 50 km of the origin")?;
    let least_ok = config.depth_min_m > 0.0 && config.depth_min_m < config.depth_max_m;
    check(
        least_ok,
        "seabed.depth_min_m",
        config.depth_min_m,
        "above 0 and below depth_max_m",
    )?;
    check(
        config.depth_max_m <= 12_000.0,
        "seabed.depth_max_m",
        config.depth_max_m,
        "at most 12000 m",
    )
}

fn validate_grid(config: &SeabedConfig) -> Result<(), WorldError> {
    if config.grid.is_none() {
        let alone = "only together with `seabed.grid`";
        agree(config.grid_frame.is_none(), "seabed.grid_frame", alone)?;
        agree(config.grid_positive.is_none(), "seabed.grid_positive", alone)?;
        return agree(
            config.grid_nodata_depth_m.is_none(),
            "seabed.grid_nodata_depth_m",
            alone,
        );
    }
    if let Some(depth) = config.grid_nodata_depth_m {
        let key = "seabed.grid_nodata_depth_m";
        check((0.0..=12_000.0).contains(&depth), key, depth, "0 to 12000 m")?;
    }
    let shelf = SeabedConfig::default();
    for (is_default, key) in [
        (config.depth_m == shelf.depth_m, "seabed.depth_m"),
        (config.slope == shelf.slope, "seabed.slope"),
        (config.downslope_deg == shelf.downslope_deg, "seabed.downslope_deg"),
        (config.meanders == shelf.meanders, "seabed.meanders"),
        (config.meander_slope == shelf.meander_slope, "seabed.meander_slope"),
        (
            config.meander_wavelength_m == shelf.meander_wavelength_m,
            "seabed.meander_wavelength_m",
        ),
        (config.banks == shelf.banks, "seabed.banks"),
        (config.bank_height_m == shelf.bank_height_m, "seabed.bank_height_m"),
        (config.bank_radius_m == shelf.bank_radius_m, "seabed.bank_radius_m"),
        (config.bank_east_m == shelf.bank_east_m, "seabed.bank_east_m"),
        (config.bank_north_m == shelf.bank_north_m, "seabed.bank_north_m"),
    ] {
        agree(is_default, key, "this key or `seabed.grid`, not both")?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use backseat_units::math::hypot;
    use proptest::prelude::*;

    use super::*;

    proptest! {
        #[test]
        fn a_shelf_can_be_followed_everywhere(
            seed in any::<u64>(), east in -1000.0..1000.0f64, north in -1000.0..1000.0f64,
        ) {
            let config = SeabedConfig { depth_m: Span::fixed(200.0), ..SeabedConfig::default() };
            let seabed = Seabed::new(&config, seed).unwrap();
            let gradient = seabed.gradient(EastNorth::new(east, north));
            let slope = hypot(gradient.east_m, gradient.north_m);
            prop_assert!((0.018..=0.06).contains(&slope), "{slope}");
        }

        #[test]
        fn the_gradient_is_the_derivative_of_the_depth(seed in any::<u64>(), east in -900.0..900.0f64, north in -900.0..900.0f64) {
            let config = SeabedConfig { depth_m: Span::fixed(200.0), banks: 3, ..SeabedConfig::default() };
            let seabed = Seabed::new(&config, seed).unwrap();
            let at = EastNorth::new(east, north);
            let gradient = seabed.gradient(at);
            let depth = |east: f64, north: f64| seabed.water_depth_m(at + EastNorth::new(east, north));
            let by_difference = EastNorth::new(
                depth(0.5, 0.0) - depth(-0.5, 0.0),
                depth(0.0, 0.5) - depth(0.0, -0.5),
            );
            prop_assert!(gradient.distance_m(by_difference) < 1e-4);
        }
    }

    #[test]
    fn seeds_differ_and_bounds_hold() {
        let config = SeabedConfig {
            depth_min_m: 10.0,
            depth_max_m: 90.0,
            ..SeabedConfig::default()
        };
        let one = Seabed::new(&config, 1).unwrap();
        assert_ne!(one, Seabed::new(&config, 2).unwrap());
        for east in [-20_000.0, 20_000.0] {
            for north in [-20_000.0, 20_000.0] {
                assert!((10.0..=90.0).contains(&one.water_depth_m(EastNorth::new(east, north))));
            }
        }
    }

    #[test]
    fn a_grid_and_a_shelf_do_not_mix() {
        let parse = |text: &str| toml::from_str::<SeabedConfig>(text).unwrap();
        let message = |text: &str| validate(&parse(text)).unwrap_err().to_string();
        assert_eq!(
            message("grid = \"a.asc\"\nbanks = 2"),
            "seabed.banks: expected this key or `seabed.grid`, not both"
        );
        assert_eq!(
            message("grid_positive = \"up\""),
            "seabed.grid_positive: expected only together with `seabed.grid`"
        );
        let error = Seabed::new(&parse("grid = \"a.asc\""), 1).unwrap_err();
        assert_eq!(
            error.to_string(),
            "seabed.grid is `a.asc`, but the caller passed no grid: expected the content of that file"
        );
    }

    #[test]
    fn a_bad_key_is_named() {
        let config = SeabedConfig {
            slope: Span::between(0.1, 0.9),
            ..SeabedConfig::default()
        };
        assert_eq!(
            Seabed::new(&config, 1).unwrap_err().to_string(),
            "seabed.slope is 0.9, expected 0 to 0.5"
        );
    }
}
