#[cfg(test)]
use proptest::prelude::{BoxedStrategy, Strategy, any};

use crate::error::Fault;
use crate::field::{Field, Reader, Writer};

/// 0 or 1.
pub(crate) struct Flag;

impl Field for Flag {
    type Value = bool;
    const FORMATS: &'static [&'static str] = &["0/1"];
    const RANGE: &'static str = "0/1";

    fn decode(reader: &mut Reader<'_>) -> Result<bool, Fault> {
        match reader.integer() {
            Ok(0) => Ok(false),
            Ok(1) => Ok(true),
            Err(fault @ (Fault::Missing | Fault::Empty)) => Err(fault),
            Ok(_) | Err(_) => Err(Fault::expected("0 or 1")),
        }
    }

    fn encode(value: &bool, writer: &mut Writer<'_>) -> Result<(), Fault> {
        writer.character(if *value { b'1' } else { b'0' });
        Ok(())
    }

    #[cfg(test)]
    fn strategy() -> BoxedStrategy<bool> {
        any::<bool>().boxed()
    }
}

/// `ON` or `OFF` (SPI 7.1).
pub(crate) struct OnOff;

impl Field for OnOff {
    type Value = bool;
    const FORMATS: &'static [&'static str] = &["ON/OFF"];
    const RANGE: &'static str = "ON/OFF";

    fn decode(reader: &mut Reader<'_>) -> Result<bool, Fault> {
        match reader.trimmed()? {
            b"ON" => Ok(true),
            b"OFF" => Ok(false),
            _ => Err(Fault::expected("ON or OFF")),
        }
    }

    fn encode(value: &bool, writer: &mut Writer<'_>) -> Result<(), Fault> {
        writer.text(if *value { "ON" } else { "OFF" });
        Ok(())
    }

    #[cfg(test)]
    fn strategy() -> BoxedStrategy<bool> {
        any::<bool>().boxed()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::forms::read;

    #[test]
    fn only_a_clear_flag_is_read() {
        assert_eq!((read::<Flag>("1"), read::<Flag>(" 00 ")), (Ok(true), Ok(false)));
        assert_eq!((read::<OnOff>("ON"), read::<OnOff>("OFF")), (Ok(true), Ok(false)));
        for bad in ["", "2", "-1", "true", "ON", "1.0", "on", "Off"] {
            assert!(read::<Flag>(bad).is_err(), "{bad}");
            assert!(bad == "ON" || read::<OnOff>(bad).is_err(), "{bad}");
        }
    }
}
