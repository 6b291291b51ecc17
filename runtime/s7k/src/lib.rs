//! The RESON 7k data format as the 6046 payload controller (PLC) uses it: Volume III 0.53 with the framing of Volume I.
//!
//! A *record* is a [`frame`]: a header, a record type header and data, optional data, a checksum. Files hold records one
//! behind the other; on the wire each record is enclosed in one or more network frames. All numbers are little-endian and
//! packed.
//!
//! Reading borrows: a [`Frame`] and everything that is read from it point into the bytes that it was read from.
//! Every bit pattern of a fixed part is read and written again as it was; [`FieldFault`] says which values are outside
//! their ranges.

mod catalogue;
mod checksum;
mod device;
pub mod file;
mod frame;
mod layout;
mod network;
pub mod plc;
pub mod record;
mod stream;
mod time;
mod wire;

pub use catalogue::{codes, layouts};
pub use checksum::{BluefinChecksum, byte_sum};
pub use device::{DeviceId, SensorIndex};
pub use frame::{
    Checksum, FRAME_LIMIT, Frame, FrameError, FrameHeader, FrameWriter, Optional, SYNC, TooLong, read_header,
};
pub use layout::{FieldFault, Layout, LayoutField, Range, Truncated};
pub use network::{NetworkError, NetworkHeader};
pub use stream::{StreamCounts, StreamError, StreamItem, StreamReader};
pub use time::Time7k;
pub use wire::{Chars, CodeTable, Reserved};
