//! Works on eight bytes of text at once, as one little-endian integer: the first byte is the lowest.

const ONES: u64 = u64::from_ne_bytes([1; 8]);
const HIGHS: u64 = u64::from_ne_bytes([0x80; 8]);

/// The same byte eight times.
pub(crate) const fn all(byte: u8) -> u64 {
    u64::from_ne_bytes([byte; 8])
}

/// The index of the first byte of this value.
pub(crate) const fn first(word: u64, byte: u8) -> Option<usize> {
    match first_bit(word, byte) {
        64 => None,
        bit => Some((bit / 8) as usize),
    }
}

/// The lowest bit of the first byte of this value: a multiple of eight, or 64 if there is none.
pub(crate) const fn first_bit(word: u64, byte: u8) -> u32 {
    // Bytes of this value become zero. Borrows can make higher bytes look like hits; the lowest hit is always right.
    let zeros = word ^ all(byte);
    let hits = zeros.wrapping_sub(ONES) & !zeros & HIGHS;
    hits.trailing_zeros() & !7
}

/// Whether each byte, as a number, is at most nine.
pub(crate) const fn are_digits(values: u64) -> bool {
    // Adding 118 sets the high bit of 10 to 127. Bytes that have a high bit themselves may carry, but they are refused
    // for it anyway.
    (values.wrapping_add(all(118)) | values) & HIGHS == 0
}

/// The number that eight digits make. Each digit is a value and not a character, and the lowest byte is the first
/// digit.
pub(crate) const fn number(digits: u64) -> u64 {
    let pairs = (digits.wrapping_mul((10 << 8) + 1) >> 8) & 0x00ff_00ff_00ff_00ff;
    let fours = (pairs.wrapping_mul((100 << 16) + 1) >> 16) & 0x0000_ffff_0000_ffff;
    fours.wrapping_mul((10_000 << 32) + 1) >> 32
}

/// The eight digits of a number below 1e8, as values and not as characters. The first digit is in the lowest byte.
pub(crate) const fn digits(number: u64) -> u64 {
    let fours = (number / 10_000) | ((number % 10_000) << 32);
    // These reciprocals are exact for the numbers here: 10486 / 2^20 below 10000, 103 / 2^10 below 100.
    let hundreds = (fours.wrapping_mul(10_486) >> 20) & 0x0000_007f_0000_007f;
    let twos = hundreds | ((fours - 100 * hundreds) << 16);
    let tens = (twos.wrapping_mul(103) >> 10) & 0x000f_000f_000f_000f;
    tens | ((twos - 10 * tens) << 8)
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    #[test]
    fn every_four_digits_are_right() {
        for value in 0..10_000 {
            assert_eq!(number(digits(value)), value);
            assert_eq!(number(digits(value * 10_000 + value)), value * 10_000 + value);
        }
    }

    proptest! {
        #[test]
        fn the_first_byte_is_found(bytes in any::<[u8; 8]>(), near in 43..46u8, at in 0..8usize) {
            let mut bytes = bytes;
            bytes[at] = near;
            let word = u64::from_le_bytes(bytes);
            prop_assert_eq!(first(word, b','), bytes.iter().position(|byte| *byte == b','));
        }

        #[test]
        fn digits_are_distinguished_from_all_other_bytes(bytes in proptest::array::uniform8(0..12u8), other: u8, at in 0..9usize) {
            let mut bytes = bytes;
            if let Some(byte) = bytes.get_mut(at) {
                *byte = other;
            }
            prop_assert_eq!(are_digits(u64::from_le_bytes(bytes)), bytes.iter().all(|byte| *byte <= 9));
        }

        #[test]
        fn eight_digits_make_their_number(value in 0..100_000_000u64) {
            let text = format!("{value:08}");
            let word = u64::from_le_bytes(text.as_bytes().try_into().unwrap());
            prop_assert_eq!(number(word ^ all(b'0')), value);
            prop_assert_eq!(digits(value), word ^ all(b'0'));
        }
    }
}
