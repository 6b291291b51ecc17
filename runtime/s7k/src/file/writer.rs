//! Writes one file: header, records, catalogue.

use std::io::{self, Seek, SeekFrom, Write};

use crate::frame::{FRAME_LIMIT, Frame, FrameHeader, FrameWriter, TooLong};
use crate::record::{CatalogEntry, CatalogHeader, CatalogLocation, FileDevice, FileHeader};
use crate::wire::{Chars, Reserved};
use crate::{DeviceId, Time7k};

/// What a file's records go to.
pub trait LogFile: Write + Seek {
    /// Cuts the file to this length.
    ///
    /// # Errors
    /// The file's own.
    fn truncate(&mut self, length: u64) -> io::Result<()>;
}

impl LogFile for std::fs::File {
    fn truncate(&mut self, length: u64) -> io::Result<()> {
        self.set_len(length)
    }
}

impl LogFile for io::Cursor<Vec<u8>> {
    fn truncate(&mut self, length: u64) -> io::Result<()> {
        self.get_mut().truncate(usize::try_from(length).unwrap_or(usize::MAX));
        Ok(())
    }
}

/// What a file's header says of it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct FileInfo {
    /// Identifies the file.
    pub file_id: [u64; 2],
    /// Identifies the session; files of one session have the same.
    pub session_id: [u64; 2],
    /// The program that records, at most 64 bytes.
    pub recorder: Chars<64>,
    /// Its version, at most 16 bytes.
    pub recorder_version: Chars<16>,
    /// A name that the user gave, at most 64 bytes.
    pub user_name: Chars<64>,
    /// Notes, at most 128 bytes.
    pub notes: Chars<128>,
    /// The devices whose records the file will hold.
    pub devices: Vec<(DeviceId, u16)>,
    /// The records are of protocol version 5: so are the frames of the file's header and catalogue. Otherwise both are
    /// of version 4.
    pub version_5: bool,
}

impl FileInfo {
    /// The header of a frame that the file has of its own.
    const fn own(&self, record_type: u32, time: Time7k) -> FrameHeader {
        let header = FrameHeader::new(record_type, DeviceId::LOGGER).at(time);
        if self.version_5 { header.version_5() } else { header }
    }

    /// The frame of the file header.
    fn frame(&self, time: Time7k, catalog: CatalogLocation) -> Result<Vec<u8>, TooLong> {
        let count = u32::try_from(self.devices.len()).unwrap_or(u32::MAX);
        let header = FileHeader {
            file_id_1: self.file_id[0],
            file_id_2: self.file_id[1],
            version: 1,
            reserved: Reserved::default(),
            session_id_1: self.session_id[0],
            session_id_2: self.session_id[1],
            data_size: count.saturating_mul(FileDevice::SIZE as u32),
            devices: count,
            recorder: self.recorder,
            recorder_version: self.recorder_version,
            user_name: self.user_name,
            notes: self.notes,
        };
        let mut out = Vec::new();
        let mut frame = FrameWriter::begin(self.own(7200, time), &mut out);
        header.write(frame.bytes());
        for (device, enumerator) in &self.devices {
            FileDevice {
                device: *device,
                enumerator: *enumerator,
            }
            .write(frame.bytes());
        }
        frame.begin_optional(CatalogLocation::OPTIONAL_ID);
        catalog.write(frame.bytes());
        frame.finish(FRAME_LIMIT)?;
        Ok(out)
    }
}

/// Writes one file.
///
/// Each record is handed to the file in one write and is not held back, so that a writer that is killed loses no record
/// that was written. A write that fails leaves the file as it was before.
#[derive(Debug)]
pub struct FileWriter<F> {
    file: F,
    info: FileInfo,
    started: Time7k,
    offset: u64,
    entries: Vec<CatalogEntry>,
}

impl<F: LogFile> FileWriter<F> {
    /// Begins a file with its header.
    ///
    /// # Errors
    /// The file's own; `InvalidInput` if the header is too long.
    pub fn create(mut file: F, info: FileInfo, time: Time7k) -> io::Result<Self> {
        let header = info
            .frame(time, CatalogLocation { size: 0, offset: 0 })
            .map_err(invalid)?;
        file.write_all(&header)?;
        let mut writer = Self {
            file,
            info,
            started: time,
            offset: 0,
            entries: Vec::new(),
        };
        if let Ok(frame) = Frame::read(&header, FRAME_LIMIT) {
            writer.note(&frame);
        }
        Ok(writer)
    }

    /// Writes a record as it is.
    ///
    /// # Errors
    /// The file's own. Then the file ends with the record before.
    pub fn write(&mut self, frame: &Frame<'_>) -> io::Result<()> {
        if let Err(error) = self.file.write_all(frame.bytes()) {
            // Where this fails too, the file ends with part of a record, which readers skip.
            let cut = self
                .file
                .truncate(self.offset)
                .and_then(|()| self.file.seek(SeekFrom::Start(self.offset)));
            drop(cut);
            return Err(error);
        }
        self.note(frame);
        Ok(())
    }

    fn note(&mut self, frame: &Frame<'_>) {
        let header = frame.header();
        self.entries.push(CatalogEntry {
            size: header.size,
            offset: self.offset,
            // The catalogue has 16 bits for what the frame has 32 for.
            record_type: (header.record_type & 0xFFFF) as u16,
            device: (header.device.0 & 0xFFFF) as u16,
            enumerator: header.enumerator,
            time: header.time,
            record_count: header.record_count,
            reserved: Reserved::default(),
        });
        self.offset += u64::from(header.size);
    }

    /// How long the file is, bytes.
    #[must_use]
    pub const fn length(&self) -> u64 {
        self.offset
    }

    /// How long the file will be with its catalogue, bytes, after one record more of so many bytes.
    #[must_use]
    pub const fn closed_length(&self, record: u64) -> u64 {
        let entries = (self.entries.len() as u64 + 1) * CatalogEntry::SIZE as u64;
        let catalog = (FrameHeader::FRAME_MIN + CatalogHeader::SIZE) as u64 + entries;
        self.offset + record + catalog
    }

    /// Writes the catalogue and its place, and gives the file back.
    ///
    /// # Errors
    /// The file's own. Then the file has no catalogue, or names none; its records are whole.
    pub fn finish(mut self, time: Time7k) -> io::Result<F> {
        let entries = u32::try_from(self.entries.len()).map_err(io::Error::other)?;
        let mut out = Vec::new();
        let mut frame = FrameWriter::begin(self.info.own(7300, time), &mut out);
        let size = CatalogHeader::SIZE as u32;
        CatalogHeader {
            size,
            version: 1,
            entries,
            reserved: Reserved::default(),
        }
        .write(frame.bytes());
        for entry in &self.entries {
            entry.write(frame.bytes());
        }
        // A catalogue is as long as its file has records, whatever the limit of a record is.
        let size = frame.finish(usize::MAX).map_err(invalid)?.size;
        if let Err(error) = self.file.write_all(&out) {
            let cut = self.file.truncate(self.offset);
            drop(cut);
            return Err(error);
        }
        let location = CatalogLocation {
            size,
            offset: self.offset,
        };
        let header = self.info.frame(self.started, location).map_err(invalid)?;
        self.file.seek(SeekFrom::Start(0))?;
        self.file.write_all(&header)?;
        self.file.seek(SeekFrom::End(0))?;
        self.file.flush()?;
        Ok(self.file)
    }
}

fn invalid(error: TooLong) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, error)
}
