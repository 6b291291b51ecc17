use backseat_spi::{
    Direction, Fault, FrameCounts, Framer, FromVehicle, MAX_LINE, Policy, Sentence, ToVehicle, catalogue,
};

const CONTROL: &str = "$BFCTL,081025.987,1*78";

fn checked(body: &str) -> String {
    let sum = body.bytes().fold(0, |sum, byte| sum ^ byte);
    format!("${body}*{sum:02X}\r\n")
}

/// The number of sentences in a stream, the counts, and the most memory that the framer had.
fn frame(policy: Policy, bytes: &[u8]) -> (usize, FrameCounts, usize) {
    let mut framer = Framer::new(policy);
    let (mut sentences, mut memory) = (0, 0);
    for read in bytes.chunks(16_384) {
        framer.push(read);
        memory = memory.max(framer.memory());
        while framer.next_sentence().is_some() {
            sentences += 1;
        }
    }
    (sentences, framer.counts(), memory)
}

/// Safety requirement 013.
#[test]
fn ten_megabytes_without_a_line_end_take_no_memory() {
    let control = format!("\r\n{CONTROL}\r\n");
    for filler in ["a", "$BFMSC,081025.987,", ",", "\u{0}"] {
        let mut stream = b"$BFMSC,081025.987,".to_vec();
        while stream.len() < 10_000_000 {
            stream.extend_from_slice(filler.as_bytes());
        }
        stream.extend_from_slice(control.as_bytes());
        let (sentences, counts, memory) = frame(Policy::FromVehicle, &stream);
        assert_eq!(sentences, 1, "after {filler:?}");
        if filler.contains('$') {
            assert!(counts.cut_short > 500_000 && counts.too_long == 0, "{counts:?}");
        } else {
            assert_eq!((counts.too_long, counts.cut_short), (1, 0), "{filler:?}");
            assert!(counts.noise_bytes > 9_900_000);
        }
        assert!(memory < 100_000, "{memory} bytes for {filler:?}");
    }
}

/// Safety requirement 013.
#[test]
fn a_thousand_unknown_sentences_are_returned_as_unknown() {
    let stream: String = (0..1000)
        .map(|number| checked(&format!("BF{number:03},{}", "x,".repeat(number))))
        .collect();
    let mut framer = Framer::new(Policy::FromVehicle);
    framer.push(stream.as_bytes());
    let (mut unknown, mut bytes) = (0, 0);
    while let Some(sentence) = framer.next_sentence() {
        let FromVehicle::Unknown(message) = FromVehicle::decode(&sentence).unwrap() else {
            panic!("{} is a known message", sentence.raw())
        };
        unknown += 1;
        bytes = bytes.max(message.fields().map(str::len).sum());
        assert!(sentence.raw().len() <= MAX_LINE);
    }
    assert_eq!(unknown, 1000);
    assert!(bytes < MAX_LINE);
    assert_eq!(
        framer.counts(),
        FrameCounts {
            sentences: 1000,
            ..FrameCounts::default()
        }
    );
    assert!(framer.memory() <= Framer::MAX_MEMORY);
}

/// One of the counts.
type Count = fn(&FrameCounts) -> u64;

#[test]
fn each_cause_is_counted_separately() {
    let long = format!("$BFMSC,081025.987,{}\r\n", "a".repeat(MAX_LINE));
    let causes: [(&[u8], Count); 7] = [
        (b"$BFCTL,081025.987,0*78\r\n", |counts| counts.checksum_invalid),
        (b"$BFCTL,081025.987,0*7\r\n", |counts| counts.checksum_invalid),
        (b"$BFCTL,081025.987,1\r\n", |counts| counts.checksum_absent),
        (b"$B CTL,081025.987,1*00\r\n", |counts| counts.malformed),
        (b"$BFCTL,\xff\xfe*00\r\n", |counts| counts.not_utf8),
        (b"$BFCTL,0810", |counts| counts.cut_short),
        (long.as_bytes(), |counts| counts.too_long),
    ];
    for (bad, count) in causes {
        let mut stream = bad.repeat(3);
        stream.extend_from_slice(format!("{CONTROL}\r\n").as_bytes());
        let (sentences, counts, _) = frame(Policy::FromVehicle, &stream);
        assert_eq!(
            (sentences, count(&counts)),
            (1, 3),
            "{:?}",
            bad.escape_ascii().to_string()
        );
        let dropped = counts.checksum_invalid
            + counts.checksum_absent
            + counts.malformed
            + counts.not_utf8
            + counts.cut_short
            + counts.too_long
            + counts.overflowed;
        assert_eq!((dropped, counts.sentences), (3, 1), "under one cause only: {counts:?}");
    }
}

/// Replaces each number, code, time, place and flag of each message by something invalid.
#[test]
fn an_invalid_value_is_refused_in_every_field_of_every_message() {
    let mut refused = 0;
    for entry in catalogue() {
        let (line, _) = entry.example.split_once('*').unwrap();
        let fields: Vec<&str> = line.split(',').collect();
        let formats = entry.fields.iter().flat_map(|field| field.formats);
        for (at, format) in formats.enumerate() {
            if matches!(*format, "c--c" | "rrr" | "reserved") {
                continue;
            }
            for bad in [
                "NaN",
                "nan",
                "inf",
                "-inf",
                "Infinity",
                "1e400",
                "-1e400",
                "1e3",
                "0x10",
                "1,5",
                "--1",
                "\u{e9}",
                "1 2",
                "99999999999999999999999999999999999999999999999999999999999999999999999999",
            ] {
                // Digits are valid data of a frame too.
                if *format == "hex" && bad.bytes().all(|byte| byte.is_ascii_hexdigit()) || bad.contains(',') {
                    continue;
                }
                let mut changed = fields.clone();
                changed[at + 1] = bad;
                let line = changed.join(",");
                let sentence = Sentence::parse(&line).unwrap();
                let error = match entry.direction {
                    Direction::FromVehicle => FromVehicle::decode(&sentence).map(drop),
                    Direction::ToVehicle => ToVehicle::decode(&sentence).map(drop),
                };
                let error = error.expect_err(&line);
                assert_eq!(error.message, entry.name, "{line}");
                assert!(error.number <= at + 1, "{line}: {error}");
                assert!(
                    matches!(error.fault, Fault::Malformed { .. } | Fault::OutOfRange(_)),
                    "{line}: {error}"
                );
                refused += 1;
            }
        }
    }
    assert!(refused > 3000, "{refused}");
}

/// A line that ends anywhere is a message, an error, or another message: never a panic.
#[test]
fn truncated_lines_are_errors_or_shorter_messages() {
    for entry in catalogue() {
        for end in 0..=entry.example.len() {
            let Ok(sentence) = Sentence::parse(&entry.example[..end]) else {
                continue;
            };
            drop(FromVehicle::decode(&sentence));
            drop(ToVehicle::decode(&sentence));
        }
    }
}
