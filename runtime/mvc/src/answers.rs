use backseat_spi::{AckStatus, Acknowledgement, BehaviorId, CommandName, EchoedTime, Text};
use backseat_units::{TimeOfDay, Timestamp};

use crate::event::{ClientId, MvcEventKind};
use crate::faults::Verdict;
use crate::mvc::Mvc;
use crate::server::Topic;

/// The longest text of an answer, characters: what a client sends is quoted, not sent back whole.
const TEXT_MAX: usize = 160;

/// Commands whose own section speaks of their acknowledgement (SPI 7.1, 7.3, 7.5, 7.6, 7.8, 7.19, 7.22 to 7.24).
const OF_THEIR_SECTIONS: [&str; 9] = ["LOG", "TOP", "RTK", "RTC", "RCN", "RMP", "SIL", "TRM", "BOY"];

/// What an acknowledgement is about.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Regarding {
    pub(crate) client: ClientId,
    pub(crate) command: CommandName,
    pub(crate) created: TimeOfDay,
    pub(crate) behavior: Option<BehaviorId>,
    /// The connection that asked is gone: nobody is told, not even a new connection with the same number.
    pub(crate) muted: bool,
}

impl Mvc {
    /// No command at all.
    pub(crate) fn no_command(&mut self, now: Timestamp, re: Regarding, name: &str) {
        let text = format!("{} is no command", name.chars().take(20).collect::<String>());
        self.invalid(
            now,
            Regarding {
                command: CommandName::NAK,
                created: TimeOfDay::MIDNIGHT,
                ..re
            },
            &text,
        );
    }

    pub(crate) fn invalid(&mut self, now: Timestamp, re: Regarding, text: &str) {
        self.note(
            now,
            MvcEventKind::CommandInvalid(re.client, re.command, Text::cleaned(clipped(text))),
        );
        self.acknowledge(now, re, AckStatus::Invalid, text);
    }

    /// BFACK (SPI 6.21), where the client has asked for acknowledgements.
    pub(crate) fn acknowledge(&mut self, now: Timestamp, re: Regarding, status: AckStatus, text: &str) {
        if re.muted || !self.server.has(re.client, Topic::Acknowledgement) {
            return;
        }
        let interpretation = self.interpretation;
        let spoken_of = OF_THEIR_SECTIONS.contains(&re.command.as_str()) || status == AckStatus::Invalid;
        if interpretation.acknowledges_sections && !spoken_of {
            return;
        }
        let decimals = interpretation.echo_decimals;
        let verdict = self.faults.verdict(re.command, status);
        let (status, delay) = match verdict {
            Verdict::Says(status) => (status, None),
            Verdict::Late(status, delay) => (status, Some(delay)),
            Verdict::Lost => return,
        };
        let message = Acknowledgement {
            created: self.stamp(now),
            command: re.command,
            command_created: EchoedTime::with_decimals(re.created, decimals),
            // 0 is none on the wire.
            behavior: re.behavior.filter(|id| id.get() != 0),
            status,
            text: Text::cleaned(clipped(text)),
        };
        match delay {
            None => self.send(now, re.client, message.into()),
            Some(delay) => self.faults.delay(now + delay, re.client, message),
        }
    }
}

fn clipped(text: &str) -> &str {
    let end = text.char_indices().nth(TEXT_MAX).map_or(text.len(), |(at, _)| at);
    text.get(..end).unwrap_or(text)
}
