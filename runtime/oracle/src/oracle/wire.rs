use backseat_spi::{ChecksumState, Sentence, ToVehicle};
use backseat_units::TimeOfDay;
use memchr::memchr_iter;

use crate::navigation::Fix;

/// The message of a line of ours, without its line feed, or what is wrong with the line.
pub(super) fn our_message(line: &[u8]) -> Result<ToVehicle, String> {
    let Some(body) = line.strip_suffix(b"\r") else {
        return Err("no carriage return before the line feed".to_owned());
    };
    let text = core::str::from_utf8(body).map_err(|error| error.to_string())?;
    let sentence = Sentence::parse(text).map_err(|error| error.to_string())?;
    let digits = body.len().checked_sub(3).and_then(|at| body.get(at..));
    let two_digits = matches!(digits, Some([b'*', high, low])
        if [high, low].iter().all(|digit| matches!(digit, b'0'..=b'9' | b'A'..=b'F')));
    if sentence.checksum() != ChecksumState::Valid || !two_digits {
        return Err("no right checksum of two upper-case digits".to_owned());
    }
    if !sentence.name().starts_with("BP") || sentence.name().len() != 5 {
        return Err("not the name of a payload's sentence".to_owned());
    }
    ToVehicle::decode(&sentence).map_err(|error| error.to_string())
}

/// What stands before a line's checksum, which is right and has two digits.
fn checked(line: &[u8]) -> Option<&[u8]> {
    let line = line.trim_ascii_end();
    let star = line.len().checked_sub(3).filter(|at| line.get(*at) == Some(&b'*'))?;
    let body = line.get(..star)?;
    let sum = body.get(1..)?.iter().fold(0, |sum, byte| sum ^ byte);
    let digit = |at: usize| char::from(*line.get(at)?).to_digit(16);
    (digit(star + 1)? * 16 + digit(star + 2)? == u32::from(sum)).then_some(body)
}

/// What BFNVG says (SPI 6.1). Nothing where the checksum is wrong or any of its fields is not what the specification
/// writes: damage that the checksum does not show is seldom in one field alone.
pub(super) fn fix(line: &[u8]) -> Option<Fix> {
    let mut fields = Fields(checked(line)?.strip_prefix(b"$BFNVG,")?);
    let _created = whole_time(fields.take())?;
    let latitude_deg = angle(&mut fields, 2, [b"N", b"S"]).filter(|deg| deg.abs() <= 90.0)?;
    let longitude_deg = angle(&mut fields, 3, [b"E", b"W"]).filter(|deg| deg.abs() <= 180.0)?;
    // A code that the specification does not know says nothing against the place.
    let _quality = Some(fields.take()).filter(|text| matches!(text, [b'0'..=b'9']))?;
    let altitude = fields.take();
    let altitude_m = match altitude {
        b"" => 0.0,
        altitude => number(altitude).filter(|metres| *metres >= 0.0)?,
    };
    let depth_m = number(fields.take())?;
    let heading_deg = number(fields.take()).filter(|deg| (0.0..=360.0).contains(deg))?;
    let (_roll, _pitch) = (number(fields.take())?, number(fields.take())?);
    Some(Fix {
        solution: whole_time(fields.take())?,
        latitude_deg,
        longitude_deg,
        depth_m,
        locked: altitude_m > 0.0,
        heading_deg,
    })
}

/// Degrees of so many digits and minutes, then the side on which they count as positive or as negative.
fn angle(fields: &mut Fields<'_>, digits: usize, [positive, negative]: [&[u8]; 2]) -> Option<f64> {
    let (degrees, minutes) = fields.take().split_at_checked(digits)?;
    let minutes = number(minutes).filter(|minutes| (0.0..=60.0).contains(minutes))?;
    let degrees = number(degrees).filter(|_| degrees.iter().all(u8::is_ascii_digit))?;
    let deg = degrees + minutes / 60.0;
    match fields.take() {
        side if side == positive => Some(deg),
        side if side == negative => Some(-deg),
        _ => None,
    }
}

/// What is left of a sentence's fields.
struct Fields<'a>(&'a [u8]);

impl<'a> Fields<'a> {
    /// The next one, which is empty where there is none.
    fn take(&mut self) -> &'a [u8] {
        let end = self.0.iter().position(|byte| *byte == b',');
        let (field, rest) = self.0.split_at(end.unwrap_or(self.0.len()));
        self.0 = rest.get(1..).unwrap_or_default();
        field
    }
}

