use core::fmt;
use std::borrow::Cow;

use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// The payload's own identifier of a requested behavior (SPI 7.5), unique for the whole mission.
///
/// In messages that may lack an identifier, 0 on the wire means none, so do not give this number to a behavior.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(transparent)]
pub struct BehaviorId(u32);

impl BehaviorId {
    /// Makes an identifier from its number.
    #[must_use]
    pub const fn new(number: u32) -> Self {
        Self(number)
    }

    /// Its number.
    #[must_use]
    pub const fn get(self) -> u32 {
        self.0
    }
}

impl fmt::Display for BehaviorId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

/// The three letters of a command as acknowledgements give them (SPI 6.21): `RMB` for BPRMB.
///
/// Upper-case letters and digits.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct CommandName([u8; 3]);

/// A name that is not the name of a command.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("expected the three upper-case letters of a command: RMB or BPRMB")]
pub struct CommandNameError;

impl CommandName {
    /// The name that a vehicle acknowledges if a line was not a command.
    pub const NAK: Self = Self(*b"NAK");

    /// Makes a name from three letters, or from the five letters of the sentence's name: `RMB` and `BPRMB` are the
    /// same.
    ///
    /// # Errors
    /// [`CommandNameError`] if the text is neither.
    pub fn new(name: &str) -> Result<Self, CommandNameError> {
        let letters = if name.len() == 5 {
            name.strip_prefix("BP").unwrap_or(name)
        } else {
            name
        };
        letters
            .as_bytes()
            .try_into()
            .ok()
            .and_then(Self::from_letters)
            .ok_or(CommandNameError)
    }

    pub(crate) fn from_letters(letters: [u8; 3]) -> Option<Self> {
        letters
            .iter()
            .all(|byte| byte.is_ascii_uppercase() || byte.is_ascii_digit())
            .then_some(Self(letters))
    }

    /// The three letters.
    #[must_use]
    pub fn as_str(&self) -> &str {
        core::str::from_utf8(&self.0).expect("the constructor accepts only ASCII")
    }
}

impl Serialize for CommandName {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.as_str())
    }
}

impl<'de> Deserialize<'de> for CommandName {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let name = <Cow<'de, str>>::deserialize(deserializer)?;
        Self::new(&name).map_err(serde::de::Error::custom)
    }
}

impl fmt::Debug for CommandName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "CommandName({})", self.as_str())
    }
}

impl fmt::Display for CommandName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.as_str())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn three_letters_and_the_whole_name_are_the_same_command() {
        assert_eq!(CommandName::new("LOG").unwrap(), CommandName::new("BPLOG").unwrap());
        assert_eq!(CommandName::new("BPLOG").unwrap().as_str(), "LOG");
        for bad in ["", "LO", "LOGS", "log", "BFLOG", "é1", "BPL,G"] {
            assert!(CommandName::new(bad).is_err(), "{bad:?}");
        }
    }
}
