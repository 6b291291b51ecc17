use std::collections::BTreeMap;
use std::fs::{self, File};
use std::io::{self, Seek, SeekFrom, Write};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::time::Duration;

use backseat_plc::{FileEffect, FileFailure, FileId};
use tokio::sync::mpsc::UnboundedSender;

use super::{Folder, Job, Report, file_of, size_of};
use crate::clock::Clock;

/// How often the free space is measured.
const MEASURE_EVERY: Duration = Duration::from_secs(1);
/// The ending of a file that replaces another one as soon as it is whole.
const NEW: &str = ".new";

/// The thread's side.
pub(super) struct Writer {
    files: Files,
    waiting: Arc<AtomicUsize>,
    reports: UnboundedSender<Report>,
}

/// The controller's files in a folder.
pub(crate) struct Files {
    folder: Folder,
    open: BTreeMap<FileId, OpenFile>,
}

struct OpenFile {
    file: File,
    path: PathBuf,
    /// The file that this one replaces when it is closed.
    replaces: Option<PathBuf>,
    length: u64,
    /// An effect failed: the rest is left out, so that the file ends with the last record that is whole.
    broken: bool,
}

impl Writer {
    pub(super) fn new(folder: Folder, waiting: Arc<AtomicUsize>, reports: UnboundedSender<Report>) -> Self {
        Self {
            files: Files::new(folder),
            waiting,
            reports,
        }
    }

    /// Carries out what comes, until the end.
    pub(super) fn serve(mut self, jobs: &Receiver<Job>) {
        let clock = Clock::start();
        let mut measure_at = Duration::ZERO;
        loop {
            match jobs.recv_timeout(MEASURE_EVERY) {
                Ok(Job::Effect(effect)) => {
                    let (file, size) = (file_of(&effect), size_of(&effect));
                    if let Err((error, path)) = self.files.carry_out(effect) {
                        let text = format!("{}: {error}", path.display());
                        // The controller has ended if nothing receives this.
                        let _gone = self.reports.send(Report::Failed(file, FileFailure::from(&error), text));
                    }
                    self.waiting.fetch_sub(size, Ordering::Relaxed);
                }
                Ok(Job::End(done)) => {
                    self.files.open.clear();
                    // Whoever asked may have given up.
                    let _late = done.send(());
                    return;
                }
                Err(RecvTimeoutError::Timeout) => {}
                Err(RecvTimeoutError::Disconnected) => return,
            }
            if clock.elapsed() >= measure_at {
                measure_at = clock.elapsed() + MEASURE_EVERY;
                if let Ok((_, free)) = self.files.folder.space() {
                    let waiting = self.waiting.load(Ordering::Relaxed) as u64;
                    let _gone = self.reports.send(Report::Free(free.saturating_sub(waiting)));
                }
            }
        }
    }
}

impl Files {
    pub(crate) const fn new(folder: Folder) -> Self {
        Self {
            folder,
            open: BTreeMap::new(),
        }
    }

    /// Carries an effect out. Once one has failed, the rest of its file is left out.
    ///
    /// # Errors
    /// What failed, and with which file.
    pub(crate) fn carry_out(&mut self, effect: FileEffect) -> Result<(), (io::Error, PathBuf)> {
        match effect {
            FileEffect::Open { file, place, replace } => {
                let path = self.folder.path(&place);
                let opened = OpenFile::open(path.clone(), replace).map_err(|error| (error, path))?;
                self.open.insert(file, opened);
                Ok(())
            }
            FileEffect::Append { file, bytes } => self.change(file, |open| open.append(&bytes)),
            FileEffect::Patch { file, at, bytes } => self.change(file, |open| open.patch(at, &bytes)),
            FileEffect::Truncate { file, length } => self.change(file, |open| open.truncate(length)),
            FileEffect::Close { file } => match self.open.remove(&file) {
                Some(open) => open.close(),
                None => Ok(()),
            },
        }
    }

    /// Changes a file that is whole so far. A file that could not be opened, or is broken, stays as it is.
    fn change(
        &mut self,
        file: FileId,
        change: impl FnOnce(&mut OpenFile) -> io::Result<()>,
    ) -> Result<(), (io::Error, PathBuf)> {
        let Some(open) = self.open.get_mut(&file).filter(|open| !open.broken) else {
            return Ok(());
        };
        change(open).map_err(|error| {
            open.broken = true;
            (error, open.path.clone())
        })
    }
}

impl OpenFile {
    fn open(path: PathBuf, replace: bool) -> io::Result<Self> {
        if let Some(folder) = path.parent() {
            fs::create_dir_all(folder)?;
        }
        let (path, replaces) = if replace {
            let mut new = path.clone().into_os_string();
            new.push(NEW);
            (PathBuf::from(new), Some(path))
        } else {
            (path, None)
        };
        let mut options = File::options();
        options.write(true);
        if replace {
            options.create(true).truncate(true);
        } else {
            options.create_new(true);
        }
        Ok(Self {
            file: options.open(&path)?,
            path,
            replaces,
            length: 0,
            broken: false,
        })
    }

    fn append(&mut self, bytes: &[u8]) -> io::Result<()> {
        let written = self.file.seek(SeekFrom::Start(self.length));
        let written = written.and_then(|_| self.file.write_all(bytes));
        if written.is_err() {
            // A record of which only a part found room is taken away again. If that fails too, readers skip it.
            let _cut = self.file.set_len(self.length);
        } else {
            self.length += bytes.len() as u64;
        }
        written
    }

    fn patch(&mut self, at: u64, bytes: &[u8]) -> io::Result<()> {
        self.file.seek(SeekFrom::Start(at))?;
        self.file.write_all(bytes)
    }

    fn truncate(&mut self, length: u64) -> io::Result<()> {
        self.length = self.length.min(length);
        self.file.set_len(length)
    }

    fn close(self) -> Result<(), (io::Error, PathBuf)> {
        match self.replaces {
            Some(path) if !self.broken => fs::rename(&self.path, &path).map_err(|error| (error, path)),
            Some(_) | None => Ok(()),
        }
    }
}
