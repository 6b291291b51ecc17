//! The file that a command writes: it appears under its name when it is whole.

use std::fs::File;
use std::io::{self, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};

use backseat_s7k::file::LogFile;

use crate::error::Error;

/// A file to write. Until [`Output::commit`] it has another name (`.part` behind its own), so that a failed command
/// leaves an existing file as it was. A device or a pipe is written directly.
#[derive(Debug)]
pub(crate) struct Output {
    path: PathBuf,
    part: Option<PathBuf>,
    file: File,
}

impl Output {
    pub(crate) fn create(path: &Path) -> Result<Self, Error> {
        let failed = |source| Error::write(path, source);
        let (opened, part) = match std::fs::metadata(path) {
            Ok(kind) if kind.is_dir() => {
                return Err(Error::OutputFolder { path: path.to_owned() });
            }
            Ok(kind) if !kind.is_file() => (path.to_owned(), None),
            _ => {
                let mut name = path.as_os_str().to_owned();
                name.push(".part");
                let part = PathBuf::from(name);
                (part.clone(), Some(part))
            }
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
