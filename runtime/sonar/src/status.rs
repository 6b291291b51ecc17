//! A short text of the sonar's state for the payload's status (BPSTS, SPI 7.2).

use serde::{Deserialize, Serialize};

/// The longest status text, characters.
pub const STATUS_CHARS: usize = 80;

/// Something about the sonar that an operator may count as a fault of the payload.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Condition {
    /// There is no connection, or not everything has been said on it.
    NotReady,
    /// An alarm is active.
    Alarm,
    /// A sensor is not healthy.
    Unhealthy,
    /// Logging was ordered, and the controller does not say that it logs.
    NotLogging,
}

/// Cuts a text that is ASCII, at the last whole word if there is one.
pub(crate) fn cut(mut text: String) -> String {
    if text.len() > STATUS_CHARS {
        text.truncate(STATUS_CHARS - 3);
        let end = text.rfind(' ').unwrap_or(text.len());
        text.truncate(end);
        text.push_str("...");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_long_status_is_cut_between_words() {
        assert_eq!(cut("sonar ready".to_owned()), "sonar ready");
        let long = cut("alarm ".repeat(20));
        assert!(long.len() <= STATUS_CHARS && long.ends_with("alarm..."), "{long}");
        assert!(cut("x".repeat(300)).len() <= STATUS_CHARS);
    }
}
