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
    "character {character:?} at byte {at} is not allowed: expected printable ascii without comma, asterisk, dollar"
)]
pub struct TextError {
    /// The first character that is not allowed.
    pub character: char,
    /// Where it stands, bytes from the start.
    pub at: usize,
}

impl Text {
    /// The text as it stands.
    ///
    /// # Errors
    /// [`TextError`] names the first character that is not allowed.
    pub fn new(text: &str) -> Result<Self, TextError> {
        match text.char_indices().find(|&(_, character)| !is_allowed(character)) {
            None => Ok(Self(text.into())),
            Some((at, character)) => Err(TextError { character, at }),
        }
    }

    /// The text with a blank in place of each character that is not allowed.
    #[must_use]
    pub fn cleaned(text: &str) -> Self {
        if text.bytes().all(|byte| is_allowed(char::from(byte))) {
            return Self(text.into());
        }
        Self(
            text.chars()
                .map(|character| if is_allowed(character) { character } else { ' ' })
                .collect(),
        )
    }

    /// The text.
    #[must_use]
    pub fn as_str(&self) -> &str {
        &self.0
    }

    /// Whether there is none.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }
}

fn is_allowed(character: char) -> bool {
    matches!(character, ' '..='~') && !matches!(character, ',' | '*' | '$')
}

impl<'de> Deserialize<'de> for Text {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let text = <Cow<'de, str>>::deserialize(deserializer)?;
        Self::new(&text).map_err(serde::de::Error::custom)
    }
}

impl fmt::Display for Text {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.0)
    }
}

impl AsRef<str> for Text {
    fn as_ref(&self) -> &str {
        &self.0
    }
}

impl TryFrom<&str> for Text {
    type Error = TextError;
    fn try_from(text: &str) -> Result<Self, TextError> {
        Self::new(text)
    }
}

impl PartialEq<str> for Text {
    fn eq(&self, other: &str) -> bool {
        &*self.0 == other
    }
}

impl PartialEq<&str> for Text {
    fn eq(&self, other: &&str) -> bool {
        &*self.0 == *other
    }
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
    fn a_serialised_text_is_a_string_and_checked_on_the_way_back() {
        let text = Text::new("line 3").unwrap();
        assert_eq!(serde_json::to_string(&text).unwrap(), "\"line 3\"");
        assert_eq!(serde_json::from_str::<Text>("\"line 3\"").unwrap(), text);
        let error = serde_json::from_str::<Text>("\"line, 3\"").unwrap_err();
        assert!(
            error.to_string().starts_with("character ',' at byte 4 is not allowed"),
            "{error}"
        );
    }
}
