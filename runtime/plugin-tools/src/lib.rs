//! The tools of a plugin's author, for folders anywhere: someone with the program and a Rust toolchain, or Python,
//! needs nothing else of this project.
//!
//! | module | what it does |
//! |---|---|
//! | `kit` | the sources of the SDK, which the program carries: unpacks them into the user's data folder, and repairs them |
//! | `project` | makes a new plugin, and finds the parts of one |
//! | `python` | the environment in which plugins in Python are tested and built |
//! | `build` | runs the author's unit tests, and builds the component |
//! | `component` | what a file says of itself before anything of it is compiled or run |
//! | `trial` | flies a mission with a plugin, and measures the plugin |
//! | `report` | what an operator reads before signing a plugin off |
//!
//! Nothing here reads a clock: the caller passes a [`Stopwatch`].

mod build;
mod component;
mod error;
mod grant;
mod kit;
mod project;
mod python;
mod report;
mod tally;
mod trial;

pub use backseat_plugin_host::Stopwatch;

pub use build::{build, unit_tests};
pub use component::{ComponentFile, Inspection, Interface};
pub use error::ToolError;
pub use kit::Kit;
pub use project::{Language, Project};
pub use report::{Headroom, OfMission, Report, Task, TrialFault, Trials, Used};
pub use tally::{Fault, KindTally, Refused};
pub use trial::{Flights, Trial};

/// SHA-256 in hexadecimal.
fn sha256(bytes: &[u8]) -> String {
    use sha2::{Digest as _, Sha256};
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}
