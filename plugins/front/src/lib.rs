//! Zigzags over a front, a narrow zone between warm and cold water, and stays with it while it moves.
//!
//! The vehicle steers across the front at an angle. When it is far enough on the other side, it turns back, as Zhang,
//! Godin, Bellingham and Ryan do ("Using an autonomous underwater vehicle to track a coastal upwelling front", IEEE J.
//! Oceanic Eng. 37(3), 2012). They tell the two waters apart by their stratification; here it is the temperature at one
//! depth, against the mean of the warmest and the coldest water on the last two legs. [`Tracker`] decides when to turn,
//! [`FrontPlugin`] makes the requests.

mod config;
mod plugin;
mod tracker;

pub use config::{Config, ConfigError};
pub use plugin::FrontPlugin;
pub use tracker::{Settings, Tracker};

backseat_sdk::export!(FrontPlugin);
