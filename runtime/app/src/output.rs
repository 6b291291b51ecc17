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

/// Writes a line, or several that `text` has. What would drive a terminal is escaped, as a log may have any text. A closed
/// pipe is no error: the reader has left, and the exit code still counts.
pub(crate) fn line(text: Arguments<'_>) -> Result<()> {
    let text = text.to_string();
    let drives = |character: char| character.is_control() && !matches!(character, '\n' | '\t');
    let text = if text.contains(drives) {
        escaped(&text, drives)
    } else {
        text
    };
    match writeln!(std::io::stdout().lock(), "{text}") {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => Err(error).context("standard output"),
        _ => Ok(()),
    }
}

/// The text in which such characters are escaped.
pub(crate) fn escaped(text: &str, which: impl Fn(char) -> bool) -> String {
    let mut escaped = String::with_capacity(text.len() + 16);
    for character in text.chars() {
        if which(character) {
            escaped.extend(character.escape_default());
        } else {
            escaped.push(character);
        }
    }
    escaped
}

/// A size in KiB, rounded.
pub(crate) fn kib(bytes: usize) -> String {
    format!("{:.0}", bytes as f64 / 1024.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_drives_no_terminal() {
        assert_eq!(
            escaped("a\u{1b}[2K\tb\n°", |letter| letter == '\u{1b}'),
            "a\\u{1b}[2K\tb\n°"
        );
    }
}
