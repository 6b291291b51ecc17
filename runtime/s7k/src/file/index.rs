//! Where a file has which records.

use std::io::{self, BufReader, Read, Seek, SeekFrom};

use super::reader::{FileItem, FileReader, Skipped};
use crate::frame::{FRAME_LIMIT, Frame, FrameError, FrameHeader, read_header};
use crate::record::{CatalogEntry, CatalogLocation, Record};
use crate::{DeviceId, Time7k};

/// A record of a file.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct IndexEntry {
    /// Its place, in bytes from the file's start.
    pub offset: u64,
    /// Its length, bytes.
    pub size: u32,
    /// Its type.
    pub record_type: u32,
    /// The device that it is from. Out of a catalogue, only its lower 16 bits.
    pub device: DeviceId,
    /// Tells apart several devices of one kind.
    pub enumerator: u16,
    /// Its time.
    pub time: Time7k,
    /// Its count.
    pub record_count: u32,
}

/// The records of a file, in its order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Index {
    /// The records.
    pub entries: Vec<IndexEntry>,
    /// Bytes that are no record.
    pub skipped: Vec<Skipped>,
    /// The file's length, bytes.
    pub bytes: u64,
}

/// Why a catalogue cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum IndexError {
    /// The file cannot be read.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// The file names no catalogue: it was not closed, or its writer makes none.
    #[error("the file names no catalogue")]
    NoCatalog,
    /// The catalogue is not where the file header says, or is damaged.
    #[error("no catalogue at byte {offset}, where the file header says that it is")]
    NotThere {
        /// The place that the file header names.
        offset: u64,
    },
    /// An entry of the catalogue points outside the file.
    #[error("entry {entry} of the catalogue points to bytes {offset} to {end} of a file of {bytes}")]
    Outside {
        /// The entry, from 0.
        entry: usize,
        /// Where its record would begin.
        offset: u64,
        /// Where its record would end.
        end: u64,
        /// The file's length.
        bytes: u64,
    },
}

impl IndexEntry {
    fn of(header: &FrameHeader, offset: u64) -> Self {
        Self {
            offset,
            size: header.size,
            record_type: header.record_type,
            device: header.device,
            enumerator: header.enumerator,
            time: header.time,
            record_count: header.record_count,
        }
    }
}

impl From<&CatalogEntry> for IndexEntry {
    fn from(entry: &CatalogEntry) -> Self {
        Self {
            offset: entry.offset,
            size: entry.size,
            record_type: u32::from(entry.record_type),
            device: DeviceId(u32::from(entry.device)),
            enumerator: entry.enumerator,
            time: entry.time,
            record_count: entry.record_count,
        }
    }
}

impl Index {
    /// Goes over the file from header to header. Only damaged places are read byte by byte.
    ///
    /// # Errors
    /// The source's own.
    pub fn scan<R: Read + Seek>(source: R) -> io::Result<Self> {
        Self::scan_with_limit(source, FRAME_LIMIT)
    }

    /// As [`Self::scan`], with records of at most `limit` bytes.
    ///
    /// # Errors
    /// The source's own.
    pub fn scan_with_limit<R: Read + Seek>(mut source: R, limit: usize) -> io::Result<Self> {
        let bytes = source.seek(SeekFrom::End(0))?;
        source.seek(SeekFrom::Start(0))?;
        let mut index = Self {
            bytes,
            ..Self::default()
        };
        let mut source = BufReader::with_capacity(4096, source);
        let mut offset = 0;
        while offset < bytes {
            match next_header(&mut source, bytes - offset, limit)? {
                Some(header) => {
                    index.entries.push(IndexEntry::of(&header, offset));
                    offset += u64::from(header.size);
                    source.seek_relative(i64::from(header.size) - FrameHeader::SIZE as i64)?;
                }
                None => {
                    source.seek(SeekFrom::Start(offset))?;
                    offset = index.go_over_damage(&mut source, offset, limit)?;
                    source.seek(SeekFrom::Start(offset))?;
                }
            }
        }
        Ok(index)
    }

