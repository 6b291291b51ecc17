//! Behavior tests of the program from a user's point of view: a command line, exit codes, two streams, files, signals
//! and a TCP port. This crate is the harness; the tests are in `tests/it`, one file for each behavior.
//!
//! [`backseat_test_support::program`] builds the program once for each process, and [`backseat_test_support::plugins`]
//! the plugins, so that `cargo test` needs no preparation.
//!
//! ```no_run
//! use backseat_suite::{Backseat, Mission};
//!
//! let mission = Mission::steady().edit("world.toml", "timeout_s = 600", "timeout_s = 60");
//! let report = Backseat::new().args(["sim", "--json"]).mission(&mission).run().exit(0).json();
//! assert_eq!(report["outcome"], "completed");
//! ```
//!
//! Tests in real time wait with [`eventually`] for what must happen, and allow it plenty of time. Only safety bounds
//! are checked to the second, by the vehicle's own clock in its log.

mod clock;
mod mission;
mod process;
mod program;
mod scripted;
mod stall;
mod vehicle;

pub use clock::{Stopwatch, eventually, settle};
pub use mission::Mission;
pub use process::Process;
pub use program::{Backseat, Finished};
pub use rustix::process::Signal;
pub use scripted::{Behavior, Heard, Scripted};
pub use stall::Stall;
pub use vehicle::{Line, Vehicle, Way, free_address};
