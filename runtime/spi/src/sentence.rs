use nom::bytes::complete::take_while1;
use nom::character::complete::char;
use nom::sequence::preceded;
use nom::{IResult, Parser};

use crate::hex;

/// One sentence, `$NAME,field,…*HH`, borrowed from its line (SPI 4.2).
///
/// Its checksum follows the last asterisk of the line. A payload relays the lines of its modem in a text (SPI 7.14), so
/// the fields may hold dollar signs and asterisks, including those of another checksum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sentence<'a> {
    raw: &'a str,
    name: &'a str,
    body: Option<&'a str>,
    checksum: ChecksumState,
}

/// The state of a sentence's checksum.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ChecksumState {
    /// There is one, and it is right.
    Valid,
    /// There is none: payloads need not send one (SPI 4.2).
    Absent,
    /// There is one and it is wrong, or the text after the asterisk is not a checksum.
    Invalid,
}

/// A line that is not a sentence.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("not a sentence: expected a dollar sign, a name of letters and digits, then a comma, an asterisk or the end")]
pub struct SentenceError;

impl<'a> Sentence<'a> {
    /// Splits a line into its parts. The line end and trailing blanks may be there or not.
    ///
    /// A wrong or missing checksum is not an error: see [`Sentence::checksum`]. [`crate::Framer`] finds sentences in a
    /// stream and checks their checksums.
    ///
    /// # Errors
    /// [`SentenceError`] if the line does not have the form of a sentence.
    #[inline]
    pub fn parse(line: &'a str) -> Result<Self, SentenceError> {
        let raw = line.trim_ascii_end();
        let parts = parts(raw.as_bytes())?;
        // All delimiters are ASCII, so these cuts are at character boundaries.
        let name_end = 1 + parts.name.len();
        let body = parts
            .body
            .and_then(|body| raw.get(name_end + 1..name_end + 1 + body.len()));
        let checked = 1..name_end + parts.body.map_or(0, |body| body.len() + 1);
        let checksum = match parts.digits {
            None => ChecksumState::Absent,
            Some(digits) if checksum(digits) == raw.as_bytes().get(checked).map(xor) => ChecksumState::Valid,
            Some(_) => ChecksumState::Invalid,
        };
        Ok(Self {
            raw,
            name: raw.get(1..name_end).ok_or(SentenceError)?,
            body,
            checksum,
        })
    }

    /// The name, `BFNVG`.
    #[must_use]
    pub const fn name(&self) -> &'a str {
        self.name
    }

    /// The fields after the name, each as its raw text. A sentence that ends with its name has none.
    #[must_use]
    pub fn fields(&self) -> Fields<'a> {
        Fields { rest: self.body }
    }

    /// The state of the checksum.
    #[must_use]
    pub const fn checksum(&self) -> ChecksumState {
        self.checksum
    }

    /// The whole sentence from the dollar sign on, without the line end.
    #[must_use]
    pub const fn raw(&self) -> &'a str {
        self.raw
    }

    /// The text of all fields, with their commas; `None` if the sentence ends with its name.
    pub(crate) const fn body(&self) -> Option<&'a str> {
        self.body
    }
}

/// The fields of a sentence, each as its raw text.
#[derive(Clone, Debug)]
pub struct Fields<'a> {
    rest: Option<&'a str>,
}

impl<'a> Fields<'a> {
    pub(crate) const fn of(body: Option<&'a str>) -> Self {
        Self { rest: body }
    }
}

impl serde::Serialize for Fields<'_> {
    fn serialize<S: serde::Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(self.clone())
    }
}

impl<'a> Iterator for Fields<'a> {
    type Item = &'a str;

    fn next(&mut self) -> Option<&'a str> {
        let rest = self.rest?;
        match rest.split_once(',') {
            Some((field, rest)) => {
                self.rest = Some(rest);
                Some(field)
            }
            None => {
                self.rest = None;
                Some(rest)
            }
        }
    }
}

/// The exclusive or of all bytes between `$` and `*`: the NMEA 0183 checksum.
pub(crate) fn xor(bytes: &[u8]) -> u8 {
    let mut words = bytes.chunks_exact(8);
    let mut sum = words.by_ref().fold(0, |sum, word| {
        sum ^ u64::from_le_bytes(word.try_into().expect("eight bytes"))
    });
    match (words.remainder(), bytes.last_chunk()) {
        ([], _) => {}
        // The last eight bytes again, without those that were already in the last word.
        (rest, Some(last)) => sum ^= u64::from_le_bytes(*last) >> (64 - 8 * rest.len()),
        (rest, None) => return rest.iter().fold(0, |sum, byte| sum ^ byte),
    }
    sum ^= sum >> 32;
    sum ^= sum >> 16;
    (sum ^ (sum >> 8)) as u8
}

struct Parts<'a> {
    name: &'a [u8],
    body: Option<&'a [u8]>,
    digits: Option<&'a [u8]>,
}

fn parts(line: &[u8]) -> Result<Parts<'_>, SentenceError> {
    let (rest, name) = name(line).map_err(|_| SentenceError)?;
    let (body, digits) = match rest {
        [] => (None, None),
        [b'*', digits @ ..] => (None, Some(digits)),
        [b',', body @ ..] => match last_star(body) {
            None => (Some(body), None),
            Some(star) => (Some(&body[..star]), Some(&body[star + 1..])),
        },
        _ => return Err(SentenceError),
    };
    Ok(Parts { name, body, digits })
}

