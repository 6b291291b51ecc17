//! Quantities, time and geodesy.
//!
//! Newtypes are made by meaning, not by dimension: [`Depth`] and [`Altitude`] are both metres, and mixing them is
//! the accident that loses vehicles. Plain `f64` stands only inside the mathematics, with its unit in its name.
//!
//! Every function here is arithmetic or [`math`] (the `libm` crate), so that the same inputs give the same bits on
//! every platform, the plugins' wasm32 included.

mod frame;
pub mod math;
mod position;
mod quantity;
mod time;
mod utm;

pub use frame::{EastNorth, LocalFrame};
pub use position::{Latitude, Longitude, Position};
pub use quantity::{Altitude, Depth, GridHeading, Heading, OutOfRange, Speed};
pub use time::{TimeOfDay, TimeOfDayError, Timestamp, Utc};
pub use utm::utm_convergence_deg;
