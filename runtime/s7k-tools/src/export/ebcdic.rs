//! EBCDIC (code page 037), in which SEG-Y has its textual header.

/// The bytes of a text; a character that the table lacks becomes a space.
pub(super) fn ebcdic(text: &str) -> impl Iterator<Item = u8> {
    text.chars().map(byte)
}

const SPACE: u8 = 0x40;

/// Characters beside letters and digits.
const OTHERS: [(char, u8); 24] = [
    ('.', 0x4B),
    ('<', 0x4C),
    ('(', 0x4D),
    ('+', 0x4E),
    ('|', 0x4F),
    ('&', 0x50),
    ('!', 0x5A),
    ('$', 0x5B),
    ('*', 0x5C),
    (')', 0x5D),
    (';', 0x5E),
    ('-', 0x60),
    ('/', 0x61),
    (',', 0x6B),
    ('%', 0x6C),
    ('_', 0x6D),
    ('>', 0x6E),
    ('?', 0x6F),
    (':', 0x7A),
    ('#', 0x7B),
    ('@', 0x7C),
    ('\'', 0x7D),
    ('=', 0x7E),
    ('"', 0x7F),
];

fn byte(character: char) -> u8 {
    let Ok(ascii) = u8::try_from(character) else {
        return SPACE;
    };
    // Letters lie in three runs: A to I, J to R, S to Z.
    match ascii {
        b'A'..=b'I' => 0xC1 + (ascii - b'A'),
        b'J'..=b'R' => 0xD1 + (ascii - b'J'),
        b'S'..=b'Z' => 0xE2 + (ascii - b'S'),
        b'a'..=b'i' => 0x81 + (ascii - b'a'),
        b'j'..=b'r' => 0x91 + (ascii - b'j'),
        b's'..=b'z' => 0xA2 + (ascii - b's'),
        b'0'..=b'9' => 0xF0 + (ascii - b'0'),
        _ => OTHERS
            .iter()
            .find(|(other, _)| *other == character)
            .map_or(SPACE, |(_, byte)| *byte),
    }
}
