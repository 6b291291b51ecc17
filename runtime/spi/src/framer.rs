mod line;

pub use line::sentence_start;
use memchr::{memchr, memchr2};

use crate::MAX_LINE;
use crate::framer::line::{judge, judge_parts};
use crate::sentence::Sentence;

/// Cuts a stream of bytes into sentences. The bytes may arrive in pieces of any size.
///
/// Push what was read, then take sentences until there are none. Bytes that are not a sentence, and sentences that the
/// policy does not allow, are dropped and counted, and reading continues at the next `$`. No bytes make the framer
/// panic, and [`Framer::MAX_MEMORY`] bounds its memory (safety requirement 013). The time that a stream takes grows no
/// faster than its length.
///
/// A `$` inside a line is part of a text, or it begins a sentence after one that was cut short. The line's checksum,
/// after the last asterisk, shows which:
///
/// 1. The sentence begins at the first `$` from which the checksum is right, and ends with the line.
/// 2. If the checksum is right from several, the first of them wins whose sentence can hold the next `$`: that `$` is
///    in a text, or the message is unknown. If none can, the first of all wins. The checksum is right from a wrong `$`
///    by chance, after one cut sentence in 256, or because a fragment occurs twice and cancels itself out.
/// 3. If it is right from none, or if the line has no checksum, the sentence begins at the last `$`.
///
/// Each `$` before the sentence counts as a sentence that was cut short. So does each `$` inside it from which the
/// checksum is right too, because a sentence may have been lost there.
#[derive(Clone, Debug)]
pub struct Framer {
    policy: Policy,
    buffer: Vec<u8>,
    cursor: Cursor,
    counts: FrameCounts,
    watched: Watched,
}

/// The names of [`Framer::watching`], and which of them have been lost.
#[derive(Clone, Copy, Debug)]
struct Watched {
    names: &'static [&'static str],
    lost: u32,
}

impl Watched {
    /// What begins at the start of these bytes was dropped.
    #[cold]
    #[inline(never)]
    fn lost_at(&mut self, bytes: &[u8]) {
        let Some(rest) = bytes.strip_prefix(b"$") else {
            return;
        };
        for (index, name) in self.names.iter().enumerate() {
            if rest.starts_with(name.as_bytes()) {
                self.lost |= 1 << index;
            }
        }
    }
}

/// What a sentence must have to pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Policy {
    /// Sent by a vehicle: a correct checksum of two digits (SPI 4.2: each of its messages has one).
    FromVehicle,
    /// Sent by a payload: the checksum may be absent, or have one digit if the first would be zero.
    FromPayload,
}

/// What a [`Framer`] has found since it was made.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FrameCounts {
    /// Sentences that were returned.
    pub sentences: u64,
    /// Dropped: the checksum is wrong, or does not have the two digits that the policy requires.
    pub checksum_invalid: u64,
    /// Dropped: no checksum although the policy requires one.
    pub checksum_absent: u64,
    /// Dropped: no name, or one that is not letters and digits.
    pub malformed: u64,
    /// Dropped: longer than [`MAX_LINE`].
    pub too_long: u64,
    /// Dropped: not UTF-8.
    pub not_utf8: u64,
    /// Dropped: cut short by the `$` of the next sentence, or perhaps lost inside the sentence that was returned.
    pub cut_short: u64,
    /// Good sentences that were dropped, the oldest first, because more than [`Framer::MAX_BACKLOG`] bytes came before
    /// they were taken.
    pub overflowed: u64,
    /// Bytes outside sentences, without line ends. The rest of a line that was too long counts too.
    pub noise_bytes: u64,
}

impl FrameCounts {
    /// The sum of all counts except `sentences`: as long as it stays the same, nothing has been lost.
    #[must_use]
    pub const fn lost(&self) -> u64 {
        let Self {
            sentences: _,
            checksum_invalid,
            checksum_absent,
            malformed,
            too_long,
            not_utf8,
            cut_short,
            overflowed,
            noise_bytes,
        } = *self;
        checksum_invalid + checksum_absent + malformed + too_long + not_utf8 + cut_short + overflowed + noise_bytes
    }
}

