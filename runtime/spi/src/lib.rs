//! The Bluefin Standard Payload Interface (SPI 1.12a): framing, typed messages, catalogue.
//!
//! Bytes become sentences in a [`Framer`], sentences become messages by [`FromVehicle::decode`] and
//! [`ToVehicle::decode`], and messages become bytes again by `encode`. There is one enum a direction, so that sending
//! what only the vehicle sends does not compile. Nothing here does I/O or knows the time.
//!
//! Decoding is tolerant, as real vehicles and clients need it: more fields than expected, blanks around numbers,
//! missing zero padding and absent checksums of payloads pass; what cannot be read is an error that names message,
//! field and fault. Encoding is strict: three decimals of a second, a checksum of two upper-case digits, CRLF, and an
//! error rather than a sentence that the other side could misread.
//!
//! ```
//! use backseat_spi::{Framer, FromVehicle, Policy};
//!
//! let mut framer = Framer::new(Policy::FromVehicle);
//! framer.push(b"$BFCTL,081025.987,1*78\r\n");
//! let sentence = framer.next_sentence().expect("one whole sentence was pushed");
//! let message = FromVehicle::decode(&sentence)?;
//! assert!(matches!(message, FromVehicle::BackseatControl(control) if control.granted));
//! # Ok::<(), backseat_spi::DecodeError>(())
//! ```

mod catalogue;
mod codes;
mod error;
mod field;
mod forms;
mod framer;
mod from_vehicle;
mod identity;
mod number;
mod sentence;
mod table;
mod text;
mod to_vehicle;
mod unknown;

pub use catalogue::{Direction, Entry, EntryField, catalogue};
pub use codes::{
    AckStatus, HorizontalMode, Interrupt, ModifySpeedMode, ModifyVerticalMode, PlanElementKind, PositionQuality,
    SpeedMode, VerticalMode,
};
pub use error::{DecodeError, EncodeError, Fault};
pub use framer::{FrameCounts, Framer, Policy};
pub use from_vehicle::{
    Acknowledgement, BackseatControl, BehaviorBegin, BehaviorEnd, Ctd, FromVehicle, MissionCommand, MissionStatus,
    Navigation, PlanElement, Shutdown, VehicleVersion, VelocityAndRates,
};
pub use identity::{BehaviorId, CommandName, CommandNameError};
pub use sentence::{ChecksumState, Fields, Sentence, SentenceError};
pub use text::{Text, TextError};
pub use to_vehicle::{
    CancelAll, CancelBehavior, EndModify, LogMessage, LoggingControl, ModifyBehavior, PayloadStatus, PayloadVersion,
    RequestPlan, ToVehicle, Trackcircle, Trackline,
};
pub use unknown::UnknownMessage;

/// The longest line that is read or written, bytes, from `$` to the line feed and with both.
///
/// The specification names no limit. This one is over every sentence of it but the acoustic packets of the fastest
/// modems: BFCPR and BPCPD may hold eight frames in hexadecimal digits (SPI 9.3, 9.4).
pub const MAX_LINE: usize = 1024;
