//! What people look at the Standard Payload Interface with: the catalogue, recordings, hand-written sentences, a live
//! vehicle.
//!
//! [`list`], [`decode`] and [`encode`] are functions over `Read` and `Write`; [`connect`] is a driver, with a socket and a
//! clock. None of them decides anything for a vehicle, and the only sentence that any of them sends is BPLOG.

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
