//! The hunt looks for a mission in which something unsafe is sent, or in which control is not handed back.
//!
//! A seed draws a [`Scenario`] (fence, limits, the front seat's plan, the world, the mock's choices where the
//! specification is open, two plugins that make requests all the time) and [`Fault`]s: faults of link, vehicle and
//! navigation, plugins that misbehave, a runtime that is killed, stopped or has a full disk, and the operator's hold.
//! Each fault begins at a time, or when the run is in a certain state, for example while an insert is unanswered or
//! under a lease. Together they are a [`Plan`], which is data that can be printed, kept and replayed.
//!
//! [`Range::fly`] flies it in simulation with the code that goes to sea: a safety phase with faults, then a liveness
//! phase without, in which everything must converge. `backseat-oracle` judges safety from the bytes on the link and the
//! vehicle's truth alone. A [`Flight`] that fails is [shrunk](shrink) to a small plan that fails in the same way.

mod area;
mod clean;
mod coverage;
mod dice;
mod digests;
mod excuse;
mod fault;
mod flight;
mod hunt;
mod margins;
mod phase;
mod plan;
mod scenario;
mod shrink;

pub use clean::Alarm;
pub use coverage::Coverage;
pub use digests::{Digests, each_seed, of_mission, of_plans};
pub use fault::{Fault, PLUGIN_FAULTS, SWAPS};
pub use flight::{Failure, Flight, Range};
pub use hunt::{Flown, Hunt, Order};
pub use plan::{Come, Plan, Planned};
pub use scenario::Scenario;
pub use shrink::shrink;