/// The position of reading in the buffer.
#[derive(Clone, Copy, Debug, Default)]
struct Cursor {
    /// Everything before this is done.
    start: usize,
    /// There is no line feed between `start` and this, and no `$` after `start` and before `inner`: that part need not
    /// be searched again.
    searched: usize,
    /// The first `$` after `start`, if there is one before `searched`.
    inner: Option<usize>,
}

impl Framer {
    /// How many bytes are kept that were pushed and not taken. More bytes drop the oldest sentences.
    pub const MAX_BACKLOG: usize = 1 << 20;

    /// The most memory that a framer takes, bytes, whatever is pushed.
    pub const MAX_MEMORY: usize = 4 * Self::MAX_BACKLOG;

    /// How many bytes of one push are processed at a time.
    const CHUNK: usize = 1 << 16;

    /// Makes an empty framer.
    #[must_use]
    pub const fn new(policy: Policy) -> Self {
        Self {
            policy,
            buffer: Vec::new(),
            cursor: Cursor {
                start: 0,
                searched: 0,
                inner: None,
            },
            watched: Watched { names: &[], lost: 0 },
            counts: FrameCounts {
                sentences: 0,
                checksum_invalid: 0,
                checksum_absent: 0,
                malformed: 0,
                too_long: 0,
                not_utf8: 0,
                cut_short: 0,
                overflowed: 0,
                noise_bytes: 0,
            },
        }
    }

    /// Notes from now on whether a line with one of these names, 32 at most, is dropped: because of its checksum, for
    /// example. A name that was damaged itself cannot be recognised.
    #[must_use]
    pub const fn watching(mut self, names: &'static [&'static str]) -> Self {
        assert!(names.len() <= 32, "too many names");
        self.watched = Watched { names, lost: 0 };
        self
    }

    /// Which of the names of [`Framer::watching`] began a line that was dropped since the last call: the bit of each
    /// is set, the first one lowest. What counts as cut short counts here too.
    pub const fn take_watched(&mut self) -> u32 {
        core::mem::replace(&mut self.watched.lost, 0)
    }

    /// Adds any number of bytes, as they were read.
    pub fn push(&mut self, bytes: &[u8]) {
        for chunk in bytes.chunks(Self::CHUNK) {
            self.make_room(chunk.len());
            self.buffer.extend_from_slice(chunk);
        }
    }

    /// The next sentence that the policy allows; `None` until more bytes are pushed.
    pub fn next_sentence(&mut self) -> Option<Sentence<'_>> {
        let (counts, watched) = (&mut self.counts, &mut self.watched);
        let sentence = next(&self.buffer, &mut self.cursor, counts, watched, self.policy)?;
        self.counts.sentences += 1;
        Some(sentence)
    }

    /// What the framer has found so far.
    #[must_use]
    pub const fn counts(&self) -> FrameCounts {
        self.counts
    }

    /// Forgets what was pushed and not taken, for a new connection. The counts stay.
    pub fn clear(&mut self) {
        self.buffer.clear();
        self.cursor = Cursor::default();
    }

    /// The memory that the framer takes now, bytes; never more than [`Framer::MAX_MEMORY`].
    #[must_use]
    pub const fn memory(&self) -> usize {
        self.buffer.capacity()
    }

    fn make_room(&mut self, needed: usize) {
        while self.buffer.len() - self.cursor.start + needed > Self::MAX_BACKLOG {
            // At the end of this loop at most one incomplete line is left.
            let (counts, watched) = (&mut self.counts, &mut self.watched);
            let Some(sentence) = next(&self.buffer, &mut self.cursor, counts, watched, self.policy) else {
                break;
            };
            watched.lost_at(sentence.raw().as_bytes());
            counts.overflowed += 1;
        }
        // Moving the rest costs no more than the bytes that have been taken since the last move.
        if self.cursor.start > 0 && self.cursor.start >= self.buffer.len() / 2 {
            self.buffer.drain(..self.cursor.start);
            self.cursor.searched = self.cursor.searched.saturating_sub(self.cursor.start);
            self.cursor.inner = self.cursor.inner.map(|inner| inner - self.cursor.start);
            self.cursor.start = 0;
        }
    }
}

