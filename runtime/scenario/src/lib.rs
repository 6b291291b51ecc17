//! The part of a mission that only simulation needs: `world.toml` with the vehicle, the front seat's plan, faults and
//! expectations, and the files that it names; also the payload controller and what its sonars hear.
//!
//! A mission goes to sea without any of this, so an error here does not prevent a dive. A command that needs the
//! scenario reports the error in one line, with the file and the place.

mod controller;
mod error;
mod faults;
mod grid;
mod scenario;
mod set;
mod soundings;

pub use controller::{read_controller, true_pose};
pub use error::ScenarioError;
pub use faults::{read_faults, read_script};
pub use scenario::Scenario;
pub use set::{WORLD_PREFIX, split_sets};
pub use soundings::Soundings;
