use core::fmt;
use std::borrow::Cow;

use serde::{Deserialize, Deserializer, Serialize};

/// Free text of a sentence: printable ASCII without the delimiters comma, asterisk and dollar (SPI 4.2, Table 1).
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(transparent)]
pub struct Text(Box<str>);

/// A character that the text of a sentence must not hold.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "character {character:?} at byte {at} is not allowed: expected printable ASCII without comma, asterisk and dollar sign"
)]
pub struct TextError {
    /// The first character that is not allowed.
    pub character: char,
    /// The index of its first byte.
    pub at: usize,
}

impl Text {
    /// Makes a text, unchanged.
    ///
    /// # Errors
    /// [`TextError`] names the first character that is not allowed.
    pub fn new(text: &str) -> Result<Self, TextError> {
        match first_foreign(text, is_allowed) {
            None => Ok(Self(text.into())),
            Some((at, character)) => Err(TextError { character, at }),
        }
    }

    /// Makes a text with a blank in place of each character that is not allowed.
    #[must_use]
    pub fn cleaned(text: &str) -> Self {
        Self(blanked(text, is_allowed))
    }
}

const fn is_allowed(character: char) -> bool {
    is_printable(character) && !matches!(character, ',' | '*' | '$')
}

/// Text that ends its sentence and is passed on unchanged: printable ASCII, including delimiters.
///
/// The specification reserves comma and asterisk (SPI 4.2), but the lines that a payload relays from its modem (SPI
/// 7.14) are often sentences themselves, with commas, a dollar sign and a checksum of their own. If the text is the
/// last field of its sentence and the sentence has its checksum, this is not ambiguous.
#[derive(Clone, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(transparent)]
pub struct RelayedText(Box<str>);

/// A character that no text may hold, not even a text that ends its sentence.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("character {character:?} at byte {at} is not allowed: expected printable ASCII")]
pub struct RelayedTextError {
    /// The first character that is not allowed.
    pub character: char,
    /// The index of its first byte.
    pub at: usize,
}

impl RelayedText {
    /// Makes a text, unchanged.
    ///
    /// # Errors
    /// [`RelayedTextError`] names the first character that is not allowed.
    pub fn new(text: &str) -> Result<Self, RelayedTextError> {
        match first_foreign(text, is_printable) {
            None => Ok(Self(text.into())),
            Some((at, character)) => Err(RelayedTextError { character, at }),
        }
    }

    /// Makes a text with a blank in place of each character that is not allowed.
    #[must_use]
    pub fn cleaned(text: &str) -> Self {
        Self(blanked(text, is_printable))
    }

    /// Whether a payload's command begins inside the text (SPI 7). A vehicle that starts a new sentence at each dollar
    /// sign would carry out that command, so such a text is read and never written.
    #[must_use]
    pub fn holds_command(&self) -> bool {
        self.0.contains("$BP")
    }
}

const fn is_printable(character: char) -> bool {
    matches!(character, ' '..='~')
}

impl From<Text> for RelayedText {
    fn from(text: Text) -> Self {
        Self(text.0)
    }
}

/// What both types of text share: they are read as strings, checked when they are read, and compared with strings.
macro_rules! is_string {
    ($text:ident, $error:ident) => {
        impl $text {
            /// The text.
            #[must_use]
            pub fn as_str(&self) -> &str {
                &self.0
            }

            /// Whether the text is empty.
            #[must_use]
            pub fn is_empty(&self) -> bool {
                self.0.is_empty()
            }
        }

        impl<'de> Deserialize<'de> for $text {
            fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
                let text = <Cow<'de, str>>::deserialize(deserializer)?;
                Self::new(&text).map_err(serde::de::Error::custom)
            }
        }

        impl fmt::Display for $text {
            fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str(&self.0)
            }
        }

        impl AsRef<str> for $text {
            fn as_ref(&self) -> &str {
                &self.0
            }
        }

        impl TryFrom<&str> for $text {
            type Error = $error;
            fn try_from(text: &str) -> Result<Self, $error> {
                Self::new(text)
            }
        }

        impl PartialEq<str> for $text {
            fn eq(&self, other: &str) -> bool {
                &*self.0 == other
            }
        }

        impl PartialEq<&str> for $text {
            fn eq(&self, other: &&str) -> bool {
                &*self.0 == *other
            }
        }
    };
}

is_string!(Text, TextError);
is_string!(RelayedText, RelayedTextError);

/// The first character that is not allowed, and its index in bytes.
fn first_foreign(text: &str, is_allowed: fn(char) -> bool) -> Option<(usize, char)> {
    text.char_indices().find(|&(_, character)| !is_allowed(character))
}

/// The text with a blank in place of each character that is not allowed.
fn blanked(text: &str, is_allowed: fn(char) -> bool) -> Box<str> {
    if text.bytes().all(|byte| is_allowed(char::from(byte))) {
        return text.into();
    }
    let or_blank = |character| if is_allowed(character) { character } else { ' ' };
    text.chars().map(or_blank).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn delimiters_controls_and_other_alphabets_are_refused_or_blanked() {
        assert_eq!(Text::new("all well: 3/4 (ok)").unwrap().as_str(), "all well: 3/4 (ok)");
        for bad in ["a,b", "a*b", "a$b", "a\rb", "a\nb", "a\tb", "a\u{7f}b", "aéb"] {
            assert_eq!(Text::new(bad).unwrap_err().at, 1, "{bad:?}");
            assert_eq!(Text::cleaned(bad).as_str(), "a b");
        }
    }

    #[test]
    fn a_serialised_text_is_a_string_and_is_checked_when_read_back() {
        let text = Text::new("line 3").unwrap();
        assert_eq!(serde_json::to_string(&text).unwrap(), "\"line 3\"");
        assert_eq!(serde_json::from_str::<Text>("\"line 3\"").unwrap(), text);
        let error = serde_json::from_str::<Text>("\"line, 3\"").unwrap_err();
        assert!(
            error.to_string().starts_with("character ',' at byte 4 is not allowed"),
            "{error}"
        );
    }

    #[test]
    fn a_relayed_text_may_hold_delimiters_but_no_control_characters() {
        let line = "$CCRXD,1,2*5B";
        assert_eq!(RelayedText::new(line).unwrap(), line);
        assert_eq!(RelayedText::from(Text::new("abort").unwrap()), "abort");
        for bad in ["a\rb", "a\nb", "a\tb", "a\u{7f}b", "aéb"] {
            assert_eq!(RelayedText::new(bad).unwrap_err().at, 1, "{bad:?}");
            assert_eq!(RelayedText::cleaned(bad).as_str(), "a b");
        }
        let json = serde_json::to_string(&RelayedText::cleaned(line)).unwrap();
        assert_eq!(json, format!("\"{line}\""));
        assert_eq!(serde_json::from_str::<RelayedText>(&json).unwrap(), line);
        let error = serde_json::from_str::<RelayedText>("\"a\\r\"").unwrap_err();
        assert!(error.to_string().starts_with("character '\\r' at byte 1"), "{error}");
        assert!(!RelayedText::cleaned(line).holds_command());
        assert!(RelayedText::cleaned("$CCRXD,$BPKIL").holds_command());
    }
}
