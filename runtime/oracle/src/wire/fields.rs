use std::fmt;

use crate::earth::Position;
use crate::time_of_day::{Echo, TimeOfDay};

/// How a line of ours differs from the specification.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// It does not end with a carriage return before the line feed (SPI 4.2).
    End,
    /// It does not begin with a dollar sign, or does not end with the right checksum in two upper-case digits.
    Frame,
    /// A byte is not printable, or is reserved (SPI 4.2).
    Byte,
    /// Its name is not that of a payload's sentence.
    Name,
    /// A field differs from the specification, or is missing.
    Field {
        /// Which field, counted from 1 after the name.
        index: usize,
        /// What the specification has there.
        expected: &'static str,
    },
    /// It has more fields than the specification.
    Surplus,
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::End => f.write_str("no carriage return before the line feed"),
            Self::Frame => f.write_str("no $, or no correct checksum in two upper-case digits"),
            Self::Byte => f.write_str("a reserved or unprintable byte"),
            Self::Name => f.write_str("not the name of a payload's sentence"),
            Self::Field { index, expected } => write!(f, "field {index}: expected {expected}"),
            Self::Surplus => f.write_str("more fields than the specification has"),
        }
    }
}

/// A vertical setpoint, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Setpoint {
    /// Depth below the surface.
    Depth(f64),
    /// Altitude above the seabed.
    Altitude(f64),
}

impl fmt::Display for Setpoint {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Depth(metres) => write!(f, "depth {metres} m"),
            Self::Altitude(metres) => write!(f, "altitude {metres} m"),
        }
    }
}

/// A speed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Speed {
    /// Through the water, m/s.
    MetresPerSecond(f64),
    /// Turns of the thruster per minute.
    Rpm(f64),
}

/// The rest of a sentence's fields (SPI 4.2, Table 1).
#[derive(Clone, Copy, Debug)]
pub(super) struct Fields<'a> {
    /// The rest begins with the comma before the next field, and is empty after the last one.
    rest: &'a [u8],
    index: usize,
}

impl<'a> Fields<'a> {
    /// Starts with the bytes after a sentence's name.
    pub(super) const fn new(rest: &'a [u8]) -> Self {
        Self { rest, index: 0 }
    }

