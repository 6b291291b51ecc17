use backseat_spi::{Framer, FromVehicle, Policy, ToVehicle};

/// The sentences of the link, of which most are not wanted.
pub(super) struct Link {
    from_vehicle: Skimmer,
    to_vehicle: Skimmer,
}

impl Link {
    pub(super) const fn new() -> Self {
        Self {
            from_vehicle: Skimmer::new(Policy::FromVehicle),
            to_vehicle: Skimmer::new(Policy::FromPayload),
        }
    }

    /// A new connection.
    pub(super) fn begin(&mut self) {
        self.from_vehicle.clear();
        self.to_vehicle.clear();
    }

    /// Takes bytes of the vehicle. `wants` is asked about each line that begins as a sentence.
    pub(super) fn receive(&mut self, bytes: &[u8], wants: impl FnMut(&[u8]) -> bool) {
        self.from_vehicle.push(bytes, wants);
    }

    /// Passes on the vehicle's messages, each with its line.
    pub(super) fn heard(&mut self, mut hear: impl FnMut(&[u8], &FromVehicle)) {
        while let Some(sentence) = self.from_vehicle.framer.next_sentence() {
            if let Ok(message) = FromVehicle::decode(&sentence) {
                hear(sentence.raw().as_bytes(), &message);
            }
        }
    }

    /// Takes bytes for the vehicle.
    pub(super) fn send(&mut self, bytes: &[u8], wants: impl FnMut(&[u8]) -> bool) {
        self.to_vehicle.push(bytes, wants);
    }

    /// Passes on our messages.
    pub(super) fn sent(&mut self, mut take: impl FnMut(&ToVehicle)) {
        while let Some(sentence) = self.to_vehicle.framer.next_sentence() {
            if let Ok(message) = ToVehicle::decode(&sentence) {
                take(&message);
            }
        }
    }
}

/// A framer that is spared the lines which nobody wants: these are most of all bytes.
struct Skimmer {
    framer: Framer,
    /// What was pushed last ended with a line, so the next byte begins one.
    at_line: bool,
}

impl Skimmer {
    const fn new(policy: Policy) -> Self {
        Self {
            framer: Framer::new(policy),
            at_line: true,
        }
    }

    fn clear(&mut self) {
        self.framer.clear();
        self.at_line = true;
    }

    fn push(&mut self, bytes: &[u8], mut wants: impl FnMut(&[u8]) -> bool) {
        for line in bytes.split_inclusive(|byte| *byte == b'\n') {
            let whole = line.ends_with(b"\n");
            // A part of a line, or a line with another `$`, is the framer's to judge.
            let skipped = self.at_line && whole && is_plain(line) && !wants(line);
            if !skipped {
                self.framer.push(line);
            }
            self.at_line = whole;
        }
    }
}

/// Whether a line begins as a sentence and cannot have another one inside.
fn is_plain(line: &[u8]) -> bool {
    line.split_first()
        .is_some_and(|(first, rest)| *first == b'$' && !rest.contains(&b'$'))
}

/// The name of the sentence that a line begins as.
pub(super) fn name(line: &[u8]) -> &[u8] {
    line.get(1..6)
        .filter(|_| line.get(6) == Some(&b','))
        .unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    const DEPTH: &[u8] = b"$BFRDP,081025.987,303.4125*48\r\n";
    const CONTROL: &[u8] = b"$BFCTL,081025.987,1*78\r\n";

    fn heard(pieces: &[&[u8]], wanted: &[u8]) -> usize {
        let mut link = Link::new();
        let mut count = 0;
        for piece in pieces {
            link.receive(piece, |line| name(line) == wanted);
            link.heard(|_, _| count += 1);
        }
        count
    }

    #[test]
    fn lines_that_nobody_wants_are_skipped() {
        let all = [DEPTH, CONTROL, DEPTH].concat();
        assert_eq!(heard(&[&all], b"BFRDP"), 2);
        assert_eq!(heard(&[&all], b"BFCTL"), 1);
        assert_eq!(heard(&[&all], b"BFNVG"), 0);
    }

    #[test]
    fn a_sentence_in_pieces_is_heard() {
        for cut in 1..DEPTH.len() {
            let (begin, end) = DEPTH.split_at(cut);
            let rest = [end, CONTROL, DEPTH].concat();
            assert_eq!(heard(&[begin, &rest], b"BFRDP"), 2, "{cut}");
        }
    }

    #[test]
    fn a_sentence_after_one_that_was_cut_short_is_heard() {
        let damaged = [b"$BFNVG,0810".as_slice(), DEPTH].concat();
        assert_eq!(heard(&[&damaged], b"BFRDP"), 1);
        assert_eq!(heard(&[b"noise\xff\n", DEPTH, b"$BFRDP,nonsense*00\r\n"], b"BFRDP"), 1);
    }
}
