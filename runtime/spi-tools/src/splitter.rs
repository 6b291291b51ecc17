use backseat_spi::{MAX_LINE, Policy, sentence_start};
use memchr::{memchr, memchr_iter, memrchr};

/// Splits a stream of bytes into pieces that begin with `$`, and keeps all of them, the broken ones too.
///
/// [`backseat_spi::Framer`] drops what a runtime must not act on. These tools are for finding faults, so each piece is
/// given out with the way in which it ended, and only bytes outside of any sentence are counted and skipped. A `$`
/// inside a line begins a new piece unless the checksum shows that it belongs to the sentence, as in the framer. Memory
/// is bounded by one push and [`MAX_LINE`].
#[derive(Clone, Debug, Default)]
pub(crate) struct Splitter {
    buffer: Vec<u8>,
    /// Everything before this has been given out.
    start: usize,
    /// There is no line feed between `start` and here.
    searched: usize,
    /// Where the sentence begins that ends with the line, once that is known; a piece before it was cut short.
    whole: Option<usize>,
    /// The number of line feeds before `start`.
    lines: u64,
    ended: bool,
    pub(crate) noise_bytes: u64,
    pub(crate) too_long: u64,
}

/// Bytes that began with `$`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Piece<'a> {
    /// From the dollar sign on, without the line end.
    pub(crate) bytes: &'a [u8],
    pub(crate) end: End,
    /// The number of its line, from 1; lines end with a line feed.
    pub(crate) line: u64,
}

/// How a piece ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum End {
    /// With a line feed, as it should.
    Line,
    /// The next `$` came first.
    Dollar,
    /// The input or the connection ended.
    Input,
}

enum Extent {
    /// The piece's length in bytes, and the number of bytes to skip after it.
    Piece(usize, End, usize),
    TooLong,
    /// More bytes are needed.
    Unknown,
}

impl Splitter {
    /// Adds bytes as they were read.
    pub(crate) fn push(&mut self, bytes: &[u8]) {
        self.buffer.drain(..self.start);
        self.searched = self.searched.saturating_sub(self.start);
        self.whole = self.whole.map(|whole| whole - self.start);
        self.start = 0;
        self.buffer.extend_from_slice(bytes);
    }

    /// Marks the end of the input: what is left is given out too. The next push starts over.
    pub(crate) const fn end(&mut self) {
        self.ended = true;
    }

    pub(crate) fn next(&mut self) -> Option<Piece<'_>> {
        loop {
            let pending = &self.buffer[self.start..];
            if pending.is_empty() {
                self.ended = false;
                return None;
            }
            if pending[0] != b'$' {
                let dollar = memchr(b'$', pending).unwrap_or(pending.len());
                self.pass(dollar);
                continue;
            }
            let (length, end, skip) = match self.extent() {
                Extent::Piece(length, end, skip) => (length, end, skip),
                Extent::TooLong => {
                    // The bytes up to the next dollar sign are noise, whether they have arrived or not.
                    self.too_long += 1;
                    self.start += MAX_LINE;
                    continue;
                }
                Extent::Unknown => {
                    self.searched = self.buffer.len();
                    return None;
                }
            };
            let line = self.lines + 1;
            self.lines += skip as u64;
            let from = self.start;
            self.start += length + skip;
            let bytes = self.buffer[from..from + length].trim_ascii_end();
            return Some(Piece { bytes, end, line });
        }
    }

    /// Where the piece that begins at `start` ends.
    fn extent(&mut self) -> Extent {
        let pending = &self.buffer[self.start..];
        let window = &pending[..pending.len().min(MAX_LINE)];
        let next = || memchr(b'$', &window[1..]).map_or(Extent::TooLong, |at| Extent::Piece(1 + at, End::Dollar, 0));
        if self.whole.is_some_and(|whole| self.start < whole) {
            return next();
        }
        let searched = self.searched.saturating_sub(self.start).max(1);
        let (length, end, skip) = match memchr(b'\n', &window[searched..]) {
            Some(at) => (searched + at, End::Line, 1),
            None if window.len() == MAX_LINE => return next(),
            None if self.ended => (pending.len(), End::Input, 0),
            None => return Extent::Unknown,
        };
        let line = &window[..length];
        let whole = sentence_start(line, Policy::FromPayload).or_else(|| memrchr(b'$', line));
        if self.whole.take().is_none() && whole != Some(0) {
            self.whole = whole.map(|at| self.start + at);
            return next();
        }
        Extent::Piece(length, end, skip)
    }

    /// Counts a piece as noise.
    pub(crate) const fn count_noise(&mut self, bytes: u64) {
        self.noise_bytes += bytes;
    }

    fn pass(&mut self, length: usize) {
        let noise = &self.buffer[self.start..self.start + length];
        let feeds = memchr_iter(b'\n', noise).count() as u64;
        self.lines += feeds;
        self.noise_bytes += length as u64 - feeds - memchr_iter(b'\r', noise).count() as u64;
        self.start += length;
    }
}