/// Takes the next good sentence, and counts what it drops before it. Inlined, because otherwise the sentence would be
/// returned through memory.
#[inline(always)]
fn next<'a>(
    buffer: &'a [u8],
    cursor: &mut Cursor,
    counts: &mut FrameCounts,
    watched: &mut Watched,
    policy: Policy,
) -> Option<Sentence<'a>> {
    loop {
        let pending = &buffer[cursor.start..];
        if pending.first().is_some_and(|first| *first != b'$') {
            let dollar = memchr(b'$', pending).unwrap_or(pending.len());
            counts.noise_bytes += noise(&pending[..dollar]);
            cursor.start += dollar;
            continue;
        }
        if pending.is_empty() {
            return None;
        }
        // A sentence ends within this window, or is too long.
        let window = &pending[..pending.len().min(MAX_LINE)];
        let searched = cursor.searched.saturating_sub(cursor.start).max(1);
        let found = match cursor.inner {
            None => memchr2(b'$', b'\n', &window[searched..]),
            Some(_) => memchr(b'\n', &window[searched..]),
        };
        match found.map(|at| searched + at) {
            Some(at) if window[at] == b'$' => {
                cursor.inner = Some(cursor.start + at);
                cursor.searched = cursor.start + at + 1;
            }
            Some(end) => {
                cursor.start += end + 1;
                let sentence = match cursor.inner.take() {
                    None => judge(&window[..end], counts, policy),
                    Some(_) => judge_parts(&window[..end], counts, watched, policy),
                };
                if let Some(sentence) = sentence {
                    return Some(sentence);
                }
                watched.lost_at(&window[..end]);
            }
            None if window.len() == MAX_LINE => drop_start(buffer, cursor, counts, watched),
            None => {
                cursor.searched = buffer.len();
                return None;
            }
        }
    }
}

/// Drops a `$` that no line feed follows within the longest line: continues at the next `$`, or after everything that
/// was searched.
#[cold]
fn drop_start(buffer: &[u8], cursor: &mut Cursor, counts: &mut FrameCounts, watched: &mut Watched) {
    watched.lost_at(&buffer[cursor.start..]);
    cursor.searched = cursor.start + MAX_LINE;
    match cursor.inner {
        Some(inner) => {
            counts.cut_short += 1;
            cursor.start = inner;
            let next = memchr(b'$', &buffer[inner + 1..cursor.searched]);
            cursor.inner = next.map(|at| inner + 1 + at);
        }
        None => {
            // The rest up to the next dollar sign is noise, whether it has arrived or not.
            counts.too_long += 1;
            cursor.start = cursor.searched;
        }
    }
}

fn noise(bytes: &[u8]) -> u64 {
    bytes.iter().filter(|byte| !matches!(byte, b'\r' | b'\n')).count() as u64
}

#[cfg(test)]
mod tests {
    use proptest::prelude::*;

    use super::*;

    const CONTROL: &str = "$BFCTL,081025.987,1*78";

    /// The sentences of a stream that is pushed in pieces.
    fn sentences(policy: Policy, pieces: &[&[u8]]) -> (Vec<String>, FrameCounts) {
        let mut framer = Framer::new(policy);
        let mut out = Vec::new();
        for piece in pieces {
            framer.push(piece);
            while let Some(sentence) = framer.next_sentence() {
                out.push(sentence.raw().to_owned());
            }
        }
        (out, framer.counts())
    }

    #[test]
    fn line_ends_of_all_kinds_and_blank_lines_pass() {
        let stream = format!("{CONTROL}\r\n\n{CONTROL}\n\r\n\r\n{CONTROL} \r\n");
        for policy in [Policy::FromVehicle, Policy::FromPayload] {
            let (out, counts) = sentences(policy, &[stream.as_bytes()]);
            assert_eq!(out, [CONTROL; 3]);
            assert_eq!(
                counts,
                FrameCounts {
                    sentences: 3,
                    ..FrameCounts::default()
                }
            );
        }
    }

