//! Tools for people who work with the Standard Payload Interface: its catalogue, recordings, hand-written sentences, a
//! live vehicle.
//!
//! [`list`], [`decode`] and [`encode`] are functions over `Read` and `Write`; [`connect`] is a driver with a socket and
//! a clock. None of them makes decisions for a vehicle, and BPLOG is the only sentence that any of them sends.

mod address;
mod connect;
mod decode;
mod encode;
mod error;
mod list;
mod paint;
mod panel;
mod reading;
mod sheet;
mod splitter;
mod subscription;
mod tally;
mod text;
mod traffic;
mod watch;

pub use address::Address;
pub use connect::{Connection, View, Watched, connect};
pub use decode::{Decoding, decode};
pub use encode::encode;
pub use error::Error;
pub use list::{Listing, list};
pub use sheet::Form;
pub use subscription::Subscription;
pub use tally::Tally;
pub use traffic::{Traffic, decode_traffic};
