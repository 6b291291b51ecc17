//! Records out of a file, and what is damaged between them.

use std::io::{self, Read};

use memchr::memmem;

use crate::frame::{Checksum, FRAME_LIMIT, Frame, FrameError, FrameHeader, SYNC, read_header};

/// What a file holds at a place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FileItem<'a> {
    /// A whole record, at this place in the file.
    Record {
        /// Bytes from the file's start.
        offset: u64,
        /// The record.
        frame: Frame<'a>,
    },
    /// Bytes that could not be read as a record.
    Skipped(Skipped),
}

/// Bytes of a file that could not be read as a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Skipped {
    /// Where they begin, in bytes from the file's start.
    pub offset: u64,
    /// How many they are.
    pub bytes: u64,
    /// What was wrong with the first of them.
    pub why: FrameError,
}

/// The bytes of [`SYNC`], and where a frame has them.
const PATTERN: [u8; 4] = SYNC.to_le_bytes();
const SYNC_AT: usize = 4;

/// What begins a slice of a file. `last` is true if the file ends with the slice.
enum Found {
    /// A record of so many bytes.
    Record(usize),
    /// So many bytes are none. Whether a record follows them is not known if the slice ends there.
    Skip(usize, FrameError),
    /// The slice must be at least so long.
    More(usize),
}

/// Looks at the start of a slice. What follows a record decides whether its size is believed: see [`is_believed`].
fn look(bytes: &[u8], last: bool, limit: usize) -> Found {
    match Frame::read(bytes, limit) {
        Ok(frame) => {
            let size = frame.bytes().len();
            let behind = &bytes[size..];
            if behind.len() < FrameHeader::SIZE && !last {
                return Found::More(size + FrameHeader::SIZE);
            }
            match inner_start(&frame, behind, limit) {
                Some(inner) => Found::Skip(
                    inner,
                    FrameError::Size {
                        size: frame.header().size,
                        limit,
                    },
                ),
                None => Found::Record(size),
            }
        }
        Err(FrameError::Incomplete { needed, .. }) if !last => Found::More(needed),
        Err(error) => Found::Skip(next_start(bytes, 1, limit), error),
    }
}

/// Where a record begins inside a frame whose size is damaged; `None` if the frame is to be believed.
///
/// A frame is believed if another follows it, if it ends the file, or if its checksum is right. Else a record that begins
/// inside it shows that its size is wrong.
fn inner_start(frame: &Frame<'_>, behind: &[u8], limit: usize) -> Option<usize> {
    let followed = behind.is_empty() || read_header(behind, limit).is_ok();
    if followed || matches!(frame.checksum(), Checksum::Valid | Checksum::Unclaimed { right: true }) {
        return None;
    }
    let bytes = frame.bytes();
    let inner = next_start(bytes, 1, limit);
    (inner < bytes.len()).then_some(inner)
}

/// Where the next frame's header may begin, from `from` on; the slice's end if there is none.
fn next_start(bytes: &[u8], from: usize, limit: usize) -> usize {
    let first = (from + SYNC_AT).min(bytes.len());
    let starts = memmem::find_iter(&bytes[first..], &PATTERN).map(|at| first + at - SYNC_AT);
    let mut plausible = starts.filter(|at| {
        matches!(
            read_header(&bytes[*at..], limit),
            Ok(_) | Err(FrameError::Incomplete { .. })
        )
    });
    plausible.next().unwrap_or(bytes.len())
}

/// The records of a file in memory, without a copy.
#[derive(Clone, Debug)]
pub struct Frames<'a> {
    bytes: &'a [u8],
    at: usize,
    limit: usize,
}

impl<'a> Frames<'a> {
    /// Of a whole file, with records of at most [`FRAME_LIMIT`] bytes.
    #[must_use]
    pub const fn new(bytes: &'a [u8]) -> Self {
        Self::with_limit(bytes, FRAME_LIMIT)
    }

    /// Of a whole file, with records of at most `limit` bytes.
    #[must_use]
    pub const fn with_limit(bytes: &'a [u8], limit: usize) -> Self {
        Self { bytes, at: 0, limit }
    }
}

impl<'a> Iterator for Frames<'a> {
    type Item = FileItem<'a>;

