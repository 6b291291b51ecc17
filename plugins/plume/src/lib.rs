//! Maps a scalar from the vehicle's CTD with tracklines, finds its maximum, and circles it.
//!
//! The lines are inserts: the vehicle flies them by itself, one after the other. As it goes back to its own plan when
//! nothing is queued, the next must be with it before the current one ends: [`Plume`] keeps two queued ahead, and
//! decides on what depends on the measurements while a line is still being flown. First comes a lawnmower over the
//! [`Area`], then a cross through the maximum as [`locate`] then knows it, then the circle.

mod area;
mod config;
mod gaussian;
mod least_squares;
mod locate;
mod plugin;
mod samples;
mod survey;

pub use area::{Area, Line};
pub use config::{BoxConfig, Channel, Config, ConfigError};
pub use gaussian::Gaussian;
pub use locate::{Located, Method, locate};
pub use plugin::Plume;
pub use samples::{Bin, Samples};

backseat_sdk::export!(Plume);