    #[test]
    fn a_vehicle_must_send_its_checksum_and_a_payload_may() {
        let stream = b"$AB\r\n$AB*3\n$AB*03\r\n$AB*04\n$BPRMP,1*6a\n";
        let (out, counts) = sentences(Policy::FromVehicle, &[stream]);
        assert_eq!(out, ["$AB*03"]);
        assert_eq!((counts.checksum_absent, counts.checksum_invalid), (1, 3));
        let (out, counts) = sentences(Policy::FromPayload, &[stream]);
        assert_eq!(out, ["$AB", "$AB*3", "$AB*03"]);
        assert_eq!((counts.checksum_absent, counts.checksum_invalid), (0, 2));
    }

    #[test]
    fn noise_is_counted_and_dropped() {
        let (out, counts) = sentences(
            Policy::FromVehicle,
            &[b"login: \r\n", b"abc", CONTROL.as_bytes(), b"\r\nxyz"],
        );
        assert_eq!(out, [CONTROL]);
        assert_eq!(counts.noise_bytes, 7 + 3 + 3);
    }

    #[test]
    fn a_dollar_sign_inside_a_line_starts_a_new_sentence() {
        let (out, counts) = sentences(Policy::FromVehicle, &[b"$BFNVG,0810$BF", CONTROL.as_bytes(), b"\r\n"]);
        assert_eq!(out, [CONTROL]);
        assert_eq!(counts.cut_short, 2);
    }

    #[test]
    fn bad_lines_are_dropped_and_counted_by_their_cause() {
        let stream = [
            b"$BF\xff,1*00\r\n$,1*00\r\n$BFCTL,081025.987,0*78\r\n".as_slice(),
            CONTROL.as_bytes(),
            b"\r\n",
        ]
        .concat();
        let (out, counts) = sentences(Policy::FromVehicle, &[&stream]);
        assert_eq!(out, [CONTROL]);
        assert_eq!((counts.not_utf8, counts.malformed, counts.checksum_invalid), (1, 1, 1));
    }

    #[test]
    fn the_longest_line_passes_and_one_byte_more_does_not() {
        let line = |length: usize| {
            let body = format!("BPMSG,{}", "a".repeat(length - "$BPMSG,*HH\r\n".len()));
            format!("${body}*{:02X}\r\n", crate::sentence::xor(body.as_bytes()))
        };
        let (out, counts) = sentences(Policy::FromVehicle, &[line(MAX_LINE).as_bytes()]);
        assert_eq!((out.len(), counts.too_long), (1, 0));
        let long = [line(MAX_LINE + 1), line(50 * MAX_LINE), format!("{CONTROL}\r\n")].concat();
        let (out, counts) = sentences(Policy::FromVehicle, &[long.as_bytes()]);
        assert_eq!(out, [CONTROL]);
        assert_eq!(counts.too_long, 2);
    }

    /// Safety requirement 013.
    #[test]
    fn memory_is_bounded_and_the_newest_is_kept() {
        let end = format!("\r\n{CONTROL}\r\n");
        for filler in ["A", "$", "$BFNVG,", "\n", "$AB*03\r\n", "$AB*04\r\n", "é\r\n"] {
            let mut stream = filler.repeat(8_000_000 / filler.len()).into_bytes();
            stream.extend_from_slice(end.as_bytes());
            let mut framer = Framer::new(Policy::FromVehicle);
            framer.push(&stream);
            assert!(
                framer.memory() <= Framer::MAX_MEMORY,
                "{} bytes kept of {filler:?}",
                framer.memory()
            );
            let mut last = String::new();
            while let Some(sentence) = framer.next_sentence() {
                last = sentence.raw().to_owned();
            }
            assert_eq!(last, CONTROL, "after {filler:?}");
        }
    }

    #[test]
    fn a_good_sentence_that_is_dropped_before_it_is_taken_is_counted() {
        let mut framer = Framer::new(Policy::FromVehicle);
        let stream = format!("{CONTROL}\r\n").repeat(100_000);
        framer.push(stream.as_bytes());
        let mut taken = 0;
        while framer.next_sentence().is_some() {
            taken += 1;
        }
        assert_eq!(framer.counts().sentences, taken);
        assert!(framer.counts().overflowed > 0);
        assert_eq!(taken + framer.counts().overflowed, 100_000);
    }

