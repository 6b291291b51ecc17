use backseat_spi::{Direction, LoggingControl, Text, ToVehicle, catalogue};

use crate::error::Error;
use crate::list::is_named;

/// The messages that a watch requests from the vehicle. It sends these BPLOG sentences and nothing else.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Subscription {
    /// Three letters each; empty means every message.
    only: Vec<&'static str>,
}

impl Subscription {
    /// Every message from the vehicle.
    #[must_use]
    pub const fn everything() -> Self {
        Self { only: Vec::new() }
    }

    /// Some messages, by names such as `NVG` or `BFNVG`.
    ///
    /// # Errors
    /// [`Error::NoMessage`] and [`Error::NotFromVehicle`].
    pub fn only<'a>(names: impl IntoIterator<Item = &'a str>) -> Result<Self, Error> {
        let mut only = Vec::new();
        for name in names.into_iter().map(str::trim) {
            let mut named = catalogue().iter().filter(|entry| is_named(entry, name)).peekable();
            if named.peek().is_none() {
                return Err(Error::NoMessage { name: name.to_owned() });
            }
            match named.find(|entry| entry.direction == Direction::FromVehicle) {
                Some(entry) => only.push(&entry.name[2..]),
                None => return Err(Error::NotFromVehicle { name: name.to_owned() }),
            }
        }
        Ok(Self { only })
    }

    /// The sentences for the first subscription.
    ///
    /// CTL comes first: vehicles send BFCTL only when control changes, so a late subscriber misses it. ACK is not part
    /// of ALL (SPI 7.1).
    pub(crate) fn sentences(&self) -> Vec<u8> {
        if self.only.is_empty() {
            sentences(["CTL", "ACK", "MIS", "ALL"])
        } else {
            sentences(self.only.iter().copied())
        }
    }

    /// The sentences for a vehicle that stays silent: each message by its own name, for a vehicle that does not know
    /// ALL.
    pub(crate) fn sentences_again(&self) -> Vec<u8> {
        if !self.only.is_empty() {
            return self.sentences();
        }
        let status = catalogue().iter().filter(|entry| entry.section.starts_with("6."));
        let each = status
            .map(|entry| &entry.name[2..])
            .filter(|name| !matches!(*name, "CTL" | "ACK" | "MIS"));
        sentences(["CTL", "ACK", "MIS", "ALL"].into_iter().chain(each))
    }
}

fn sentences<'a>(messages: impl IntoIterator<Item = &'a str>) -> Vec<u8> {
    let mut out = Vec::new();
    for message in messages {
        let sentence = ToVehicle::from(LoggingControl {
            message: Text::cleaned(message),
            on: true,
        });
        sentence
            .encode(&mut out)
            .expect("the names of the catalogue are letters and digits");
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(bytes: &[u8]) -> Vec<String> {
        let text = std::str::from_utf8(bytes).unwrap();
        let lines = text.split_terminator("\r\n");
        lines
            .map(|line| {
                let name = line.strip_prefix("$BPLOG,").unwrap();
                name.split_once(",ON*").unwrap().0.to_owned()
            })
            .collect()
    }

    #[test]
    fn control_is_subscribed_to_first_and_acknowledgements_by_name() {
        let all = Subscription::everything();
        assert_eq!(names(&all.sentences()), ["CTL", "ACK", "MIS", "ALL"]);
        let again = names(&all.sentences_again());
        assert_eq!((again.len(), again[0].as_str()), (4 + 24 - 3, "CTL"));
        assert!(again.contains(&"NVG".to_owned()));
    }

    #[test]
    fn some_messages_are_subscribed_to_by_any_form_of_their_names() {
        let some = Subscription::only(["nvg", " BFCTL", "CTD"]).unwrap();
        assert_eq!(names(&some.sentences()), ["NVG", "CTL", "CTD"]);
        assert_eq!(some.sentences(), some.sentences_again());
        assert!(
            Subscription::only(["NVG", ""])
                .unwrap_err()
                .to_string()
                .contains("unknown message")
        );
        assert!(
            Subscription::only(["RMB"])
                .unwrap_err()
                .to_string()
                .starts_with("RMB goes to the vehicle")
        );
    }
}
