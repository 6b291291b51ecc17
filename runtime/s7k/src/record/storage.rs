//! Records of files and of time: file header (7200), catalogue (7300), time message (7400).

use super::{RecordError, RecordFault};
use crate::device::DeviceId;
use crate::frame::Optional;
use crate::layout::{Range, layouts};
use crate::time::Time7k;
use crate::wire::{Chars, Reserved};

layouts! {
    /// The record type header of a file header, the first record of a file.
    "Volume I, 7200" FileHeader file_header {
        /// Identifies the file, first half.
        file_id_1: u64, "identifier", Range::ANY;
        /// Identifies the file, second half.
        file_id_2: u64, "identifier", Range::ANY;
        /// Version of this record.
        version: u16, "version", Range::ANY;
        /// Reserved.
        reserved: Reserved<2>, "reserved", Range::ANY;
        /// Identifies the session, first half. Files of one session have the same.
        session_id_1: u64, "identifier", Range::ANY;
        /// Identifies the session, second half.
        session_id_2: u64, "identifier", Range::ANY;
        /// Length of the list of devices.
        data_size: u32, "bytes", Range::ANY;
        /// Number of devices in the list.
        devices: u32, "count", Range::ANY;
        /// Name of the program that recorded.
        recorder: Chars<64>, "text", Range::ANY;
        /// Version of that program.
        recorder_version: Chars<16>, "text", Range::ANY;
        /// Name that the user gave.
        user_name: Chars<64>, "text", Range::ANY;
        /// Notes.
        notes: Chars<128>, "text", Range::ANY;
    }

    /// A device in the list of a file header.
    "Volume I, 7200" FileDevice file_device {
        /// The device.
        device: DeviceId, "device identifier", Range::ANY;
        /// Tells apart several devices of one kind.
        enumerator: u16, "system enumerator", Range::ANY;
    }

    /// Where a file has its catalogue: the optional data of a file header.
    "Volume I, 7200" CatalogLocation catalog_location {
        /// Length of the catalogue's record; 0 if there is none.
        size: u32, "bytes", Range::ANY;
        /// Place of the catalogue's record in the file; 0 if there is none.
        offset: u64, "bytes", Range::ANY;
    }

    /// The record type header of a catalogue, the last record of a file.
    "Volume I, 7300" CatalogHeader catalog_header {
        /// Length of this header.
        size: u32, "bytes", Range::ANY;
        /// Version of this record.
        version: u16, "version", Range::new(1.0, 1.0);
        /// Number of entries.
        entries: u32, "count", Range::ANY;
        /// Reserved.
        reserved: Reserved<4>, "reserved", Range::ANY;
    }

    /// A record of the file, in its catalogue. The catalogue itself has no entry.
    "Volume I, 7300" CatalogEntry catalog_entry {
        /// Length of the record's frame.
        size: u32, "bytes", Range::ANY;
        /// Place of the frame in the file.
        offset: u64, "bytes", Range::ANY;
        /// Record type.
        record_type: u16, "record type", Range::ANY;
        /// The device that the record is from, its lower 16 bits.
        device: u16, "device identifier", Range::ANY;
        /// Tells apart several devices of one kind.
        enumerator: u16, "system enumerator", Range::ANY;
        /// Time of the record, UTC.
        time: Time7k, "UTC", Range::ANY;
        /// Record count.
        record_count: u32, "count", Range::ANY;
        /// Reserved.
        reserved: Reserved<16>, "reserved", Range::ANY;
    }

    /// A time message. The time is that of its frame.
    "Volume I, 7400" TimeMessage time_message {
        /// Seconds between UTC and atomic time.
        leap_second_offset_s: i8, "s", Range::ANY;
        /// Whether a pulse marks the second.
        pulse_flag: u8, "flag", Range::new(0.0, 1.0);
        /// The port of the pulse.
        port: u16, "port", Range::ANY;
        /// Reserved.
        reserved_1: Reserved<4>, "reserved", Range::ANY;
        /// Reserved.
        reserved_2: Reserved<8>, "reserved", Range::ANY;
    }
}

