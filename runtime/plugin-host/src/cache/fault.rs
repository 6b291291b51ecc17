use std::io;
use std::path::{Path, PathBuf};

use crate::cache::key::VERSION;
use crate::cache::{Late, Notice, PATIENCE};
use crate::error::one_line;

/// What is wrong with a folder or a file of the cache, and where. Each is one line.
#[derive(Debug, thiserror::Error)]
#[error("{}: {flaw}", path.display())]
pub(super) struct Fault {
    path: PathBuf,
    pub(super) flaw: Flaw,
}

#[derive(Debug, PartialEq, Eq, thiserror::Error)]
pub(super) enum Flaw {
    // Of the folder, or of the disk under it.
    #[error("{0}")]
    Folder(String),
    #[error("it belongs to user {owner}, and this program runs as user {user}")]
    FolderOwner { owner: u32, user: u32 },
    #[error("a link, expected a folder: name the folder itself")]
    FolderLink,
    #[error("mode {mode:03o} gives others access, expected 700: look who wrote what is in it, then `chmod 700` it")]
    FolderMode { mode: u32 },
    #[error("the disk has not answered for {seconds} s")]
    Slow { seconds: u64 },
    #[error("the thread that was to do it has failed")]
    Thread,
    #[error("{0}")]
    Write(String),
    #[error("the file system keeps no owners or modes")]
    Unkept,
    #[error("{free_mib} MiB are free, and {needed_mib} must be")]
    Full { free_mib: u64, needed_mib: u64 },
    #[error("it has room for {room_mib} MiB, and a compiled plugin has {bytes} bytes")]
    Room { room_mib: u64, bytes: u64 },
    // Of a file.
    #[error("a link")]
    Link,
    #[error("not a regular file")]
    Kind,
    #[error("it belongs to user {owner}, and this program runs as user {user}")]
    Owner { owner: u32, user: u32 },
    #[error("mode {mode:03o}, expected 600")]
    Mode { mode: u32 },
    #[error("{0}")]
    Read(String),
    #[error("cut short")]
    Short,
    #[error("not a compiled plugin")]
    Magic,
    #[error("format {found}, expected {VERSION}")]
    Version { found: u32 },
    #[error("compiled from another plugin")]
    Component,
    #[error("compiled by another engine, or with other settings")]
    Settings,
    #[error("records {records} bytes, and has {has}")]
    Length { records: u64, has: u64 },
    #[error("damaged: its BLAKE3 is not the one that it records")]
    Digest,
    #[error("the engine refuses it: {0}")]
    Engine(String),
}

impl Fault {
    pub(super) fn new(path: &Path, flaw: Flaw) -> Self {
        Self {
            path: path.to_owned(),
            flaw,
        }
    }

    /// The folder cannot be opened or created.
    pub(super) fn of_folder(path: &Path, error: &io::Error) -> Self {
        Self::new(path, Flaw::Folder(error.to_string()))
    }

    /// A file cannot be read.
    pub(super) fn of_read(path: &Path, error: &io::Error) -> Self {
        Self::new(path, Flaw::Read(error.to_string()))
    }

    /// A file cannot be written.
    pub(super) fn of_write(path: &Path, error: &io::Error) -> Self {
        Self::new(path, Flaw::Write(error.to_string()))
    }

    pub(super) fn of_engine(path: &Path, error: &wasmtime::Error) -> Self {
        Self::new(path, Flaw::Engine(one_line(error)))
    }

    pub(super) fn late(path: &Path, late: Late) -> Self {
        let flaw = match late {
            Late::Slow => Flaw::Slow {
                seconds: PATIENCE.as_secs(),
            },
            Late::Gone => Flaw::Thread,
        };
        Self::new(path, flaw)
    }

    /// Whether only one file is concerned, and the cache can still be used.
    pub(super) fn is_of_a_file(&self) -> bool {
        match &self.flaw {
            Flaw::Folder(_)
            | Flaw::FolderOwner { .. }
            | Flaw::FolderLink
            | Flaw::FolderMode { .. }
            | Flaw::Slow { .. }
            | Flaw::Thread
            | Flaw::Write(_)
            | Flaw::Unkept
            | Flaw::Full { .. }
            | Flaw::Room { .. } => false,
            Flaw::Link
            | Flaw::Kind
            | Flaw::Owner { .. }
            | Flaw::Mode { .. }
            | Flaw::Read(_)
            | Flaw::Short
            | Flaw::Magic
            | Flaw::Version { .. }
            | Flaw::Component
            | Flaw::Settings
            | Flaw::Length { .. }
            | Flaw::Digest
            | Flaw::Engine(_) => true,
        }
    }

    /// The notice of a cache that is not used any more.
    pub(super) fn notice(&self, what: &str, so: &str) -> Notice {
        let text = format!("{what}: {self}; {so}");
        // The first two are no accident of a disk: somebody may have meant to give this program other code to run.
        let odd = matches!(self.flaw, Flaw::FolderLink | Flaw::FolderMode { .. }) || self.is_of_a_file();
        if odd { Notice::Odd(text) } else { Notice::Unusable(text) }
    }
}
