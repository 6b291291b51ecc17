//! The simulated sea: seabed, tide, current, scalar fields and targets, drawn by a seed.
//!
//! A [`World`] is made once from a [`WorldConfig`] and a seed. From then on it is a pure function of place and time: it
//! has no state that changes, so the vehicle, its sensors and the judge of a run all see the same sea. Everything is
//! analytic, except a seabed from a [`Grid`]. Places are in the east-north frame around the configured origin. `north`
//! is the frame's north, which differs from true north by
//! [`LocalFrame::convergence_deg`](backseat_units::LocalFrame::convergence_deg).
//!
//! | section | what it gives | see |
//! |---|---|---|
//! | `[origin]` | the frame | [`OriginConfig`] |
//! | `[seabed]` | a shelf with meanders and banks, or a grid from a file | [`SeabedConfig`] |
//! | `[[seabed.patches]]` | what the seabed is made of, for a sonar | [`PatchConfig`] |
//! | `[[seabed.layers]]` | layers below the seabed, for a sub-bottom profiler | [`SedimentLayerConfig`] |
//! | `[tide]` | the water level | [`TideLevelConfig`] |
//! | `[current]` | a mean flow, tidal ellipses, layers, a boundary layer at the bed | [`CurrentConfig`] |
//! | `[field]` | temperature, conductivity and a tracer: thermocline, plumes, filaments, fronts | [`FieldConfig`] |
//! | `[[targets]]` | objects on the seabed, for a sonar | [`TargetConfig`] |
//!
//! Salinity, pressure and the speed of sound are computed from the fields with the equations in [`seawater`].
//!
//! Numbers in the configuration are [`Span`]s: one number, or a range `[least, most]` from which the seed draws. Each
//! part of the world draws from its own [`Stream`], so a change to one part does not change the others.
//!
//! The crate opens no file. If `seabed.grid` names one, the code that reads the configuration must read it too:
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
//! // The content of the file that `config.seabed.grid` names.
//! let bytes = b"ncols 2 nrows 2 xllcorner -100 yllcorner -100 cellsize 100  30 30  40 40";
//! let world = World::with_grid(&config, 7, Some(Grid::from_bytes(bytes)?))?;
//! assert_eq!(world.water_depth_m(backseat_units::EastNorth::default()), 35.0);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod bottom;
mod current;
mod error;
mod field;
mod grid;
mod seabed;
pub mod seawater;
mod sediment;
mod span;
mod stream;
mod targets;
mod tide;
mod world;

pub use bottom::{Bottom, BottomClass, Patch, PatchConfig, Texture};
pub use current::{Current, CurrentConfig, LayerConfig, TideConfig};
pub use error::WorldError;
pub use field::{Field, FieldConfig, FilamentConfig, FrontConfig, PlumeConfig, ThermoclineConfig};
pub use grid::{Grid, GridFrame, GridPositive};
pub use seabed::{Seabed, SeabedConfig};
pub use sediment::{SedimentLayer, SedimentLayerConfig};
pub use span::Span;
pub use stream::Stream;
pub use targets::{Target, TargetConfig, TargetKind};
pub use tide::TideLevelConfig;
pub use world::{OriginConfig, World, WorldConfig};
