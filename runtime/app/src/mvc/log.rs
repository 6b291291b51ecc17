use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, bail};
use backseat_mvc::ClientId;
use backseat_units::Timestamp;
use tracing::warn;

/// A longer line is logged in pieces of this many bytes, more than any sentence has.
const PIECE_MAX: usize = 4352;

/// Every sentence in both directions and every event, in order, one a line, each with the vehicle's clock: `12.300 <
/// client 1 $BPRMB,…` was received, `12.300 > client 1 $BFACK,…` was sent, `12.300 -- …` happened.
///
/// Bytes other than printable ASCII are escaped as `\x1b`, a backslash as `\\`. A line that ends with one backslash is
/// continued or was cut off.
pub(crate) struct Log {
    file: BufWriter<File>,
    path: PathBuf,
    failed: bool,
    text: Vec<u8>,
}

impl Log {
    pub(crate) fn create(path: &Path) -> Result<Self> {
        let file = File::create(path).with_context(|| format!("{}", path.display()))?;
        Ok(Self {
            file: BufWriter::with_capacity(1 << 16, file),
            path: path.to_path_buf(),
            failed: false,
            text: Vec::new(),
        })
    }

    /// Logs what the vehicle has sent: whole sentences.
    pub(crate) fn sent(&mut self, now: Timestamp, client: ClientId, bytes: &[u8]) {
        for line in bytes.split(|byte| *byte == b'\n') {
            self.line(now, ">", Some(client), line, "");
        }
    }

    /// Logs a line, or a piece of one, that a client has sent.
    pub(crate) fn received(&mut self, now: Timestamp, client: ClientId, piece: &[u8]) {
        let end = if piece.ends_with(b"\n") { "" } else { "\\" };
        self.line(now, "<", Some(client), piece, end);
    }

    /// Logs an event.
    pub(crate) fn event(&mut self, now: Timestamp, text: &str) {
        self.line(now, "--", None, text.as_bytes(), "");
    }

    fn line(&mut self, now: Timestamp, mark: &str, client: Option<ClientId>, line: &[u8], end: &str) {
        let line = line.trim_ascii_end();
        if self.failed || line.is_empty() {
            return;
        }
        self.text.clear();
        for byte in line {
            match byte {
                b'\\' => self.text.extend_from_slice(b"\\\\"),
                b' '..=b'~' => self.text.push(*byte),
                _ => {
                    const DIGITS: &[u8; 16] = b"0123456789abcdef";
                    let digits = [DIGITS[usize::from(byte >> 4)], DIGITS[usize::from(byte & 15)]];
                    self.text.extend_from_slice(b"\\x");
                    self.text.extend_from_slice(&digits);
                }
            }
        }
        self.text.extend_from_slice(end.as_bytes());
        self.text.push(b'\n');
        let millis = now.as_nanos() / 1_000_000;
        let (seconds, millis) = (millis / 1000, millis % 1000);
        let written = match client {
            Some(ClientId(number)) => write!(self.file, "{seconds}.{millis:03} {mark} client {number} "),
            None => write!(self.file, "{seconds}.{millis:03} {mark} "),
        };
        let written = written.and_then(|()| self.file.write_all(&self.text));
        self.check(written);
    }

    pub(crate) fn flush(&mut self) {
        if !self.failed {
            let flushed = self.file.flush();
            self.check(flushed);
        }
    }

    /// Writes what is left.
    ///
    /// # Errors
    ///
    /// If the log is incomplete.
    pub(crate) fn finish(mut self) -> Result<()> {
        self.flush();
        if self.failed {
            bail!("{}: the log is incomplete", self.path.display());
        }
        Ok(())
    }

    fn check(&mut self, written: std::io::Result<()>) {
        if let Err(error) = written {
            warn!(
                "{}: {error}; the log ends here, the vehicle goes on",
                self.path.display()
            );
            self.failed = true;
        }
    }
}

/// Splits what a client sends into lines, whatever the reads were.
#[derive(Debug, Default)]
pub(crate) struct LineCutter {
    partial: Vec<u8>,
}

impl LineCutter {
    /// Passes on every whole line with its line feed, and every piece of a line that is too long.
    pub(crate) fn cut(&mut self, bytes: &[u8], mut take: impl FnMut(&[u8])) {
        for part in bytes.split_inclusive(|byte| *byte == b'\n') {
            let mut part = part;
            while self.partial.len() + part.len() > PIECE_MAX {
                let (head, rest) = part.split_at(PIECE_MAX - self.partial.len());
                self.partial.extend_from_slice(head);
                take(&self.partial);
                self.partial.clear();
                part = rest;
            }
            if part.ends_with(b"\n") && self.partial.is_empty() {
                take(part);
            } else {
                self.partial.extend_from_slice(part);
                if part.ends_with(b"\n") {
                    take(&self.partial);
                    self.partial.clear();
                }
            }
        }
    }

    /// The beginning of a line that is not complete yet.
    pub(crate) fn rest(&self) -> &[u8] {
        &self.partial
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cut(chunks: &[&[u8]]) -> (Vec<Vec<u8>>, Vec<u8>) {
        let mut cutter = LineCutter::default();
        let mut lines = Vec::new();
        for chunk in chunks {
            cutter.cut(chunk, |line| lines.push(line.to_vec()));
        }
        (lines, cutter.rest().to_vec())
    }

    #[test]
    fn lines_are_whole_however_they_came() {
        let whole: Vec<Vec<u8>> = vec![b"$A\r\n".to_vec(), b"\n".to_vec(), b"$B\n".to_vec()];
        assert_eq!(cut(&[b"$A\r\n\n$B\n"]), (whole.clone(), vec![]));
        assert_eq!(cut(&[b"$", b"A\r", b"\n\n$B", b"\n$C"]), (whole, b"$C".to_vec()));
    }

    #[test]
    fn no_byte_is_lost_of_a_line_without_an_end() {
        let long = vec![b'x'; 3 * PIECE_MAX + 5];
        for size in [1000, PIECE_MAX, 10_000] {
            let chunks: Vec<&[u8]> = long.chunks(size).collect();
            let (lines, rest) = cut(&chunks);
            assert!(
                lines.iter().all(|line| line.len() == PIECE_MAX) && lines.len() == 3,
                "{size}"
            );
            assert_eq!(rest.len(), 5);
        }
    }

    #[test]
    fn every_line_is_one_line_of_printable_text() {
        let folder = std::env::temp_dir().join(format!("backseat-log-{}", std::process::id()));
        let mut log = Log::create(&folder).unwrap();
        let now = Timestamp::ZERO + std::time::Duration::from_millis(12_345);
        log.received(now, ClientId(7), b"\xffa\\b\x1b\r\n");
        log.received(now, ClientId(7), b"half");
        log.received(now, ClientId(7), b"\r\n");
        log.sent(now, ClientId(7), b"$BFX\r\n$BFY\r\n");
        log.event(now, "an event");
        log.finish().unwrap();
        let text = std::fs::read_to_string(&folder).unwrap();
        std::fs::remove_file(&folder).unwrap();
        let expected = "12.345 < client 7 \\xffa\\\\b\\x1b\n12.345 < client 7 half\\\n12.345 > client 7 $BFX\n\
                        12.345 > client 7 $BFY\n12.345 -- an event\n";
        assert_eq!(text, expected);
    }
}
