//! Splits a file's bytes, which cannot be trusted, into records (safety requirement 013).
//!
//! This module checks the nested lengths first, and only then lets [`mcap`] read a record: the readers of [`mcap`]
//! subtract these lengths unchecked.

use mcap::read::ChunkReader;
use mcap::records::{Record, op};
use mcap::{McapError, McapResult, parse_record};

/// The records of a file in order, up to where the file was cut. A chunk is replaced by its records.
pub(crate) struct Records<'a> {
    rest: &'a [u8],
    chunk: Option<ChunkReader<'a>>,
}

impl<'a> Records<'a> {
    /// The records in these bytes, which begin with one.
    pub(crate) const fn of(bytes: &'a [u8]) -> Self {
        Self {
            rest: bytes,
            chunk: None,
        }
    }

    fn record(&mut self, opcode: u8, body: &'a [u8]) -> McapResult<Option<Record<'a>>> {
        if opcode == op::ATTACHMENT {
            check_attachment(body)?;
        }
        let record = parse_record(opcode, body)?;
        let Record::Chunk { header, .. } = record else {
            return Ok(Some(record));
        };
        let data = chunk_data(body, header.compressed_size)?;
        if header.compression.is_empty() {
            check_chunk(data)?;
        }
        self.chunk = Some(ChunkReader::new(header, data)?);
        Ok(None)
    }
}

impl<'a> Iterator for Records<'a> {
    type Item = McapResult<Record<'a>>;

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            if let Some(record) = self.chunk.as_mut().and_then(Iterator::next) {
                return Some(record);
            }
            self.chunk = None;
            let (opcode, body, rest) = split_record(self.rest)?;
            self.rest = rest;
            if let Some(record) = self.record(opcode, body).transpose() {
                return Some(record);
            }
        }
    }
}

/// The first record's opcode and content, and the bytes after it; `None` if the record is cut.
fn split_record(bytes: &[u8]) -> Option<(u8, &[u8], &[u8])> {
    let (&opcode, rest) = bytes.split_first()?;
    let (length, rest) = rest.split_first_chunk()?;
    let length = usize::try_from(u64::from_le_bytes(*length)).ok()?;
    let (body, rest) = rest.split_at_checked(length)?;
    Some((opcode, body, rest))
}

/// A chunk's records, which fill the end of its content except for padding.
fn chunk_data(body: &[u8], size: u64) -> McapResult<&[u8]> {
    const BEFORE_COMPRESSION: usize = 28;
    let bad = || McapError::BadChunkLength {
        header: size,
        available: body.len() as u64,
    };
    let (_, rest) = body.split_at_checked(BEFORE_COMPRESSION).ok_or_else(bad)?;
    let rest = skip_text(rest).ok_or_else(bad)?;
    let (_, data) = rest.split_at_checked(size_of::<u64>()).ok_or_else(bad)?;
    data.get(..usize::try_from(size).map_err(|_| bad())?).ok_or_else(bad)
}

/// Checks that every record of an uncompressed chunk ends within the chunk.
fn check_chunk(data: &[u8]) -> McapResult<()> {
    let mut rest = data;
    while !rest.is_empty() {
        rest = split_record(rest).ok_or(McapError::UnexpectedEoc)?.2;
    }
    Ok(())
}

/// Checks that an attachment has room for its names and its checksum.
fn check_attachment(body: &[u8]) -> McapResult<()> {
    const TIMES: usize = 2 * size_of::<u64>();
    const LENGTH_AND_CRC: usize = size_of::<u64>() + size_of::<u32>();
    body.get(TIMES..)
        .and_then(skip_text)
        .and_then(skip_text)
        .filter(|rest| rest.len() >= LENGTH_AND_CRC)
        .map(|_| ())
        .ok_or(McapError::UnexpectedEof)
}

/// The bytes after a text and its length.
fn skip_text(bytes: &[u8]) -> Option<&[u8]> {
    let (length, rest) = bytes.split_first_chunk()?;
    rest.get(usize::try_from(u32::from_le_bytes(*length)).ok()?..)
}
