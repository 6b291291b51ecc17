//! Quantities, time and geodesy.
//!
//! There is one newtype for each meaning, not for each dimension: [`Depth`] and [`Altitude`] are both in metres, and
//! mistaking one for the other is how vehicles are lost. Plain `f64` occurs only inside the mathematics, with its unit
//! in its name.
//!
//! Every function uses plain arithmetic and [`math`] (the crate `libm`) only. So the same inputs give the same bits on
//! every platform, also in the plugins' wasm32.

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
