//! Searches an area for warm water, and maps what it finds: informative path planning.
//!
//! A Gaussian process says at each place what temperature is expected and how uncertain that is. The vehicle first flies
//! some lines that are far apart, over the whole area. Then, while it flies a line, [`Search`] looks for the next one: of
//! many plans of one or two lines, it takes the one that leaves least variance for its length, where a place counts as much
//! as it is likely to be warmer than `warm_c`. Of that plan only the first line is flown, and then the next one is planned
//! with what was measured (a receding horizon). At the end a circle marks the warmest place, and the map is published.
//!
//! The framework is that of Popović, Vidal-Calleja, Hitz, Chung, Sa, Siegwart and Nieto ("An informative path planning
//! framework for UAV-based terrain monitoring", Autonomous Robots 44, 2020): what a plan takes away from the variance of the
//! map over the cost of its way, only where the value may be above a threshold, with a coarse choice of way points that is
//! refined. One thing differs: they count a place fully if its upper confidence bound is above the threshold, and not at
//! all otherwise. Here it counts by the probability that it is above, which was better in simulation.

mod config;
mod planner;
mod plugin;
mod report;
mod samples;
mod settings;
mod survey;
#[cfg(test)]
mod tests;

pub use config::{Config, ConfigError};
pub use planner::{Progress, Search};
pub use plugin::Informative;
pub use report::{Found, Peak};
pub use samples::Samples;
pub use settings::Settings;
pub use survey::Survey;

backseat_sdk::export!(Informative);
