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

mod arbiter;
mod capability;
mod context;
mod control;
mod core;
pub mod ended;
mod external;
mod identifiers;
mod io;
mod ledger;
mod monitor;
#[cfg(feature = "mutations")]
pub mod mutations;
#[cfg(not(feature = "mutations"))]
mod mutations;
mod operator;
mod order;
mod outbox;
mod outlook;
mod owner;
pub mod plugin;
mod quota;
mod recovery;
pub mod refusal;
mod session;
mod settings;
mod stamp;
mod timer;
mod vehicle;

pub use core::Core;
pub use io::{Identifiers, Input, Note, Operator, Output, Reservation, Restarted, Start};
pub use ledger::{RequestCounts, RequestKind, Transition};
pub use monitor::envelope::Envelope;
pub use monitor::limits::integrity::IntegrityLimits;
pub use monitor::limits::plugin::PluginLimits;
pub use monitor::limits::station::{BottomBox, HullBox, StationLimits};
pub use monitor::limits::{FailAction, Grant, HeadingFrame, LimitError, Limits};
pub use order::{Condition, Order, Policy};
pub use owner::{ExternalId, Owner};
pub use settings::external::{ConductivityUnit, ExternalBounds, ExternalSentence, ExternalSetup};
pub use settings::recovery::Recovery;
pub use settings::{ControlHook, PluginSetup, Settings, StatusCondition};
pub use vehicle::expected::{ExpectedElement, ExpectedPath, ExpectedPlan};
