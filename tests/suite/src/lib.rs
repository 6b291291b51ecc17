//! Behavior tests of the program, at the level where users meet it: a command line, exit codes, two streams, files,
//! signals and a TCP port. Here is the harness; the tests are in `tests/it`, a file a behavior.
//!
//! The program is built once a process by [`backseat_test_support::program`], the plugins by
//! [`backseat_test_support::plugins`], so nothing has to be done by hand before `cargo test`.
//!
//! ```no_run
//! use backseat_suite::{Backseat, Mission};
//!
//! let mission = Mission::steady().edit("world.toml", "timeout_s = 600", "timeout_s = 60");
//! let report = Backseat::new().args(["sim", "--json"]).mission(&mission).run().exit(0).json();
//! assert_eq!(report["outcome"], "completed");
//! ```
//!
//! Tests on real time wait for what must happen with [`eventually`], generously; only safety bounds are held to the
//! second, and those by the vehicle's own clock in its log.

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
