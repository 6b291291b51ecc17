//! The sentences that are judged, read from the specification (SPI 1.12a) and by nothing of `backseat-spi`: what that
//! crate misreads or miswrites must not be misread here in the same way.
//!
//! What we write is held to the specification's every word ([`read_ours`]): all 37 sentences, each of their fields, and
//! nothing after the last one. What the vehicle writes is read as any client may read it ([`read_vehicle`]): the eleven
//! sentences that a rule needs, with noise before them, more fields after them, blanks around numbers.
//!
//! No bytes make either reader panic, and neither allocates.

mod fields;
mod line;
mod ours;
mod vehicle;

pub use fields::{Fault, Setpoint, Speed};
pub use line::LINE_MAX;
pub(crate) use line::{newest_sentence, sentences};
pub use ours::{Modify, Ours, Request, Trackcircle, Trackline, read_ours};
pub use vehicle::{Answer, Element, Fix, Outcome, Said, Velocities, read_vehicle};
