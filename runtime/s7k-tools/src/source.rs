//! The recording that a command reads, several times if it must, and never as a whole.

use std::fs::File;
use std::io::{self, Read};
use std::os::unix::fs::FileExt;
use std::path::{Path, PathBuf};

use backseat_s7k::file::{FileItem, FileReader};
use backseat_s7k::record::{CatalogLocation, Record};
use backseat_s7k::{FRAME_LIMIT, Frame, FrameError};

use crate::error::{Error, InputFault};

/// A recording with at least one record.
#[derive(Debug)]
pub struct Source {
    path: PathBuf,
    file: File,
    bytes: u64,
    catalog: Option<CatalogLocation>,
}

impl Source {
    /// Opens a recording. What is appended to it later is not read.
    ///
    /// # Errors
    /// [`Error::Read`], and [`Error::Input`] if it is a folder, a pipe, empty, or has no record.
    pub fn open(path: &Path) -> Result<Self, Error> {
        let read = |source| Error::Read {
            path: path.to_owned(),
            source,
        };
        let input = |fault| Error::Input {
            path: path.to_owned(),
            fault,
        };
        // A pipe without a writer would block `open`: look at what it is first.
        let kind = std::fs::metadata(path).map_err(read)?;
        if kind.is_dir() {
            return Err(input(InputFault::Folder));
        }
        if !kind.is_file() {
            return Err(input(InputFault::NotAFile));
        }
        let file = File::open(path).map_err(read)?;
        let bytes = file.metadata().map_err(read)?.len();
        if bytes == 0 {
            return Err(input(InputFault::Empty));
        }
        let mut source = Self {
            path: path.to_owned(),
            file,
            bytes,
            catalog: None,
        };
        source.catalog = source.first_record()?;
        Ok(source)
    }

    /// Reads up to the first record, and the catalogue's place if that record names it.
    fn first_record(&self) -> Result<Option<CatalogLocation>, Error> {
        let mut records = self.records();
        let mut first_fault = None;
        while let Some(item) = records.next()? {
            match item {
                FileItem::Record { offset, frame } => {
                    let Ok(Record::FileHeader(header)) = Record::read(&frame) else {
                        return Ok(None);
                    };
                    return Ok(header.catalog().filter(|_| offset == 0));
                }
                FileItem::Skipped(skipped) => first_fault = first_fault.or(Some(skipped.why)),
            }
        }
        Err(Error::Input {
            path: self.path.clone(),
            fault: InputFault::NoRecord {
                bytes: self.bytes,
                why: first_fault.unwrap_or(FrameError::Sync { found: 0 }),
            },
        })
    }

    /// Where it is.
    #[must_use]
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Its length, bytes.
    #[must_use]
    pub const fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Where its file header says that the catalogue is.
    pub(crate) const fn catalog(&self) -> Option<CatalogLocation> {
        self.catalog
    }

    /// The longest record that is read, bytes. The catalogue of a long recording is longer than any other record.
    pub(crate) fn limit(&self) -> usize {
        let catalog = self.catalog.map_or(0, |location| {
            let behind = self.bytes.saturating_sub(location.offset);
            usize::try_from(u64::from(location.size).min(behind)).unwrap_or(0)
        });
        catalog.max(FRAME_LIMIT)
    }

    /// Its records from the start on.
    pub(crate) fn records(&self) -> Records<'_> {
        Records {
            reader: FileReader::with_limit(self.part(0), self.limit()),
            path: &self.path,
        }
    }

    /// Visits its records in one pass. Bytes that are no record are left out.
    pub(crate) fn each_record(&self, mut visit: impl FnMut(u64, &Frame<'_>) -> Result<(), Error>) -> Result<(), Error> {
        let mut records = self.records();
        while let Some(item) = records.next()? {
            if let FileItem::Record { offset, frame } = item {
                visit(offset, &frame)?;
            }
        }
        Ok(())
    }

    /// Its bytes from a place on.
    pub(crate) const fn part(&self, at: u64) -> Part<'_> {
        Part {
            file: &self.file,
            at,
            end: self.bytes,
        }
    }

    /// An error of reading it.
    pub(crate) fn read_error(&self, source: io::Error) -> Error {
        Error::Read {
            path: self.path.clone(),
            source,
        }
    }
}

/// The records of one pass over a recording.
#[derive(Debug)]
pub(crate) struct Records<'s> {
    reader: FileReader<Part<'s>>,
    path: &'s Path,
}

impl Records<'_> {
    /// The next record, or bytes that are none; `None` at the end.
    pub(crate) fn next(&mut self) -> Result<Option<FileItem<'_>>, Error> {
        self.reader.next().map_err(|source| Error::Read {
            path: self.path.to_owned(),
            source,
        })
    }
}

/// A part of a recording, read from a place of its own: several may be read at once.
#[derive(Debug)]
pub(crate) struct Part<'s> {
    file: &'s File,
    at: u64,
    end: u64,
}

impl Read for Part<'_> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let left = usize::try_from(self.end.saturating_sub(self.at)).unwrap_or(usize::MAX);
        let length = out.len().min(left);
        let read = self.file.read_at(&mut out[..length], self.at)?;
        self.at += read as u64;
        Ok(read)
    }
}
