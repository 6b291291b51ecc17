use memchr::memchr;

use crate::wire::LINE_MAX;

/// Cuts a stream of writes into lines. A line that is whole in one write is not copied.
#[derive(Clone, Debug, Default)]
pub(crate) struct Lines {
    partial: Vec<u8>,
    /// The current line is too long and was reported; its rest is dropped.
    dropping: bool,
    /// The next bytes are the end of a line, unless they begin as a sentence does.
    resumes: bool,
}

/// A piece of the stream.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Piece<'a> {
    /// A line, without its line feed.
    Line(&'a [u8]),
    /// A line that is longer than any sentence. It is reported once.
    TooLong,
}

impl Lines {
    /// Adds a write and passes on each line that it completes.
    pub(crate) fn push(&mut self, mut bytes: &[u8], mut take: impl FnMut(Piece<'_>)) {
        if let (true, Some(first)) = (self.resumes, bytes.first()) {
            self.resumes = false;
            self.dropping = *first != b'$';
        }
        while let Some(end) = memchr(b'\n', bytes) {
            let (line, rest) = (&bytes[..end], &bytes[end + 1..]);
            bytes = rest;
            if core::mem::take(&mut self.dropping) {
                continue;
            }
            if self.partial.len() + line.len() >= LINE_MAX {
                take(Piece::TooLong);
            } else if self.partial.is_empty() {
                take(Piece::Line(line));
            } else {
                self.partial.extend_from_slice(line);
                take(Piece::Line(&self.partial));
            }
            self.partial.clear();
        }
        if bytes.is_empty() || self.dropping {
            return;
        }
        if self.partial.len() + bytes.len() >= LINE_MAX {
            self.partial.clear();
            self.dropping = true;
            take(Piece::TooLong);
        } else {
            self.partial.extend_from_slice(bytes);
        }
    }

    /// Whether a line has begun and not ended.
    pub(crate) const fn is_open(&self) -> bool {
        !self.partial.is_empty()
    }

    /// Forgets the line that has begun, for a new connection.
    pub(crate) fn clear(&mut self) {
        self.partial.clear();
        self.dropping = false;
        self.resumes = false;
    }

    /// The record has a gap: the next bytes may be the end of a line.
    pub(crate) fn resume(&mut self) {
        self.clear();
        self.resumes = true;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines(writes: &[&[u8]]) -> Vec<Option<Vec<u8>>> {
        let mut cutter = Lines::default();
        let mut out = Vec::new();
        for write in writes {
            cutter.push(write, |piece| {
                out.push(match piece {
                    Piece::Line(line) => Some(line.to_vec()),
                    Piece::TooLong => None,
                });
            });
        }
        out
    }

    #[test]
    fn lines_are_the_same_in_any_split() {
        let whole = b"$A\r\n$B\r\n\n$C";
        let expected = [b"$A\r".as_slice(), b"$B\r", b""].map(|line| Some(line.to_vec()));
        assert_eq!(lines(&[whole]), expected);
        for cut in 0..whole.len() {
            assert_eq!(lines(&[&whole[..cut], &whole[cut..]]), expected, "{cut}");
        }
    }

    #[test]
    fn an_endless_line_takes_no_memory_and_is_reported_once() {
        let long = [b'x'; 3 * LINE_MAX];
        assert_eq!(lines(&[&long, &long, b"\n$A\n"]), [None, Some(b"$A".to_vec())]);
        assert_eq!(
            lines(&[&long[..LINE_MAX / 2 + 100], &long[..LINE_MAX / 2 + 100], b"\n$A\n"]),
            [None, Some(b"$A".to_vec())]
        );
    }
}
