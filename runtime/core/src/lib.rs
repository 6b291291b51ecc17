//! The backseat's state machine: session, control, leases, plan, ledger, assurance.
//!
//! Sans-IO and deterministic: no clock, no thread, no hash order. A driver hands [`Core::handle`] what happens, with
//! the time, then drains [`Core::poll_output`], and calls again no later than [`Core::poll_timeout`]:
//!
//! ```text
//! loop {
//!     core.handle(now, input);
//!     while let Some(output) = core.poll_output() { carry_out(output) }
//!     input = whichever_is_first(what_happens(), core.poll_timeout());
//! }
//! ```
//!
//! The driver at sea and the virtual clock of the simulation are both such loops, so what was simulated is what goes
//! to sea. Plugins are effects: [`Output::Invoke`] goes out and [`Input::Returned`] comes back.
//!
//! The safety requirements that code here keeps are cited where it keeps them, by their number in
//! `runtime/docs/safety.md`.

mod acoustic;
mod adjustment;
mod arbiter;
mod budget;
mod capability;
mod clock;
mod commands;
mod context;
mod control;
mod core;
mod course;
mod devices;
mod dispatch;
mod dive;
mod drivers;
mod dvl;
mod envelope;
mod expected;
mod former;
mod gate;
mod heartbeat;
mod helm;
mod hull;
mod hull_limits;
mod identifiers;
mod inserts;
mod integrity;
mod integrity_limits;
mod io;
mod irrevocable;
mod ledger;
mod limits;
mod link;
mod monitor;
mod named_insert;
mod navigation;
mod orders;
mod outbox;
mod outlook;
mod owner;
mod phase;
mod plan;
pub mod plugin;
mod plugin_limits;
mod plugins;
mod queue;
mod quota;
mod reads;
mod recall;
mod recovery;
mod refusal;
mod samples;
mod schedule;
mod session;
mod settings;
mod silent;
mod stamp;
mod subscriptions;
#[cfg(feature = "switches")]
pub mod switches;
#[cfg(not(feature = "switches"))]
mod switches;
mod timer;
mod topside;
mod vehicle;

pub use core::Core;
pub use drivers::{ConductivityUnit, DriverBounds, DriverSentence, DriverSetup};
pub use envelope::Envelope;
pub use expected::{ExpectedElement, ExpectedPath, ExpectedPlan};
pub use hull_limits::{BottomBox, HullBox, HullLimits};
pub use integrity_limits::IntegrityLimits;
pub use io::{Identifiers, Input, Note, Operator, Output, Reservation, Restarted, Start};
pub use ledger::{RequestCounts, RequestKind, Transition};
pub use limits::{FailAction, Grant, HeadingFrame, LimitError, Limits};
pub use orders::{Condition, Order, Policy};
pub use owner::{DriverId, Owner};
pub use plugin_limits::PluginLimits;
pub use recovery::Recovery;
pub use settings::{ControlHook, PluginSetup, Settings, StatusCondition};
