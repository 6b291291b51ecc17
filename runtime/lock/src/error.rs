use std::io;
use std::path::PathBuf;

/// Why a lock or a key cannot be used, in one line.
#[derive(Debug, thiserror::Error)]
pub enum LockError {
    /// A file cannot be read or written.
    #[error("{}: {source}", path.display())]
    File {
        /// Its path.
        path: PathBuf,
        /// The reason.
        source: io::Error,
    },
    /// A file is not there.
    #[error("{}: is not there: {advice}", path.display())]
    Missing {
        /// Its path.
        path: PathBuf,
        /// How it is made.
        advice: &'static str,
    },
    /// A file is there, and would be lost.
    #[error("{}: is there already: give another name, or remove it", path.display())]
    Exists {
        /// Its path.
        path: PathBuf,
    },
    /// A file is no key.
    #[error("{}: is no {expected} key: `backseat key NAME` makes a pair, NAME.key (secret) and NAME.pub (public)", path.display())]
    Key {
        /// Its path.
        path: PathBuf,
        /// `secret` or `public`.
        expected: &'static str,
    },
    /// Others can read a secret key.
    #[error("{}: others can read this secret key: chmod 600, and make a new one if somebody may have read it", path.display())]
    Permissions {
        /// Its path.
        path: PathBuf,
    },
    /// Others can write a public key.
    #[error("{}: others can write this key, and put theirs in its place: chmod go-w", path.display())]
    Writable {
        /// Its path.
        path: PathBuf,
    },
    /// Something is no file, or too large for what it should be.
    #[error("{}: expected a file of at most {most} bytes", path.display())]
    NoFile {
        /// Its path.
        path: PathBuf,
        /// Bytes.
        most: u64,
    },
    /// The system has no random numbers.
    #[error("no random numbers for a key: {0}")]
    Random(String),
    /// A file is no lock.
    #[error("{}: is no lock, or is damaged: {message}", path.display())]
    Lock {
        /// Its path.
        path: PathBuf,
        /// What is wrong.
        message: String,
    },
    /// Somebody else has signed a lock, or it was changed since.
    #[error("{}: not signed with the key of {}, or changed since: check the mission, and sign it again", path.display(), key.display())]
    Signature {
        /// The lock.
        path: PathBuf,
        /// The public key's file.
        key: PathBuf,
    },
}

impl LockError {
    pub(crate) fn file(path: &std::path::Path, source: io::Error) -> Self {
        Self::File {
            path: path.to_path_buf(),
            source,
        }
    }

    /// The same for a file that is read, with how it is made, if it is not there.
    pub(crate) fn read(path: &std::path::Path, advice: &'static str, source: io::Error) -> Self {
        if source.kind() == io::ErrorKind::NotFound {
            let path = path.to_path_buf();
            return Self::Missing { path, advice };
        }
        Self::file(path, source)
    }
}
