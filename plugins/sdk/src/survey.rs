//! Tools for surveys: lines, rectangles and their lawnmowers, a queue of inserts with retries, named timers, a grid of
//! what was seen, gradients, contours and Gaussian processes.
//!
//! Points are metres east and north in a local frame, usually the mission's ([`Briefing::frame`](crate::Briefing::frame)).
//! What has a state derives `serde`'s traits, so that it can be a field of the state that a plugin keeps with
//! [`keep!`](crate::keep!).
//!
//! ```
//! use backseat_sdk::survey::{Flight, InsertQueue, Leg, Rectangle};
//! use backseat_sdk::units::{EastNorth, LocalFrame, Position};
//! use backseat_sdk::{StepInput, Vertical};
//!
//! let frame = LocalFrame::new(Position::from_deg(42.35, -70.7).unwrap());
//! let area = Rectangle::new(EastNorth::new(0.0, 300.0), 800.0, 400.0, 90.0);
//! let mut queue = InsertQueue::default();
//! queue.extend(area.lawnmower(100.0, EastNorth::default()).into_iter().map(Leg::Line));
//!
//! // In each step:
//! let flight = Flight { frame, vertical: Vertical::Depth(15.0), speed_mps: 1.5 };
//! let input = StepInput { control: true, ..StepInput::default() };
//! let requests = queue.step(&input, &flight);
//! assert_eq!(requests.len(), 3, "one leg to fly and two behind it");
//! ```

mod contour;
mod gaussian_process;
mod gradient;
mod grid;
mod inserts;
mod shapes;
mod timers;

pub use contour::ContourFollower;
pub use gaussian_process::{Estimate, FieldMap, GaussianProcess, Kernel, Known};
pub use gradient::{PlaneFit, Slope};
pub use grid::CoverageGrid;
pub use inserts::{Circle, Flight, InsertQueue, Leg, QueueSettings, Standing, Task, Turn};
pub use shapes::{Line, Rectangle, expanding_square};
pub use timers::Timers;
