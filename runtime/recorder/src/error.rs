use std::path::PathBuf;

/// What can go wrong with a log.
#[derive(Debug, thiserror::Error)]
pub enum RecorderError {
    /// The file cannot be made.
    #[error("cannot create log {}: {source}", path.display())]
    Create {
        /// Which file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The log cannot be written: most often the disk is full. Nothing after this is recorded.
    #[error("cannot write log {log}: {source}")]
    Write {
        /// Path of the file, or `in memory`.
        log: String,
        /// Why.
        source: Box<mcap::McapError>,
    },
    /// A message has no JSON: a map of the simulation's truth whose keys are not text.
    #[error("cannot write channel {channel} of log {log}: {source}")]
    Encode {
        /// Path of the file, or `in memory`.
        log: String,
        /// The channel's topic.
        channel: &'static str,
        /// Why.
        source: serde_json::Error,
    },
    /// The file cannot be read.
    #[error("cannot read log {}: {source}", path.display())]
    Open {
        /// Which file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The file is not MCAP, or is damaged in its middle (a missing end is no error).
    #[error("log {log} is no intact MCAP file: {source}")]
    Damaged {
        /// Path of the file, or `in memory`.
        log: String,
        /// Where it fails.
        source: Box<mcap::McapError>,
    },
    /// An MCAP file, but not one of ours or of another format.
    #[error("log {log} is no backseat log: {what}, expected {expected}")]
    Foreign {
        /// Path of the file, or `in memory`.
        log: String,
        /// What was found.
        what: String,
        /// What should be there.
        expected: &'static str,
    },
    /// A message does not read as its channel's schema says.
    #[error("log {log}: message {sequence} of {channel} does not read: {source}")]
    Message {
        /// Path of the file, or `in memory`.
        log: String,
        /// The channel's topic.
        channel: &'static str,
        /// The message's sequence number.
        sequence: u32,
        /// Where it fails.
        source: serde_json::Error,
    },
}