/// A decimal number without an exponent.
fn number(text: &[u8]) -> Option<f64> {
    let text = text.trim_ascii();
    let (negative, digits) = match text.strip_prefix(b"-") {
        Some(rest) => (true, rest),
        None => (false, text),
    };
    if digits.is_empty() {
        return None;
    }
    let (mut value, mut unit, mut point) = (0_u64, 1_u64, false);
    for byte in digits {
        match byte {
            b'0'..=b'9' => {
                // More digits than a double holds say nothing.
                if value < 1_000_000_000_000_000 {
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
    Some(if negative { -value } else { value })
}

/// The names of all that could be read as sentences in a line, and when they were made where the line is whole.
pub(super) fn sentences(line: &[u8]) -> impl Iterator<Item = ([u8; 5], Option<TimeOfDay>)> {
    memchr_iter(b'$', line).filter_map(|start| {
        let sentence = line.get(start..)?;
        let name = sentence.get(1..6)?.try_into().ok()?;
        Some((name, checked(sentence).and_then(created_time)))
    })
}

/// When our sentence says that it was made: its first field.
pub(super) fn created_time(line: &[u8]) -> Option<TimeOfDay> {
    time(line.get(7..)?)
}

/// The time of day that a field is.
fn whole_time(text: &[u8]) -> Option<TimeOfDay> {
    let decimals = text.get(6..)?;
    let whole = match decimals.split_first() {
        None => true,
        Some((point, digits)) => *point == b'.' && digits.iter().all(u8::is_ascii_digit),
    };
    time(text).filter(|_| whole)
}

/// The time of day at the start of a text: hhmmss, a point, decimals to the nanosecond.
fn time(text: &[u8]) -> Option<TimeOfDay> {
    let digit = |at: usize| {
        text.get(at)
            .filter(|byte| byte.is_ascii_digit())
            .map(|byte| u32::from(byte - b'0'))
    };
    let pair = |at: usize| Some(digit(at)? * 10 + digit(at + 1)?);
    let (hour, minute, second) = (pair(0)?, pair(2)?, pair(4)?);
    let mut nanos = 0;
    if text.get(6) == Some(&b'.') {
        let mut unit = 100_000_000;
        for at in 7..16 {
            let Some(digit) = digit(at) else { break };
            nanos += digit * unit;
            unit /= 10;
        }
    }
    TimeOfDay::from_hms_nano(hour, minute, second, nanos)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fix_is_read_as_the_specification_writes_it() {
        let read = |text: &str| fix(text.as_bytes());
        let line = "$BFNVG,081025.987,4221.81092,N,07106.84603,W,1,45.3,20.1,203.1,-3.4,4.5,081025.980*4E\r";
        let told = read(line).unwrap();
        assert_eq!(told.solution, TimeOfDay::from_hms_nano(8, 10, 25, 980_000_000).unwrap());
        assert!((told.latitude_deg - 42.363_515_333).abs() < 1e-9, "{told:?}");
        assert!((told.longitude_deg + 71.114_100_5).abs() < 1e-9, "{told:?}");
        assert_eq!((told.depth_m, told.heading_deg), (20.1, 203.1));
        assert_eq!(read(&line.replace("*4E", "*4F")), None);
        assert_eq!(read(&line.replace("N,", "N")), None);
        assert!(read(&with_checksum(&line.replace(",45.3,", ",,"))).is_some());
        assert!(
            read(&with_checksum(&line.replace(",1,45", ",4,45"))).is_some(),
            "a code"
        );
        // Whatever field is damaged, and the checksum right all the same.
        for (right, damaged) in [
            ("081025.987", "0810:5.987"),
            ("4221.81092", "4271.81092"),
            (",N,", ",F,"),
            (",W,", ",G,"),
            (",1,", ",q,"),
            ("45.3", "4u.3"),
            ("20.1", "2>.1"),
            ("203.1", "403.1"),
            ("-3.4", "-3&4"),
            (",4.5", ",t.5"),
            ("081025.980", "081025.9x0"),
        ] {
            let line = line.replacen(right, damaged, 1);
            assert_eq!(read(&with_checksum(&line)), None, "{line}");
        }
        assert_eq!(number(b"-0.50"), Some(-0.5));
        assert_eq!(number(b" 7 "), Some(7.0));
        for text in ["", "-", "1e3", "nan", "1.2.3"] {
            assert_eq!(number(text.as_bytes()), None, "{text}");
        }
    }

    fn with_checksum(line: &str) -> String {
        let body = line.split('*').next().unwrap();
        let sum = body.bytes().skip(1).fold(0, |sum, byte| sum ^ byte);
        format!("{body}*{sum:02X}")
    }
}
