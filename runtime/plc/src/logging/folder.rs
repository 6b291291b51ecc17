//! A folder whose files turn what is written into effects, with the controller's own idea of its disk.

use std::collections::{BTreeSet, VecDeque};
use std::io::{self, Seek, SeekFrom, Write};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use backseat_s7k::file::{Folder, LogFile};

use super::{FileEffect, FileId, FilePlace};

/// Room that only the end of a file may use, bytes: the catalogue of a file must fit when the disk is full.
const RESERVE: u64 = 1 << 20;

/// Room without which logging does not begin, bytes: that of a long record.
const BEGIN_ROOM: u64 = 256 << 10;

/// The disk, shared by the logger and the files that it has open. No other thread has it.
#[derive(Clone, Debug)]
pub(crate) struct Disk(Arc<Mutex<Inner>>);

#[derive(Debug)]
struct Inner {
    effects: VecDeque<FileEffect>,
    next: u32,
    folder: String,
    /// The name of the next file, where a client named it.
    exact: Option<String>,
    made: BTreeSet<FilePlace>,
    open: Option<(FileId, FilePlace)>,
    capacity: u64,
    free: u64,
    /// A fault: there is no room at all.
    full: bool,
    /// A file is being ended, and may use the reserve.
    ending: bool,
}

impl Disk {
    pub(super) fn new(folder: String, capacity: u64, used: u64) -> Self {
        Self(Arc::new(Mutex::new(Inner {
            effects: VecDeque::new(),
            next: 0,
            folder,
            exact: None,
            made: BTreeSet::new(),
            open: None,
            capacity,
            free: capacity.saturating_sub(used),
            full: false,
            ending: false,
        })))
    }

    fn inner(&self) -> MutexGuard<'_, Inner> {
        // What a panic left is whole: every change is one assignment.
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(super) fn poll(&self) -> Option<FileEffect> {
        self.inner().effects.pop_front()
    }

    /// Replaces a file of the controller's own.
    pub(super) fn store(&self, name: &str, bytes: &[u8]) {
        let mut inner = self.inner();
        let file = inner.file();
        let place = FilePlace {
            folder: None,
            name: name.to_owned(),
        };
        let replace = true;
        inner.effects.push_back(FileEffect::Open { file, place, replace });
        let bytes = bytes.to_vec();
        inner.effects.push_back(FileEffect::Append { file, bytes });
        inner.effects.push_back(FileEffect::Close { file });
    }

    pub(super) fn keep(&self, place: FilePlace) {
        self.inner().made.insert(place);
    }

    pub(super) fn set_folder(&self, folder: String) {
        self.inner().folder = folder;
    }

    pub(super) fn folder(&self) -> String {
        self.inner().folder.clone()
    }

    pub(super) fn set_exact(&self, name: Option<String>) {
        self.inner().exact = name;
    }

    /// Whether this name was used in the folder.
    pub(super) fn is_made(&self, name: &str) -> bool {
        let inner = self.inner();
        let place = FilePlace {
            folder: Some(inner.folder.clone()),
            name: name.to_owned(),
        };
        inner.made.contains(&place)
    }

    /// Where a file of this name will be; a client may have named the next one otherwise.
    pub(super) fn place(&self, name: String) -> FilePlace {
        let inner = self.inner();
        FilePlace {
            folder: Some(inner.folder.clone()),
            name: inner.exact.clone().unwrap_or(name),
        }
    }

    /// The log file that is open.
    pub(super) fn open(&self) -> Option<(FileId, FilePlace)> {
        self.inner().open.clone()
    }

    pub(super) fn set_full(&self, full: bool) {
        self.inner().full = full;
    }

    pub(super) fn set_ending(&self, ending: bool) {
        self.inner().ending = ending;
    }

    pub(super) fn set_free(&self, bytes: u64) {
        self.inner().free = bytes;
    }

    /// What is free, percent of the capacity.
    pub(super) fn free_percent(&self) -> f64 {
        let inner = self.inner();
        if inner.full {
            return 0.0;
        }
        100.0 * inner.free as f64 / inner.capacity.max(1) as f64
    }

    /// Whether logging may begin.
    pub(super) fn has_room(&self) -> bool {
        self.inner().room() >= BEGIN_ROOM
    }
}

impl Inner {
    fn file(&mut self) -> FileId {
        self.next = self.next.wrapping_add(1);
        FileId(self.next)
    }

    fn room(&self) -> u64 {
        match (self.full, self.ending) {
            (_, true) => self.free,
            (true, false) => 0,
            (false, false) => self.free.saturating_sub(RESERVE.min(self.capacity / 10)),
        }
    }
}

impl Folder for Disk {
    type File = DiskFile;

    fn create(&mut self, name: &str) -> io::Result<DiskFile> {
        let mut inner = self.inner();
        if inner.room() == 0 {
            return Err(io::Error::from(io::ErrorKind::StorageFull));
        }
        let name = inner.exact.take().unwrap_or_else(|| name.to_owned());
        let place = FilePlace {
            folder: Some(inner.folder.clone()),
            name,
        };
        if !inner.made.insert(place.clone()) {
            return Err(io::Error::from(io::ErrorKind::AlreadyExists));
        }
        let file = inner.file();
        inner.open = Some((file, place.clone()));
        let replace = false;
        inner.effects.push_back(FileEffect::Open { file, place, replace });
        drop(inner);
        Ok(DiskFile {
            disk: self.clone(),
            file,
            at: 0,
            length: 0,
        })
    }
}

/// A file whose writes become effects. It is closed when it is dropped.
#[derive(Debug)]
pub(crate) struct DiskFile {
    disk: Disk,
    file: FileId,
    at: u64,
    length: u64,
}

impl Write for DiskFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let mut inner = self.disk.inner();
        let end = self.at + bytes.len() as u64;
        let growth = end.saturating_sub(self.length);
        if growth > inner.room() {
            return Err(io::Error::from(io::ErrorKind::StorageFull));
        }
        inner.free -= growth;
        let (file, at, bytes) = (self.file, self.at, bytes.to_vec());
        let written = bytes.len();
        inner.effects.push_back(if at == self.length {
            FileEffect::Append { file, bytes }
        } else {
            FileEffect::Patch { file, at, bytes }
        });
        self.at = end;
        self.length = self.length.max(end);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Seek for DiskFile {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let at = match to {
            SeekFrom::Start(at) => Some(at),
            SeekFrom::End(by) => self.length.checked_add_signed(by),
            SeekFrom::Current(by) => self.at.checked_add_signed(by),
        };
        // A place behind the end would leave a hole, which no effect describes.
        self.at = at
            .filter(|at| *at <= self.length)
            .ok_or_else(|| io::Error::from(io::ErrorKind::InvalidInput))?;
        Ok(self.at)
    }
}

impl LogFile for DiskFile {
    fn truncate(&mut self, length: u64) -> io::Result<()> {
        if length < self.length {
            let mut inner = self.disk.inner();
            inner.free += self.length - length;
            let file = self.file;
            inner.effects.push_back(FileEffect::Truncate { file, length });
            self.length = length;
        }
        Ok(())
    }
}

impl Drop for DiskFile {
    fn drop(&mut self) {
        let mut inner = self.disk.inner();
        let file = self.file;
        inner.effects.push_back(FileEffect::Close { file });
        if inner.open.as_ref().is_some_and(|(open, _)| *open == file) {
            inner.open = None;
        }
    }
}
