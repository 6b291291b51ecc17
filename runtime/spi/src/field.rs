use memchr::memchr;

use crate::error::{DecodeError, Fault};
use crate::hex;
use crate::number;
use crate::sentence::Sentence;
use crate::word;

/// How one value of a message is written on the wire: which fields it takes, and how they are read and written.
///
/// An irregular message gets a form of its own, so that the table needs no exception. A type that is always written in
/// the same way is its own form.
pub(crate) trait Field {
    /// The type of the value in the program.
    type Value;

    /// The wire fields that the value takes, in the notation of the specification, for the catalogue.
    const FORMATS: &'static [&'static str];

    /// The range of values, as text for the catalogue, in the unit of the message's field.
    const RANGE: &'static str;

    /// Takes the value's fields from the reader.
    fn decode(reader: &mut Reader<'_>) -> Result<Self::Value, Fault>;

    /// Writes exactly the fields of [`Field::FORMATS`].
    fn encode(value: &Self::Value, writer: &mut Writer<'_>) -> Result<(), Fault>;

    /// The time at which the message was made, if the value is that time.
    fn created(_value: &Self::Value) -> Option<backseat_units::TimeOfDay> {
        None
    }

    /// Values that survive the wire unchanged.
    #[cfg(test)]
    fn strategy() -> proptest::strategy::BoxedStrategy<Self::Value>;
}

/// The fields of a sentence, taken one after the other.
///
/// Works on bytes, because all delimiters are ASCII and only free text must be read as characters.
pub(crate) struct Reader<'a> {
    /// All fields with the commas between them.
    fields: &'a [u8],
    /// Where the next field starts. After the last comma one more field follows, which may be empty, and then none.
    at: usize,
    /// Where the last taken field starts.
    last: usize,
    /// Whether there is no field at all, not even an empty one.
    absent: bool,
}

impl<'a> Reader<'a> {
    pub(crate) fn new(sentence: &Sentence<'a>) -> Self {
        let body = sentence.body();
        Self {
            fields: body.unwrap_or_default().as_bytes(),
            at: usize::from(body.is_none()),
            last: 0,
            absent: body.is_none(),
        }
    }

