//! Follows a depth contour by steering with modify requests.
//!
//! The water depth is the vehicle's depth plus its altitude. [`Seabed`] fits a surface to it by recursive least squares
//! with forgetting. [`Guidance`] steers by line of sight onto the contour of that surface, as Bennett and Leonard do
//! ("A behavior-based approach to adaptive feature detection and following with autonomous underwater vehicles", IEEE
//! J. Oceanic Eng. 25(2), 2000), and corrects for the current. [`Isobath`] decides when to make requests.

mod config;
mod current;
mod guidance;
mod plugin;
mod seabed;

pub use config::{Config, ConfigError};
pub use current::CurrentEstimate;
pub use guidance::{Aim, Guidance};
pub use plugin::Isobath;
pub use seabed::{Estimate, Seabed};

backseat_sdk::export!(Isobath);
