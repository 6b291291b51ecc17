use std::io;
use std::path::{Path, PathBuf};

/// Why an export stopped. Each text is one line that says what is wrong and what to do.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The log cannot be opened or read.
    #[error("{}: cannot read: {source}", path.display())]
    Read {
        /// The log.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The input is not the log of a run.
    #[error("{}: {what}: expected the log of a run, written by `run`, `fly` or `sim --log`", path.display())]
    NoLog {
        /// The input.
        path: PathBuf,
        /// What it is instead.
        what: String,
    },
    /// A program of others has compressed the log.
    #[error("{}: is compressed with {compression}: run `mcap decompress` on it first", path.display())]
    Compressed {
        /// The log.
        path: PathBuf,
        /// The compression's name.
        compression: String,
    },
    /// A message is not what its channel says.
    #[error("{}: message {sequence} of {topic} is invalid: {source}", path.display())]
    Message {
        /// The log.
        path: PathBuf,
        /// The channel's topic.
        topic: String,
        /// The message's sequence number.
        sequence: u32,
        /// Where reading fails.
        source: serde_json::Error,
    },
    /// The log does not have the channel.
    #[error("{}: no channel {topic}; the log has {topics}", path.display())]
    NoChannel {
        /// The log.
        path: PathBuf,
        /// The topic that was asked for.
        topic: String,
        /// The topics that there are.
        topics: String,
    },
    /// The log has no position, so there is no trajectory.
    #[error("{}: no position on /navigation, so there is no trajectory to write", path.display())]
    NoPosition {
        /// The log.
        path: PathBuf,
    },
    /// The output cannot be written.
    #[error("{}: cannot write: {source}", path.display())]
    Write {
        /// The output.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// The output exists and is not replaced.
    #[error("{}: {what}", path.display())]
    Output {
        /// The output.
        path: PathBuf,
        /// What is wrong, and what to do.
        what: String,
    },
    /// An option does not go with the format.
    #[error("invalid {option}: {fault}")]
    Option {
        /// The option, as the user writes it.
        option: &'static str,
        /// What is wrong.
        fault: String,
    },
}

impl Error {
    pub(crate) fn read(path: &Path, source: io::Error) -> Self {
        Self::Read {
            path: path.to_owned(),
            source,
        }
    }

    pub(crate) fn write(path: &Path, source: io::Error) -> Self {
        Self::Write {
            path: path.to_owned(),
            source,
        }
    }

    pub(crate) fn no_log(path: &Path, what: impl Into<String>) -> Self {
        Self::NoLog {
            path: path.to_owned(),
            what: what.into(),
        }
    }

    pub(crate) fn output(path: &Path, what: impl Into<String>) -> Self {
        Self::Output {
            path: path.to_owned(),
            what: what.into(),
        }
    }

    /// Whether the reader of the output has closed it.
    #[must_use]
    pub fn is_broken_pipe(&self) -> bool {
        matches!(self, Self::Write { source, .. } if source.kind() == io::ErrorKind::BrokenPipe)
    }
}
