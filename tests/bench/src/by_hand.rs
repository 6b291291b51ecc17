//! Sentences of SPI read and written by hand, as floors: one function for each sentence, which only handles that
//! sentence.
//!
//! A reader checks the checksum and parses the fields in their order. It checks no ranges, returns no errors and
//! handles no other sentence. A writer writes the same bytes as ours.

/// The fields of a line that have not been read yet.
struct Fields<'a> {
    line: &'a [u8],
    at: usize,
}

impl<'a> Fields<'a> {
    /// The fields of a line whose name and checksum are right.
    fn of(line: &'a [u8], name: &[u8]) -> Option<Self> {
        let star = line.iter().position(|byte| *byte == b'*')?;
        let sum = line[1..star].iter().fold(0, |sum, byte| sum ^ byte);
        let digits = line.get(star + 1..star + 3)?;
        let right = line.starts_with(name) && hex(digits[0])? * 16 + hex(digits[1])? == sum;
        right.then_some(Self { line, at: name.len() })
    }

    fn next(&mut self) -> &'a [u8] {
        let from = self.at;
        while !matches!(self.line[self.at], b',' | b'*') {
            self.at += 1;
        }
        self.at += 1;
        &self.line[from..self.at - 1]
    }

    fn angle(&mut self, digits: usize, negative: &[u8]) -> Option<f64> {
        let angle = degrees(self.next(), digits)?;
        Some(if self.next() == negative { -angle } else { angle })
    }
}

/// BFNVG: time, latitude, longitude, quality and five numbers, time.
#[must_use]
pub fn navigation(line: &[u8]) -> Option<[f64; 10]> {
    let mut fields = Fields::of(line, b"$BFNVG,")?;
    let mut values = [0.0; 10];
    values[0] = clock(fields.next())?;
    values[1] = fields.angle(2, b"S")?;
    values[2] = fields.angle(3, b"W")?;
    for value in &mut values[3..9] {
        *value = number(fields.next())?;
    }
    values[9] = clock(fields.next())?;
    Some(values)
}

/// BFNVR: time and six numbers.
#[must_use]
pub fn velocity(line: &[u8]) -> Option<[f64; 7]> {
    let mut fields = Fields::of(line, b"$BFNVR,")?;
    let mut values = [0.0; 7];
    values[0] = clock(fields.next())?;
    for value in &mut values[1..] {
        *value = number(fields.next())?;
    }
    Some(values)
}

/// The result of [`acknowledgement`]: times in seconds since midnight.
#[derive(Debug)]
#[expect(missing_docs, reason = "the fields of BFACK")]
pub struct Acknowledgement {
    pub created: f64,
    pub command: [u8; 3],
    pub command_created: f64,
    pub identifier: u32,
    pub status: u8,
    pub text: Box<str>,
}

/// BFACK: time, command, its time, identifier, status, and the text as a string of its own.
#[must_use]
pub fn acknowledgement(line: &[u8]) -> Option<Acknowledgement> {
    let mut fields = Fields::of(line, b"$BFACK,")?;
    let created = clock(fields.next())?;
    let command = fields.next().try_into().ok()?;
    let command_created = clock(fields.next())?;
    let mut identifier = 0;
    for digit in fields.next() {
        identifier = identifier * 10 + u32::from(digit - b'0');
    }
    let status = *fields.next().first()? - b'0';
    fields.next();
    let text = std::str::from_utf8(fields.next()).ok()?;
    Some(Acknowledgement {
        created,
        command,
        command_created,
        identifier,
        status,
        text: text.into(),
    })
}

/// BFDVL: time, eight numbers that may be empty, time.
#[must_use]
pub fn doppler(line: &[u8]) -> Option<(f64, [Option<f64>; 8], f64)> {
    let mut fields = Fields::of(line, b"$BFDVL,")?;
    let created = clock(fields.next())?;
    let mut values = [None; 8];
    for value in &mut values {
        let field = fields.next();
        *value = if field.is_empty() { None } else { Some(number(field)?) };
    }
    Some((created, values, clock(fields.next())?))
}

/// BPRMB: milliseconds since midnight, heading, depth and speed.
pub fn modify(out: &mut Vec<u8>, millis: u32, [heading, depth, speed]: [f64; 3]) {
    let start = out.len();
    out.extend_from_slice(b"$BPRMB,");
    put_clock(out, millis);
    out.push(b',');
    put_thousandths(out, heading);
    out.push(b',');
    put_thousandths(out, depth);
    out.extend_from_slice(b",0,");
    put_thousandths(out, speed);
    out.extend_from_slice(b",1,0");
    put_end(out, start);
}

