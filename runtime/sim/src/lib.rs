//! Runtime, plugins and mock vehicle in one process on a virtual clock.
//!
//! [`Simulation`] is the second driver of `backseat_core::Core`, beside the one at sea: it carries out the same outputs
//! and gives the same inputs, and only the clock, the link and the vehicle are simulated. Time jumps from one event to
//! the next, so a mission takes only as long as its computation.
//!
//! The same mission, seed and components give the same bytes on the link. The digest shows this.

mod control;
mod digest;
mod expectation;
mod link;
mod report;
mod simulation;
mod survey_map;
mod trace;
mod vehicle_map;
mod verdict;

pub use control::{ControlTime, ControlTimes};
pub use digest::{Digest, Direction};
pub use report::{FirstFailure, Published, Report};
pub use simulation::sonars::FileSink;
pub use simulation::{SimError, Simulation, Step};
pub use survey_map::survey_map;
pub use trace::{Sample, Steering, Trace};
pub use vehicle_map::vehicle_map;
pub use verdict::{Gap, Verdict, VerdictError, judge_log};
