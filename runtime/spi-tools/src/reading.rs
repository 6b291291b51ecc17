use std::fmt;

use backseat_spi::{ChecksumState, DecodeError, Direction, Entry, FromVehicle, Sentence, ToVehicle};
use serde::Serialize;

use crate::sheet::entry;
use crate::splitter::{End, Piece};

/// One sentence of the input: its message, or why it has none.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Reading<'a> {
    /// The name as it was read, letters and digits.
    pub(crate) name: &'a str,
    /// The row of the catalogue with this name.
    pub(crate) entry: Option<&'static Entry>,
    pub(crate) checksum: Checksum,
    pub(crate) line: u64,
    pub(crate) bytes: &'a [u8],
    pub(crate) outcome: Result<Message, ReadingError>,
}

/// The state of the checksum.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Checksum {
    Valid,
    Invalid,
    Absent,
}

/// A message of either direction.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub(crate) enum Message {
    FromVehicle(FromVehicle),
    ToVehicle(ToVehicle),
}

/// Why a sentence has no message.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub(crate) enum ReadingError {
    #[error("checksum {found:?} is wrong: {right:02X} is right")]
    Checksum { found: String, right: u8 },
    #[error("unknown message")]
    Unknown,
    #[error(transparent)]
    Decode(#[from] DecodeError),
    #[error("not utf-8 from byte {at} on")]
    NotUtf8 { at: usize },
    #[error("cut short: the next sentence begins before the line ends")]
    CutShort,
    #[error("cut off: the input ends before the line does")]
    CutOff,
    #[error("expected a comma, an asterisk or the end after the name")]
    Malformed,
}

/// The kinds under which [`ReadingError`]s are counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Cause {
    Checksum,
    Unknown,
    Undecodable,
    NotUtf8,
    Cut,
    Malformed,
}

impl Cause {
    pub(crate) const fn text(self) -> &'static str {
        match self {
            Self::Checksum => "with a wrong checksum",
            Self::Unknown => "unknown",
            Self::Undecodable => "not decodable",
            Self::NotUtf8 => "not utf-8",
            Self::Cut => "cut short",
            Self::Malformed => "malformed",
        }
    }
}

impl ReadingError {
    pub(crate) const fn cause(&self) -> Cause {
        match self {
            Self::Checksum { .. } => Cause::Checksum,
            Self::Unknown => Cause::Unknown,
            Self::Decode(_) => Cause::Undecodable,
            Self::NotUtf8 { .. } => Cause::NotUtf8,
            Self::CutShort | Self::CutOff => Cause::Cut,
            Self::Malformed => Cause::Malformed,
        }
    }
}

impl<'a> Reading<'a> {
    /// Reads a piece; `None` if it does not even have a name, and so is noise.
    ///
    /// With `ignore_checksum`, a sentence with a wrong checksum is decoded too, and its checksum is reported as
    /// invalid.
    pub(crate) fn of(piece: Piece<'a>, ignore_checksum: bool) -> Option<Self> {
        let rest = piece.bytes.get(1..)?;
        let length = rest.iter().take_while(|byte| byte.is_ascii_alphanumeric()).count();
        let name = std::str::from_utf8(&rest[..length])
            .ok()
            .filter(|name| !name.is_empty())?;
        let checksum = Checksum::of(piece.bytes);
        let entry = entry(name);
        let outcome = read(piece, entry, checksum, ignore_checksum);
        Some(Self {
            name,
            entry,
            checksum,
            line: piece.line,
            bytes: piece.bytes,
            outcome,
        })
    }
}

fn read(
    piece: Piece<'_>,
    entry: Option<&Entry>,
    checksum: Checksum,
    ignore_checksum: bool,
) -> Result<Message, ReadingError> {
    match (piece.end, checksum) {
        (End::Line, _) | (End::Input, Checksum::Valid) => {}
        (End::Dollar, _) => return Err(ReadingError::CutShort),
        (End::Input, Checksum::Invalid | Checksum::Absent) => return Err(ReadingError::CutOff),
    }
    let text = std::str::from_utf8(piece.bytes).map_err(|error| ReadingError::NotUtf8 {
        at: error.valid_up_to(),
    })?;
    let sentence = Sentence::parse(text).map_err(|_| ReadingError::Malformed)?;
    match sentence.checksum() {
        ChecksumState::Invalid if !ignore_checksum => {
            let (body, digits) = text[1..].rsplit_once('*').unwrap_or((&text[1..], ""));
            return Err(ReadingError::Checksum {
                found: digits.chars().take(8).collect(),
                right: xor(body.as_bytes()),
            });
        }
        ChecksumState::Valid | ChecksumState::Absent | ChecksumState::Invalid => {}
    }
    match entry.map(|entry| entry.direction) {
        Some(Direction::FromVehicle) => Ok(Message::FromVehicle(FromVehicle::decode(&sentence)?)),
        Some(Direction::ToVehicle) => Ok(Message::ToVehicle(ToVehicle::decode(&sentence)?)),
        None => Err(ReadingError::Unknown),
    }
}

impl Checksum {
    /// Works on bytes, so that a line that is not UTF-8 has a checksum too.
    fn of(bytes: &[u8]) -> Self {
        let bytes = &bytes[1..];
        let Some(star) = memchr::memrchr(b'*', bytes) else {
            return Self::Absent;
        };
        let digits = &bytes[star + 1..];
        let found = std::str::from_utf8(digits)
            .ok()
            .filter(|digits| matches!(digits.len(), 1 | 2) && digits.bytes().all(|digit| digit.is_ascii_hexdigit()));
        match found.and_then(|digits| u8::from_str_radix(digits, 16).ok()) {
            Some(sum) if sum == xor(&bytes[..star]) => Self::Valid,
            Some(_) | None => Self::Invalid,
        }
    }
}