    fn next(&mut self) -> Option<FileItem<'a>> {
        let rest = self.bytes.get(self.at..).filter(|rest| !rest.is_empty())?;
        let offset = self.at as u64;
        match look(rest, true, self.limit) {
            Found::Record(size) => {
                self.at += size;
                let frame = Frame::read(&rest[..size], self.limit).ok()?;
                Some(FileItem::Record { offset, frame })
            }
            Found::Skip(bytes, why) => {
                self.at += bytes;
                Some(FileItem::Skipped(Skipped {
                    offset,
                    bytes: bytes as u64,
                    why,
                }))
            }
            Found::More(needed) => {
                self.at = self.bytes.len();
                let why = FrameError::Incomplete {
                    found: rest.len(),
                    needed,
                };
                Some(FileItem::Skipped(Skipped {
                    offset,
                    bytes: rest.len() as u64,
                    why,
                }))
            }
        }
    }
}

/// The records of a file as they are read. It holds one record at a time, and a block that is read ahead.
#[derive(Debug)]
pub struct FileReader<R> {
    source: R,
    buffer: Vec<u8>,
    at: usize,
    /// Where the buffer begins in the file.
    start: u64,
    last: bool,
    limit: usize,
}

/// How much is read at once, bytes.
const BLOCK: usize = 256 << 10;

impl<R: Read> FileReader<R> {
    /// Reads from the source's place on, with records of at most [`FRAME_LIMIT`] bytes.
    pub const fn new(source: R) -> Self {
        Self::with_limit(source, FRAME_LIMIT)
    }

    /// Reads from the source's place on, with records of at most `limit` bytes.
    pub const fn with_limit(source: R, limit: usize) -> Self {
        Self {
            source,
            buffer: Vec::new(),
            at: 0,
            start: 0,
            last: false,
            limit,
        }
    }

    /// The next record, or bytes that are none; `None` at the end.
    ///
    /// # Errors
    /// The source's own.
    #[expect(clippy::should_implement_trait, reason = "items borrow from the reader")]
    pub fn next(&mut self) -> io::Result<Option<FileItem<'_>>> {
        let mut skipped: Option<Skipped> = None;
        loop {
            let rest = &self.buffer[self.at..];
            if rest.is_empty() && self.last {
                return Ok(skipped.map(FileItem::Skipped));
            }
            let found = if rest.is_empty() {
                Found::More(1)
            } else {
                look(rest, self.last, self.limit)
            };
            let offset = self.start + self.at as u64;
            match found {
                Found::More(needed) => self.fill(needed)?,
                Found::Record(_) if skipped.is_some() => return Ok(skipped.map(FileItem::Skipped)),
                Found::Record(size) => {
                    let from = self.at;
                    self.at += size;
                    let frame = Frame::read(&self.buffer[from..from + size], self.limit);
                    return Ok(frame.ok().map(|frame| FileItem::Record { offset, frame }));
                }
                Found::Skip(bytes, why) => {
                    // The bytes at the slice's end may begin a frame whose pattern is not there yet.
                    let keep = if bytes == rest.len() && !self.last {
                        (PATTERN.len() + SYNC_AT - 1).min(bytes - 1)
                    } else {
                        0
                    };
                    let bytes = bytes - keep;
                    self.at += bytes;
                    let sum = skipped.map_or(0, |skipped| skipped.bytes);
                    let first = skipped.map_or((offset, why), |skipped| (skipped.offset, skipped.why));
                    skipped = Some(Skipped {
                        offset: first.0,
                        bytes: sum + bytes as u64,
                        why: first.1,
                    });
                    if keep > 0 {
                        self.fill(keep + 1)?;
                    }
                }
            }
        }
    }

    /// Reads until so many bytes are there, or the file ends.
    fn fill(&mut self, needed: usize) -> io::Result<()> {
        self.buffer.drain(..self.at);
        self.start += self.at as u64;
        self.at = 0;
        while self.buffer.len() < needed && !self.last {
            let room = needed.max(self.buffer.len() + BLOCK);
            let read = self
                .source
                .by_ref()
                .take((room - self.buffer.len()) as u64)
                .read_to_end(&mut self.buffer)?;
            self.last = read == 0;
        }
        Ok(())
    }
}
