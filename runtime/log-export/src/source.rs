//! Reads a log from its file, record by record. The file can be of any size and of any contents: memory is bounded by
//! its largest chunk, and lengths that cannot be true end the reading.

use std::fs::File;
use std::io::{BufReader, ErrorKind, Read};
use std::path::{Path, PathBuf};

use mcap::records::{Record, op};
use mcap::sans_io::{LinearReadEvent, LinearReader, LinearReaderOptions};
use mcap::{MAGIC, McapError, parse_record};

use crate::error::Error;

/// A log's file.
#[derive(Debug)]
pub(crate) struct Source {
    path: PathBuf,
    /// Its length when it was opened. A log that is still being written is read as far as this in every pass.
    length: u64,
}

/// How a log ends.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(crate) enum End {
    /// In order.
    Complete,
    /// The process was killed, or is still writing.
    Cut,
    /// With bytes that are not a record.
    Damaged(String),
}

impl Source {
    /// # Errors
    ///
    /// [`Error::Read`], and [`Error::NoLog`] where the path is not that of an MCAP file.
    pub(crate) fn open(path: &Path) -> Result<Self, Error> {
        // Before it is opened, because opening a pipe waits for its other end.
        let metadata = std::fs::metadata(path).map_err(|source| Error::read(path, source))?;
        if metadata.is_dir() {
            return Err(Error::no_log(path, "is a folder"));
        }
        if !metadata.is_file() {
            return Err(Error::no_log(path, "is a pipe or a device, and a log is read twice"));
        }
        let mut file = File::open(path).map_err(|source| Error::read(path, source))?;
        let mut magic = [0; MAGIC.len()];
        match file.read_exact(&mut magic) {
            Ok(()) if magic == *MAGIC => Ok(Self {
                path: path.to_owned(),
                length: metadata.len(),
            }),
            Ok(()) => Err(Error::no_log(path, "is not an MCAP file")),
            Err(error) if error.kind() == ErrorKind::UnexpectedEof => Err(Error::no_log(path, "is not an MCAP file")),
            Err(error) => Err(Error::read(path, error)),
        }
    }

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Gives every record to `take`, in the order of the file. The records of a chunk follow only once the whole chunk
    /// has been read and its checksum is right.
    ///
    /// # Errors
    ///
    /// [`Error::Read`], [`Error::Compressed`], and those of `take`.
    pub(crate) fn read(&self, mut take: impl FnMut(Record<'_>) -> Result<(), Error>) -> Result<End, Error> {
        let failed = |source| Error::read(&self.path, source);
        let file = File::open(&self.path).map_err(failed)?;
        let mut file = BufReader::with_capacity(1 << 18, file.take(self.length));
        let limit = usize::try_from(self.length).unwrap_or(usize::MAX);
        let options = LinearReaderOptions::default()
            .with_skip_end_magic(true)
            .with_prevalidate_chunk_crcs(true)
            .with_record_length_limit(limit);
        let mut reader = LinearReader::new_with_options(options);
        while let Some(event) = reader.next_event() {
            let error = match event {
                Ok(LinearReadEvent::ReadRequest(wanted)) => {
                    let read = file.read(reader.insert(wanted)).map_err(failed)?;
                    reader.notify_read(read);
                    continue;
                }
                Ok(LinearReadEvent::Record { opcode, data }) => match record(opcode, data) {
                    Ok(Record::DataEnd(_)) => return Ok(End::Complete),
                    Ok(record) => {
                        take(record)?;
                        continue;
                    }
                    Err(error) => error,
                },
                Err(error) => error,
            };
            return self.end(error);
        }
        Ok(End::Cut)
    }

    /// What an error of the reader says of the log's end.
    fn end(&self, error: McapError) -> Result<End, Error> {
        // A length that goes beyond the end of the file is that of a record that was not written whole.
        if matches!(
            error,
            McapError::UnexpectedEof | McapError::RecordTooLarge { .. } | McapError::ChunkTooLarge(_)
        ) {
            Ok(End::Cut)
        } else if let McapError::UnsupportedCompression(compression) = error {
            Err(Error::Compressed {
                path: self.path.clone(),
                compression,
            })
        } else {
            Ok(End::Damaged(error.to_string()))
        }
    }
}

fn record(opcode: u8, data: &[u8]) -> Result<Record<'_>, McapError> {
    if opcode == op::ATTACHMENT {
        check_attachment(data).ok_or(McapError::UnexpectedEoc)?;
    }
    parse_record(opcode, data)
}

/// Checks that an attachment has room for its names and its checksum. [`parse_record`] subtracts these lengths
/// unchecked.
fn check_attachment(data: &[u8]) -> Option<()> {
    const TIMES: usize = 2 * size_of::<u64>();
    const LENGTH_AND_CRC: usize = size_of::<u64>() + size_of::<u32>();
    let rest = skip_text(skip_text(data.get(TIMES..)?)?)?;
    (rest.len() >= LENGTH_AND_CRC).then_some(())
}

/// The bytes after a text and its length.
fn skip_text(bytes: &[u8]) -> Option<&[u8]> {
    let (length, rest) = bytes.split_first_chunk()?;
    rest.get(usize::try_from(u32::from_le_bytes(*length)).ok()?..)
}
