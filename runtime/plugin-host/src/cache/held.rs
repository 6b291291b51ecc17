//! Where an artefact is held between its check and its use.

use std::fs::File;
use std::io::{self, Read, Seek, Write};
use std::os::fd::AsRawFd;
use std::path::PathBuf;

use rustix::fs::{MemfdFlags, SealFlags};

/// An artefact that nobody can change any more.
pub(super) enum Held {
    /// A sealed file in memory (`memfd_create(2)`). The engine maps it, so nothing is copied once more, and what a plugin
    /// never touches costs nothing.
    Sealed(File),
    /// Bytes of our own, which the engine copies: where there are no such files.
    Bytes(Vec<u8>),
}

/// An artefact while it is read.
pub(super) enum Draft {
    File(File),
    Bytes(Vec<u8>),
}

impl Draft {
    /// A file in memory. An error where there are none.
    pub(super) fn file() -> io::Result<Self> {
        let flags = MemfdFlags::CLOEXEC | MemfdFlags::ALLOW_SEALING;
        Ok(Self::File(File::from(rustix::fs::memfd_create(
            "backseat-plugin",
            flags,
        )?)))
    }

    /// Room for so many bytes of our own.
    pub(super) fn bytes(count: usize) -> Self {
        Self::Bytes(Vec::with_capacity(count))
    }

    /// From now on nobody can change it, this process included.
    pub(super) fn hold(self) -> io::Result<Held> {
        match self {
            Self::File(file) => {
                let all = SealFlags::WRITE | SealFlags::GROW | SealFlags::SHRINK | SealFlags::SEAL;
                rustix::fs::fcntl_add_seals(&file, all)?;
                Ok(Held::Sealed(file))
            }
            Self::Bytes(bytes) => Ok(Held::Bytes(bytes)),
        }
    }
}

impl Write for Draft {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self {
            Self::File(file) => file.write(bytes),
            Self::Bytes(held) => held.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Held {
    /// The path under which this process can open the sealed file.
    pub(super) fn path(&self) -> Option<PathBuf> {
        match self {
            Self::Sealed(file) => Some(format!("/proc/self/fd/{}", file.as_raw_fd()).into()),
            Self::Bytes(_) => None,
        }
    }

    /// All of it, in bytes of our own.
    pub(super) fn into_bytes(self) -> io::Result<Vec<u8>> {
        match self {
            Self::Sealed(mut file) => {
                let mut bytes = Vec::new();
                file.rewind()?;
                file.read_to_end(&mut bytes)?;
                Ok(bytes)
            }
            Self::Bytes(bytes) => Ok(bytes),
        }
    }
}

#[cfg(test)]
mod tests {
    use std::os::unix::fs::FileExt;

    use super::*;

    #[test]
    fn what_is_held_cannot_be_changed() {
        let mut draft = Draft::file().unwrap();
        draft.write_all(b"native code").unwrap();
        let Held::Sealed(file) = draft.hold().unwrap() else {
            panic!("it is a file");
        };
        assert!(file.write_at(b"!", 0).is_err());
        assert!(file.write_at(b"!", 11).is_err());
        assert!(file.set_len(3).is_err());
        assert!(rustix::fs::fcntl_add_seals(&file, SealFlags::empty()).is_err());
        let held = Held::Sealed(file);
        let path = held.path().unwrap();
        assert!(
            std::fs::OpenOptions::new()
                .write(true)
                .open(&path)
                .is_ok_and(|mut file| file.write(b"!").is_err())
        );
        assert_eq!(std::fs::read(path).unwrap(), b"native code");
        assert_eq!(held.into_bytes().unwrap(), b"native code");
    }

    #[test]
    fn bytes_serve_as_well() {
        let mut draft = Draft::bytes(3);
        draft.write_all(b"native code").unwrap();
        let held = draft.hold().unwrap();
        assert_eq!(held.path(), None);
        assert_eq!(held.into_bytes().unwrap(), b"native code");
    }
}
