//! The journal of a shard: a row for each run that was flown, in the order in which they ended.
//!
//! The file begins with a line that names it and the campaign. Then come entries: length and CRC-32, four bytes each and
//! little-endian, and as many bytes as the length says, in the encoding of postcard. A process that is killed, or a
//! computer that loses its power, leaves a last entry that is cut or damaged. The journal ends before it, and the run
//! that it was of is flown again.

use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::{self, BufReader, BufWriter, Read, Seek as _, SeekFrom, Write as _};
use std::os::unix::fs::{FileExt as _, MetadataExt as _};
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::error::CampaignError;
use crate::row::{Cell, Row};

const NAME: &str = "backseat campaign journal 1";
/// No entry is as long as this.
const LONGEST: u32 = 1 << 20;

#[derive(Debug, Serialize, Deserialize)]
enum Entry {
    /// A process began to write; its computer's name.
    Session(String),
    /// The name of the next column, counted from 0.
    Column(String),
    /// A run: its number, the nanoseconds that it took, and its cells by column.
    Row(u64, u64, Vec<(u32, Cell)>),
}

/// The writer of a journal. It holds a lock on the file.
pub(crate) struct JournalWriter {
    path: PathBuf,
    out: BufWriter<File>,
    columns: BTreeMap<String, u32>,
    scratch: Vec<u8>,
}

/// A row in a journal.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Place {
    pub(crate) run: u64,
    /// Of its payload.
    offset: u64,
    length: u32,
    /// The session that wrote it.
    session: u32,
}

/// A journal to read.
pub(crate) struct Journal {
    path: PathBuf,
    file: File,
    columns: Vec<String>,
    /// The computers' names.
    sessions: Vec<String>,
    pub(crate) rows: Vec<Place>,
    /// Where the last whole entry ends.
    end: u64,
    /// The bytes behind it, which a process that was killed or a disk has damaged.
    pub(crate) damaged: u64,
}

impl JournalWriter {
    /// Opens a journal for a campaign of this identity, and cuts off a damaged end. Also returns what it has.
    ///
    /// # Errors
    ///
    /// [`CampaignError`] if another process writes it, or if it is another campaign's.
    pub(crate) fn open(path: &Path, identity: &str, host: &str) -> Result<(Self, Journal), CampaignError> {
        let failed = |source| CampaignError::file(path, source);
        let mut file = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .open(path)
            .map_err(failed)?;
        match file.try_lock() {
            Ok(()) => {}
            Err(std::fs::TryLockError::WouldBlock) => {
                return Err(CampaignError::folder(
                    path,
                    "another process flies this campaign or shard into the same folder: wait for it, or stop it",
                ));
            }
            // Some shared file systems have no locks.
            Err(std::fs::TryLockError::Error(_)) => {}
        }
        if file.metadata().map_err(failed)?.len() == 0 {
            file.write_all(head(identity).as_bytes()).map_err(failed)?;
        }
        let journal = Journal::read(path, identity)?;
        file.set_len(journal.end).map_err(failed)?;
        file.seek(SeekFrom::End(0)).map_err(failed)?;
        let names = journal.columns.iter().cloned();
        let mut writer = Self {
            path: path.to_path_buf(),
            out: BufWriter::new(file),
            columns: names.zip(0..).collect(),
            scratch: Vec::new(),
        };
        writer.entry(&Entry::Session(host.to_owned()))?;
        writer.sync()?;
        Ok((writer, journal))
    }

    /// Appends the row of a run.
    pub(crate) fn write(&mut self, run: u64, wall_ns: u64, row: &Row) -> Result<(), CampaignError> {
        let mut cells = Vec::with_capacity(row.cells.len());
        for (name, cell) in &row.cells {
            let column = match self.columns.get(name) {
                Some(column) => *column,
                None => {
                    let column = self.columns.len() as u32;
                    self.columns.insert(name.clone(), column);
                    self.entry(&Entry::Column(name.clone()))?;
                    column
                }
            };
            cells.push((column, cell.clone()));
        }
        self.entry(&Entry::Row(run, wall_ns, cells))
    }

    /// Writes what is buffered, and has it on the disk.
    pub(crate) fn sync(&mut self) -> Result<(), CampaignError> {
        let written = self.out.flush().and_then(|()| self.out.get_ref().sync_data());
        written.map_err(|source| CampaignError::file(&self.path, source))
    }

    /// Checks that the file is still where it was: what is written to one that was removed is lost.
    pub(crate) fn is_there(&self) -> Result<(), CampaignError> {
        let same = |there: &std::fs::Metadata| {
            let ours = self.out.get_ref().metadata();
            ours.is_ok_and(|ours| (ours.dev(), ours.ino()) == (there.dev(), there.ino()))
        };
        match std::fs::metadata(&self.path) {
            Ok(there) if same(&there) => Ok(()),
            Ok(_) | Err(_) => Err(CampaignError::folder(
                &self.path,
                "was removed or moved while the campaign flies: put it back, and the same command goes on",
            )),
        }
    }