    /// The next field; `None` if there is none.
    pub(super) fn take(&mut self) -> Option<&'a [u8]> {
        let rest = self.rest.strip_prefix(b",")?;
        let end = rest.iter().position(|byte| *byte == b',').unwrap_or(rest.len());
        let (field, rest) = rest.split_at(end);
        self.rest = rest;
        self.index += 1;
        Some(field)
    }

    /// Reads the next field.
    pub(super) fn read<T>(
        &mut self,
        expected: &'static str,
        read: impl FnOnce(&'a [u8]) -> Option<T>,
    ) -> Result<T, Fault> {
        let index = self.index + 1;
        self.take().and_then(read).ok_or(Fault::Field { index, expected })
    }

    /// As [`Fields::read`], but an empty field is `None`.
    pub(super) fn read_or_empty<T>(
        &mut self,
        expected: &'static str,
        read: impl FnOnce(&'a [u8]) -> Option<T>,
    ) -> Result<Option<T>, Fault> {
        self.read(expected, |text| match text {
            b"" => Some(None),
            text => read(text).map(Some),
        })
    }

    pub(super) fn time(&mut self) -> Result<TimeOfDay, Fault> {
        self.read("a time", time)
    }

    /// The time of a sentence of ours: the specification wants at least milliseconds.
    pub(super) fn precise_time(&mut self) -> Result<TimeOfDay, Fault> {
        self.read("a time to the millisecond", |text| {
            time(text).filter(|_| text.len() >= "hhmmss.sss".len())
        })
    }

    /// The echoed time of a command, with its decimals. Of a command without a time, some vehicles write nothing.
    pub(super) fn echo(&mut self) -> Result<Echo, Fault> {
        self.read("a time, or nothing", |text| match text.trim_ascii() {
            b"" => Some(Echo::NONE),
            text => time(text).map(|echoed| Echo::new(echoed, text.len().saturating_sub("hhmmss.".len()))),
        })
    }

    pub(super) fn number(&mut self) -> Result<f64, Fault> {
        self.read("a number", number)
    }

    pub(super) fn number_or_empty(&mut self) -> Result<Option<f64>, Fault> {
        self.read_or_empty("a number, or nothing", number)
    }

    pub(super) fn whole(&mut self) -> Result<u32, Fault> {
        self.read("a whole number", whole)
    }

    pub(super) fn whole_or_empty(&mut self) -> Result<Option<u32>, Fault> {
        self.read_or_empty("a whole number, or nothing", whole)
    }

    /// A code of the specification, from 0 to the last one.
    pub(super) fn code(&mut self, last: u32) -> Result<u32, Fault> {
        self.read("a code that the specification has", |text| {
            whole(text).filter(|code| *code <= last)
        })
    }

    pub(super) fn code_or_empty(&mut self, last: u32) -> Result<Option<u32>, Fault> {
        self.read_or_empty("a code that the specification has, or nothing", |text| {
            whole(text).filter(|code| *code <= last)
        })
    }

    pub(super) fn flag(&mut self) -> Result<bool, Fault> {
        self.code(1).map(|code| code == 1)
    }

    pub(super) fn text(&mut self) -> Result<&'a [u8], Fault> {
        self.read("a text", Some)
    }

    /// Latitude, hemisphere, longitude, hemisphere: four fields.
    pub(super) fn position(&mut self) -> Result<Position, Fault> {
        let latitude_deg = self.angle(2, [b"N", b"S"], 90.0)?;
        let longitude_deg = self.angle(3, [b"E", b"W"], 180.0)?;
        Ok(Position {
            latitude_deg,
            longitude_deg,
        })
    }

    /// Reads degrees with this number of digits and minutes, then the hemisphere, which gives the sign.
    fn angle(&mut self, digits: usize, [positive, negative]: [&[u8]; 2], max_deg: f64) -> Result<f64, Fault> {
        let deg = self.read("degrees and minutes", |text| {
            let (degrees, minutes) = text.split_at_checked(digits)?;
            let add = |value: u32, byte: &u8| byte.is_ascii_digit().then(|| value * 10 + u32::from(byte - b'0'));
            let degrees = f64::from(degrees.iter().try_fold(0_u32, add)?);
            let minutes = number(minutes).filter(|minutes| (0.0..=60.0).contains(minutes))?;
            Some(degrees + minutes / 60.0).filter(|deg| *deg <= max_deg)
        })?;
        self.read("a hemisphere", |side| {
            if side == positive {
                Some(deg)
            } else if side == negative {
                Some(-deg)
            } else {
                None
            }
        })
    }

    /// Reads a depth or an altitude: code, then value.
    pub(super) fn setpoint(&mut self) -> Result<Setpoint, Fault> {
        let code = self.code(1)?;
        let metres = self.number()?;
        Ok(if code == 0 {
            Setpoint::Depth(metres)
        } else {
            Setpoint::Altitude(metres)
        })
    }

    /// Reads a speed: value, then code.
    pub(super) fn speed(&mut self) -> Result<Speed, Fault> {
        let value = self.number()?;
        let code = self.code(1)?;
        Ok(if code == 0 {
            Speed::MetresPerSecond(value)
        } else {
            Speed::Rpm(value)
        })
    }

    /// Reads a reserved field, which is empty or 0.
    pub(super) fn reserved(&mut self) -> Result<(), Fault> {
        self.read("nothing, or 0", |text| matches!(text, b"" | b"0").then_some(()))
    }

    /// Checks that no field is left.
    pub(super) fn end(&self) -> Result<(), Fault> {
        if self.rest.is_empty() {
            Ok(())
        } else {
            Err(Fault::Surplus)
        }
    }
}

/// No value of the interface is larger than this.
const NUMBER_MAX: f64 = 1e9;

/// A decimal number without an exponent.
pub(super) fn number(text: &[u8]) -> Option<f64> {
    let text = text.trim_ascii();
    let (negative, digits) = match text.strip_prefix(b"-") {
        Some(rest) => (true, rest),
        None => (false, text),
    };
    let (mut value, mut unit, mut point, mut any) = (0_u64, 1_u64, false, false);
    for byte in digits {
        match byte {
            b'0'..=b'9' => {
                any = true;
                // Digits beyond those that a double holds have no effect.
                if value < 1_000_000_000_000_000 && unit < 1_000_000_000_000_000 {
                    value = value * 10 + u64::from(byte - b'0');
                    unit *= if point { 10 } else { 1 };
                } else if !point {
                    return None;
                }
            }
            b'.' if !point => point = true,
            _ => return None,
        }
    }
    let value = value as f64 / unit as f64;
    (any && value <= NUMBER_MAX).then_some(if negative { -value } else { value })
}

/// Reads a whole number that is not negative.
pub(super) fn whole(text: &[u8]) -> Option<u32> {
    let text = text.trim_ascii();
    let digit = |byte: &u8| byte.is_ascii_digit().then(|| u32::from(byte - b'0'));
    let add = |value: u32, byte: &u8| value.checked_mul(10)?.checked_add(digit(byte)?);
    (!text.is_empty()).then(|| text.iter().try_fold(0, add))?
}

