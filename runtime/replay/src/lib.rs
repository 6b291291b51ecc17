//! Replays the log of a run, real or simulated.
//!
//! A log has every input of core with its time, in the order in which core handled them, and every output. So both parts
//! of the runtime that decide anything can be run again, each from what the other one did in the recorded run:
//!
//! - **Core** from the recorded inputs, among them what plugins returned. Each output must be the recorded one, byte for
//!   byte.
//! - **Each plugin** from the steps that core asked for. The component that the log has must return what it returned
//!   then: the same requests, lines and values, with the same fuel. If another component takes its place, the report says
//!   what that one would have asked for. Its requests reach nobody: the inputs stay those of the recorded run.
//!
//! [`Task::of`] reads what a log has of its mission, [`Replay::new`] compiles and starts the plugins, and
//! [`Replay::take`] is given one message of the log after the other. Nothing here reads a file or a clock.
//!
//! A wall-clock limit that ended a step of the recorded run is not asked again: the step ends as it did then
//! ([`backseat_plugin_host::Plugin::step_again`]). After a gap, core's state is unknown, so a replay ends there.

mod crew;
mod difference;
mod drawing;
mod error;
mod member;
mod playback;
mod report;
mod task;
mod words;

pub use difference::{Difference, OutputDifference, RestartDifference, Side, StepDifference};
pub use drawing::{Asked, Drawing, Steering, TrackPoint};
pub use error::ReplayError;
pub use playback::{Flow, Replay};
pub use report::{Absent, Component, PluginReport, Refused, Report};
pub use task::{Config, Configs, Given, Task};
pub use words::{describe_input, describe_request};
