//! Readers for the sentences that the oracle judges. They follow the specification (SPI 1.12a) and use nothing of
//! `backseat-spi`, so that they do not repeat an error of that crate.
//!
//! [`read_ours`] accepts from us only what the specification defines: all 37 sentences with each of their fields, and
//! nothing after the last field. [`read_vehicle`] reads the vehicle's bytes as any client may read them: the twelve
//! sentences that a rule needs, with noise before them, more fields after them, and blanks around numbers.
//!
//! Neither reader panics on any bytes, and neither allocates.

mod fields;
mod line;
mod ours;
mod vehicle;

pub use fields::{Fault, Setpoint, Speed};
pub use line::LINE_MAX;
pub(crate) use line::{newest_sentence, sentences};
pub use ours::{Modify, Ours, Request, Trackcircle, Trackline, read_ours};
pub use vehicle::{Answer, Element, Fix, Outcome, Said, Velocities, read_vehicle};
