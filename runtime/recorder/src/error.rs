use std::path::PathBuf;

/// Errors of writing and reading logs.
#[derive(Debug, thiserror::Error)]
pub enum RecorderError {
    /// The file cannot be created.
    #[error("cannot create log {}: {source}", path.display())]
    Create {
        /// The file.
        path: PathBuf,
        /// The reason.
        source: std::io::Error,
    },
    /// The file is there already.
    #[error("cannot create log {}: it is there already: give another name, or remove it", path.display())]
    Exists {
        /// The file.
        path: PathBuf,
    },
    /// The log cannot be written, usually because the disk is full. Nothing is recorded after this.
    #[error("cannot write log {log}: {source}")]
    Write {
        /// Path of the file, or `in memory`.
        log: String,
        /// The reason.
        source: Box<mcap::McapError>,
    },
    /// A message cannot be written as JSON: the simulation's truth has a map whose keys are not text.
    #[error("cannot write channel {channel} of log {log}: {source}")]
    Encode {
        /// Path of the file, or `in memory`.
        log: String,
        /// The channel's topic.
        channel: String,
        /// The reason.
        source: serde_json::Error,
    },
    /// The file cannot be read.
    #[error("cannot read log {}: {source}", path.display())]
    Open {
        /// The file.
        path: PathBuf,
        /// The reason.
        source: std::io::Error,
    },
    /// The file is damaged in the middle. (A missing end is not an error.)
    #[error("log {log} is not an intact MCAP file: {reason}")]
    Damaged {
        /// Path of the file, or `in memory`.
        log: String,
        /// Where reading fails.
        reason: String,
    },
    /// The file is something else.
    #[error("log {log} {what}")]
    NotALog {
        /// Path of the file, or `in memory`.
        log: String,
        /// What it is.
        what: &'static str,
    },
    /// The file is MCAP with compressed chunks, which this project never writes.
    #[error(
        "log {log} is compressed with {with}, which this program does not read: `mcap decompress` writes a copy that it does"
    )]
    Compressed {
        /// Path of the file, or `in memory`.
        log: String,
        /// The name of the compression.
        with: String,
    },
    /// The log has a format that another version of the program writes.
    #[error("log {log} has format {found:?}, and this version reads format {expected} only")]
    Format {
        /// Path of the file, or `in memory`.
        log: String,
        /// The log's format.
        found: String,
        /// The format that this crate reads.
        expected: &'static str,
    },
    /// The file is MCAP, but not a log of this project.
    #[error("log {log} is not a backseat log: {what}, expected {expected}")]
    Foreign {
        /// Path of the file, or `in memory`.
        log: String,
        /// What was found.
        what: String,
        /// What was expected.
        expected: &'static str,
    },
    /// A message does not match its channel's schema.
    #[error("log {log}: message {sequence} of {channel} is invalid: {source}")]
    Message {
        /// Path of the file, or `in memory`.
        log: String,
        /// The channel's topic.
        channel: String,
        /// The message's sequence number.
        sequence: u32,
        /// Where reading fails.
        source: serde_json::Error,
    },
}
