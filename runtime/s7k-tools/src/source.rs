//! The recording that a command reads, several times if it must, and never as a whole.

use std::cell::Cell;
use std::fs::{File, Metadata};
use std::io::{self, Read};
use std::os::unix::fs::{FileExt, MetadataExt};
use std::path::{Path, PathBuf};

use backseat_s7k::file::{FileItem, FileReader};
use backseat_s7k::record::{CatalogLocation, Record};
use backseat_s7k::{FRAME_LIMIT, Frame, FrameError};

use crate::error::{Error, InputFault};
use crate::moment::Moment;

/// A recording with at least one record: a file, or several that are read one behind the other.
#[derive(Debug)]
pub struct Source {
    path: PathBuf,
    files: Vec<Piece>,
    bytes: u64,
    catalog: Option<CatalogLocation>,
    /// The longest catalogue that a file header names, bytes.
    catalog_bytes: u64,
    /// What the last whole pass left out.
    left_out: Cell<LeftOut>,
}

/// A file, and where its first byte is in the recording.
#[derive(Debug)]
struct Piece {
    file: File,
    at: u64,
    bytes: u64,
}

/// Bytes that are no record.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct LeftOut {
    pub(crate) places: u64,
    pub(crate) bytes: u64,
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
            files: vec![Piece { file, at: 0, bytes }],
            bytes,
            catalog: None,
            catalog_bytes: 0,
            left_out: Cell::default(),
        };
        source.catalog = source.first_record()?;
        source.catalog_bytes = source.catalog.map_or(0, |location| {
            u64::from(location.size).min(bytes.saturating_sub(location.offset))
        });
        Ok(source)
    }

    /// Opens the files of one recording and reads them one behind the other, in the order of their first times, whatever
    /// the order of `paths` is. Offsets count from the start of the first file.
    ///
    /// # Errors
    /// As [`Source::open`], and [`Error::Contents`] if a file is given twice.
    ///
    /// # Panics
    /// If `paths` is empty.
    pub fn join(paths: &[PathBuf]) -> Result<Self, Error> {
        let mut sources = Vec::new();
        for path in paths {
            let source = Self::open(path)?;
            if sources.iter().any(|(_, other): &(_, Self)| source.shares_a_file(other)) {
                return Err(Error::contents(path, "is given twice"));
            }
            sources.push((source.first_time()?, source));
        }
        // A file without any time comes first.
        sources.sort_by_key(|(time, _)| *time);
        let mut sources = sources.into_iter().map(|(_, source)| source);
        let mut joined = sources.next().expect("a command names at least one file");
        for source in sources {
            joined.catalog_bytes = joined.catalog_bytes.max(source.catalog_bytes);
            for piece in source.files {
                let bytes = piece.bytes;
                joined.files.push(Piece {
                    at: joined.bytes,
                    ..piece
                });
                joined.bytes += bytes;
            }
        }
        Ok(joined)
    }

    fn first_time(&self) -> Result<Option<Moment>, Error> {
        let mut records = self.records();
        while let Some(item) = records.next()? {
            if let FileItem::Record { frame, .. } = item
                && let Some(time) = Moment::of(&frame.header().time)
            {
                return Ok(Some(time));
            }
        }
        Ok(None)
    }

    fn shares_a_file(&self, other: &Self) -> bool {
        let of = |source: &Self| -> Vec<Metadata> {
            let files = source.files.iter();
            files.filter_map(|piece| piece.file.metadata().ok()).collect()
        };
        of(other).iter().any(|metadata| self.is_same_file(metadata))
    }

    /// Whether this is a file that is read here, by whatever name.
    pub(crate) fn is_same_file(&self, other: &Metadata) -> bool {
        self.files.iter().any(|piece| {
            let own = piece.file.metadata();
            own.is_ok_and(|own| (own.dev(), own.ino()) == (other.dev(), other.ino()))
        })
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
        usize::try_from(self.catalog_bytes).unwrap_or(0).max(FRAME_LIMIT)
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
        let mut left_out = LeftOut::default();
        while let Some(item) = records.next()? {
            match item {
                FileItem::Record { offset, frame } => visit(offset, &frame)?,
                FileItem::Skipped(skipped) => {
                    left_out.places += 1;
                    left_out.bytes += skipped.bytes;
                }
            }
        }
        self.left_out.set(left_out);
        Ok(())
    }

    /// What the last [`Source::each_record`] left out.
    pub(crate) fn left_out(&self) -> LeftOut {
        self.left_out.get()
    }

    /// Its bytes from a place on.
    pub(crate) fn part(&self, at: u64) -> Part<'_> {
        Part { files: &self.files, at }
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
    files: &'s [Piece],
    at: u64,
}

impl Read for Part<'_> {
    fn read(&mut self, out: &mut [u8]) -> io::Result<usize> {
        let behind = self.files.partition_point(|piece| piece.at + piece.bytes <= self.at);
        let Some(piece) = self.files.get(behind) else {
            return Ok(0);
        };
        let inside = self.at - piece.at;
        let left = usize::try_from(piece.bytes - inside).unwrap_or(usize::MAX);
        let length = out.len().min(left);
        let read = piece.file.read_at(&mut out[..length], inside)?;
        self.at += read as u64;
        Ok(read)
    }
}
