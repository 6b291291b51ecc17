//! What only simulation knows of a mission: `world.toml`, with the vehicle, the front seat's plan, faults and
//! expectations, and the files that it names.
//!
//! A mission goes to sea without any of it. What is wrong here keeps nobody from a dive, but for whoever asks for the
//! scenario: it gets one line with the file and the place.

mod error;
mod faults;
mod grid;
mod scenario;

pub use error::ScenarioError;
pub use faults::read_faults;
pub use scenario::Scenario;
