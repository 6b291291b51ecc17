//! The hunt: looks for a mission in which something unsafe is sent, or in which the helm does not come back.
//!
//! A seed draws a [`Scenario`] (fence, limits, the front seat's plan, the world, how it reads what the specification
//! leaves open, two restless plugins) and [`Fault`]s: faults of link, vehicle and navigation, plugins that go wrong,
//! the runtime killed, stopped or with a full disk, the operator's hold. Each fault comes at a time, or when the run
//! is in a state: while an insert is not answered, under a lease. Together they are a [`Plan`], data that is printed,
//! kept and replayed.
//!
//! [`Range::fly`] flies it in simulation, on the code that goes to sea: a safety phase with faults, then a liveness
//! phase without, in which all must converge. `backseat-oracle` judges what is safe from the bytes on the link and the
//! vehicle's truth alone. A [`Flight`] that fails is [shrunk](shrink) to a plan that is small and fails the same way.

mod area;
mod clean;
mod coverage;
mod dice;
mod digests;
mod excuse;
mod fault;
mod flight;
mod hunt;
mod phase;
mod plan;
mod scenario;
mod shrink;

pub use clean::Alarm;
pub use coverage::Coverage;
pub use digests::{Digests, each_seed, of_mission, of_plans};
pub use fault::{Fault, PLUGIN_FAULTS};
pub use flight::{Failure, Flight, Range};
pub use hunt::{Flown, Hunt, Order};
pub use plan::{Come, Plan, Planned};
pub use scenario::Scenario;
pub use shrink::shrink;
