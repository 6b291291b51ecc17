use crate::error::Fault;
use crate::word;

/// The greatest magnitude of a plain number. It is far greater than the specification needs in any unit, and small
/// enough that six decimals of it are exact in 64 bits.
pub(crate) const LIMIT: f64 = 1e9;

const NOT_A_NUMBER: Fault = Fault::expected("a plain decimal number of at most 1e9, without exponent");
const NOT_AN_INTEGER: Fault = Fault::expected("a whole number from 0 to 4294967295");
const NOT_A_SIGNED_INTEGER: Fault = Fault::expected("a whole number from -2147483648 to 2147483647");

/// Powers of ten that a double holds exactly.
const POWERS: [f64; 16] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15,
];

const PAIRS: [u8; 200] = {
    let mut pairs = [0; 200];
    let mut value = 0;
    while value < 100 {
        pairs[value * 2] = b'0' + (value / 10) as u8;
        pairs[value * 2 + 1] = b'0' + (value % 10) as u8;
        value += 1;
    }
    pairs
};

/// Reads a floating-point number that ends at a comma or at the end of the bytes, and returns it with its length. It
/// reads all numbers that real senders write, except the rarest.
///
/// `None` means that [`parse_decimal`] must look at the text. The scan meets every byte, so that it refuses what the
/// standard library would accept (`inf`, `nan`, `1e3`). Up to 15 digits then make an exact integer, and one division by
/// an exact power of ten rounds correctly. Minus zero becomes zero.
pub(crate) fn scan_decimal(bytes: &[u8]) -> Option<(f64, usize)> {
    match bytes.first_chunk() {
        Some(chunk) => scan_short(u64::from_le_bytes(*chunk)).or_else(|| scan_long(bytes)),
        None => scan_long(bytes),
    }
}

/// Reads a number of at most seven characters. The comma after it must be among the eight characters of `word`.
#[inline]
pub(crate) fn scan_short(word: u64) -> Option<(f64, usize)> {
    let end = word::first_bit(word, b',');
    if !(8..=56).contains(&end) {
        return None;
    }
    let negative = word & 0xff == u64::from(b'-');
    let skipped = if negative { 8 } else { 0 };
    let mut width = end - skipped;
    let mut text = (word >> skipped) & ((1 << width) - 1);
    let mut decimals = 0;
    let point = word::first_bit(text, b'.');
    if point < 64 {
        let before = (1 << point) - 1;
        text = (text & before) | ((text >> 8) & !before);
        width -= 8;
        decimals = (width - point) / 8;
    }
    if width == 0 {
        return None;
    }
    // Moves the digits to the end, with zeros before them.
    let values = (text ^ (word::all(b'0') >> (64 - width))) << (64 - width);
    if !word::are_digits(values) {
        return None;
    }
    let magnitude = word::number(values) as f64 / POWERS[decimals as usize & 15];
    let value = if negative { 0.0 - magnitude } else { magnitude };
    Some((value, end as usize / 8))
}

fn scan_long(bytes: &[u8]) -> Option<(f64, usize)> {
    let (negative, first) = match bytes.first()? {
        b'-' => (true, 1),
        _ => (false, 0),
    };
    let mut mantissa = 0;
    let mut at = scan_digits(bytes, first, &mut mantissa);
    let mut digits = at - first;
    let mut decimals = 0;
    if bytes.get(at) == Some(&b'.') {
        let point = at;
        at = scan_digits(bytes, point + 1, &mut mantissa);
        decimals = at - point - 1;
        digits += decimals;
    }
    if !matches!(bytes.get(at), None | Some(b',')) || !(1..=15).contains(&digits) {
        return None;
    }
    let magnitude = mantissa as f64 / POWERS[decimals];
    let value = if negative { 0.0 - magnitude } else { magnitude };
    (magnitude <= LIMIT).then_some((value, at))
}

/// Appends the digits from `at` on to a number, which wraps if there are too many, and returns where they end.
fn scan_digits(bytes: &[u8], mut at: usize, mantissa: &mut u64) -> usize {
    while let Some(&byte) = bytes.get(at) {
        let digit = byte.wrapping_sub(b'0');
        if digit > 9 {
            break;
        }
        *mantissa = mantissa.wrapping_mul(10).wrapping_add(u64::from(digit));
        at += 1;
    }
    at
}

/// Reads a floating-point numeric field (SPI 4.2, Table 1) that has been trimmed.
pub(crate) fn parse_decimal(bytes: &[u8]) -> Result<f64, Fault> {
    if let Some((value, length)) = scan_decimal(bytes)
        && length == bytes.len()
    {
        return Ok(value);
    }
    if !bytes
        .iter()
        .all(|byte| byte.is_ascii_digit() || matches!(byte, b'+' | b'-' | b'.'))
    {
        return Err(NOT_A_NUMBER);
    }
    let value: f64 = core::str::from_utf8(bytes)
        .ok()
        .and_then(|text| text.parse().ok())
        .ok_or(NOT_A_NUMBER)?;
    if value.abs() <= LIMIT {
        Ok(value + 0.0)
    } else {
        Err(NOT_A_NUMBER)
    }
}