    /// Safety requirement 001.
    #[test]
    fn a_dropped_line_with_a_watched_name_is_noted() {
        let cut = CONTROL.replace("*78", "");
        let too_long = format!("$BFCTL,{}", "1".repeat(2 * MAX_LINE));
        for (stream, lost) in [
            (format!("{CONTROL}\r\n"), 0),
            ("$BFCTL,081025.987,0*78\r\n".to_owned(), 1),
            (format!("{cut}\r\n"), 1),
            (format!("{cut}{CONTROL}\r\n"), 1),
            (format!("$BFNVG,0810{CONTROL}\r\n"), 2),
            (format!("{too_long}\r\n"), 1),
            ("$BFNVG,1*00\r\n$BFCTL\r\n$BFCTX,0*00\r\n".to_owned(), 3),
            ("$BFCTL,\u{e9}*00\r\n".to_owned(), 1),
        ] {
            let mut framer = Framer::new(Policy::FromVehicle).watching(&["BFCTL", "BFNVG"]);
            for piece in stream.as_bytes().chunks(5) {
                framer.push(piece);
                while framer.next_sentence().is_some() {}
            }
            assert_eq!((framer.take_watched(), framer.take_watched()), (lost, 0), "{stream:?}");
        }
        let mut framer = Framer::new(Policy::FromVehicle).watching(&["BFCTL"]);
        framer.push(format!("{CONTROL}\r\n").repeat(100_000).as_bytes());
        assert_eq!(framer.take_watched(), 1, "dropped before it was taken");
        // A text may have anything in it.
        let text = "BFTOP,081025.987,3,say $BFCTL";
        let line = format!("${text}*{:02X}\r\n", crate::sentence::xor(text.as_bytes()));
        let mut framer = Framer::new(Policy::FromVehicle).watching(&["BFCTL"]);
        framer.push(line.as_bytes());
        assert!(framer.next_sentence().is_some());
        assert_eq!(framer.take_watched(), 0);
    }

    #[test]
    fn a_new_connection_does_not_see_the_old_ones_half_line() {
        let mut framer = Framer::new(Policy::FromVehicle);
        framer.push(b"$BFCTL,081025.987,1");
        assert!(framer.next_sentence().is_none());
        framer.clear();
        framer.push(format!("*78\r\n{CONTROL}\r\n").as_bytes());
        assert_eq!(framer.next_sentence().unwrap().raw(), CONTROL);
        assert!(framer.next_sentence().is_none());
        // The framer also forgets how far it had searched the old bytes.
        framer.push(b"$BFCTL,081025.987,1$BFCTL,08");
        assert!(framer.next_sentence().is_none());
        framer.clear();
        framer.push(b"$AB*03\r\n");
        assert_eq!(framer.next_sentence().unwrap().raw(), "$AB*03");
    }

    proptest! {
        #[test]
        fn the_cuts_of_a_stream_do_not_matter(
            parts in proptest::collection::vec(
                prop_oneof![
                    Just(CONTROL.as_bytes().to_vec()), Just(b"\r\n".to_vec()), Just(b"\n".to_vec()), Just(b"$".to_vec()),
                    Just(b"$AB*03\r\n".to_vec()), Just(vec![b'x'; MAX_LINE * 2 / 3]), Just(b"$BFNVG,".to_vec()),
                    proptest::collection::vec(any::<u8>(), 0..40),
                ],
                0..30,
            ),
            cuts in proptest::collection::vec(1..200usize, 1..20),
        ) {
            let stream = parts.concat();
            let mut pieces = Vec::new();
            let mut rest = stream.as_slice();
            for cut in cuts.iter().cycle() {
                if rest.is_empty() {
                    break;
                }
                let (piece, after) = rest.split_at((*cut).min(rest.len()));
                pieces.push(piece);
                rest = after;
            }
            for policy in [Policy::FromVehicle, Policy::FromPayload] {
                prop_assert_eq!(sentences(policy, &pieces), sentences(policy, &[&stream]));
            }
        }
    }
}
