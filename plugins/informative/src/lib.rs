//! Maps a field, such as the temperature at one depth, with more care where it is high: informative path planning.
//!
//! A Gaussian process says at each place what value is expected and how uncertain that is. While the vehicle flies a line,
//! [`Planner`] looks for the next one: of some plans of two lines, it takes the one after which least uncertainty is left,
//! where the uncertainty of high places counts more. Of that plan only the first line is flown, and then the next one is
//! planned with what was measured (a receding horizon). The method is that of Hitz, Galceran, Garneau, Pomerleau and
//! Siegwart ("Adaptive continuous-space informative path planning for online environmental monitoring", J. Field Robotics
//! 34(8), 2017), with straight lines in place of splines, and as many plans a step as the fuel allows.

mod config;
mod planner;
mod plugin;

pub use config::{Config, ConfigError};
pub use planner::{Planner, Settings};
pub use plugin::Informative;

backseat_sdk::export!(Informative);
