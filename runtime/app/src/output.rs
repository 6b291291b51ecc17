//! Standard output, whose failing is an error and no panic.

use std::fmt::Arguments;
use std::io::{ErrorKind, Write};

use anyhow::{Context, Result};

/// As `println!`, in a function that returns a `Result`.
macro_rules! say {
    ($($argument:tt)*) => {
        crate::output::line(format_args!($($argument)*))?
    };
}
pub(crate) use say;

/// Writes a line. Where the reader has gone there is nothing to say any more, and the exit code still counts.
pub(crate) fn line(text: Arguments<'_>) -> Result<()> {
    match writeln!(std::io::stdout().lock(), "{text}") {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(error).context("standard output"),
        _ => Ok(()),
    }
}