    fn entry(&mut self, entry: &Entry) -> Result<(), CampaignError> {
        let failed = |source| CampaignError::file(&self.path, source);
        self.scratch.clear();
        let bytes = postcard::to_extend(entry, std::mem::take(&mut self.scratch))
            .map_err(|error| failed(io::Error::other(error)))?;
        let length = bytes.len() as u32;
        let written = self
            .out
            .write_all(&length.to_le_bytes())
            .and_then(|()| self.out.write_all(&crc32fast::hash(&bytes).to_le_bytes()))
            .and_then(|()| self.out.write_all(&bytes));
        self.scratch = bytes;
        written.map_err(failed)
    }
}

impl Journal {
    /// Reads a journal up to its first damaged entry.
    ///
    /// # Errors
    ///
    /// [`CampaignError`] if the file is not a journal of a campaign of this identity.
    pub(crate) fn read(path: &Path, identity: &str) -> Result<Self, CampaignError> {
        let failed = |source| CampaignError::file(path, source);
        let file = File::open(path).map_err(failed)?;
        let mut input = BufReader::with_capacity(1 << 20, &file);
        let expected = head(identity);
        let mut first = vec![0; expected.len()];
        let whole = input.read_exact(&mut first);
        if whole.is_err() || first != expected.as_bytes() {
            let message = if first.starts_with(NAME.as_bytes()) {
                "is the journal of another campaign: give another folder"
            } else {
                "is not a journal that `backseat campaign` has written: move this file elsewhere"
            };
            return Err(CampaignError::folder(path, message));
        }
        let mut journal = Self {
            path: path.to_path_buf(),
            columns: Vec::new(),
            sessions: Vec::new(),
            rows: Vec::new(),
            end: expected.len() as u64,
            damaged: 0,
            file: file.try_clone().map_err(failed)?,
        };
        let mut bytes = Vec::new();
        while let Some(entry) = next(&mut input, &mut bytes).map_err(failed)? {
            match entry {
                Head::Session(host) => journal.sessions.push(host),
                Head::Column(name) => journal.columns.push(name),
                Head::Row(run) => journal.rows.push(Place {
                    run,
                    offset: journal.end + 8,
                    length: bytes.len() as u32,
                    session: journal.sessions.len().saturating_sub(1) as u32,
                }),
            }
            journal.end += 8 + bytes.len() as u64;
        }
        let length = file.metadata().map_err(failed)?.len();
        journal.damaged = length.saturating_sub(journal.end);
        Ok(journal)
    }

    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    pub(crate) fn columns(&self) -> &[String] {
        &self.columns
    }

    pub(crate) fn host(&self, place: &Place) -> &str {
        self.sessions.get(place.session as usize).map_or("", String::as_str)
    }

    /// The nanoseconds that a run took, and its cells by the journal's columns.
    pub(crate) fn row(&self, place: &Place, bytes: &mut Vec<u8>) -> Result<(u64, Vec<(u32, Cell)>), CampaignError> {
        bytes.resize(place.length as usize, 0);
        self.file
            .read_exact_at(bytes, place.offset)
            .map_err(|source| CampaignError::file(&self.path, source))?;
        match postcard::from_bytes(bytes) {
            Ok(Entry::Row(_, wall_ns, cells)) => Ok((wall_ns, cells)),
            Ok(Entry::Session(_) | Entry::Column(_)) | Err(_) => Err(CampaignError::folder(
                &self.path,
                "changed while it was read: try again when nobody writes it",
            )),
        }
    }
}

fn head(identity: &str) -> String {
    format!("{NAME}\n{identity}\n")
}

/// An entry as far as the index needs it.
enum Head {
    Session(String),
    Column(String),
    Row(u64),
}

/// The next entry, with its bytes; `None` at the end or at a damaged one.
fn next(input: &mut impl Read, bytes: &mut Vec<u8>) -> io::Result<Option<Head>> {
    let mut frame = [0; 8];
    if !fill(input, &mut frame)? {
        return Ok(None);
    }
    let [a, b, c, d, e, f, g, h] = frame;
    let length = u32::from_le_bytes([a, b, c, d]);
    if length == 0 || length > LONGEST {
        return Ok(None);
    }
    bytes.resize(length as usize, 0);
    if !fill(input, bytes)? || crc32fast::hash(bytes) != u32::from_le_bytes([e, f, g, h]) {
        return Ok(None);
    }
    // The cells of a row are read when the row is.
    let Ok((kind, rest)) = postcard::take_from_bytes::<u32>(bytes) else {
        return Ok(None);
    };
    let head = match kind {
        0 => postcard::from_bytes(rest).ok().map(Head::Session),
        1 => postcard::from_bytes(rest).ok().map(Head::Column),
        2 => postcard::take_from_bytes::<u64>(rest)
            .ok()
            .map(|(run, _)| Head::Row(run)),
        _ => None,
    };
    Ok(head)
}