    /// Reads on byte by byte, until a record follows a damaged place. Returns where to go on.
    fn go_over_damage<R: Read>(&mut self, source: R, start: u64, limit: usize) -> io::Result<u64> {
        let mut reader = FileReader::with_limit(source, limit);
        let mut damaged = false;
        while let Some(item) = reader.next()? {
            match item {
                FileItem::Record { offset, .. } if damaged => return Ok(start + offset),
                FileItem::Record { offset, frame } => {
                    self.entries.push(IndexEntry::of(frame.header(), start + offset));
                }
                FileItem::Skipped(skipped) => {
                    damaged = true;
                    self.skipped.push(Skipped {
                        offset: start + skipped.offset,
                        ..skipped
                    });
                }
            }
        }
        Ok(self.bytes)
    }

    /// Reads the catalogue that the file header names.
    ///
    /// # Errors
    /// [`IndexError`] if there is none, or if it does not fit the file.
    pub fn from_catalog<R: Read + Seek>(mut source: R) -> Result<Self, IndexError> {
        let bytes = source.seek(SeekFrom::End(0))?;
        let record = read_record(&mut source, 0, bytes, FRAME_LIMIT)?.ok_or(IndexError::NoCatalog)?;
        let location = Frame::read(&record, FRAME_LIMIT)
            .ok()
            .and_then(|frame| match Record::read(&frame) {
                Ok(Record::FileHeader(header)) => header.catalog(),
                _ => None,
            });
        let CatalogLocation { offset, size } = location.ok_or(IndexError::NoCatalog)?;
        // The catalogue of many records is longer than any other record; the file header says how long.
        let limit = FRAME_LIMIT.max(usize::try_from(size).unwrap_or(FRAME_LIMIT));
        let record = read_record(&mut source, offset, bytes, limit)?.ok_or(IndexError::NotThere { offset })?;
        let frame = Frame::read(&record, limit).map_err(|_| IndexError::NotThere { offset })?;
        let Ok(Record::Catalog(catalog)) = Record::read(&frame) else {
            return Err(IndexError::NotThere { offset });
        };
        let mut index = Self {
            bytes,
            ..Self::default()
        };
        for (entry, record) in catalog.entries().enumerate() {
            let end = record.offset.saturating_add(u64::from(record.size));
            if end > bytes {
                return Err(IndexError::Outside {
                    entry,
                    offset: record.offset,
                    end,
                    bytes,
                });
            }
            index.entries.push(IndexEntry::from(&record));
        }
        index.entries.push(IndexEntry::of(frame.header(), offset));
        Ok(index)
    }
}

/// The header at the source's place, if the whole record is in the file.
fn next_header<R: Read>(source: &mut R, left: u64, limit: usize) -> io::Result<Option<FrameHeader>> {
    let mut header = [0; FrameHeader::SIZE];
    if left < header.len() as u64 {
        return Ok(None);
    }
    source.read_exact(&mut header)?;
    let header = read_header(&header, limit).ok();
    Ok(header.filter(|header| u64::from(header.size) <= left))
}

/// The whole record at a place; `None` if there is none.
fn read_record<R: Read + Seek>(source: &mut R, offset: u64, bytes: u64, limit: usize) -> io::Result<Option<Vec<u8>>> {
    if offset >= bytes {
        return Ok(None);
    }
    source.seek(SeekFrom::Start(offset))?;
    let Some(header) = next_header(source, bytes - offset, limit)? else {
        return Ok(None);
    };
    source.seek(SeekFrom::Start(offset))?;
    let mut record = vec![0; header.size as usize];
    source.read_exact(&mut record)?;
    Ok(Some(record))
}

impl core::fmt::Display for Skipped {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let Self { offset, bytes, why } = self;
        if matches!(why, FrameError::Incomplete { .. }) {
            write!(
                f,
                "byte {offset}: the last {bytes} bytes are not a whole record ({why})"
            )
        } else {
            write!(f, "byte {offset}: {bytes} bytes are not a record ({why})")
        }
    }
}
