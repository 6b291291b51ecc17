use backseat_spi::{ChecksumState, FrameCounts, Framer, FromVehicle, MAX_LINE, Policy, Sentence, ToVehicle};

const POLICIES: [Policy; 2] = [Policy::FromVehicle, Policy::FromPayload];

/// A sentence that both policies allow.
const CONTROL: &str = "$BFCTL,081025.987,1*78";

/// Frames a stream in one push. Every sentence must be whole, unchanged, and allowed by the policy. A `$` may be inside
/// it only if its checksum is right. Memory must stay within its bound. Every byte must be in a sentence, in a counted
/// drop or in counted noise. Whatever the stream is, a sentence after it on a line of its own must be returned, and on
/// the same line it must end the last sentence.
pub fn frame(data: &[u8]) {
    for policy in POLICIES {
        let mut framer = Framer::new(policy);
        framer.push(data);
        assert!(framer.memory() <= Framer::MAX_MEMORY);
        let mut from = 0;
        let mut given = 0;
        while let Some(sentence) = framer.next_sentence() {
            given += 1;
            let raw = sentence.raw().as_bytes();
            assert!(raw.len() <= MAX_LINE && !raw.contains(&b'\n') && raw.starts_with(b"$"));
            assert!(sentence.checksum() == ChecksumState::Valid || !raw[1..].contains(&b'$'));
            assert_eq!(Sentence::parse(sentence.raw()), Ok(sentence));
            match (policy, sentence.checksum()) {
                (_, ChecksumState::Valid) | (Policy::FromPayload, ChecksumState::Absent) => {}
                (_, state) => panic!("a sentence with a checksum that is {state:?} got through"),
            }
            let at = data[from..].windows(raw.len()).position(|window| window == raw);
            from += at.expect("sentences come out in order, as they went in") + raw.len();
        }
        let counts = framer.counts();
        assert_eq!(counts.sentences, given);
        let lines = data.iter().filter(|byte| matches!(byte, b'$')).count() as u64;
        assert!(events(counts) <= lines, "{counts:?} of {lines} dollar signs");
        assert!(counts.noise_bytes <= data.len() as u64);
        let mut glued = framer.clone();
        glued.push(format!("{CONTROL}\r\n").as_bytes());
        let last = last(&mut glued).expect("the control is there");
        assert!(last.ends_with(CONTROL), "{last:?}");
        framer.push(format!("\n{CONTROL}\r\n").as_bytes());
        assert_eq!(self::last(&mut framer).as_deref(), Some(CONTROL));
        framer.push(data);
        framer.clear();
        assert!(framer.next_sentence().is_none());
        framer.push(b"$AB*03\n");
        assert_eq!(self::last(&mut framer).as_deref(), Some("$AB*03"));
    }
}

fn last(framer: &mut Framer) -> Option<String> {
    let mut last = None;
    while let Some(sentence) = framer.next_sentence() {
        last = Some(sentence.raw().to_owned());
    }
    last
}

/// Frames a stream in pieces, whose lengths come from its first bytes, and as a whole. Both must give the same
/// sentences and the same counts. In both directions, each sentence must be a message or an error that names one of its
/// fields.
pub fn stream(data: &[u8]) {
    let (cuts, data) = data.split_at(data.len().min(8));
    if cuts.is_empty() || data.len() >= Framer::MAX_BACKLOG {
        return;
    }
    for policy in POLICIES {
        let whole = sentences(policy, core::iter::once(data));
        let mut rest = data;
        let mut lengths = cuts.iter().cycle();
        let pieces = core::iter::from_fn(|| {
            let length = usize::from(*lengths.next()?);
            let (piece, after) = rest.split_at(length.max(1).min(rest.len()));
            rest = after;
            (!piece.is_empty()).then_some(piece)
        });
        assert_eq!(sentences(policy, pieces), whole);
    }
}

fn sentences<'a>(policy: Policy, pieces: impl Iterator<Item = &'a [u8]>) -> (Vec<String>, FrameCounts) {
    let mut framer = Framer::new(policy);
    let mut out = Vec::new();
    for piece in pieces {
        framer.push(piece);
        while let Some(sentence) = framer.next_sentence() {
            for error in [FromVehicle::decode(&sentence).err(), ToVehicle::decode(&sentence).err()] {
                assert!(error.is_none_or(|error| error.number <= sentence.fields().count() + 1));
            }
            out.push(sentence.raw().to_owned());
        }
    }
    (out, framer.counts())
}

/// Each of these began with its own dollar sign.
fn events(counts: FrameCounts) -> u64 {
    let FrameCounts {
        sentences,
        checksum_invalid,
        checksum_absent,
        malformed,
        too_long,
        not_utf8,
        cut_short,
        overflowed,
        noise_bytes: _,
    } = counts;
    sentences + checksum_invalid + checksum_absent + malformed + too_long + not_utf8 + cut_short + overflowed
}
