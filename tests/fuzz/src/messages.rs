use core::fmt::Debug;

use backseat_spi::{
    ChecksumState, DecodeError, EncodeError, Framer, FromVehicle, MAX_LINE, Policy, Sentence, ToVehicle, TopsideRelay,
};

/// Fields that may be read with more values than are written, because losing the message would be worse.
const READ_ONLY: [(&str, &str); 4] = [
    ("BFRBS", "charge_percent"),
    ("BFCPS", "frames"),
    ("BFCPR", "frames"),
    ("BPTMR", "text"),
];

/// Decodes a line as a message from the vehicle. A message that decodes must encode; the result must decode to the same
/// message and encode to the same bytes; and a framer must return these bytes unchanged.
pub fn from_vehicle(data: &[u8]) {
    if let Some(sentence) = sentence(data) {
        fixpoint(&sentence, FromVehicle::decode, FromVehicle::encode);
    }
}

/// The same for a payload's line.
pub fn to_vehicle(data: &[u8]) {
    if let Some(sentence) = sentence(data) {
        fixpoint(&sentence, ToVehicle::decode, ToVehicle::encode);
    }
}

/// A framer never returns longer lines.
fn sentence(data: &[u8]) -> Option<Sentence<'_>> {
    let line = core::str::from_utf8(data)
        .ok()
        .filter(|line| line.len() <= MAX_LINE && !line.contains('\n'))?;
    Sentence::parse(line).ok()
}

fn fixpoint<M: Debug + PartialEq>(
    sentence: &Sentence<'_>,
    decode: fn(&Sentence<'_>) -> Result<M, DecodeError>,
    encode: fn(&M, &mut Vec<u8>) -> Result<(), EncodeError>,
) {
    let first = match decode(sentence) {
        Ok(message) => message,
        Err(error) => {
            assert!(error.to_string().lines().count() == 1, "more than one line: {error}");
            assert!(error.found.chars().count() <= DecodeError::FOUND_CHARS);
            return;
        }
    };
    let mut line = Vec::new();
    if let Err(error) = encode(&first, &mut line) {
        match error {
            // Our form of a line may be longer than the one that was read, because of padding, six decimals and the
            // checksum.
            EncodeError::TooLong { .. } => {
                assert!(sentence.raw().len() > MAX_LINE / 2, "{first:?} grew beyond all measure");
            }
            EncodeError::Field { message, field, .. } if READ_ONLY.contains(&(message, field)) => {}
            EncodeError::Field { .. } | EncodeError::Known { .. } => {
                panic!("{first:?} was read and cannot be written: {error}")
            }
        }
        assert!(line.is_empty(), "bytes left behind by an error");
        return;
    }
    assert!(line.len() <= MAX_LINE && line.ends_with(b"\r\n"));
    let text = core::str::from_utf8(&line).expect("what is written is text");
    assert!(
        !text.trim_end_matches("\r\n").contains(['\r', '\n']),
        "{text:?} is not one line"
    );
    let is_relay = text.starts_with(&format!("${},", TopsideRelay::NAME));
    assert!(is_relay || text.matches('$').count() == 1, "{text:?}");
    for policy in [Policy::FromVehicle, Policy::FromPayload] {
        let mut framer = Framer::new(policy);
        framer.push(&line);
        let framed = framer.next_sentence().expect("what is written is framed");
        assert_eq!(framed.raw(), text.trim_end_matches("\r\n"));
    }
    let written = Sentence::parse(text).expect("what is written is a sentence");
    assert_eq!(written.checksum(), ChecksumState::Valid);
    let second = decode(&written).expect("what is written decodes");
    let mut again = Vec::new();
    encode(&second, &mut again).expect("what was written once can be written again");
    assert_eq!(line, again, "{first:?} then {second:?}");
    let third =
        decode(&Sentence::parse(core::str::from_utf8(&again).expect("the same bytes")).expect("the same bytes"));
    assert_eq!(third.expect("the same bytes"), second);
}
