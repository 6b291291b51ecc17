//! Finds the sentence in one line, or the reason why there is none. No bytes make this code panic, and it copies none
//! (safety requirement 013).

use core::cmp::Ordering;

use memchr::{memchr_iter, memrchr, memrchr_iter};

use crate::catalogue::catalogue;
use crate::framer::{FrameCounts, Policy, Watched};
use crate::sentence::{ChecksumState, Sentence, checksum, last_star, xor};

/// The sentence of a line; if there is none, the reason is counted.
#[inline(always)]
pub(super) fn judge<'a>(line: &'a [u8], counts: &mut FrameCounts, policy: Policy) -> Option<Sentence<'a>> {
    let Ok(line) = core::str::from_utf8(line) else {
        counts.not_utf8 += 1;
        return None;
    };
    let Ok(sentence) = Sentence::parse(line) else {
        counts.malformed += 1;
        return None;
    };
    let two_digits = || matches!(sentence.raw().as_bytes(), [.., b'*', high, _] if *high != b'*');
    match (sentence.checksum(), policy) {
        (ChecksumState::Valid, Policy::FromPayload) | (ChecksumState::Absent, Policy::FromPayload) => Some(sentence),
        (ChecksumState::Valid, Policy::FromVehicle) if two_digits() => Some(sentence),
        (ChecksumState::Absent, Policy::FromVehicle) => {
            counts.checksum_absent += 1;
            None
        }
        (ChecksumState::Valid | ChecksumState::Invalid, Policy::FromVehicle | Policy::FromPayload) => {
            counts.checksum_invalid += 1;
            None
        }
    }
}

/// The sentence of a line with a `$` inside it, by the rules of [`crate::Framer`]; if there is none, the reason is
/// counted.
#[cold]
#[inline(never)]
pub(super) fn judge_parts<'a>(
    line: &'a [u8],
    counts: &mut FrameCounts,
    watched: &mut Watched,
    policy: Policy,
) -> Option<Sentence<'a>> {
    let line = line.trim_ascii_end();
    let start = match right_start(line, policy) {
        Some(start) => start,
        None => Start {
            at: memrchr(b'$', line).unwrap_or(0),
            doubts: 0,
        },
    };
    let (before, rest) = line.split_at(start.at);
    counts.cut_short += memchr_iter(b'$', before).count() as u64 + start.doubts;
    let sentence = judge(rest, counts, policy);
    let may_be_lost = |at: usize| match at.cmp(&start.at) {
        Ordering::Less => true,
        Ordering::Equal => sentence.is_none(),
        Ordering::Greater => sentence.is_none() || start.doubts > 0,
    };
    for at in memchr_iter(b'$', line).filter(|at| may_be_lost(*at)) {
        watched.lost_at(&line[at..]);
    }
    sentence
}

/// Where the sentence of a line begins, by its checksum: the `$` that the rules of [`crate::Framer`] choose, or `None`
/// if the checksum is right from no `$`.
///
/// For callers that cut lines themselves. The line is without its line feed.
#[must_use]
pub fn sentence_start(line: &[u8], policy: Policy) -> Option<usize> {
    right_start(line.trim_ascii_end(), policy).map(|start| start.at)
}

/// Where the sentence of a line begins.
struct Start {
    at: usize,
    /// How many later `$` could have been the start too.
    doubts: u64,
}

/// The `$` from which the checksum of a line is right. The search goes from the last `$` back to the first. Each adds
/// its own part to the sum of the parts behind it, so the time is linear in the length of the line.
fn right_start(line: &[u8], policy: Policy) -> Option<Start> {
    let star = last_star(line)?;
    let digits = &line[star + 1..];
    let wanted = checksum(digits).filter(|_| policy == Policy::FromPayload || digits.len() == 2)?;
    let (mut sum, mut end, mut right) = (0, star, 0);
    // The best start so far, and whether its sentence can hold the next `$`.
    let mut best: Option<(Start, bool)> = None;
    for at in memrchr_iter(b'$', &line[..star]) {
        let part = &line[at + 1..end];
        // A `$` is never part of a longer character, so each part must be UTF-8 by itself; otherwise no sentence begins
        // before it.
        if core::str::from_utf8(part).is_err() {
            break;
        }
        sum ^= xor(part);
        let name = part.iter().take_while(|byte| byte.is_ascii_alphanumeric()).count();
        let is_named = name > 0 && part.get(name).map_or(end == star, |byte| *byte == b',');
        if sum == wanted && is_named {
            let fits = end == star || ends_in_text(part, name);
            if fits || best.as_ref().is_none_or(|(_, best_fits)| !best_fits) {
                best = Some((Start { at, doubts: right }, fits));
            }
            right += 1;
        }
        sum ^= b'$';
        end = at;
    }
    best.map(|(start, _)| start)
}

/// Whether the first part of a sentence, whose name has `name` letters, ends inside a text. An unknown message may have
/// a text anywhere, and so may the fields that a later version adds.
fn ends_in_text(part: &[u8], name: usize) -> bool {
    let (name, fields) = part.split_at(name);
    let Some(entry) = catalogue().iter().find(|entry| entry.name.as_bytes() == name) else {
        return true;
    };
    let number = memchr_iter(b',', fields).count();
    let mut formats = entry.fields.iter().flat_map(|field| field.formats);
    formats
        .nth(number.saturating_sub(1))
        .is_none_or(|format| *format == "c--c")
}
