//! Judges a run from the recorded link bytes and the mock vehicle's truth alone.
//!
//! An [`Oracle`] is given every write on the vehicle link at its sender, every change of the link, and the vehicle's
//! truth ten times a second, all in the order of their times. It knows the fence, the [`Limits`], and what the safety
//! requirements promise; it shares no code with what it judges. What it finds are [`Violation`]s, and its
//! [`Statistics`] say how much there was to judge, so that an empty run is not taken for a clean one.
//!
//! Where the delay of the link leaves open what the runtime could have known, the oracle gives it the benefit of the
//! longest delay: a violation stands on any reading.

mod area;
mod conduct;
mod consequence;
mod control;
mod delivery;
mod due;
mod error;
mod geojson;
mod hold;
mod inserts;
mod lease;
mod limits;
mod lines;
mod navigation;
mod operator;
mod oracle;
mod plan;
mod plane;
mod process;
mod rule;
mod services;
mod stamps;
mod state;
mod statistics;
mod surroundings;
mod violation;
mod zone;

pub use error::OracleError;
pub use limits::{Activity, Caps, ControlHook, Limits, Truth};
pub use oracle::Oracle;
pub use state::State;
pub use statistics::Statistics;
pub use violation::Violation;
