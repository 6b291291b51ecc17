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

/// What BFNVG says (SPI 6.1). Nothing where the checksum is wrong or a field cannot be read.
pub(super) fn fix(line: &[u8]) -> Option<Fix> {
    let body = checked(line)?;
    // Where each field begins, the name being the first.
    let mut starts = [0; 13];
    for (start, comma) in starts.get_mut(1..)?.iter_mut().zip(memchr_iter(b',', body)) {
        *start = comma + 1;
    }
    let field = |index: usize| {
        let start = *starts.get(index)?;
        let end = match starts.get(index + 1) {
            Some(next) if *next > 0 => next - 1,
            Some(_) | None => body.len(),
        };
        body.get(start..end).filter(|_| start > 0)
    };
    let angle = |index: usize, digits: usize, negative: &[u8]| {
        let text = field(index)?;
        let deg = number(text.get(..digits)?)? + number(text.get(digits..)?)? / 60.0;
        let side = field(index + 1)?;
        Some(if side == negative { -deg } else { deg })
    };
    Some(Fix {
        solution: time(field(12)?)?,
        latitude_deg: angle(2, 2, b"S").filter(|deg| deg.abs() <= 90.0)?,
        longitude_deg: angle(4, 3, b"W").filter(|deg| deg.abs() <= 180.0)?,
        depth_m: number(field(8)?)?,
        heading_deg: number(field(9)?)?,
    })
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
        assert_eq!(number(b"-0.50"), Some(-0.5));
        assert_eq!(number(b" 7 "), Some(7.0));
        for text in ["", "-", "1e3", "nan", "1.2.3"] {
            assert_eq!(number(text.as_bytes()), None, "{text}");
        }
    }
}