/// Fills a buffer; false if the input ends before.
fn fill(input: &mut impl Read, buffer: &mut [u8]) -> io::Result<bool> {
    match input.read_exact(buffer) {
        Ok(()) => Ok(true),
        Err(error) if error.kind() == io::ErrorKind::UnexpectedEof => Ok(false),
        Err(error) => Err(error),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn row(value: f64) -> Row {
        let mut row = Row::default();
        row.cells.push(("rms_m".to_owned(), Cell::Number(value)));
        row.text("outcome", "completed");
        row
    }

    #[test]
    fn a_journal_goes_on_after_a_cut_at_every_byte() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.journal");
        let (mut writer, _) = JournalWriter::open(&path, "id", "here").unwrap();
        for run in 0..5 {
            writer.write(run, 7, &row(run as f64)).unwrap();
        }
        writer.sync().unwrap();
        drop(writer);
        let whole = std::fs::read(&path).unwrap();
        let head = head("id").len();
        for cut in head..whole.len() {
            std::fs::write(&path, &whole[..cut]).unwrap();
            let (mut writer, before) = JournalWriter::open(&path, "id", "there").unwrap();
            let done = before.rows.len() as u64;
            for run in done..5 {
                writer.write(run, 7, &row(run as f64)).unwrap();
            }
            writer.sync().unwrap();
            drop(writer);
            let journal = Journal::read(&path, "id").unwrap();
            let runs: Vec<u64> = journal.rows.iter().map(|place| place.run).collect();
            assert_eq!(runs, [0, 1, 2, 3, 4], "cut at {cut}");
            let mut bytes = Vec::new();
            for place in &journal.rows {
                let (wall_ns, cells) = journal.row(place, &mut bytes).unwrap();
                let named = cells
                    .iter()
                    .map(|(column, cell)| (journal.columns()[*column as usize].as_str(), cell));
                let numbers: Vec<_> = named.filter(|(name, _)| *name == "rms_m").collect();
                assert_eq!(numbers, [("rms_m", &Cell::Number(place.run as f64))]);
                assert_eq!(wall_ns, 7);
            }
        }
    }

    #[test]
    fn a_damaged_entry_ends_a_journal() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.journal");
        let (mut writer, _) = JournalWriter::open(&path, "id", "here").unwrap();
        for run in 0..5 {
            writer.write(run, 7, &row(run as f64)).unwrap();
        }
        writer.sync().unwrap();
        drop(writer);
        let whole = std::fs::read(&path).unwrap();
        // The last row's last byte, and zeros instead of the last rows, as a power loss leaves them.
        let mut flipped = whole.clone();
        *flipped.last_mut().unwrap() ^= 1;
        std::fs::write(&path, &flipped).unwrap();
        let journal = Journal::read(&path, "id").unwrap();
        assert_eq!(journal.rows.len(), 4);
        assert!(journal.damaged > 8, "{}", journal.damaged);
        let mut zeros = whole;
        let length = zeros.len();
        zeros[length - 60..].fill(0);
        std::fs::write(&path, &zeros).unwrap();
        assert!(Journal::read(&path, "id").unwrap().rows.len() < 5);
    }

    #[test]
    fn a_journal_that_was_removed_is_noticed() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.journal");
        let (writer, _) = JournalWriter::open(&path, "id", "here").unwrap();
        assert!(writer.is_there().is_ok());
        std::fs::remove_file(&path).unwrap();
        assert!(
            writer
                .is_there()
                .unwrap_err()
                .to_string()
                .contains("was removed or moved")
        );
        std::fs::write(&path, "another").unwrap();
        assert!(writer.is_there().is_err());
    }

    #[test]
    fn a_journal_belongs_to_one_campaign_and_one_process() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.journal");
        let (writer, _) = JournalWriter::open(&path, "id", "here").unwrap();
        let error = JournalWriter::open(&path, "id", "here").err().unwrap().to_string();
        assert!(error.contains("another process flies this campaign"), "{error}");
        drop(writer);
        let error = JournalWriter::open(&path, "xx", "here").err().unwrap().to_string();
        assert!(error.contains("is the journal of another campaign"), "{error}");
        std::fs::write(&path, "something else that is long enough").unwrap();
        let error = JournalWriter::open(&path, "id", "here").err().unwrap().to_string();
        assert!(error.contains("is not a journal"), "{error}");
    }
}