#[cfg(test)]
mod tests {
    use backseat_spi::{ChecksumState, Framer, Policy, Sentence};
    use proptest::prelude::*;

    use super::*;

    fn pieces(stream: &[&[u8]]) -> (Vec<(String, End, u64)>, Splitter) {
        let mut splitter = Splitter::default();
        let mut out = Vec::new();
        let mut take = |splitter: &mut Splitter| {
            while let Some(piece) = splitter.next() {
                out.push((String::from_utf8_lossy(piece.bytes).into_owned(), piece.end, piece.line));
            }
        };
        for part in stream {
            splitter.push(part);
            take(&mut splitter);
        }
        splitter.end();
        take(&mut splitter);
        (out, splitter)
    }

    #[test]
    fn every_piece_comes_with_its_end_and_its_line() {
        let (out, splitter) = pieces(&[b"boot\r\n\n$A,1\r\r\n$B,2\n$C,", b"3$D,4\r\n  \n$E"]);
        let expected = [
            ("$A,1", End::Line, 3),
            ("$B,2", End::Line, 4),
            ("$C,3", End::Dollar, 5),
            ("$D,4", End::Line, 5),
            ("$E", End::Input, 7),
        ];
        let expected: Vec<_> = expected
            .iter()
            .map(|(text, end, line)| ((*text).to_owned(), *end, *line))
            .collect();
        assert_eq!(out, expected);
        assert_eq!(splitter.noise_bytes, 6, "boot and two blanks");
    }

    /// A modem's line with its checksum, in a sentence with its own.
    const RELAY: &str = "$BPTMR,081025.987,3,$CCRXD,1,2*5B*64";

    #[test]
    fn a_dollar_sign_in_a_sentence_with_a_right_checksum_is_part_of_it() {
        let stream = format!("$BFNVG,08$BF{RELAY}\r\n{RELAY}\n{RELAY}");
        for cut in [1, 10, stream.len()] {
            let chunks: Vec<&[u8]> = stream.as_bytes().chunks(cut).collect();
            let (out, _) = pieces(&chunks);
            let expected = [
                ("$BFNVG,08", End::Dollar, 1),
                ("$BF", End::Dollar, 1),
                (RELAY, End::Line, 1),
                (RELAY, End::Line, 2),
                (RELAY, End::Input, 3),
            ];
            let expected = expected.map(|(text, end, line)| (text.to_owned(), end, line));
            assert_eq!(out, expected);
        }
    }

    #[test]
    fn ten_megabytes_without_a_line_end_take_no_memory_and_lose_nothing_after_them() {
        let mut splitter = Splitter::default();
        splitter.push(b"$BFNVG,");
        let mut most = 0;
        for _ in 0..160 {
            splitter.push(&[b'7'; 1 << 16]);
            assert_eq!(splitter.next(), None);
            most = most.max(splitter.buffer.capacity());
        }
        splitter.push(b"$BFSHT,081025.987*71\r\n");
        assert_eq!(splitter.next().unwrap().bytes, b"$BFSHT,081025.987*71");
        assert_eq!(
            (splitter.too_long, splitter.noise_bytes),
            (1, 7 + (160 << 16) - MAX_LINE as u64)
        );
        assert!(most < 1 << 18, "{most}");
    }

    proptest! {
        /// Every sentence that the runtime's framer passes on is found here too, wherever the stream is split.
        #[test]
        fn the_good_pieces_are_the_framers_sentences(
            parts in proptest::collection::vec(
                prop_oneof![
                    Just(b"$BFCTL,081025.987,1*78".to_vec()), Just(b"\r\n".to_vec()), Just(b"\n".to_vec()),
                    Just(b"$BPRMP\n".to_vec()), Just(b"$AB*03\r\n".to_vec()), Just(vec![b'x'; 900]),
                    Just(b"$BFNVG,".to_vec()), proptest::collection::vec(any::<u8>(), 0..40),
                    Just(RELAY.as_bytes().to_vec()), Just(b"$BPXYZ,1".to_vec()), "[$*,A0\r\n]{0,5}".prop_map(String::into_bytes),
                ],
                0..40,
            ),
            cut in 1..300usize,
        ) {
            let stream = parts.concat();
            let mut framer = Framer::new(Policy::FromPayload);
            framer.push(&stream);
            let mut expected = Vec::new();
            while let Some(sentence) = framer.next_sentence() {
                expected.push(sentence.raw().to_owned());
            }
            let chunks: Vec<&[u8]> = stream.chunks(cut).collect();
            let (out, splitter) = pieces(&chunks);
            prop_assert_eq!(splitter.too_long, framer.counts().too_long);
            let good = out.into_iter().filter(|(text, end, _)| {
                let fits = Sentence::parse(text).is_ok_and(|sentence| sentence.checksum() != ChecksumState::Invalid);
                *end == End::Line && fits && !text.contains('\u{fffd}')
            });
            prop_assert_eq!(good.map(|(text, _, _)| text).collect::<Vec<_>>(), expected);
        }
    }
}
