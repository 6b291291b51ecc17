//! The state machine of the backseat: session, control, leases, plan, ledger, safety monitor.
//!
//! It is sans-IO and deterministic: it has no clock and no thread, and nothing depends on hash order. A driver passes
//! each event and its time to [`Core::handle`], drains [`Core::poll_output`], and calls again no later than
//! [`Core::poll_timeout`]:
//!
//! ```text
//! loop {
//!     core.handle(now, input);
//!     while let Some(output) = core.poll_output() { carry_out(output) }
//!     input = whichever_is_first(what_happens(), core.poll_timeout());
//! }
//! ```
//!
//! The driver at sea and the simulation with its virtual clock are both such loops, so the code that goes to sea is the
//! code that was simulated. Core does not call a plugin. It asks for a step with [`Output::Invoke`], and the driver
//! answers with [`Input::Returned`].
//!
//! Code that keeps a safety requirement cites the requirement by its number in `runtime/docs/safety.md`.

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
mod sonars;
mod stamp;
mod timer;
mod vehicle;

pub use core::Core;
pub use io::{
    FromSonar, Identifiers, Input, Note, Operator, Output, Reservation, Restarted, SonarOrder, SonarOutcome,
    SonarRates, Start, ToSonar,
};
pub use ledger::{RequestCounts, RequestKind, Transition};
pub use monitor::envelope::{Envelope, LeaseReach};
pub use monitor::limits::integrity::IntegrityLimits;
pub use monitor::limits::plugin::PluginLimits;
pub use monitor::limits::station::{BottomBox, HullBox, StationLimits};
pub use monitor::limits::{FailAction, Grant, HeadingFrame, LimitError, Limits};
pub use order::{Condition, Order, Policy};
pub use owner::{ExternalId, Owner};
pub use settings::external::{ConductivityUnit, ExternalBounds, ExternalSentence, ExternalSetup};
pub use settings::recovery::Recovery;
pub use settings::{ControlHook, PluginSetup, Settings, SonarSetup, StatusCondition};
pub use vehicle::expected::{ExpectedElement, ExpectedPath, ExpectedPlan};
