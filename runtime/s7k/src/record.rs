//! Records by their type.

mod bluefin;
mod controller;
mod edgetech;
mod imagery;
mod samples;
mod storage;

pub use bluefin::{
    BluefinData, BluefinDataType, BluefinFault, BluefinFormat, BluefinFrame, BluefinFrameHeader, BluefinHeader,
    BluefinRecord, EnvironmentField, EnvironmentFrame, EnvironmentQuality, NavigationField, NavigationFrame,
    NavigationQuality,
};
pub use controller::{
    Acknowledge, Action, AlarmMode, CommandHeader, CommandRecord, CommandStatus, MessageHeader, MessageRecord,
    MessageType,
};
pub use edgetech::{CoordinateUnits, Correlated, EdgeTechFormat, SegyHeader, SideScanHeader, TriggerSource};
pub use imagery::{
    Channel, ChannelHeader, ChannelSide, HeaderLayout, Imagery, ImageryHeader, Polarity, RangeKind, SampleFormat,
};
pub use samples::Samples;
pub use storage::{
    CatalogEntry, CatalogHeader, CatalogLocation, CatalogRecord, FileDevice, FileHeader, FileHeaderRecord, TimeMessage,
};

use crate::frame::{Frame, FrameError};
use crate::layout::{Layout, Truncated};

