//! Records of the payload controller: commands (11000), acknowledgements (11001), alarms and status (11002).

use super::{RecordError, RecordFault};
use crate::device::SensorIndex;
use crate::frame::Frame;
use crate::layout::{Range, layouts};
use crate::plc::CommandId;
use crate::wire::{Wire, before_nul, codes};

codes! {
    /// Whether a command sets or retrieves.
    pub enum Action: u32 {
        /// Not stated.
        0 Unspecified,
        /// Set.
        1 Set,
        /// Retrieve: usually solicits a response.
        2 Get,
    }

    /// What became of a command.
    pub enum CommandStatus: u32 {
        /// It was rejected.
        0 Rejected,
        /// It was accepted.
        1 Accepted,
        /// It is not known.
        2 Unknown,
    }

    /// What a message is.
    pub enum MessageType: i32 {
        /// Status.
        0 Status,
        /// Alarm.
        1 Alarm,
    }

    /// Whether an alarm begins or ends.
    pub enum AlarmMode: i32 {
        /// Not stated.
        -1 Unspecified,
        /// The alarm is over.
        0 Clear,
        /// The alarm is active.
        1 Active,
    }
}

layouts! {
    /// The record type header of a command.
    "Volume III, Table 8" CommandHeader command_header {
        /// Whom the command is for.
        sensor: SensorIndex, "index", Range::new(-1.0, 2_147_483_647.0);
        /// The command.
        command: CommandId, "code", Range::new(0.0, 28.0);
        /// Whether it sets or retrieves.
        action: Action, "code", Range::new(0.0, 2.0);
        /// Length of the text that follows.
        bytes: u32, "bytes", Range::ANY;
    }

    /// An acknowledgement. It carries no ticket: it answers the oldest command of this kind to this sensor.
    "Volume III, Table 9" Acknowledge acknowledge {
        /// The command that is answered.
        command: CommandId, "code", Range::new(0.0, 28.0);
        /// Whom the command was for.
        sensor: SensorIndex, "index", Range::new(-1.0, 2_147_483_647.0);
        /// What became of it.
        status: CommandStatus, "code", Range::new(0.0, 2.0);
    }

    /// The record type header of a status or an alarm.
    "Volume III, Table 10" MessageHeader message_header {
        /// Status or alarm.
        message: MessageType, "code", Range::new(0.0, 1.0);
        /// Whether an alarm begins or ends.
        mode: AlarmMode, "code", Range::new(-1.0, 1.0);
        /// Which status or alarm: Tables 17 and 18.
        id: i32, "identifier", Range::new(0.0, 11_000.0);
        /// Length of the text that follows.
        bytes: u32, "bytes", Range::ANY;
    }
}

/// A command, borrowed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CommandRecord<'a> {
    /// The record type header.
    pub header: CommandHeader,
    text: &'a [u8],
    rest: &'a [u8],
}

/// A status or an alarm, borrowed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MessageRecord<'a> {
    /// The record type header.
    pub header: MessageHeader,
    text: &'a [u8],
    rest: &'a [u8],
}

impl<'a> CommandRecord<'a> {
    pub(super) fn read(record_type: u32, body: &'a [u8]) -> Result<Self, RecordError> {
        let header = CommandHeader::read(body).map_err(|error| RecordError {
            record_type,
            at: 0,
            fault: error.into(),
        })?;
        let (text, rest) = text(record_type, header.bytes, &body[CommandHeader::SIZE..])?;
        Ok(Self { header, text, rest })
    }

    /// The command's text as it lies in the record, with a closing NUL if there is one.
    #[must_use]
    pub const fn text_bytes(&self) -> &'a [u8] {
        self.text
    }

    /// The command's text. Bytes that are not UTF-8 become replacement characters.
    #[must_use]
    pub fn text(&self) -> std::borrow::Cow<'a, str> {
        String::from_utf8_lossy(before_nul(self.text))
    }

    /// What follows the text. A sender may fill up with NUL; anything else says that the header's length is wrong.
    #[must_use]
    pub const fn rest(&self) -> &'a [u8] {
        self.rest
    }

    /// The command and its target in the frame of a command's record, whatever else is wrong with the record. `None` if
    /// the header ends before them.
    #[must_use]
    pub fn addressed(frame: &Frame<'_>) -> Option<(CommandId, SensorIndex)> {
        let start = frame.payload().get(..SensorIndex::SIZE + CommandId::SIZE)?;
        let (sensor, command) = start.split_at(SensorIndex::SIZE);
        Some((CommandId::get(command), SensorIndex::get(sensor)))
    }

    /// Appends the record as it was read.
    pub(super) fn write(&self, out: &mut Vec<u8>) {
        self.header.write(out);
        out.extend_from_slice(self.text);
        out.extend_from_slice(self.rest);
    }
}

impl<'a> MessageRecord<'a> {
    pub(super) fn read(record_type: u32, body: &'a [u8]) -> Result<Self, RecordError> {
        let header = MessageHeader::read(body).map_err(|error| RecordError {
            record_type,
            at: 0,
            fault: error.into(),
        })?;
        let (text, rest) = text(record_type, header.bytes, &body[MessageHeader::SIZE..])?;
        Ok(Self { header, text, rest })
    }

    /// The message's text as it lies in the record, with a closing NUL if there is one.
    #[must_use]
    pub const fn text_bytes(&self) -> &'a [u8] {
        self.text
    }

    /// The message's text. Bytes that are not UTF-8 become replacement characters.
    #[must_use]
    pub fn text(&self) -> std::borrow::Cow<'a, str> {
        String::from_utf8_lossy(before_nul(self.text))
    }

    /// Appends the record as it was read.
    pub(super) fn write(&self, out: &mut Vec<u8>) {
        self.header.write(out);
        out.extend_from_slice(self.text);
        out.extend_from_slice(self.rest);
    }
}

/// The text of so many bytes, and what follows it.
fn text(record_type: u32, bytes: u32, behind: &[u8]) -> Result<(&[u8], &[u8]), RecordError> {
    let fault = RecordFault::List {
        list: "text",
        count: bytes,
        size: 1,
        found: behind.len(),
    };
    let split = usize::try_from(bytes)
        .ok()
        .and_then(|length| behind.split_at_checked(length));
    split.ok_or(RecordError {
        record_type,
        at: CommandHeader::SIZE - 4,
        fault,
    })
}
