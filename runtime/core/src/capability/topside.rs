//! Messages to and from the topside (SPI 5.5, 7.3).

use backseat_spi::{Direction, Text, ToVehicle, TopsideMessage, TopsideText, Transport as Way, catalogue};
use backseat_units::Timestamp;

use crate::context::Context;
use crate::ended::{EndCause, Failure};
use crate::io::Note;
use crate::plugin::{Event, Refusal, RequestState, Topic, TopsideRequest, Transport};
use crate::quota::LastMinute;
use crate::refusal::{Figure, Reason};
use crate::session::commands::{Answer, Purpose};
use crate::session::dispatch::Dispatch;

/// The longest text, bytes. The specification sets no limit; an acoustic modem takes minutes to send this much.
const TEXT_BYTES_MAX: usize = 200;

/// What has been sent to the topside.
#[derive(Debug, Default)]
#[cfg_attr(feature = "explore", derive(Clone, serde::Serialize))]
pub(crate) struct Topside {
    sent: LastMinute,
}

impl Topside {
    /// Counts a message that was sent.
    pub(crate) fn count(&mut self, now: Timestamp) {
        self.sent.add(now);
    }
}

impl Topside {
    /// Checks a request and returns what to send.
    pub(crate) fn check(
        &mut self,
        cx: &mut Context,
        request: u64,
        asked: &TopsideRequest,
    ) -> Result<Dispatch, Refusal> {
        let text = admit_text(&asked.text)?;
        let most = cx.monitor.limits().topside_per_min;
        if !self.sent.has_room(cx.now, most) {
            return Err(Figure::TopsideMessages.one_over(most));
        }
        let message = ToVehicle::TopsideText(TopsideText {
            created: cx.stamper.stamp(cx.now, "TOP"),
            slowest: way(asked.slowest),
            text,
        });
        Ok(Dispatch::new("TOP", message, Purpose::Topside(request)))
    }

    /// Success means that the message waits for a link, not that anybody has read it (7.3). The vehicle reports nothing
    /// more about it.
    pub(crate) fn answered(&mut self, cx: &mut Context, request: u64, answer: Answer<'_>) {
        match answer {
            Answer::Pending => cx.transition(request, RequestState::Pending),
            Answer::Done => {
                cx.transition(request, RequestState::Accepted);
                cx.transition(request, RequestState::Ended(EndCause::Queued.into()));
            }
            Answer::Refused(text) => cx.transition(request, RequestState::Failed(Failure::Vehicle(text.to_owned()))),
            Answer::Missing => cx.transition(request, RequestState::TimedOut),
        }
    }

    /// BFTOP.
    pub(crate) fn heard(&self, cx: &mut Context, message: &TopsideMessage) {
        cx.heard(message.created);
        let text = message.text.as_str();
        cx.note(Note::Text {
            text: format!("message from the topside: {text}"),
        });
    }

    /// Passes the topside's message to the plugins.
    pub(crate) fn tell(&self, cx: &mut Context, message: &TopsideMessage) {
        let text = message.text.as_str();
        let event = Event::TopsideMessage {
            transport: transport(message.transport),
            text: text.to_owned(),
        };
        cx.plugins.tell_wanting(Topic::Topside, &event);
    }
}

/// Returns a plugin's text unchanged, or why it is refused. A text is never corrected: the topside reads what the
/// plugin wrote.
///
/// A text is refused if it contains the three letters of a command in upper case, wherever they are: some vehicles take
/// a sentence for the command whose name its text contains. Lower case is harmless, because names are case-sensitive
/// (4.2). Hexadecimal digits, in which vehicles send binary data (7.3), are harmless too: no name consists of them.
fn admit_text(text: &str) -> Result<Text, Refusal> {
    if text.trim().is_empty() {
        return Err(Reason::TextEmpty.into());
    }
    if text.len() > TEXT_BYTES_MAX {
        return Err(Figure::TextBytes.over(text.len() as f64, TEXT_BYTES_MAX as f64));
    }
    let text = Text::new(text).map_err(|error| Refusal::Unwritable(error.to_string()))?;
    let commands = catalogue()
        .iter()
        .filter(|entry| entry.direction == Direction::ToVehicle)
        .filter_map(|entry| entry.name.strip_prefix("BP"));
    for letters in commands {
        if let Some(at) = text.as_str().find(letters) {
            return Err(Refusal::CommandInText {
                letters: letters.to_owned(),
                at,
            });
        }
    }
    Ok(text)
}

const fn way(transport: Transport) -> Way {
    match transport {
        Transport::Ethernet => Way::Ethernet,
        Transport::Wifi => Way::Wifi,
        Transport::RadioModem => Way::RfModem,
        Transport::AcousticModem => Way::AcousticModem,
    }
}

const fn transport(way: Way) -> Option<Transport> {
    match way {
        Way::Ethernet => Some(Transport::Ethernet),
        Way::Wifi => Some(Transport::Wifi),
        Way::RfModem => Some(Transport::RadioModem),
        Way::AcousticModem => Some(Transport::AcousticModem),
        Way::Other(_) => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_of_commands_are_refused_in_upper_case_and_hexadecimal_digits_are_not() {
        for bad in ["at RMB", "STOP", "BPKIL", "all CONtacts lost", "xRTKx"] {
            let refusal = admit_text(bad).unwrap_err();
            assert!(matches!(refusal, Refusal::CommandInText { .. }), "{refusal:?}");
        }
        for good in [
            "at rmb",
            "stop",
            "0123456789ABCDEF",
            "FEEDBEEF",
            "Line 3 done: 2 contacts",
        ] {
            assert_eq!(admit_text(good).unwrap().as_str(), good);
        }
    }
}
