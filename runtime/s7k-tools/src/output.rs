//! The file that a command writes: it appears under its name when it is whole.

use std::fs::File;
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use backseat_s7k::file::LogFile;

use crate::error::Error;
use crate::source::Source;

/// A file to write. Until [`Output::commit`] it has another name (`.part` behind its own), so that a failed command
/// leaves an existing file as it was. A device, a pipe or what a link names is written directly. It is never a file that is read.
#[derive(Debug)]
pub(crate) struct Output {
    path: PathBuf,
    part: Option<PathBuf>,
    file: File,
}

impl Output {
    /// Opens it, before anything is written to it.
    pub(crate) fn create(path: &Path, source: &Source) -> Result<Self, Error> {
        let failed = |source| Error::write(path, source);
        let mut part = path.as_os_str().to_owned();
        part.push(".part");
        let part = PathBuf::from(part);
        for written in [path, &part] {
            // By its number, because a link or another spelling names the same file.
            if std::fs::metadata(written).is_ok_and(|file| source.is_same_file(&file)) {
                return Err(Error::OutputIsInput {
                    path: written.to_owned(),
                });
            }
        }
        // A link keeps its place, above all /dev/stdout, which may lead to a file.
        let is_link = std::fs::symlink_metadata(path).is_ok_and(|kind| kind.is_symlink());
        let (opened, part) = match std::fs::metadata(path) {
            Ok(kind) if kind.is_dir() => {
                return Err(Error::OutputFolder { path: path.to_owned() });
            }
            Ok(kind) if !kind.is_file() => (path.to_owned(), None),
            Ok(_) | Err(_) if is_link => (path.to_owned(), None),
            _ => (part.clone(), Some(part)),
        };
        let file = File::options()
            .read(part.is_some())
            .write(true)
            .create(true)
            .truncate(true)
            .open(opened)
            .map_err(failed)?;
        Ok(Self {
            path: path.to_owned(),
            part,
            file,
        })
    }

    /// Gives the file its name.
    pub(crate) fn commit(mut self) -> Result<(), Error> {
        let done = self.file.flush().and_then(|()| match &self.part {
            Some(part) => std::fs::rename(part, &self.path),
            None => Ok(()),
        });
        done.map_err(|source| Error::write(&self.path, source))?;
        self.part = None;
        Ok(())
    }
}

impl Drop for Output {
    fn drop(&mut self) {
        if let Some(part) = &self.part {
            // What cannot be removed stays: the error that led here is the one to report.
            let _left = std::fs::remove_file(part);
        }
    }
}

impl Write for Output {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl Seek for Output {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.file.seek(to)
    }
}

impl LogFile for Output {
    fn truncate(&mut self, length: u64) -> io::Result<()> {
        self.file.set_len(length)
    }
}
