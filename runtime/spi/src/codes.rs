use crate::error::Fault;
use crate::field::{Field, Reader, Writer};
use crate::number;

/// Numbered choices of the specification. The open ones keep what it may number later; the closed ones refuse it.
macro_rules! codes {
    ($(
        $(#[$doc:meta])*
        $kind:ident $name:ident { $($(#[$variant_doc:meta])* $variant:ident = $code:literal,)* }
    )*) => {$( codes! { @$kind $(#[$doc])* $name { $($(#[$variant_doc])* $variant = $code,)* } } )*};

    (@open $(#[$doc:meta])* $name:ident { $($(#[$variant_doc:meta])* $variant:ident = $code:literal,)* }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum $name {
            $($(#[$variant_doc])* $variant,)*
            /// A number that version 1.12a does not define.
            Other(u32),
        }

        impl $name {
            /// The choice that a number on the wire means.
            #[must_use]
            pub const fn from_code(code: u32) -> Self {
                match code { $($code => Self::$variant,)* other => Self::Other(other) }
            }

            /// Its number on the wire.
            #[must_use]
            pub const fn code(self) -> u32 {
                match self { $(Self::$variant => $code,)* Self::Other(other) => other }
            }
        }

        impl Field for $name {
            type Value = Self;
            const FORMATS: &'static [&'static str] = &[concat!("code", $(" ", $code,)* " …")];

            fn decode(reader: &mut Reader<'_>) -> Result<Self, Fault> {
                number::parse_integer(reader.trimmed()?).map(Self::from_code)
            }

            fn encode(value: &Self, writer: &mut Writer<'_>) -> Result<(), Fault> {
                // `Other(0)` would come back as the choice that 0 means.
                if Self::from_code(value.code()) != *value {
                    return Err(Fault::expected("the choice's own name: its number is defined"));
                }
                writer.integer(value.code());
                Ok(())
            }

            #[cfg(test)]
            fn strategy() -> proptest::strategy::BoxedStrategy<Self> {
                use proptest::prelude::*;
                prop_oneof![0..8u32, any::<u32>()].prop_map(Self::from_code).boxed()
            }
        }
    };

    (@closed $(#[$doc:meta])* $name:ident { $($(#[$variant_doc:meta])* $variant:ident = $code:literal,)* }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
        pub enum $name { $($(#[$variant_doc])* $variant,)* }

        impl $name {
            /// The choice that a number on the wire means, if it means one.
            #[must_use]
            pub const fn from_code(code: u32) -> Option<Self> {
                match code { $($code => Some(Self::$variant),)* _ => None }
            }

            /// Its number on the wire.
            #[must_use]
            pub const fn code(self) -> u32 {
                match self { $(Self::$variant => $code,)* }
            }
        }

        impl Field for $name {
            type Value = Self;
            const FORMATS: &'static [&'static str] = &[concat!("code", $(" ", $code,)*)];

            fn decode(reader: &mut Reader<'_>) -> Result<Self, Fault> {
                let code = number::parse_integer(reader.trimmed()?)?;
                Self::from_code(code).ok_or(Fault::expected(concat!("one of" $(, " ", $code)*)))
            }

            fn encode(value: &Self, writer: &mut Writer<'_>) -> Result<(), Fault> {
                writer.integer(value.code());
                Ok(())
            }

            #[cfg(test)]
            fn strategy() -> proptest::strategy::BoxedStrategy<Self> {
                use proptest::prelude::*;
                proptest::sample::select(vec![$(Self::$variant),*]).boxed()
            }
        }
    };
}

codes! {
    /// Where the vehicle's position comes from (SPI 6.1).
    open PositionQuality {
        /// No GPS is in the solution.
        NoGps = 0,
        /// The solution includes GPS.
        Gps = 1,
    }

    /// What became of a command (SPI 6.21).
    closed AckStatus {
        /// Unknown message, or parameters that are wrong.
        Invalid = 0,
        /// Understood, tried, and failed.
        Failed = 1,
        /// Done.
        Succeeded = 2,
        /// Understood; a second acknowledgement follows within 2 s.
        Pending = 3,
    }

    /// What a point of the mission plan is (SPI 6.20).
    open PlanElementKind {
        /// A waypoint.
        Waypoint = 0,
        /// Where a trackline starts.
        TracklineStart = 1,
        /// Where a trackline ends.
        TracklineEnd = 2,
        /// One of the points that stand for a trackcircle.
        Trackcircle = 3,
    }

    /// What the vertical value of a BPRTK or BPRTC is (SPI 7.5, 7.6).
    open VerticalMode {
        /// Depth below the surface, metres.
        Depth = 0,
        /// Height above the seabed, metres.
        Altitude = 1,
    }

    /// What the speed of a BPRTK or BPRTC is (SPI 7.5, 7.6). BPRMB counts the other way round: [`ModifySpeedMode`].
    open SpeedMode {
        /// Speed through the water, metres per second.
        MetresPerSecond = 0,
        /// Turns of the thruster a minute.
        Rpm = 1,
    }

    /// When an insert begins (SPI 7.5, 7.6).
    open Interrupt {
        /// After the current behavior.
        AfterCurrent = 0,
        /// At once. An error while another interrupting insert runs; the interrupted behavior is not resumed.
        InterruptCurrent = 4,
    }

    /// What the vertical value of a BPRMB is (SPI 7.12).
    open ModifyVerticalMode {
        /// Depth below the surface, metres.
        Depth = 0,
        /// Height above the seabed, metres.
        Altitude = 1,
        /// Pitch, degrees.
        Pitch = 2,
        /// An adjustment of the elevator, degrees.
        Elevator = 3,
    }

    /// What the speed of a BPRMB is (SPI 7.12). BPRTK and BPRTC count the other way round: [`SpeedMode`].
    open ModifySpeedMode {
        /// Turns of the thruster a minute.
        Rpm = 0,
        /// Speed through the water, metres per second.
        MetresPerSecond = 1,
    }

    /// What the horizontal value of a BPRMB is (SPI 7.12).
    open HorizontalMode {
        /// A heading, degrees.
        Heading = 0,
        /// An adjustment of the rudder, degrees.
        Rudder = 1,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn speed_modes_of_inserts_and_modifies_are_each_others_reverse() {
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
}