impl CatalogLocation {
    /// The format of the optional data that hold it.
    pub const OPTIONAL_ID: u32 = 7300;
}

/// A file header with its devices, borrowed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FileHeaderRecord<'a> {
    /// The record type header.
    pub header: FileHeader,
    devices: &'a [u8],
    rest: &'a [u8],
    optional: Option<Optional<'a>>,
}

impl<'a> FileHeaderRecord<'a> {
    pub(super) fn read(record_type: u32, body: &'a [u8], optional: Option<Optional<'a>>) -> Result<Self, RecordError> {
        let fail = |at: usize, fault: RecordFault| RecordError { record_type, at, fault };
        let header = FileHeader::read(body).map_err(|error| fail(0, error.into()))?;
        let behind = &body[FileHeader::SIZE..];
        let (devices, rest) =
            list("devices", header.devices, FileDevice::SIZE, behind).map_err(|fault| fail(FileHeader::SIZE, fault))?;
        Ok(Self {
            header,
            devices,
            rest,
            optional,
        })
    }

    /// The devices whose records the file may hold.
    pub fn devices(&self) -> impl Iterator<Item = FileDevice> + use<'a> {
        self.devices
            .chunks(FileDevice::SIZE)
            .filter_map(|bytes| FileDevice::read(bytes).ok())
    }

    /// Where the catalogue is; `None` if the file was not closed, or has none.
    #[must_use]
    pub fn catalog(&self) -> Option<CatalogLocation> {
        let optional = self
            .optional
            .filter(|optional| optional.id == CatalogLocation::OPTIONAL_ID)?;
        CatalogLocation::read(optional.bytes)
            .ok()
            .filter(|location| location.offset > 0)
    }

    /// Appends the record as it was read, without its optional data.
    pub(super) fn write(&self, out: &mut Vec<u8>) {
        self.header.write(out);
        out.extend_from_slice(self.devices);
        out.extend_from_slice(self.rest);
    }
}

/// A catalogue, borrowed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CatalogRecord<'a> {
    /// The record type header.
    pub header: CatalogHeader,
    entries: &'a [u8],
    rest: &'a [u8],
}

impl<'a> CatalogRecord<'a> {
    pub(super) fn read(record_type: u32, body: &'a [u8]) -> Result<Self, RecordError> {
        let fail = |at: usize, fault: RecordFault| RecordError { record_type, at, fault };
        let header = CatalogHeader::read(body).map_err(|error| fail(0, error.into()))?;
        let behind = &body[CatalogHeader::SIZE..];
        let (entries, rest) = list("entries", header.entries, CatalogEntry::SIZE, behind)
            .map_err(|fault| fail(CatalogHeader::SIZE, fault))?;
        Ok(Self { header, entries, rest })
    }

    /// The records of the file, in its order.
    pub fn entries(&self) -> impl Iterator<Item = CatalogEntry> + use<'a> {
        self.entries
            .chunks(CatalogEntry::SIZE)
            .filter_map(|bytes| CatalogEntry::read(bytes).ok())
    }

    /// Appends the record as it was read.
    pub(super) fn write(&self, out: &mut Vec<u8>) {
        self.header.write(out);
        out.extend_from_slice(self.entries);
        out.extend_from_slice(self.rest);
    }
}

/// Splits a list of so many entries off.
fn list<'a>(list: &'static str, count: u32, size: usize, bytes: &'a [u8]) -> Result<(&'a [u8], &'a [u8]), RecordFault> {
    let length = usize::try_from(count).ok().and_then(|count| count.checked_mul(size));
    let size = u32::try_from(size).unwrap_or(u32::MAX);
    let fault = RecordFault::List {
        list,
        count,
        size,
        found: bytes.len(),
    };
    length.and_then(|length| bytes.split_at_checked(length)).ok_or(fault)
}