/// Reads an integer numeric field that has been trimmed.
pub(crate) fn parse_integer(bytes: &[u8]) -> Result<u32, Fault> {
    if bytes.is_empty() {
        return Err(NOT_AN_INTEGER);
    }
    bytes
        .iter()
        .try_fold(0u32, |value, byte| match byte.wrapping_sub(b'0') {
            digit @ 0..=9 => value.checked_mul(10)?.checked_add(u32::from(digit)),
            _ => None,
        })
        .ok_or(NOT_AN_INTEGER)
}

/// Reads an integer numeric field that has been trimmed and may be negative.
pub(crate) fn parse_signed(bytes: &[u8]) -> Result<i32, Fault> {
    let (negative, digits) = match bytes {
        [b'-', digits @ ..] => (true, digits),
        digits => (false, digits),
    };
    let magnitude = parse_integer(digits).map_err(|_| NOT_A_SIGNED_INTEGER)?;
    let value = i64::from(magnitude);
    i32::try_from(if negative { -value } else { value }).map_err(|_| NOT_A_SIGNED_INTEGER)
}

/// Writes a number with at most `decimals` places (at most 6), without trailing zeros and without minus zero.
///
/// Rounds half away from zero. The fixed-point code is written by hand because the standard library's formatting takes
/// many times as long.
pub(crate) fn write_decimal(out: &mut Vec<u8>, value: f64, decimals: u8) -> Result<(), Fault> {
    let magnitude = value.abs();
    if magnitude.is_nan() || magnitude > LIMIT {
        return Err(NOT_A_NUMBER);
    }
    let scaled = (magnitude * POWERS[usize::from(decimals)] + 0.5) as u64;
    // A division by a constant costs only a multiplication.
    let (whole, millionths) = match decimals {
        0 => (scaled, 0),
        1 => (scaled / 10, scaled % 10 * 100_000),
        2 => (scaled / 100, scaled % 100 * 10_000),
        3 => (scaled / 1_000, scaled % 1_000 * 1_000),
        4 => (scaled / 10_000, scaled % 10_000 * 100),
        5 => (scaled / 100_000, scaled % 100_000 * 10),
        _ => (scaled / 1_000_000, scaled % 1_000_000),
    };
    if value < 0.0 && scaled > 0 {
        out.push(b'-');
    }
    write_integer(out, whole);
    if millionths > 0 {
        let digits = word::digits(millionths * 100);
        let length = 8 - digits.leading_zeros() as usize / 8;
        push_characters(out, ((digits | word::all(b'0')) << 8) | u64::from(b'.'), 1 + length);
    }
    Ok(())
}

/// Writes a whole number.
#[inline]
pub(crate) fn write_integer(out: &mut Vec<u8>, value: u64) {
    if value < 10 {
        out.push(b'0' + value as u8);
    } else if value < 100 {
        out.extend_from_slice(&two_digits(value as u32));
    } else {
        write_long_integer(out, value);
    }
}

/// Writes a whole number that is not 0.
fn write_long_integer(out: &mut Vec<u8>, value: u64) {
    const EIGHT_DIGITS: u64 = 100_000_000;
    if value < EIGHT_DIGITS {
        let digits = word::digits(value);
        let noughts = digits.trailing_zeros() / 8;
        let characters = (digits | word::all(b'0')) >> (noughts * 8);
        push_characters(out, characters, 8 - noughts as usize);
    } else {
        write_long_integer(out, value / EIGHT_DIGITS);
        push_characters(out, word::digits(value % EIGHT_DIGITS) | word::all(b'0'), 8);
    }
}

/// Appends the first characters of a word: stores eight bytes and cuts the rest off.
fn push_characters(out: &mut Vec<u8>, characters: u64, length: usize) {
    let end = out.len() + length;
    out.extend_from_slice(&characters.to_le_bytes());
    out.truncate(end);
}

