//! The Bluefin Standard Payload Interface (SPI 1.12a): framing, typed messages, catalogue.
//!
//! A [`Framer`] cuts bytes into sentences, [`FromVehicle::decode`] and [`ToVehicle::decode`] make messages of
//! sentences, and `encode` turns messages into bytes again. Each direction has an enum of its own, so a program that
//! sends a message of the vehicle does not compile. This crate does no I/O and reads no clock.
//!
//! Decoding is tolerant, because real vehicles and clients need it: it accepts more fields than expected, blanks around
//! numbers, missing zero padding, and payloads' sentences without a checksum. For what it cannot read it returns an
//! error that names message, field and fault. Encoding is strict: it writes three decimals of a second, a checksum of
//! two upper-case digits and CRLF, and returns an error rather than write a sentence that the other side could misread.
//! A few values are accepted in decoding and refused in encoding, where losing the whole message would be worse.
//!
//! Messages serialise as their fields, without their name. [`FromVehicle::deserialize_named`] and
//! [`ToVehicle::deserialize_named`] read them back. [`catalogue`] lists all 71 messages with their sections, units and
//! ranges.
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
mod circle_entry;
mod codes;
mod echo;
mod error;
mod field;
mod forms;
mod framer;
mod from_vehicle;
mod hex;
mod identity;
mod number;
mod packet;
mod sentence;
mod table;
mod text;
mod to_vehicle;
mod unknown;
mod word;

pub use catalogue::{Direction, Entry, EntryField, catalogue};
pub use circle_entry::CircleEntry;
pub use codes::{
    AbortReason, AckStatus, AdjustmentError, AdjustmentStatus, DurationUnit, FrameReceivedStatus, FrameSentStatus,
    HorizontalMode, Interrupt, ModifySpeedMode, ModifyVerticalMode, PlanElementKind, PositionQuality, SpeedMode,
    SurfaceMode, Transport, VerticalMode, VerticalReference,
};
pub use echo::EchoedTime;
pub use error::{DecodeError, EncodeError, Fault};
pub use framer::{FrameCounts, Framer, Policy, sentence_start};
pub use from_vehicle::{
    Acknowledgement, BackseatControl, Battery, BehaviorBegin, BehaviorEnd, BuoyancyStatus, CartesianNavigation,
    Compass, ControlSurfaces, Ctd, DepthSensor, Dvl, DvlBeams, DvlTriggering, FromVehicle, Imu, LoggingBegin,
    LoggingEnd, MediumAccess, MissionCommand, MissionStatus, Navigation, PacketReceived, PacketSent, PlanElement,
    RelativeNavigation, ServoPositions, Shutdown, SoundVelocity, Telemetry, TopsideMessage, TrimStatus, VehicleSpeed,
    VehicleVersion, VelocityAndRates,
};
pub use identity::{BehaviorId, CommandName, CommandNameError};
pub use packet::{FrameData, FrameDataError, ReceivedFrame};
pub use sentence::{ChecksumState, Fields, Sentence, SentenceError};
pub use text::{RelayedText, RelayedTextError, Text, TextError};
pub use to_vehicle::{
    Abort, BearingOffset, BottomPosition, BuoyancyAdjustment, Camera, CancelAll, CancelBehavior, CancelCurrent,
    CancelElement, Continue, DvlTriggerRequest, EndModify, GpsHit, HullPosition, HullSpeedLimit, Kill, Light,
    LogMessage, LoggingControl, ModifyBehavior, Packet, PayloadCtd, PayloadStatus, PayloadVersion, PositionFix,
    RelativeReset, RequestPlan, Resume, SilentMode, SonarAngle, StartEmptyMission, Suspend, ToVehicle, TopsideRelay,
    TopsideText, Trackcircle, Trackline, TrimAdjustment,
};
pub use unknown::UnknownMessage;

/// The longest line that is read or written, bytes, including the `$` and the line feed.
///
/// The specification names no limit. The longest sentences are acoustic packets, BFCPR and BPCPD (SPI 9.3, 9.4), with
/// eight frames in hexadecimal digits. Of the modems that the specification names, the WHOI modem has the largest
/// frames in its fastest PSK modes: 256 bytes each, together 4096 digits. The other fields take at most 186 bytes,
/// which leaves a reserve of 70.
pub const MAX_LINE: usize = 4352;