    /// The next field, unchanged.
    pub(crate) fn bytes(&mut self) -> Result<&'a [u8], Fault> {
        let rest = self.rest()?;
        let length = find_comma(rest).unwrap_or(rest.len());
        self.skip(length);
        Ok(&rest[..length])
    }

    /// The next field as text.
    pub(crate) fn text(&mut self) -> Result<&'a str, Fault> {
        self.bytes().map(as_text)
    }

    /// The rest as text, including its commas.
    pub(crate) fn text_to_end(&mut self) -> Result<&'a str, Fault> {
        let rest = self.rest()?;
        self.skip(rest.len());
        Ok(as_text(rest))
    }

    /// The next field without blanks around it; an error if nothing is left.
    pub(crate) fn trimmed(&mut self) -> Result<&'a [u8], Fault> {
        let bytes = trim(self.bytes()?);
        if bytes.is_empty() { Err(Fault::Empty) } else { Ok(bytes) }
    }

    /// The next field as a floating-point number.
    #[inline]
    pub(crate) fn decimal(&mut self) -> Result<f64, Fault> {
        match self.short_decimal() {
            Some(value) => Ok(value),
            None => self.long_decimal(),
        }
    }

    /// Takes the next field if it is a short number. Separate from [`Self::decimal`] so that the result is returned in
    /// registers.
    #[inline(never)]
    fn short_decimal(&mut self) -> Option<f64> {
        let (value, length) = number::scan_short(self.window()?)?;
        self.skip(length);
        Some(value)
    }

    fn long_decimal(&mut self) -> Result<f64, Fault> {
        let rest = self.rest()?;
        self.decimal_from(rest, 0)
    }

    /// The next field as a whole number.
    pub(crate) fn integer(&mut self) -> Result<u32, Fault> {
        match self.digit() {
            Some(digit) => Ok(u32::from(digit)),
            None => number::parse_integer(self.trimmed()?),
        }
    }

    /// The next field as a whole number that may be negative.
    pub(crate) fn signed(&mut self) -> Result<i32, Fault> {
        match self.digit() {
            Some(digit) => Ok(i32::from(digit)),
            None => number::parse_signed(self.trimmed()?),
        }
    }

    /// The next field as fixed-width digits and then a floating-point number: `ddmm.mm`.
    pub(crate) fn digits_and_decimal<const WIDTH: usize>(&mut self, fault: Fault) -> Result<(u32, f64), Fault> {
        let mut rest = self.rest()?;
        if rest.first().is_none_or(|byte| !byte.is_ascii_digit()) {
            let length = find_comma(rest).unwrap_or(rest.len());
            let field = trim(&rest[..length]);
            if field.is_empty() {
                self.skip(length);
                return Err(Fault::Empty);
            }
            rest = rest.trim_ascii_start();
        }
        let (Some(digits), Some(b'0'..=b'9' | b'.')) = (rest.first_chunk::<WIDTH>(), rest.get(WIDTH)) else {
            self.last = self.at;
            return Err(fault);
        };
        let mut whole = 0;
        for byte in digits {
            match byte.wrapping_sub(b'0') {
                digit @ 0..=9 => whole = whole * 10 + u32::from(digit),
                _ => {
                    self.last = self.at;
                    return Err(fault);
                }
            }
        }
        Ok((whole, self.decimal_from(rest, WIDTH).map_err(|_| fault)?))
    }

    /// The number that starts at `skip` in `rest`, which starts in the next field.
    fn decimal_from(&mut self, rest: &'a [u8], skip: usize) -> Result<f64, Fault> {
        let before = self.fields.len() - self.at - rest.len() + skip;
        let from = &rest[skip..];
        if let Some((value, length)) = number::scan_decimal(from) {
            self.skip(before + length);
            return Ok(value);
        }
        let length = find_comma(from).unwrap_or(from.len());
        self.skip(before + length);
        let text = trim(&from[..length]);
        if text.is_empty() {
            Err(Fault::Empty)
        } else {
            number::parse_decimal(text)
        }
    }

    /// Takes the next field if it is a single digit.
    fn digit(&mut self) -> Option<u8> {
        let [character] = self.peek()?;
        let digit = character.wrapping_sub(b'0');
        (digit <= 9).then(|| {
            self.skip(1);
            digit
        })
    }

    /// Whether no field is left.
    pub(crate) const fn is_done(&self) -> bool {
        self.at > self.fields.len()
    }

    /// The next bytes, if they may be a field of exactly that length. The caller must make sure that there is no comma
    /// among them before it calls [`Self::skip`].
    pub(crate) fn peek<const N: usize>(&self) -> Option<&'a [u8; N]> {
        let rest = self.fields.get(self.at..)?;
        match rest.get(N) {
            None | Some(b',') => rest.first_chunk(),
            Some(_) => None,
        }
    }

    /// Takes the next field, whose length is known.
    pub(crate) const fn skip(&mut self, length: usize) {
        self.last = self.at;
        self.at += length + 1;
    }

    /// How many fields are left.
    pub(crate) fn remaining(&self) -> usize {
        let rest = self.fields.get(self.at..);
        rest.map_or(0, |rest| 1 + memchr::memchr_iter(b',', rest).count())
    }

    /// Whether there is a next field and it is blank.
    pub(crate) fn next_is_blank(&self) -> bool {
        self.fields.get(self.at..).is_some_and(|rest| match rest {
            [] | [b',', ..] => true,
            [first, ..] if first.is_ascii_whitespace() => matches!(rest.trim_ascii_start(), [] | [b',', ..]),
            _ => false,
        })
    }

    /// The error for a fault in the last taken field.
    #[cold]
    pub(crate) fn error(&self, message: &'static str, field: &'static str, fault: Fault) -> DecodeError {
        let (before, last) = self.fields.split_at_checked(self.last).unwrap_or((self.fields, b""));
        let commas = memchr::memchr_iter(b',', before).count();
        // A missing field comes after the last one.
        let missing = usize::from(self.last > self.fields.len() && !self.absent);
        let found = as_text(&last[..find_comma(last).unwrap_or(last.len())]);
        let found = found
            .chars()
            .take(DecodeError::FOUND_CHARS)
            .collect::<String>()
            .into_boxed_str();
        DecodeError {
            message,
            field,
            number: 1 + commas + missing,
            found,
            fault,
        }
    }

    /// Everything from the next field on.
    fn rest(&mut self) -> Result<&'a [u8], Fault> {
        match self.fields.get(self.at..) {
            Some(rest) => Ok(rest),
            None => {
                self.last = self.at;
                Err(Fault::Missing)
            }
        }
    }

    /// The next eight bytes; `None` if there are fewer.
    fn window(&self) -> Option<u64> {
        let chunk = self.fields.get(self.at..)?.first_chunk()?;
        Some(u64::from_le_bytes(*chunk))
    }
}

fn as_text(bytes: &[u8]) -> &str {
    core::str::from_utf8(bytes).expect("a piece of a str that is cut at commas is valid UTF-8")
}