/// The two digits of a value, which must be below 100.
pub(crate) fn two_digits(value: u32) -> [u8; 2] {
    let pair = value as usize % 100 * 2;
    [PAIRS[pair], PAIRS[pair + 1]]
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    fn written(value: f64, decimals: u8) -> String {
        let mut out = Vec::new();
        write_decimal(&mut out, value, decimals).unwrap();
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn numbers_are_written_short() {
        for (value, decimals, text) in [
            (0.0, 3, "0"),
            (-0.0, 3, "0"),
            (-0.0004, 3, "0"),
            (0.0005, 3, "0.001"),
            (-0.05, 3, "-0.05"),
            (45.3, 3, "45.3"),
            (100.0, 3, "100"),
            (1e9, 6, "1000000000"),
            (-123_456.789_012, 6, "-123456.789012"),
            (0.9996, 3, "1"),
            (10.01, 2, "10.01"),
            (7.0, 0, "7"),
        ] {
            assert_eq!(written(value, decimals), text);
        }
        for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, 1.1e9, f64::MAX] {
            assert!(write_decimal(&mut Vec::new(), bad, 3).is_err(), "{bad}");
        }
    }

    #[test]
    fn numbers_of_real_senders_are_read() {
        for (text, value) in [
            ("1", 1.0),
            ("1.", 1.0),
            (".5", 0.5),
            ("-.5", -0.5),
            ("0090.500", 90.5),
            ("+2", 2.0),
            ("-0", 0.0),
        ] {
            assert_eq!(parse_decimal(text.as_bytes()), Ok(value), "{text}");
        }
        assert!(parse_decimal(b"-0").unwrap().is_sign_positive());
        let long = "0.10000000000000000555111512312578270211815834045410156250";
        assert_eq!(parse_decimal(long.as_bytes()), Ok(0.1));
    }

    #[test]
    fn text_that_is_not_a_plain_number_is_refused() {
        for bad in [
            "", "-", ".", "-.", "1e3", "1E3", "1e400", "inf", "-inf", "NaN", "infinity", "1.2.3", "--1", "1-", "0x1",
            "1 2",
        ] {
            assert!(parse_decimal(bad.as_bytes()).is_err(), "{bad:?}");
        }
        assert!(parse_decimal("9".repeat(400).as_bytes()).is_err());
        for bad in ["", "-1", "+1", "1.0", "4294967296", "a"] {
            assert!(parse_integer(bad.as_bytes()).is_err(), "{bad:?}");
        }
        assert_eq!(parse_integer(b"007"), Ok(7));
        for bad in ["", "-", "--1", "+1", "1.0", "2147483648", "-2147483649", "-a"] {
            assert!(parse_signed(bad.as_bytes()).is_err(), "{bad:?}");
        }
        assert_eq!(
            (parse_signed(b"-0"), parse_signed(b"-2147483648")),
            (Ok(0), Ok(i32::MIN))
        );
    }

    proptest! {
        #[test]
        fn reading_agrees_with_the_standard_library(text in "-?[0-9]{1,12}(\\.[0-9]{0,12})?") {
            let expected = text.parse::<f64>().unwrap();
            prop_assert_eq!(parse_decimal(text.as_bytes()).ok(), (expected.abs() <= LIMIT).then_some(expected));
        }

        #[test]
        fn a_number_before_a_comma_is_read_like_one_at_the_end(text in "[-+]?[0-9]{0,4}\\.?[0-9]{0,5}", after in "[-.0-9,]{0,9}") {
            let field = format!("{text},{after}");
            let expected = match text.parse::<f64>() {
                Ok(value) if !text.starts_with('+') => Some((value, text.len())),
                _ => None,
            };
            prop_assert_eq!(scan_decimal(field.as_bytes()), expected);
        }

        #[test]
        fn only_numbers_are_read_as_numbers(text in "[-+.,0-9 e:/\u{80}]{0,9}") {
            let plain = !text.contains(['+', ' ', 'e', '\u{80}', '/', ':']);
            for field in [format!("{text},,,,,,,,"), text.clone()] {
                let first = field.split(',').next().unwrap_or_default();
                let scanned = scan_decimal(field.as_bytes());
                let expected = first.parse::<f64>().ok().map(|value| (value, first.len()));
                prop_assert!(scanned == expected || !plain || text.contains(','), "{field:?} {scanned:?}");
                prop_assert!(scanned.is_none() || scanned == expected, "{field:?} {scanned:?}");
            }
        }

        #[test]
        fn a_written_number_is_read_back_to_half_a_unit(value in -1e9..1e9f64, decimals in 0..=6u8) {
            let text = written(value, decimals);
            let back = parse_decimal(text.as_bytes()).unwrap();
            prop_assert!((back - value).abs() <= 0.500_001 / POWERS[usize::from(decimals)] + value.abs() * 1e-15);
            prop_assert_eq!(written(back, decimals), text);
        }

        #[test]
        fn writing_agrees_with_the_standard_library(scaled in -1_000_000_000_000i64..1_000_000_000_000) {
            let value = scaled as f64 / 1000.0;
            let expected = format!("{value:.3}");
            let expected = expected.trim_end_matches('0').trim_end_matches('.');
            prop_assert_eq!(written(value, 3), expected);
        }

        #[test]
        fn integers_survive(value: u32) {
            let mut out = Vec::new();
            write_integer(&mut out, u64::from(value));
            prop_assert_eq!(parse_integer(&out), Ok(value));
        }
    }
}
