//! Bytes as hexadecimal digits: written in upper case, read in either case (SPI 9.3).

use core::fmt;
use std::borrow::Cow;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::error::Fault;

const UPPER: &[u8; 16] = b"0123456789ABCDEF";

/// The two digits of a byte.
pub(crate) const fn digits(byte: u8) -> [u8; 2] {
    [UPPER[(byte >> 4) as usize], UPPER[(byte & 15) as usize]]
}

/// The value of a digit.
pub(crate) const fn value(digit: u8) -> Option<u8> {
    match digit {
        b'0'..=b'9' => Some(digit - b'0'),
        b'A'..=b'F' => Some(digit - b'A' + 10),
        b'a'..=b'f' => Some(digit - b'a' + 10),
        _ => None,
    }
}

/// The bytes that digits stand for. An empty text is no bytes.
pub(crate) fn decode(text: &[u8]) -> Result<Box<[u8]>, Fault> {
    const FAULT: Fault = Fault::expected("an even number of hexadecimal digits");
    if !text.len().is_multiple_of(2) {
        return Err(FAULT);
    }
    let bytes = text
        .chunks_exact(2)
        .map(|pair| Some((value(pair[0])? << 4) | value(pair[1])?));
    bytes.collect::<Option<Box<[u8]>>>().ok_or(FAULT)
}

/// Displays bytes as digits.
pub(crate) struct Digits<'a>(pub(crate) &'a [u8]);

impl fmt::Display for Digits<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02X}"))
    }
}

impl Serialize for Digits<'_> {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_str(self)
    }
}

pub(crate) fn serialize<S: Serializer>(bytes: &[u8], serializer: S) -> Result<S::Ok, S::Error> {
    Digits(bytes).serialize(serializer)
}

pub(crate) fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Box<[u8]>, D::Error> {
    let text = <Cow<'de, str>>::deserialize(deserializer)?;
    decode(text.as_bytes()).map_err(serde::de::Error::custom)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn digits_of_either_case_are_read_in_pairs() {
        assert_eq!(*decode(b"00fFaB9c").unwrap(), [0, 0xff, 0xab, 0x9c]);
        assert!(decode(b"").unwrap().is_empty());
        for bad in [b"0".as_slice(), b"0G", b"000", b"0x", b" 0", b"\xff0", b"-1", b"+1"] {
            assert!(decode(bad).is_err(), "{bad:?}");
        }
        for byte in 0..=u8::MAX {
            assert_eq!(*decode(&digits(byte)).unwrap(), [byte]);
        }
    }
}