/// BPRTK: milliseconds since midnight, identifier, both ends as degrees north and west, altitude and speed.
pub fn trackline(out: &mut Vec<u8>, millis: u32, identifier: u32, ends: [f64; 4], [altitude, speed]: [f64; 2]) {
    let start = out.len();
    out.extend_from_slice(b"$BPRTK,");
    put_clock(out, millis);
    out.push(b',');
    put_whole(out, identifier);
    for (angle, hemisphere) in ends.into_iter().zip([b'N', b'W', b'N', b'W']) {
        out.push(b',');
        put_angle(out, (angle * 6e7 + 0.5) as u64, if hemisphere == b'N' { 2 } else { 3 });
        out.extend_from_slice(&[b',', hemisphere]);
    }
    out.extend_from_slice(b",1,");
    put_thousandths(out, altitude);
    out.push(b',');
    put_thousandths(out, speed);
    out.extend_from_slice(b",0,0");
    put_end(out, start);
}

fn hex(digit: u8) -> Option<u8> {
    char::from(digit)
        .to_digit(16)
        .and_then(|digit| u8::try_from(digit).ok())
}

fn number(text: &[u8]) -> Option<f64> {
    const SCALES: [f64; 10] = [1.0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9];
    let (negative, digits) = match text {
        [b'-', rest @ ..] => (true, rest),
        rest => (false, rest),
    };
    let (mut whole, mut decimals, mut point) = (0u64, 0, false);
    for byte in digits {
        match byte {
            b'0'..=b'9' => {
                whole = whole * 10 + u64::from(byte - b'0');
                decimals += usize::from(point);
            }
            b'.' if !point => point = true,
            _ => return None,
        }
    }
    let value = whole as f64 / SCALES.get(decimals)?;
    Some(if negative { -value } else { value })
}

fn clock(text: &[u8]) -> Option<f64> {
    Some(number(text.get(..2)?)? * 3600.0 + number(text.get(2..4)?)? * 60.0 + number(text.get(4..)?)?)
}

fn degrees(text: &[u8], digits: usize) -> Option<f64> {
    Some(number(text.get(..digits)?)? + number(text.get(digits..)?)? / 60.0)
}

fn put_digits<const N: usize>(out: &mut Vec<u8>, mut value: u64) {
    let mut digits = [0; N];
    for digit in digits.iter_mut().rev() {
        *digit = b'0' + (value % 10) as u8;
        value /= 10;
    }
    out.extend_from_slice(&digits);
}

fn put_whole(out: &mut Vec<u8>, mut value: u32) {
    let mut digits = [0; 10];
    let mut at = digits.len();
    loop {
        at -= 1;
        digits[at] = b'0' + (value % 10) as u8;
        value /= 10;
        if value == 0 {
            break;
        }
    }
    out.extend_from_slice(&digits[at..]);
}

fn put_thousandths(out: &mut Vec<u8>, value: f64) {
    let value = (value * 1e3 + 0.5) as u32;
    put_whole(out, value / 1000);
    let rest = value % 1000;
    if rest == 0 {
        return;
    }
    out.push(b'.');
    put_digits::<3>(out, u64::from(rest));
    while out.last() == Some(&b'0') {
        out.pop();
    }
}

fn put_clock(out: &mut Vec<u8>, millis: u32) {
    let seconds = millis / 1000;
    for part in [seconds / 3600, seconds / 60 % 60, seconds % 60] {
        put_digits::<2>(out, u64::from(part));
    }
    out.push(b'.');
    put_digits::<3>(out, u64::from(millis % 1000));
}

fn put_angle(out: &mut Vec<u8>, micro_minutes: u64, digits: usize) {
    let degrees = micro_minutes / 60_000_000;
    if digits == 2 {
        put_digits::<2>(out, degrees);
    } else {
        put_digits::<3>(out, degrees);
    }
    put_digits::<2>(out, micro_minutes / 1_000_000 % 60);
    out.push(b'.');
    put_digits::<6>(out, micro_minutes % 1_000_000);
}

fn put_end(out: &mut Vec<u8>, start: usize) {
    const DIGITS: &[u8; 16] = b"0123456789ABCDEF";
    let sum = out[start + 1..].iter().fold(0u8, |sum, byte| sum ^ byte);
    out.extend_from_slice(&[
        b'*',
        DIGITS[usize::from(sum >> 4)],
        DIGITS[usize::from(sum & 15)],
        b'\r',
        b'\n',
    ]);
}
