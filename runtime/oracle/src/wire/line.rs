use memchr::{memchr_iter, memrchr};

use super::fields::time_at_start;
use crate::time_of_day::TimeOfDay;

/// The longest line that is read, bytes. The specification names no limit. The longest sentence is BPCPD (SPI 9.4) with
/// eight frames. The largest frames of the modems that it names have 256 bytes: 4,096 digits, and the fields before
/// them.
pub const LINE_MAX: usize = 4352;

/// The exclusive or of the bytes between the dollar sign and the asterisk (NMEA 0183).
fn checksum(between: &[u8]) -> u8 {
    between.iter().fold(0, |sum, byte| sum ^ byte)
}

/// The bytes between the dollar sign and the asterisk, and the two bytes after the asterisk, which must end the text.
pub(super) fn split_checksum(sentence: &[u8]) -> Option<(&[u8], [u8; 2])> {
    let (rest, digits) = sentence.split_last_chunk::<2>()?;
    Some((rest.strip_suffix(b"*")?.strip_prefix(b"$")?, *digits))
}

/// Whether two digits, of either case, are the checksum of the body.
pub(super) fn is_checksum(body: &[u8], digits: [u8; 2]) -> bool {
    let [high, low] = digits.map(|digit| char::from(digit).to_digit(16));
    match (high, low) {
        (Some(high), Some(low)) => high * 16 + low == u32::from(checksum(body)),
        (Some(_) | None, Some(_) | None) => false,
    }
}

/// The name and the fields of a sentence if its checksum is right. Blanks may follow it.
pub(super) fn checked(sentence: &[u8]) -> Option<([u8; 5], &[u8])> {
    let (body, digits) = split_checksum(sentence.trim_ascii_end())?;
    let (name, rest) = body.split_first_chunk::<5>()?;
    is_checksum(body, digits).then_some((*name, rest))
}

/// The sentence at the end of a line. The bytes before the last dollar sign are noise.
pub(crate) fn newest_sentence(line: &[u8]) -> Option<&[u8]> {
    memrchr(b'$', line).and_then(|start| line.get(start..))
}

/// The names of everything in a line that could be read as a sentence, with the time at which it was made if the
/// sentence is whole.
pub(crate) fn sentences(line: &[u8]) -> impl Iterator<Item = ([u8; 5], Option<TimeOfDay>)> {
    memchr_iter(b'$', line).filter_map(|start| {
        let sentence = line.get(start..)?;
        let name = *sentence.get(1..)?.first_chunk::<5>()?;
        let created = checked(sentence).and_then(|(_, rest)| time_at_start(rest.get(1..)?));
        Some((name, created))
    })
}
