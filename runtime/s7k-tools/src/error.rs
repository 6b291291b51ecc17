use std::io;
use std::path::{Path, PathBuf};

use backseat_s7k::FrameError;

/// Why a tool stopped. Each text is one line that says what is wrong and what to do.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The input cannot be opened or read.
    #[error("{}: cannot read: {source}", path.display())]
    Read {
        /// The input.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The input is no recording.
    #[error("{}: {fault}", path.display())]
    Input {
        /// The input.
        path: PathBuf,
        /// What it is instead.
        fault: InputFault,
    },
    /// The recording does not have what the command needs.
    #[error("{}: {what}", path.display())]
    Contents {
        /// The input.
        path: PathBuf,
        /// What is missing, and what to do.
        what: String,
    },
    /// The output cannot be written.
    #[error("{}: cannot write: {source}: {}", path.display(), advice(source))]
    Write {
        /// The output.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The output is a folder.
    #[error("{}: is a folder: name a file in it", path.display())]
    OutputFolder {
        /// The output.
        path: PathBuf,
    },
    /// The output is the recording that is read.
    #[error("{}: is the recording that is read: choose another name with --out", path.display())]
    OutputIsInput {
        /// The output.
        path: PathBuf,
    },
    /// Standard output cannot be written.
    #[error("cannot write: {0}")]
    Stdout(#[source] io::Error),
    /// An option has a value that cannot be used.
    #[error("invalid {option}: {fault}")]
    Option {
        /// The option, as the user writes it.
        option: &'static str,
        /// What is wrong, and what was expected.
        fault: String,
    },
}

/// Why an input is no recording.
#[derive(Debug, thiserror::Error)]
pub enum InputFault {
    /// It is a folder.
    #[error("is a folder: give a recording (.s7k) in it")]
    Folder,
    /// It is a pipe, a socket or a device. The tools read their input several times.
    #[error("is a pipe or a device, and the input is read more than once: save it to a file first")]
    NotAFile,
    /// It has no bytes.
    #[error("is empty: give a recording (.s7k) with at least one record")]
    Empty,
    /// No record begins anywhere in it.
    #[error("is not a 7k recording: no record in its {bytes} bytes ({why}): give a .s7k file")]
    NoRecord {
        /// Its length, bytes.
        bytes: u64,
        /// What was wrong with its first bytes.
        why: FrameError,
    },
}

fn advice(source: &io::Error) -> &'static str {
    use io::ErrorKind::{FileTooLarge, NotFound, QuotaExceeded, StorageFull};
    let kind = source.kind();
    if [StorageFull, QuotaExceeded, FileTooLarge].contains(&kind) {
        "free some space, or choose another place with --out"
    } else if kind == NotFound {
        "create the folder first, or choose another place with --out"
    } else {
        "choose another place with --out"
    }
}

impl Error {
    /// The recording at this path lacks something.
    pub(crate) fn contents(path: &Path, what: impl Into<String>) -> Self {
        Self::Contents {
            path: path.to_owned(),
            what: what.into(),
        }
    }

    /// The output at this path failed.
    pub(crate) fn write(path: &Path, source: io::Error) -> Self {
        Self::Write {
            path: path.to_owned(),
            source,
        }
    }

    /// Whether the reader of the output has closed it, as `head` does. This is not a failure.
    #[must_use]
    pub fn is_broken_pipe(&self) -> bool {
        match self {
            Self::Stdout(error) | Self::Write { source: error, .. } => error.kind() == io::ErrorKind::BrokenPipe,
            Self::Read { .. }
            | Self::Input { .. }
            | Self::Contents { .. }
            | Self::OutputFolder { .. }
            | Self::OutputIsInput { .. }
            | Self::Option { .. } => false,
        }
    }
}
