//! Tests of a plugin on the host, in milliseconds and without the runtime.
//!
//! - [`Harness`] steps a plugin: a test gives events, control and navigation, and looks at the requests, the log and the
//!   measures.
//! - [`Basin`] has a simple vehicle, which flies what the plugin asks for, for an hour in some milliseconds, with
//!   [`Fault`]s. It is no simulation: the vehicle turns at once, the fence is a circle, and nothing else is checked. It
//!   finds mistakes in a plugin's own logic. `backseat plugin test` flies the plugin in the simulation.
//!
//! ```
//! use std::time::Duration;
//!
//! use backseat_sdk::survey::{Flight, InsertQueue, Leg, Rectangle};
//! use backseat_sdk::testing::{Basin, Fault};
//! use backseat_sdk::{Briefing, Description, NoConfig, Plugin, Request, StepInput, Vertical, units::EastNorth};
//! # use backseat_sdk::units::{LocalFrame, Position};
//!
//! struct Survey {
//!     frame: Option<LocalFrame>,
//!     queue: InsertQueue,
//! }
//!
//! impl Plugin for Survey {
//!     type Config = NoConfig;
//! #   fn describe() -> Description {
//! #       Description { name: "survey".into(), version: "0".into(), step_period_ns: 1_000_000_000, topics: vec![], grants: vec![] }
//! #   }
//!     // …
//! #   fn new(_: NoConfig) -> Result<Self, String> {
//! #       let mut queue = InsertQueue::default();
//! #       let area = Rectangle::new(EastNorth::default(), 400.0, 200.0, 0.0);
//! #       queue.extend(area.lawnmower(50.0, EastNorth::default()).into_iter().map(Leg::Line));
//! #       Ok(Self { frame: None, queue })
//! #   }
//! #   fn brief(&mut self, briefing: &Briefing) -> Result<(), String> {
//! #       self.frame = Some(briefing.frame()?);
//! #       Ok(())
//! #   }
//! #   fn step(&mut self, input: &StepInput) -> Result<Vec<Request>, String> {
//! #       let frame = self.frame.ok_or("no frame")?;
//! #       Ok(self.queue.step(input, &Flight { frame, vertical: Vertical::Depth(15.0), speed_mps: 1.5 }))
//! #   }
//! #   backseat_sdk::keep!(queue);
//! }
//!
//! // The same survey, whatever happens on the way.
//! for seed in 0..50 {
//!     let mut basin = Basin::<Survey>::new("{}").unwrap();
//!     basin.faults = Fault::draw(seed);
//!     let flight = basin.fly(Duration::from_secs(7200));
//!     assert!(flight.failures.is_empty(), "{:?}", flight.failures);
//!     assert!(basin.harness.plugin.queue.is_done(), "seed {seed}: {:?}", basin.faults);
//! }
//! ```

mod basin;
mod fault;
mod harness;

use std::collections::BTreeMap;

pub use basin::{Basin, Flown};
pub use fault::Fault;
pub use harness::Harness;

use crate::host::{Recorder, with};
use crate::{Refusal, Request};

/// Calls a function in which [`fence::check`](crate::fence::check) gives these answers: a refusal, or `None` if there is
/// room. For a test that steps a plugin by itself, without a [`Harness`].
pub fn with_fence<R>(fence: impl FnMut(&Request) -> Option<Refusal> + 'static, call: impl FnOnce() -> R) -> R {
    let recorder = Recorder {
        lines: Vec::new(),
        measures: BTreeMap::new(),
        fence: Box::new(fence),
    };
    with(recorder, call).1
}
