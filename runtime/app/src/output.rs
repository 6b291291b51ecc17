//! Standard output. A failed write is an error, not a panic.

use std::fmt::Arguments;
use std::io::{ErrorKind, Write};

use anyhow::{Context, Result};

/// Like `println!`, for a function that returns a `Result`.
macro_rules! say {
    ($($argument:tt)*) => {
        crate::output::line(format_args!($($argument)*))?
    };
}
pub(crate) use say;

/// Writes a line. A closed pipe is no error: the reader has left, and the exit code still counts.
pub(crate) fn line(text: Arguments<'_>) -> Result<()> {
    match writeln!(std::io::stdout().lock(), "{text}") {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(error).context("standard output"),
        _ => Ok(()),
    }
}

/// A size in KiB, rounded.
pub(crate) fn kib(bytes: usize) -> String {
    format!("{:.0}", bytes as f64 / 1024.0)
}