/// Blanks around numbers are legal (SPI 4.2, Table 1: "the first non-whitespace character"). Most have none.
pub(crate) fn trim(bytes: &[u8]) -> &[u8] {
    match bytes {
        [first, .., last] if !first.is_ascii_whitespace() && !last.is_ascii_whitespace() => bytes,
        _ => bytes.trim_ascii(),
    }
}

/// Searches eight bytes at a time. Most fields are short, so a vector search costs more to start than it saves.
fn find_comma(bytes: &[u8]) -> Option<usize> {
    let mut rest = bytes;
    let mut searched = 0;
    while let Some((chunk, after)) = rest.split_first_chunk::<8>() {
        let word = u64::from_le_bytes(*chunk);
        if let Some(at) = word::first(word, b',') {
            return Some(searched + at);
        }
        searched += 8;
        rest = after;
        if searched == 32 {
            return memchr(b',', rest).map(|at| searched + at);
        }
    }
    rest.iter().position(|byte| *byte == b',').map(|at| searched + at)
}

/// Appends the fields of a sentence, each after its comma.
pub(crate) struct Writer<'a> {
    out: &'a mut Vec<u8>,
}

impl<'a> Writer<'a> {
    pub(crate) const fn new(out: &'a mut Vec<u8>) -> Self {
        Self { out }
    }

    /// Writes a field of one ASCII character, which must not be a delimiter.
    pub(crate) fn character(&mut self, character: u8) {
        self.out.extend_from_slice(&[b',', character]);
    }

    /// Writes a field of ASCII text. It may hold a delimiter only if it ends the sentence.
    pub(crate) fn text(&mut self, text: &str) {
        self.out.push(b',');
        self.out.extend_from_slice(text.as_bytes());
    }

    /// Writes an empty field.
    pub(crate) fn empty(&mut self) {
        self.out.push(b',');
    }

    /// Writes a whole number.
    pub(crate) fn integer(&mut self, value: u32) {
        self.out.push(b',');
        number::write_integer(self.out, u64::from(value));
    }

    /// Writes a whole number that may be negative.
    pub(crate) fn signed(&mut self, value: i32) {
        self.out.push(b',');
        if value < 0 {
            self.out.push(b'-');
        }
        number::write_integer(self.out, u64::from(value.unsigned_abs()));
    }

    /// Writes a number with at most `decimals` places, without trailing zeros.
    pub(crate) fn decimal(&mut self, value: f64, decimals: u8) -> Result<(), Fault> {
        self.out.push(b',');
        number::write_decimal(self.out, value, decimals)
    }

    /// Writes bytes as upper-case hexadecimal digits.
    pub(crate) fn hex(&mut self, bytes: &[u8]) {
        self.out.push(b',');
        self.out.reserve(bytes.len() * 2);
        bytes
            .iter()
            .for_each(|byte| self.out.extend_from_slice(&hex::digits(*byte)));
    }

    /// Begins a new field with its comma, and returns the buffer.
    pub(crate) fn field(&mut self) -> &mut Vec<u8> {
        self.out.push(b',');
        self.out
    }
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn fields_come_in_order_and_end() {
        let sentence = Sentence::parse("$X, a ,,0123456789abcdef0123456789abcdef0123456789,é,b").unwrap();
        let mut reader = Reader::new(&sentence);
        assert_eq!(reader.remaining(), 5);
        assert_eq!(reader.trimmed(), Ok(b"a".as_slice()));
        assert!(reader.next_is_blank());
        assert_eq!(reader.trimmed(), Err(Fault::Empty));
        assert_eq!(reader.text().unwrap().len(), 42);
        assert_eq!(reader.text(), Ok("é"));
        assert_eq!(reader.text(), Ok("b"));
        assert_eq!(reader.text(), Err(Fault::Missing));
        assert!(!reader.next_is_blank());
    }

    #[test]
    fn the_text_to_the_end_leaves_nothing() {
        for (line, text) in [("$X,1,a,b,", "a,b,"), ("$X,1,", ""), ("$X,1,é*00", "é")] {
            let mut reader = Reader::new(&Sentence::parse(line).unwrap());
            reader.bytes().unwrap();
            assert_eq!(reader.text_to_end(), Ok(text), "{line}");
            assert!(reader.is_done());
            assert_eq!(reader.text_to_end(), Err(Fault::Missing));
        }
    }

    proptest! {
        #[test]
        fn the_comma_is_found_at_every_position(text in "[-,+.\u{80}\u{ff}a]{0,80}") {
            prop_assert_eq!(find_comma(text.as_bytes()), text.find(','));
        }
    }
}
