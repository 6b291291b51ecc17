//! What only simulation knows: seabed, current, scalar fields; seeded.
//!
//! A [`World`] is made once from a [`WorldConfig`] and a seed, and is then a pure function of place and time: it has
//! no state that moves, so that the vehicle, its sensors and the judge of a run all see the same sea. Everything is
//! analytic, in the east-north frame about the configured origin; `north` here is the frame's, which differs from true
//! north by [`LocalFrame::convergence_deg`](backseat_units::LocalFrame::convergence_deg).
//!
//! Numbers of the configuration are [`Span`]s: one number, or `[least, most]` between which the seed draws.
//! Each source of chance has its own [`Stream`], so that a change in one leaves the others as they were.

mod current;
mod error;
mod field;
mod grid;
mod seabed;
mod span;
mod stream;
mod world;

pub use current::{Current, CurrentConfig, LayerConfig, TideConfig};
pub use error::WorldError;
pub use field::{Field, FieldConfig, PlumeConfig};
pub use grid::{Grid, GridFrame, GridPositive};
pub use seabed::{Seabed, SeabedConfig};
pub use span::Span;
pub use stream::Stream;
pub use world::{OriginConfig, World, WorldConfig};
