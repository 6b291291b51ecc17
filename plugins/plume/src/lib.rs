//! Maps a quantity that the vehicle's CTD measures, by flying tracklines; finds its maximum, and circles it.
//!
//! The lines are inserts, which the vehicle flies by itself, one after the other. The vehicle returns to its own plan
//! when nothing is queued, so it must receive the next line before the current one ends. The SDK's queue therefore keeps two
//! lines queued, and [`Plume`] decides on the next stage while a line is still being flown. The first stage is a lawnmower
//! pattern over the [`Area`], the second a cross through the maximum that [`locate`] finds, the last a circle.

mod area;
mod config;
mod gaussian;
mod least_squares;
mod locate;
mod plugin;
mod samples;
mod survey;

pub use area::Area;
pub use config::{BoxConfig, Channel, Config, ConfigError};
pub use gaussian::Gaussian;
pub use locate::{Located, Method, locate};
pub use plugin::Plume;
pub use samples::{Bin, Samples};

backseat_sdk::export!(Plume);