/// A record, typed, borrowed from the bytes that it was read from.
#[expect(
    clippy::large_enum_variant,
    reason = "it lives on the stack, for as long as its bytes are borrowed"
)]
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Record<'a> {
    /// 3000: EdgeTech FS-DW sidescan.
    SideScan(Imagery<'a>),
    /// 3001: EdgeTech FS-DW sub-bottom profiler.
    SubBottom(Imagery<'a>),
    /// 3100: framed data from a Bluefin vehicle.
    Bluefin(BluefinRecord<'a>),
    /// 7200: file header.
    FileHeader(FileHeaderRecord<'a>),
    /// 7300: file catalogue.
    Catalog(CatalogRecord<'a>),
    /// 7400: time message.
    Time(TimeMessage, &'a [u8]),
    /// 11000: command to the payload controller.
    Command(CommandRecord<'a>),
    /// 11001: its acknowledgement.
    Acknowledge(Acknowledge, &'a [u8]),
    /// 11002: alarm or status of the payload controller.
    Message(MessageRecord<'a>),
    /// A record of another type: its record type header and data.
    Other(&'a [u8]),
}

/// One type of record.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct RecordType {
    /// Its number.
    pub number: u32,
    /// Its title.
    pub title: &'static str,
    /// Where it is specified.
    pub source: &'static str,
    /// Its fixed parts, by their types.
    pub layouts: &'static [&'static str],
    /// The test that reads and rewrites it.
    pub test: &'static str,
}

/// The types of records that are decoded.
pub const RECORD_TYPES: &[RecordType] = &[
    RecordType {
        number: 3000,
        title: "EdgeTech FS-DW sidescan",
        source: "Volume III, 2.2",
        layouts: &["ImageryHeader", "ChannelHeader", "SideScanHeader"],
        test: "sidescan_is_read_in_both_layouts_of_its_header",
    },
    RecordType {
        number: 3001,
        title: "EdgeTech FS-DW sub-bottom profile",
        source: "Volume III, 2.3",
        layouts: &["ImageryHeader", "ChannelHeader", "SegyHeader"],
        test: "samples_have_the_type_that_the_header_says",
    },
    RecordType {
        number: 3100,
        title: "framed Bluefin data",
        source: "Volume III, 2.4",
        layouts: &[
            "BluefinHeader",
            "BluefinFrameHeader",
            "NavigationFrame",
            "EnvironmentFrame",
        ],
        test: "vehicle_data_are_written_and_read_frame_by_frame",
    },
    RecordType {
        number: 7200,
        title: "file header",
        source: "Volume I, 7200",
        layouts: &["FileHeader", "FileDevice", "CatalogLocation"],
        test: "every_type_cut_at_every_byte_is_an_error_or_a_shorter_record",
    },
    RecordType {
        number: 7300,
        title: "file catalogue",
        source: "Volume I, 7300",
        layouts: &["CatalogHeader", "CatalogEntry"],
        test: "every_type_cut_at_every_byte_is_an_error_or_a_shorter_record",
    },
    RecordType {
        number: 7400,
        title: "time message",
        source: "Volume I, 7400",
        layouts: &["TimeMessage"],
        test: "every_type_cut_at_every_byte_is_an_error_or_a_shorter_record",
    },
    RecordType {
        number: 11_000,
        title: "payload controller command",
        source: "Volume III, 2.5",
        layouts: &["CommandHeader"],
        test: "commands_acknowledgements_and_messages_are_read",
    },
    RecordType {
        number: 11_001,
        title: "payload controller command acknowledge",
        source: "Volume III, 2.6",
        layouts: &["Acknowledge"],
        test: "commands_acknowledgements_and_messages_are_read",
    },
    RecordType {
        number: 11_002,
        title: "payload controller alarm or status",
        source: "Volume III, 2.7",
        layouts: &["MessageHeader"],
        test: "commands_acknowledgements_and_messages_are_read",
    },
];

/// A record that is not what its type says.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("record {record_type} at byte {at} of its body: {fault}")]
pub struct RecordError {
    /// The record's type.
    pub record_type: u32,
    /// Where the part begins that is wrong, in bytes from the start of the record type header.
    pub at: usize,
    /// What is wrong.
    pub fault: RecordFault,
}

/// What is wrong with a record.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum RecordFault {
    /// The frame's parts cannot be told apart.
    #[error(transparent)]
    Frame(#[from] FrameError),
    /// A fixed part is not whole.
    #[error(transparent)]
    Truncated(#[from] Truncated),
    /// A channel's samples are not as many bytes as its header says.
    #[error(
        "channel {channel} field samples: {samples} samples of {bytes_per_sample} bytes do not fit, {found} bytes remain"
    )]
    Samples {
        /// The channel, from 0.
        channel: usize,
        /// Samples that the header says.
        samples: u32,
        /// Bytes of each that the header says.
        bytes_per_sample: u8,
        /// Bytes that there are.
        found: usize,
    },
    /// A list is shorter than its count says, or longer than allowed.
    #[error("{list}: {count} of {size} bytes each do not fit, there is room for {found} bytes")]
    List {
        /// The list.
        list: &'static str,
        /// Entries that the header says.
        count: u32,
        /// Bytes of each entry.
        size: u32,
        /// Bytes that there are, or that may be.
        found: usize,
    },
    /// Bytes follow the last channel.
    #[error("{bytes} bytes follow the last channel, in both layouts of the header")]
    Rest {
        /// How many.
        bytes: usize,
    },
}

impl<'a> Record<'a> {
    /// Reads the record in a frame. A type that is not known gives [`Self::Other`].
    ///
    /// # Errors
    /// [`RecordError`] names record, byte, part and field.
    pub fn read(frame: &Frame<'a>) -> Result<Self, RecordError> {
        let record_type = frame.header().record_type;
        let fail = |fault: RecordFault| RecordError {
            record_type,
            at: 0,
            fault,
        };
        let body = frame.body().map_err(|error| fail(error.into()))?;
        let optional = frame.optional().map_err(|error| fail(error.into()))?;
        Ok(match record_type {
            3000 => Self::SideScan(Imagery::read(record_type, body, optional)?),
            3001 => Self::SubBottom(Imagery::read(record_type, body, optional)?),
            3100 => Self::Bluefin(BluefinRecord::read(record_type, body)?),
            7200 => Self::FileHeader(FileHeaderRecord::read(record_type, body, optional)?),
            7300 => Self::Catalog(CatalogRecord::read(record_type, body)?),
            7400 => {
                let time = TimeMessage::read(body).map_err(|error| fail(error.into()))?;
                Self::Time(time, &body[TimeMessage::SIZE..])
            }
            11_000 => Self::Command(CommandRecord::read(record_type, body)?),
            11_001 => {
                let acknowledge = Acknowledge::read(body).map_err(|error| fail(error.into()))?;
                Self::Acknowledge(acknowledge, &body[Acknowledge::SIZE..])
            }
            11_002 => Self::Message(MessageRecord::read(record_type, body)?),
            _ => Self::Other(body),
        })
    }

    /// Appends the record type header and data, byte for byte as they were read.
    pub fn write(&self, out: &mut Vec<u8>) {
        match self {
            Self::SideScan(imagery) | Self::SubBottom(imagery) => imagery.write(out),
            Self::Bluefin(record) => record.write(out),
            Self::FileHeader(record) => record.write(out),
            Self::Catalog(record) => record.write(out),
            Self::Time(time, rest) => {
                time.write(out);
                out.extend_from_slice(rest);
            }
            Self::Command(record) => record.write(out),
            Self::Acknowledge(acknowledge, rest) => {
                acknowledge.write(out);
                out.extend_from_slice(rest);
            }
            Self::Message(record) => record.write(out),
            Self::Other(body) => out.extend_from_slice(body),
        }
    }
}

/// The enumerations of all records, in their order.
pub(crate) const CODES: [&[crate::CodeTable]; 4] = [imagery::CODES, edgetech::CODES, bluefin::CODES, controller::CODES];

/// The layouts of all records, in their order.
pub(crate) const LAYOUTS: [&[Layout]; 5] = [
    imagery::LAYOUTS,
    edgetech::LAYOUTS,
    bluefin::LAYOUTS,
    storage::LAYOUTS,
    controller::LAYOUTS,
];

#[cfg(test)]
mod tests;