/// Reads a whole number that may be negative.
pub(super) fn integer(text: &[u8]) -> Option<i32> {
    let text = text.trim_ascii();
    let value = match text.strip_prefix(b"-") {
        Some(rest) => whole(rest).map(|value| -i64::from(value)),
        None => whole(text).map(i64::from),
    };
    value.and_then(|value| value.try_into().ok())
}

/// Reads a field as a time of day: hhmmss, and a point with any number of decimals.
fn time(text: &[u8]) -> Option<TimeOfDay> {
    let whole = match text.get(6..)?.split_first() {
        None => true,
        Some((point, digits)) => *point == b'.' && digits.iter().all(u8::is_ascii_digit),
    };
    time_at_start(text).filter(|_| whole)
}

/// Reads the time of day at the start of a text, whatever follows it. Decimals beyond nanoseconds are ignored.
pub(super) fn time_at_start(text: &[u8]) -> Option<TimeOfDay> {
    let digit = |at: usize| {
        let byte = text.get(at).filter(|byte| byte.is_ascii_digit())?;
        Some(byte - b'0')
    };
    let pair = |at: usize| Some(digit(at)? * 10 + digit(at + 1)?);
    let (hour, minute, second) = (pair(0)?, pair(2)?, pair(4)?);
    let mut nanos = 0;
    if text.get(6) == Some(&b'.') {
        let mut unit = 100_000_000;
        for at in 7..16 {
            let Some(digit) = digit(at) else { break };
            nanos += u32::from(digit) * unit;
            unit /= 10;
        }
    }
    TimeOfDay::new(hour, minute, second, nanos)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_those_of_table_1() {
        for (text, read) in [
            ("-0.50", Some(-0.5)),
            (" 7 ", Some(7.0)),
            (" -7.", Some(-7.0)),
            ("007.250", Some(7.25)),
            (".5", Some(0.5)),
            ("0.1", Some(0.1)),
            ("0.12345678901234567890", Some(0.123_456_789_012_345)),
            ("1000000000", Some(1e9)),
            ("1000000000.1", None),
            ("1234567890123456789", None),
            ("", None),
            (" ", None),
            ("-", None),
            (".", None),
            ("+1", None),
            ("- 1", None),
            ("1e3", None),
            ("nan", None),
            ("1.2.3", None),
            ("1 2", None),
        ] {
            assert_eq!(number(text.as_bytes()), read, "{text}");
        }
        for (text, read) in [
            ("0", Some(0)),
            (" 042 ", Some(42)),
            ("4294967295", Some(u32::MAX)),
            ("4294967296", None),
            ("-1", None),
            ("1.0", None),
            ("", None),
        ] {
            assert_eq!(whole(text.as_bytes()), read, "{text}");
        }
    }

    #[test]
    fn times_are_those_of_table_1() {
        let nanos = |text: &str| time(text.as_bytes()).map(TimeOfDay::as_nanos);
        assert_eq!(nanos("000001"), Some(1_000_000_000));
        assert_eq!(nanos("000001.5"), Some(1_500_000_000));
        assert_eq!(nanos("000001.000000001234"), Some(1_000_000_001));
        assert_eq!(nanos("235960.5"), Some(86_400_500_000_000));
        for text in [
            "",
            "00001",
            "240000",
            "006000",
            "000060",
            "000001.x",
            "000001,5",
            "0:0001.000",
            " 00001",
        ] {
            assert_eq!(nanos(text), None, "{text}");
        }
    }

    #[test]
    fn places_are_those_of_table_1() {
        let read = |text: &str| Fields::new(text.as_bytes()).position().ok();
        let place = read(",4221.81092,N,07106.84603,W").unwrap();
        assert!((place.latitude_deg - 42.363_515_333).abs() < 1e-9, "{place:?}");
        assert!((place.longitude_deg + 71.114_100_5).abs() < 1e-9, "{place:?}");
        // Minutes without padding, and the ends of the ranges.
        assert_eq!(read(",421.5,S,0711.5,E").unwrap().latitude_deg, -42.025);
        assert_eq!(read(",9000,S,18000,E").unwrap().latitude_deg, -90.0);
        for text in [
            ",9000.1,N,00000,E",
            ",0000,N,18000.1,E",
            ",4260.1,N,00000,E",
            ",42-1,N,00000,E",
            ",4 00,N,00000,E",
            ",4200,n,00000,E",
            ",4200,E,00000,E",
            ",4200,N,00000,N",
            ",4200,N,00000",
            ",42,N,00000,E",
        ] {
            assert_eq!(read(text), None, "{text}");
        }
    }
}
