use backseat_spi::{ChecksumState, Sentence, ToVehicle};
use backseat_units::TimeOfDay;
use memchr::memchr_iter;

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

/// The time of BFNVG's solution: its twelfth field (SPI 6.1). Nothing where the checksum is wrong.
pub(super) fn solution_time(line: &[u8]) -> Option<TimeOfDay> {
    let line = line.trim_ascii_end();
    let star = line.len().checked_sub(3).filter(|at| line.get(*at) == Some(&b'*'))?;
    let sum = line.get(1..star)?.iter().fold(0, |sum, byte| sum ^ byte);
    let digit = |at: usize| char::from(*line.get(at)?).to_digit(16);
    if digit(star + 1)? * 16 + digit(star + 2)? != u32::from(sum) {
        return None;
    }
    let start = memchr_iter(b',', line).nth(11)? + 1;
    time(line.get(start..star)?)
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
