//! What only simulation knows: seabed, tide, current, scalar fields and targets; seeded.
//!
//! A [`World`] is made once from a [`WorldConfig`] and a seed, and is then a pure function of place and time: it has
//! no state that moves, so that the vehicle, its sensors and the judge of a run all see the same sea. Everything is
//! analytic but a seabed from a [`Grid`], in the east-north frame about the configured origin; `north` here is the
//! frame's, which differs from true north by
//! [`LocalFrame::convergence_deg`](backseat_units::LocalFrame::convergence_deg).
//!
//! | section | what it gives | see |
//! |---|---|---|
//! | `[origin]` | the frame | [`OriginConfig`] |
//! | `[seabed]` | a shelf with meanders and banks, or a grid from a file | [`SeabedConfig`] |
//! | `[tide]` | the water level | [`TideLevelConfig`] |
//! | `[current]` | a mean flow, tidal ellipses, layers, a boundary layer at the bed | [`CurrentConfig`] |
//! | `[field]` | temperature, conductivity and a tracer: thermocline, plumes, filaments, fronts | [`FieldConfig`] |
//! | `[[targets]]` | things on the seabed, for a sonar | [`TargetConfig`] |
//!
//! Salinity, pressure and the speed of sound follow from the fields by [`seawater`]'s equations.
//!
//! Numbers of the configuration are [`Span`]s: one number, or `[least, most]` between which the seed draws.
//! Each source of chance has its own [`Stream`], so that a change in one leaves the others as they were.
//!
//! The crate opens no file. Where `seabed.grid` names one, whoever reads the configuration reads it too:
//!
//! ```
//! use backseat_world::{Grid, World, WorldConfig};
//!
//! let config: WorldConfig = toml::from_str(r#"
//! [origin]
//! latitude_deg = 42.3
//! longitude_deg = -70.9
//! [seabed]
//! grid = "bed.asc"
//! "#)?;
//! // Of the file that `config.seabed.grid` names.
//! let bytes = b"ncols 2 nrows 2 xllcorner -100 yllcorner -100 cellsize 100  30 30  40 40";
//! let world = World::with_grid(&config, 7, Some(Grid::from_bytes(bytes)?))?;
//! assert_eq!(world.water_depth_m(backseat_units::EastNorth::default()), 35.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod current;
mod error;
mod field;
mod grid;
mod seabed;
pub mod seawater;
mod span;
mod stream;
mod targets;
mod tide;
mod world;

pub use current::{Current, CurrentConfig, LayerConfig, TideConfig};
pub use error::WorldError;
pub use field::{Field, FieldConfig, FilamentConfig, FrontConfig, PlumeConfig, ThermoclineConfig};
pub use grid::{Grid, GridFrame, GridPositive};
pub use seabed::{Seabed, SeabedConfig};
pub use span::Span;
pub use stream::Stream;
pub use targets::{Target, TargetConfig, TargetKind};
pub use tide::TideLevelConfig;
pub use world::{OriginConfig, World, WorldConfig};
