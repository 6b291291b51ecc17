use serde::{Deserialize, Serialize};

use crate::error::Fault;
use crate::field::{Field, Reader, Writer};

/// Numbered choices of the specification. A number that it does not define is kept, so that the code that acts on it
/// can refuse it.
macro_rules! codes {
    ($(
        $(#[$doc:meta])*
        $name:ident { $($(#[$variant_doc:meta])* $variant:ident = $code:literal,)* }
    )*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
        #[serde(rename_all = "kebab-case")]
        pub enum $name {
            $($(#[$variant_doc])* $variant,)*
            /// A number that version 1.12a does not define.
            Other(i32),
        }

        impl $name {
            /// The choice that a number on the wire means.
            #[must_use]
            pub const fn from_code(code: i32) -> Self {
                match code { $($code => Self::$variant,)* other => Self::Other(other) }
            }

            /// The choice's number on the wire.
            #[must_use]
            pub const fn code(self) -> i32 {
                match self { $(Self::$variant => $code,)* Self::Other(other) => other }
            }
        }

        impl Field for $name {
            type Value = Self;
            const FORMATS: &'static [&'static str] = &["x"];
            const RANGE: &'static str = concat!($(stringify!($code), " ", stringify!($variant), ", ",)* "…");

            fn decode(reader: &mut Reader<'_>) -> Result<Self, Fault> {
                reader.signed().map(Self::from_code)
            }

            fn encode(value: &Self, writer: &mut Writer<'_>) -> Result<(), Fault> {
                // `Other(0)` would be read back as the choice that 0 means.
                if Self::from_code(value.code()) != *value {
                    return Err(Fault::expected("the named choice, because its number is defined"));
                }
                writer.signed(value.code());
                Ok(())
            }

            #[cfg(test)]
            fn strategy() -> proptest::strategy::BoxedStrategy<Self> {
                use proptest::prelude::*;
                prop_oneof![0..8i32, any::<i32>()].prop_map(Self::from_code).boxed()
            }
        }
    )*};
}

codes! {
    /// Where the vehicle's position comes from (SPI 6.1).
    PositionQuality {
        /// No GPS is in the solution.
        NoGps = 0,
        /// The solution includes GPS.
        Gps = 1,
    }

    /// The outcome of a command (SPI 6.21).
    ///
    /// An undefined number does not say whether the command was done or refused, so the command stays as unresolved as
    /// without the acknowledgement.
    AckStatus {
        /// Unknown message, or wrong parameters.
        Invalid = 0,
        /// Understood, tried, and failed.
        Failed = 1,
        /// Done.
        Succeeded = 2,
        /// Understood; a second acknowledgement follows within 2 s.
        Pending = 3,
    }

    /// What a point of the mission plan is (SPI 6.20).
    PlanElementKind {
        /// A waypoint.
        Waypoint = 0,
        /// Where a trackline starts.
        TracklineStart = 1,
        /// Where a trackline ends.
        TracklineEnd = 2,
        /// One of the points that stand for a trackcircle.
        Trackcircle = 3,
    }

    /// The meaning of the vertical value of a BPRTK or BPRTC (SPI 7.5, 7.6).
    VerticalMode {
        /// Depth below the surface, metres.
        Depth = 0,
        /// Altitude above the seabed, metres.
        Altitude = 1,
    }

    /// The unit of the speed of a BPRTK or BPRTC (SPI 7.5, 7.6). BPRMB numbers the two units the other way round:
    /// [`ModifySpeedMode`].
    SpeedMode {
        /// Speed through the water, metres per second.
        MetresPerSecond = 0,
        /// Turns of the thruster per minute.
        Rpm = 1,
    }

    /// When an insert begins (SPI 7.5, 7.6).
    Interrupt {
        /// After the current behavior.
        AfterCurrent = 0,
        /// At once. An error while another interrupting insert runs. The interrupted behavior is not resumed.
        InterruptCurrent = 4,
    }

    /// The meaning of the vertical value of a BPRMB (SPI 7.12).
    ModifyVerticalMode {
        /// Depth below the surface, metres.
        Depth = 0,
        /// Altitude above the seabed, metres.
        Altitude = 1,
        /// Pitch, degrees.
        Pitch = 2,
        /// An adjustment of the elevator, degrees.
        Elevator = 3,
    }

    /// The unit of the speed of a BPRMB (SPI 7.12). BPRTK and BPRTC number the two units the other way round: [`SpeedMode`].
    ModifySpeedMode {
        /// Turns of the thruster per minute.
        Rpm = 0,
        /// Speed through the water, metres per second.
        MetresPerSecond = 1,
    }

    /// The meaning of the horizontal value of a BPRMB (SPI 7.12).
    HorizontalMode {
        /// A heading, degrees.
        Heading = 0,
        /// An adjustment of the rudder, degrees.
        Rudder = 1,
    }

    /// How a message travels between vehicle and topside (SPI 5.5, 7.3, 7.14).
    Transport {
        /// Ethernet.
        Ethernet = 0,
        /// 802.11.
        Wifi = 1,
        /// The RF modem.
        RfModem = 2,
        /// The acoustic modem.
        AcousticModem = 3,
    }

    /// The state of a trim or buoyancy adjustment (SPI 6.22, 6.23).
    AdjustmentStatus {
        /// No adjustment runs.
        Idle = 0,
        /// An adjustment runs.
        InProgress = 1,
        /// The adjustment has ended successfully.
        Completed = 2,
        /// The adjustment has failed.
        Failed = 3,
    }

    /// The error of a trim or buoyancy adjustment (SPI 6.22, 6.23).
    AdjustmentError {
        /// No error.
        None = 0,
        /// The operation failed.
        Failed = 1,
        /// The operation was cancelled.
        Canceled = 2,
        /// Trim or buoyancy is at its limit, or there is no flow.
        AtLimit = 3,
        /// An error while idle.
        Idle = 4,
    }

    /// The outcome of one frame of a sent packet (SPI 9.2).
    FrameSentStatus {
        /// There was no such frame.
        Unset = 0,
        /// Sent; no acknowledgement was requested.
        Unacknowledged = 1,
        /// Sent and acknowledged.
        Acked = 2,
        /// Not sent.
        FailedToSend = 3,
    }

    /// How one frame of a packet was received (SPI 9.3).
    FrameReceivedStatus {
        /// There was no such frame.
        Unset = 0,
        /// Its data are good.
        Good = 1,
        /// Its data are corrupted.
        Corrupted = 6,
        /// It could not be decoded.
        Undecodable = 7,
    }

    /// How to surface for GPS (SPI 7.7).
    SurfaceMode {
        /// In a straight line.
        StraightLine = 0,
        /// In a spiral; not available in this version.
        Spiral = 1,
        /// The vehicle does not surface by itself.
        Manual = 2,
    }

    /// Why a mission is ended (SPI 7.16).
    AbortReason {
        /// The mission was successful.
        Successful = 0,
        /// Something is wrong. A missing or empty reason means this too.
        Errors = 1,
    }

    /// The unit of an empty mission's duration (SPI 7.20).
    DurationUnit {
        /// Hours.
        Hours = 0,
        /// Minutes.
        Minutes = 1,
        /// Seconds.
        Seconds = 2,
    }
}

impl Default for Interrupt {
    /// SPI 7.5: "new behavior runs after current (default)".
    fn default() -> Self {
        Self::AfterCurrent
    }
}

impl Default for AbortReason {
    /// Errors (SPI 7.16).
    fn default() -> Self {
        Self::Errors
    }
}

impl Default for FrameSentStatus {
    /// No frame.
    fn default() -> Self {
        Self::Unset
    }
}

impl Default for FrameReceivedStatus {
    /// No frame.
    fn default() -> Self {
        Self::Unset
    }
}

/// The meaning of the vertical value of a BPGBP (SPI 8.7): `D` or `A` on the wire.
///
/// The only choice without `Other`. It is a letter, so there is no number to keep. A vehicle that took a depth for an
/// altitude would go to the wrong place, so any other letter is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum VerticalReference {
    /// Depth below the surface, metres.
    Depth,
    /// Altitude above the seabed, metres.
    Altitude,
}

impl Field for VerticalReference {
    type Value = Self;
    const FORMATS: &'static [&'static str] = &["D/A"];
    const RANGE: &'static str = "D/A";

    fn decode(reader: &mut Reader<'_>) -> Result<Self, Fault> {
        match reader.trimmed()? {
            b"D" => Ok(Self::Depth),
            b"A" => Ok(Self::Altitude),
            _ => Err(Fault::expected("D or A")),
        }
    }

    fn encode(value: &Self, writer: &mut Writer<'_>) -> Result<(), Fault> {
        writer.character(match value {
            Self::Depth => b'D',
            Self::Altitude => b'A',
        });
        Ok(())
    }

    #[cfg(test)]
    fn strategy() -> proptest::strategy::BoxedStrategy<Self> {
        use proptest::prelude::*;
        prop_oneof![Just(Self::Depth), Just(Self::Altitude)].boxed()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::forms::{read, written};

    #[test]
    fn inserts_and_modifies_number_their_speed_modes_in_opposite_ways() {
        assert_eq!((SpeedMode::MetresPerSecond.code(), SpeedMode::Rpm.code()), (0, 1));
        assert_eq!(
            (ModifySpeedMode::MetresPerSecond.code(), ModifySpeedMode::Rpm.code()),
            (1, 0)
        );
    }

    #[test]
    fn a_defined_number_is_not_written_under_another_name() {
        let mut out = Vec::new();
        assert!(Interrupt::encode(&Interrupt::Other(4), &mut Writer::new(&mut out)).is_err());
        assert!(Interrupt::encode(&Interrupt::Other(1), &mut Writer::new(&mut out)).is_ok());
        assert_eq!(out, b",1");
    }

    #[test]
    fn an_undefined_number_is_kept() {
        assert_eq!(read::<AckStatus>("7"), Ok(AckStatus::Other(7)));
        assert_eq!(
            read::<FrameReceivedStatus>("-2147483648"),
            Ok(FrameReceivedStatus::Other(i32::MIN))
        );
        assert_eq!(written::<SurfaceMode>(&SurfaceMode::Other(-3)).unwrap(), ",-3");
        assert!(read::<AckStatus>("2147483648").is_err());
        assert!(read::<AckStatus>("1.5").is_err());
    }

    #[test]
    fn a_letter_that_is_neither_depth_nor_altitude_is_refused() {
        assert_eq!(read::<VerticalReference>(" D "), Ok(VerticalReference::Depth));
        for bad in ["", "d", "a", "0", "DA"] {
            assert!(read::<VerticalReference>(bad).is_err(), "{bad}");
        }
    }

    #[test]
    fn choices_are_serialised_by_name_and_other_numbers_as_such() {
        let text = |value: FrameSentStatus| serde_json::to_string(&value).unwrap();
        assert_eq!(text(FrameSentStatus::FailedToSend), "\"failed-to-send\"");
        assert_eq!(text(FrameSentStatus::Other(-9)), r#"{"other":-9}"#);
        assert_eq!(
            serde_json::from_str::<Transport>("\"rf-modem\"").unwrap(),
            Transport::RfModem
        );
        assert_eq!(
            serde_json::from_str::<Transport>(r#"{"other":12}"#).unwrap(),
            Transport::Other(12)
        );
        assert!(serde_json::from_str::<Transport>("\"telepathy\"").is_err());
    }
}