fn name(line: &[u8]) -> IResult<&[u8], &[u8]> {
    preceded(char('$'), take_while1(|byte: u8| byte.is_ascii_alphanumeric())).parse(line)
}

/// The position of the asterisk before the checksum. It is nearly always the third byte from the end.
#[inline]
pub(crate) fn last_star(text: &[u8]) -> Option<usize> {
    match text {
        [before @ .., b'*', high, low] if *high != b'*' && *low != b'*' => Some(before.len()),
        _ => memchr::memrchr(b'*', text),
    }
}

/// One or two hexadecimal digits of either case: real clients send `*4` for `*04`.
pub(crate) fn checksum(digits: &[u8]) -> Option<u8> {
    match *digits {
        [low] => hex::value(low),
        [high, low] => Some((hex::value(high)? << 4) | hex::value(low)?),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_parts_of_a_sentence_are_found() {
        let sentence = Sentence::parse("$BFCTL,081025.987,1*78\r\n").unwrap();
        assert_eq!(sentence.name(), "BFCTL");
        assert_eq!(sentence.fields().collect::<Vec<_>>(), ["081025.987", "1"]);
        assert_eq!(sentence.checksum(), ChecksumState::Valid);
        assert_eq!(sentence.raw(), "$BFCTL,081025.987,1*78");
    }

    #[test]
    fn checksums_of_real_clients_are_read() {
        let state = |line: &str| Sentence::parse(line).unwrap().checksum();
        let sum = xor(b"BPRCA,010203.000");
        assert_eq!(state("$BPRCA,010203.000"), ChecksumState::Absent);
        assert_eq!(state(&format!("$BPRCA,010203.000*{sum:02x}")), ChecksumState::Valid);
        assert_eq!(state(&format!("$BPRCA,010203.000*{sum:02X} ")), ChecksumState::Valid);
        assert_eq!(
            state(&format!("$BPRCA,010203.000*{:02X}", sum ^ 1)),
            ChecksumState::Invalid
        );
        for no_checksum in ["*", "*G0", "*0", "*000", "*é"] {
            assert_eq!(
                state(&format!("$BPRCA,010203.000{no_checksum}")),
                ChecksumState::Invalid,
                "{no_checksum}"
            );
        }
        // A and B alone give 0x03, which real clients print as one digit.
        assert_eq!(state("$AB*3"), ChecksumState::Valid);
    }

    #[test]
    fn the_checksum_is_after_the_last_asterisk() {
        let relayed = "BPTMR,081025.987,3,$CCRXD,1,2*5B";
        let line = format!("${relayed}*{:02X}", xor(relayed.as_bytes()));
        let sentence = Sentence::parse(&line).unwrap();
        assert_eq!(sentence.checksum(), ChecksumState::Valid);
        assert_eq!(
            sentence.fields().collect::<Vec<_>>(),
            ["081025.987", "3", "$CCRXD", "1", "2*5B"]
        );
        let state = |line: &str| Sentence::parse(line).unwrap().checksum();
        assert_eq!(
            state(&format!("${relayed}")),
            ChecksumState::Invalid,
            "the checksum is that of the relayed line"
        );
        assert_eq!(state(&format!("{line}*")), ChecksumState::Invalid);
        // Directly after the name there is no text that could hold an asterisk.
        for line in ["$AB*03*03", "$AB*3*", "$AB**03"] {
            assert_eq!(state(line), ChecksumState::Invalid, "{line}");
        }
        for (text, star) in [
            ("", None),
            ("ab", None),
            ("*", Some(0)),
            ("a*", Some(1)),
            ("a*bc", Some(1)),
        ] {
            assert_eq!(last_star(text.as_bytes()), star, "{text}");
        }
        for (text, star) in [("a*b*", 3), ("a*b*c", 3), ("**c", 1), ("a*bcd", 1), ("*a*bc", 2)] {
            assert_eq!(last_star(text.as_bytes()), Some(star), "{text}");
        }
    }

    #[test]
    fn no_field_and_one_empty_field_differ() {
        assert_eq!(Sentence::parse("$BPRMP").unwrap().fields().count(), 0);
        assert_eq!(Sentence::parse("$BPRMP,").unwrap().fields().collect::<Vec<_>>(), [""]);
        assert_eq!(Sentence::parse("$BPRMP,,").unwrap().fields().count(), 2);
    }

    #[test]
    fn a_line_that_is_not_a_sentence_is_refused() {
        for bad in [
            "",
            "$",
            "BFCTL,1",
            "$,1",
            "$*00",
            "$BF CTL,1",
            "$BFé,1",
            "$BFCTL;1",
            " $BFCTL,1",
        ] {
            assert_eq!(Sentence::parse(bad), Err(SentenceError), "{bad:?}");
        }
    }

    proptest::proptest! {
        #[test]
        fn the_checksum_covers_every_byte(bytes in proptest::collection::vec(proptest::num::u8::ANY, 0..40)) {
            proptest::prop_assert_eq!(xor(&bytes), bytes.iter().fold(0, |sum, byte| sum ^ byte));
        }
    }
}