fn xor(bytes: &[u8]) -> u8 {
    bytes.iter().fold(0, |sum, byte| sum ^ byte)
}

impl Message {
    /// Appends the sentence with checksum and line end.
    pub(crate) fn encode(&self, out: &mut Vec<u8>) -> Result<(), backseat_spi::EncodeError> {
        match self {
            Self::FromVehicle(message) => message.encode(out),
            Self::ToVehicle(message) => message.encode(out),
        }
    }
}

/// A line of raw input to show to people: bytes other than printable ASCII are escaped, and the line is cut at a fixed
/// number of characters.
pub(crate) struct Raw<'a>(pub(crate) &'a [u8]);

impl Raw<'_> {
    const SHOWN: usize = 120;
}

impl fmt::Display for Raw<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let shown = &self.0[..self.0.len().min(Self::SHOWN)];
        shown.escape_ascii().fmt(f)?;
        if shown.len() < self.0.len() {
            write!(f, "… ({} bytes)", self.0.len())?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use backseat_spi::catalogue;

    use super::*;

    fn piece(bytes: &[u8], end: End) -> Piece<'_> {
        Piece { bytes, end, line: 7 }
    }

    fn reading(line: &str) -> Reading<'_> {
        Reading::of(piece(line.as_bytes(), End::Line), false).unwrap()
    }

    fn error(line: &str) -> String {
        reading(line).outcome.unwrap_err().to_string()
    }

    #[test]
    fn every_example_of_both_directions_is_read() {
        for entry in catalogue() {
            let reading = reading(entry.example);
            assert_eq!((reading.name, reading.checksum), (entry.name, Checksum::Valid));
            let direction = match reading.outcome.unwrap() {
                Message::FromVehicle(_) => Direction::FromVehicle,
                Message::ToVehicle(_) => Direction::ToVehicle,
            };
            assert_eq!(direction, entry.direction);
        }
    }

    #[test]
    fn what_is_wrong_is_said_with_what_would_be_right() {
        // The misprint of the specification's own example.
        let misprint = "$BFNVG,081025.987,4221.81092,N,07106.84603,W,1,45.3,20.1,203.1,-3.4,4.5,081025.980*5b";
        assert_eq!(error(misprint), "checksum \"5b\" is wrong: 4E is right");
        assert_eq!(reading(misprint).checksum, Checksum::Invalid);
        let ignored = Reading::of(piece(misprint.as_bytes(), End::Line), true).unwrap();
        assert!(ignored.outcome.is_ok() && ignored.checksum == Checksum::Invalid);
        assert_eq!(error("$GPGGA,1,2"), "unknown message");
        assert_eq!(error("$BFXYZ,1,2"), "unknown message");
        assert_eq!(error("$BPNVG,1,2"), "unknown message");
        assert_eq!(
            error("$BFCTL;1"),
            "expected a comma, an asterisk or the end after the name"
        );
        assert!(error("$BFCTL,081025.987,2").starts_with("BFCTL field 2 (granted) \"2\": "));
    }

    #[test]
    fn the_checksum_is_the_last_one_of_a_sentence_that_relays_another() {
        let relay = reading("$BPTMR,081025.987,3,$CCRXD,1,2*5B*64");
        assert_eq!(relay.checksum, Checksum::Valid);
        assert!(relay.outcome.is_ok());
        let wrong = error("$BPTMR,081025.987,3,$CCRXD,1,2*5B*65");
        assert_eq!(wrong, "checksum \"65\" is wrong: 64 is right");
    }

    #[test]
    fn a_checksum_is_judged_on_bytes_of_any_kind() {
        let mut line = b"$BFMSC,081025.987,lev\xe9*".to_vec();
        let right = xor(&line[1..line.len() - 1]);
        line.extend_from_slice(format!("{right:02x}").as_bytes());
        let reading = Reading::of(piece(&line, End::Line), false).unwrap();
        assert_eq!((reading.name, reading.checksum), ("BFMSC", Checksum::Valid));
        assert_eq!(reading.outcome, Err(ReadingError::NotUtf8 { at: 21 }));
    }

    #[test]
    fn what_is_cut_is_no_message_but_for_a_last_line_with_its_checksum() {
        let cut = |line: &str, end| {
            Reading::of(piece(line.as_bytes(), end), false)
                .unwrap()
                .outcome
                .map(|_| ())
        };
        assert_eq!(cut("$BFMSC,081025.987,start li", End::Input), Err(ReadingError::CutOff));
        assert_eq!(
            cut("$BFMSC,081025.987,start li", End::Dollar),
            Err(ReadingError::CutShort)
        );
        assert_eq!(cut("$BFCTL,081025.987,1*78", End::Input), Ok(()));
        assert_eq!(Reading::of(piece(b"$", End::Line), false), None);
        assert_eq!(Reading::of(piece(b"$,1", End::Line), false), None);
    }

    #[test]
    fn raw_input_cannot_steer_a_terminal() {
        let shown = Raw(b"$BF\x1b[2J\xff").to_string();
        assert_eq!(shown, "$BF\\x1b[2J\\xff");
        assert!(Raw(&[b'a'; 500]).to_string().ends_with("… (500 bytes)"));
    }
}
