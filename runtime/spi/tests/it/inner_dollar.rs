//! Lines with a `$` inside: one sentence, or several of which only the last is complete.

use std::time::{Duration, Instant};

use backseat_spi::{
    EncodeError, FrameCounts, Framer, FromVehicle, MAX_LINE, Policy, RelayedText, Sentence, ToVehicle, TopsideRelay,
    Transport, catalogue,
};
use backseat_units::TimeOfDay;
use proptest::prelude::*;

const POLICIES: [Policy; 2] = [Policy::FromVehicle, Policy::FromPayload];
const CONTROL: &str = "$BFCTL,081025.987,1*78";

fn xor(text: &[u8]) -> u8 {
    text.iter().fold(0, |sum, byte| sum ^ byte)
}

fn checked(body: &str) -> String {
    format!("${body}*{:02X}", xor(body.as_bytes()))
}

fn frame<'a>(policy: Policy, pieces: impl IntoIterator<Item = &'a [u8]>) -> (Vec<String>, FrameCounts) {
    let mut framer = Framer::new(policy);
    let mut out = Vec::new();
    for piece in pieces {
        framer.push(piece);
        while let Some(sentence) = framer.next_sentence() {
            out.push(sentence.raw().to_owned());
        }
        assert!(framer.memory() <= Framer::MAX_MEMORY);
    }
    (out, framer.counts())
}

/// What one line gives in both directions: the sentences, and how many were cut short.
fn line(text: &str) -> (Vec<String>, u64) {
    let whole = format!("{text}\r\n");
    let [vehicle, payload] = POLICIES.map(|policy| frame(policy, [whole.as_bytes()]));
    assert_eq!(vehicle, payload, "{text}");
    let (sentences, counts) = vehicle;
    assert_eq!(counts.lost(), counts.cut_short, "{text}: {counts:?}");
    (sentences, counts.cut_short)
}

#[test]
fn a_line_with_a_right_checksum_is_one_sentence() {
    for body in [
        "BPSTS,081025.987,1,battery cost $5",
        "BPSTS,081025.987,1,$",
        "BPTMR,081025.987,3,$CCRXD,1,2*5B",
        "BPTMR,081025.987,3,$CCRXD,1,2*5B $CCRXD,3,4*59",
        "BPTMR,081025.987,3,$CCRXD,1,2*",
        "BFTOP,081025.987,3,$$$",
        // An unknown message, which may contain anything.
        "BFXYZ,$",
        // This field is not a text, but nothing else in the line fits.
        "BFCTL,081025.987,$1",
    ] {
        let text = checked(body);
        assert_eq!(line(&text), (vec![text.clone()], 0));
    }
}

#[test]
fn a_cut_sentence_is_skipped_and_the_complete_one_after_it_is_read() {
    let relay = checked("BPTMR,081025.987,3,$CCRXD,1,2*5B");
    for whole in [CONTROL, &relay] {
        for (cut, number) in [
            ("$", 1),
            ("$BFNVG,081025.987,42", 1),
            ("$BFNVG,0810$BF", 2),
            ("$BFCTL,081025.987,1*", 1),
            // A complete sentence without its line end.
            (CONTROL, 1),
        ] {
            assert_eq!(
                line(&format!("{cut}{whole}")),
                (vec![whole.to_owned()], number),
                "{cut}"
            );
        }
    }
}

/// A fragment that occurs twice cancels out in the checksum.
#[test]
fn a_checksum_that_fits_several_dollar_signs_belongs_to_the_first_possible_one() {
    let twice = format!("$BFNVG,08$BFNVG,08{CONTROL}");
    assert_eq!(line(&twice), (vec![CONTROL.to_owned()], 2), "a BFNVG contains no $");
    let twice = format!("$BFMIS,0810$BFMIS,0810{CONTROL}");
    assert_eq!(
        line(&twice),
        (vec![CONTROL.to_owned()], 2),
        "the time of a BFMIS contains no $"
    );
    let twice = format!("$BFXYZ,0810$BFXYZ,0810{CONTROL}");
    assert_eq!(
        line(&twice),
        (vec![twice.clone()], 1),
        "an unknown message may contain anything"
    );
    // Sentences that the first one may have swallowed count as lost.
    let twice = format!("$BFMIS,081025.987,b$BFMIS,081025.987,b{CONTROL}");
    assert_eq!(line(&twice), (vec![twice.clone()], 1));
    // Neither message can contain a `$`, but the first one has it. Its fields are checked when it is decoded.
    let mut twice = "$BFNVG,08$BFNVG,08$BFCTL,081025.987,1$".to_owned();
    twice.push_str(&format!("*{:02X}", xor(b"BFCTL,081025.987,1$")));
    assert_eq!(line(&twice), (vec![twice.clone()], 1));
}

/// Nothing shows that such a line is one sentence.
#[test]
fn without_a_checksum_the_sentence_begins_at_the_last_dollar_sign() {
    let (out, counts) = frame(Policy::FromPayload, [b"$BPSTS,081025.987,1,for $5 or $6\n".as_slice()]);
    assert_eq!((out, counts.cut_short), (vec!["$6".to_owned()], 2));
    let (out, counts) = frame(Policy::FromPayload, [b"$BPRMB,0810$BPRMP,081025.987\n".as_slice()]);
    assert_eq!((out, counts.cut_short), (vec!["$BPRMP,081025.987".to_owned()], 1));
    // The only checksum belongs to the relayed line.
    let relayed = format!("$BPTMR,081025.987,3,{}\n", checked("CCRXD,1,2"));
    let (out, counts) = frame(Policy::FromPayload, [relayed.as_bytes()]);
    assert_eq!((out, counts.cut_short), (vec![checked("CCRXD,1,2")], 1));
    // Only a payload may send a checksum of one digit.
    let body = (' '..='~')
        .map(|last| format!("BPSTS,1,${last}"))
        .find(|body| xor(body.as_bytes()) < 16)
        .unwrap();
    let short = format!("${body}*{:X}\n", xor(body.as_bytes()));
    let (out, counts) = frame(Policy::FromPayload, [short.as_bytes()]);
    assert_eq!(
        (out.as_slice(), counts.lost()),
        ([short.trim_end().to_owned()].as_slice(), 0)
    );
    let (out, counts) = frame(Policy::FromVehicle, [short.as_bytes()]);
    assert_eq!((out.len(), counts.cut_short, counts.checksum_invalid), (0, 1, 1));
    // An asterisk in the text just before it does not make it a checksum of two digits.
    let [vehicle, payload] = POLICIES.map(|policy| frame(policy, [b"$A,G**0\n".as_slice()]).1);
    assert_eq!((vehicle.sentences, vehicle.checksum_invalid), (0, 1));
    assert_eq!((payload.sentences, payload.lost()), (1, 0));
}

#[test]
fn a_damaged_line_counts_once_for_each_dollar_sign() {
    let damaged = checked("BPSTS,081025.987,1,cost $5").replace("cost", "cast");
    let (out, counts) = frame(Policy::FromVehicle, [format!("{damaged}\r\n{CONTROL}\r\n").as_bytes()]);
    assert_eq!(out, [CONTROL]);
    assert_eq!((counts.cut_short, counts.checksum_invalid, counts.lost()), (1, 1, 2));
    // Invalid UTF-8 in the first part does not harm the second.
    let (out, counts) = frame(
        Policy::FromVehicle,
        [b"$BFMSC,\xff".as_slice(), CONTROL.as_bytes(), b"\r\n"],
    );
    assert_eq!((out, counts.cut_short, counts.lost()), (vec![CONTROL.to_owned()], 1, 1));
    let mut bytes = checked("BFMSC,081025.987,$").into_bytes();
    bytes.splice(10..10, *b"\xff\xff");
    bytes.extend_from_slice(b"\r\n");
    let (out, counts) = frame(Policy::FromVehicle, [bytes.as_slice()]);
    assert_eq!(
        (out.len(), counts.cut_short, counts.malformed + counts.checksum_invalid),
        (0, 1, 1),
        "{counts:?}"
    );
}

#[test]
fn the_longest_line_is_read_and_a_longer_one_begins_at_its_next_dollar_sign() {
    let text = |length: usize| {
        checked(&format!(
            "BPTMR,081025.987,3,${}",
            "a".repeat(length - "$BPTMR,081025.987,3,$*HH\r\n".len())
        ))
    };
    let longest = text(MAX_LINE);
    assert_eq!(line(&longest), (vec![longest.clone()], 0));
    // With one byte more, the part that begins at the inner `$` still fits, but it is not a sentence.
    let long = format!("{}\r\n{CONTROL}\r\n", text(MAX_LINE + 1));
    let (out, counts) = frame(Policy::FromVehicle, [long.as_bytes()]);
    assert_eq!(out, [CONTROL]);
    assert_eq!(
        (
            counts.cut_short,
            counts.malformed + counts.checksum_invalid,
            counts.lost()
        ),
        (1, 1, 2),
        "{counts:?}"
    );
    // A long cut sentence does not remove the complete one after it.
    for length in [MAX_LINE - CONTROL.len() - 3, MAX_LINE - CONTROL.len(), MAX_LINE - 2] {
        let cut = format!("$BFMSC,{}", "a".repeat(length - 7));
        assert_eq!(
            line(&format!("{cut}{CONTROL}")),
            (vec![CONTROL.to_owned()], 1),
            "{length}"
        );
    }
}

/// Every byte takes the same time, whatever the bytes are and in whatever pieces they come.
#[test]
#[expect(clippy::disallowed_methods, reason = "what is tested is how long it takes")]
fn dollar_signs_cost_linear_time() {
    const BYTES: usize = 8_000_000;
    let sums = format!("{}*00\n", "$A,".repeat(MAX_LINE / 3 - 2));
    let not_text = ["$A,".repeat(MAX_LINE / 3 - 4).as_bytes(), b"\xff*00\n"].concat();
    let dollars = |number: usize| [vec![b'$'; number].as_slice(), b"\n"].concat();
    let far_apart = [b"$".as_slice(), &[b'a'; MAX_LINE - 2]].concat();
    for (what, unit) in [
        ("full lines", dollars(MAX_LINE - 1)),
        ("a checksum that is right from every other one", sums.into_bytes()),
        ("the same, and not UTF-8", not_text),
        ("no line end", vec![b'$']),
        ("lines that are too long", dollars(300_000)),
        ("far apart", far_apart),
    ] {
        let stream = unit.repeat(BYTES / unit.len());
        for step in [1, 4096, stream.len()] {
            let begin = Instant::now();
            let (_, counts) = frame(Policy::FromPayload, stream.chunks(step));
            let taken = begin.elapsed();
            assert!(counts.lost() > 0);
            // This is ten times what a busy machine needs. If the framer looked at all pending bytes for each `$`, it
            // would take an hour.
            assert!(taken < Duration::from_secs(5), "{what}, {step} at a time: {taken:?}");
        }
    }
}

/// SPI 7.14: one side reads exactly what the other side has written.
#[test]
fn a_relayed_line_goes_through_a_framer_unchanged() {
    for text in [
        "abort",
        "",
        " padded ",
        "$CCRXD,1,2,3*5B",
        "$CCRXD,1,2,3*5B$CCRXD,1*22",
        "go to A, then B",
        ",,*,$,*",
        "*",
        "50 % of $4",
        "$CCTXD,0,1,0,48656C6C6F*7",
        "!AIVDM,1,1,,B,15M67FC000G?ufbE`FepT@3n00Sa,0*5C",
    ] {
        for second in 0..60 {
            let relay = TopsideRelay {
                created: TimeOfDay::from_hms_nano(8, 10, second, 987_000_000).unwrap(),
                transport: Transport::AcousticModem,
                text: RelayedText::new(text).unwrap(),
            };
            let message = ToVehicle::from(relay);
            let mut bytes = Vec::new();
            message.encode(&mut bytes).unwrap();
            for policy in POLICIES {
                let mut framer = Framer::new(policy);
                framer.push(&bytes);
                let sentence = framer.next_sentence().unwrap();
                assert_eq!(ToVehicle::decode(&sentence).unwrap(), message, "{}", sentence.raw());
                assert!(framer.next_sentence().is_none());
                let counts = framer.counts();
                assert_eq!((counts.sentences, counts.lost() - counts.cut_short), (1, 0));
            }
        }
    }
}

#[test]
fn a_command_inside_a_relayed_line_is_read_and_not_written() {
    let text = checked("BPTMR,081025.987,3,$BPKIL,081025.987,now*00");
    let message = ToVehicle::decode(&Sentence::parse(&text).unwrap()).unwrap();
    let ToVehicle::TopsideRelay(relay) = &message else {
        panic!("another message")
    };
    assert_eq!(relay.text, "$BPKIL,081025.987,now*00");
    let mut out = Vec::new();
    let error = message.encode(&mut out).unwrap_err();
    assert!(
        matches!(error, EncodeError::Field { field: "text", .. }) && out.is_empty(),
        "{error}"
    );
    assert_eq!(
        error.to_string(),
        "BPTMR field text: expected a text without $BP, which a vehicle could take for a command"
    );
}

/// SPI 4.2: comma and asterisk are delimiters. They stay delimiters in texts that other fields follow, or may follow in
/// a later version.
#[test]
fn other_texts_end_at_a_comma_and_have_blanks_instead_of_delimiters() {
    let vehicle = |body: &str| FromVehicle::decode(&Sentence::parse(&checked(body)).unwrap()).unwrap();
    let FromVehicle::TopsideMessage(top) = vehicle("BFTOP,081025.987,3,$5 for 2*3,later") else {
        panic!("another message")
    };
    assert_eq!(top.text, " 5 for 2 3");
    let FromVehicle::Acknowledgement(ack) = vehicle("BFACK,081025.987,STS,081025.950,0,2,0,cost $5,later") else {
        panic!("another message")
    };
    assert_eq!(ack.text, "cost  5");
    let FromVehicle::MissionStatus(status) = vehicle("BFMIS,081025.987,$a.dive,Running $1,2*3") else {
        panic!("another message")
    };
    assert_eq!(
        (
            status.dive_file.as_str(),
            status.status.as_str(),
            status.details.as_str()
        ),
        (" a.dive", "Running  1", "2 3")
    );
    let payload = |body: &str| ToVehicle::decode(&Sentence::parse(&checked(body)).unwrap()).unwrap();
    let ToVehicle::PayloadStatus(status) = payload("BPSTS,081025.987,1,cost $5*2,later") else {
        panic!("another message")
    };
    assert_eq!(status.text, "cost  5 2");
    // A comma in this text would move the reason, which is the field after it.
    assert!(ToVehicle::decode(&Sentence::parse("$BPABT,081025.987,leak, bay 2,1").unwrap()).is_err());
}

/// What the framer should do, written as plainly as possible: it tries every `$` of every line.
mod reference {
    use super::*;

    fn is_right(sentence: &[u8], policy: Policy) -> bool {
        let Ok(text) = core::str::from_utf8(sentence) else {
            return false;
        };
        let Some((body, digits)) = text[1..].trim_ascii_end().rsplit_once('*') else {
            return false;
        };
        let name: String = body.chars().take_while(char::is_ascii_alphanumeric).collect();
        let is_named = !name.is_empty() && (body.len() == name.len() || body[name.len()..].starts_with(','));
        let is_short = digits.len() == 1 && policy == Policy::FromPayload;
        (digits.len() == 2 || is_short)
            && digits.chars().all(|digit| digit.is_ascii_hexdigit())
            && u8::from_str_radix(digits, 16).is_ok_and(|sum| sum == xor(body.as_bytes()))
            && is_named
    }

    /// Whether the field of the first inner `$` may contain one.
    fn is_sound(sentence: &[u8]) -> bool {
        let text = core::str::from_utf8(sentence).unwrap();
        let Some((before, _)) = text[1..].split_once('$') else {
            return true;
        };
        let mut fields: Vec<&str> = before.split(',').collect();
        let name = fields.remove(0);
        let Some(entry) = catalogue().iter().find(|entry| entry.name == name) else {
            return true;
        };
        let formats: Vec<&str> = entry
            .fields
            .iter()
            .flat_map(|field| field.formats.iter().copied())
            .collect();
        fields.len() > formats.len() || formats[fields.len() - 1] == "c--c"
    }

    /// One line from its first `$` on, without the line feed.
    fn line(line: &[u8], policy: Policy, out: &mut Vec<String>, counts: &mut FrameCounts) {
        let dollars: Vec<usize> = (0..line.len()).filter(|at| line[*at] == b'$').collect();
        let right: Vec<usize> = dollars
            .iter()
            .copied()
            .filter(|at| is_right(&line[*at..], policy))
            .collect();
        let sound = right.iter().copied().find(|at| is_sound(&line[*at..]));
        let chosen = sound.or(right.first().copied()).or(dollars.last().copied()).unwrap();
        counts.cut_short += dollars.iter().filter(|at| **at < chosen).count() as u64;
        counts.cut_short += right.iter().filter(|at| **at > chosen).count() as u64;
        let Ok(text) = core::str::from_utf8(&line[chosen..]) else {
            counts.not_utf8 += 1;
            return;
        };
        let text = text.trim_ascii_end();
        let name = text[1..].chars().take_while(char::is_ascii_alphanumeric).count();
        if name == 0 || text[1 + name..].starts_with(|next| next != ',' && next != '*') {
            counts.malformed += 1;
        } else if right.is_empty() && text.contains('*') {
            counts.checksum_invalid += 1;
        } else if right.is_empty() && policy == Policy::FromVehicle {
            counts.checksum_absent += 1;
        } else {
            counts.sentences += 1;
            out.push(text.to_owned());
        }
    }

    pub(super) fn frame(policy: Policy, stream: &[u8]) -> (Vec<String>, FrameCounts) {
        let (mut out, mut counts) = (Vec::new(), FrameCounts::default());
        let mut rest = stream;
        loop {
            let noise = rest.iter().take_while(|byte| **byte != b'$').count();
            counts.noise_bytes += rest[..noise].iter().filter(|byte| !b"\r\n".contains(byte)).count() as u64;
            rest = &rest[noise..];
            let end = rest.iter().position(|byte| *byte == b'\n');
            match end {
                Some(end) if end < MAX_LINE => {
                    line(&rest[..end], policy, &mut out, &mut counts);
                    rest = &rest[end + 1..];
                }
                None if rest.len() < MAX_LINE => return (out, counts),
                Some(_) | None => match rest[1..MAX_LINE].iter().position(|byte| *byte == b'$') {
                    Some(at) => {
                        counts.cut_short += 1;
                        rest = &rest[1 + at..];
                    }
                    None => {
                        counts.too_long += 1;
                        rest = &rest[MAX_LINE..];
                    }
                },
            }
        }
    }
}

/// Bodies of sentences, with texts that matter to the framer.
fn body() -> impl Strategy<Value = String> {
    let text = "[$*,A-C1 \r]{0,8}";
    prop_oneof![
        text.prop_map(|text| format!("BPTMR,081025.987,3,{text}")),
        text.prop_map(|text| format!("BFMIS,081025.987,{text}")),
        text.prop_map(|text| format!("BPSTS,{text}")),
        text.prop_map(|text| format!("BFCTL,{text}")),
        text.prop_map(|text| format!("X{text}")),
        text,
    ]
}

/// A valid or invalid sentence, or a piece of a stream of sentences.
fn part() -> impl Strategy<Value = Vec<u8>> {
    let bytes = |text: String| text.into_bytes();
    prop_oneof![
        6 => body().prop_map(move |body| bytes(checked(&body))),
        // The same body twice, so that the first one cancels out in the checksum.
        3 => body().prop_map(move |body| bytes(format!("${body}${body}"))),
        3 => (body(), any::<prop::sample::Index>(), 1..=255u8).prop_map(|(body, at, flip)| {
            let mut damaged = checked(&body).into_bytes();
            let at = at.index(damaged.len());
            damaged[at] ^= flip;
            damaged
        }),
        3 => (body(), any::<prop::sample::Index>()).prop_map(|(body, at)| {
            let cut = checked(&body).into_bytes();
            cut[..at.index(cut.len())].to_vec()
        }),
        1 => body().prop_map(move |body| bytes(format!("${body}*{:X}", xor(body.as_bytes()) & 15))),
        1 => body().prop_map(move |body| bytes(format!("${body}"))),
        2 => Just(CONTROL.as_bytes().to_vec()),
        8 => Just(b"\r\n".to_vec()),
        2 => "[$*,\r\nA0]{0,6}".prop_map(bytes),
        1 => Just(b"\xff".to_vec()),
        1 => Just("é".as_bytes().to_vec()),
        1 => proptest::collection::vec(any::<u8>(), 0..20),
        1 => (1..=MAX_LINE).prop_map(|length| vec![b'x'; length]),
        1 => (1..=MAX_LINE / 9).prop_map(move |times| bytes("$BPSTS,1,".repeat(times))),
    ]
}

fn pieces<'a>(stream: &'a [u8], cuts: &'a [usize]) -> impl Iterator<Item = &'a [u8]> {
    let mut rest = stream;
    cuts.iter().cycle().map_while(move |cut| {
        let (piece, after) = rest.split_at((*cut).min(rest.len()));
        rest = after;
        (!piece.is_empty()).then_some(piece)
    })
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(1000))]

    /// The framer gives the sentences and counts of the reference for the stream in one piece, byte by byte, and cut at
    /// random.
    #[test]
    fn the_framer_agrees_with_the_reference(
        parts in proptest::collection::vec(part(), 0..24),
        cuts in proptest::collection::vec(1..300usize, 1..8),
    ) {
        let stream = parts.concat();
        for policy in POLICIES {
            let expected = reference::frame(policy, &stream);
            prop_assert_eq!(&frame(policy, [stream.as_slice()]), &expected);
            prop_assert_eq!(&frame(policy, pieces(&stream, &cuts)), &expected);
            prop_assert_eq!(&frame(policy, stream.chunks(1)), &expected);
        }
    }

    /// Every relayed text is read unchanged, and a sentence lost before it does not matter.
    #[test]
    fn every_relayed_text_is_read_unchanged(text in "[ -~]{0,80}", millis in 0..86_400_000u64) {
        let message = ToVehicle::from(TopsideRelay {
            created: TimeOfDay::from_nanos(millis * 1_000_000).unwrap(),
            transport: Transport::AcousticModem,
            text: RelayedText::new(&text.replace("$BP", "$CC")).unwrap(),
        });
        let mut bytes = b"noise\n$BPSTS,081025.987\xff,1\n".to_vec();
        message.encode(&mut bytes).unwrap();
        let mut framer = Framer::new(Policy::FromVehicle);
        framer.push(&bytes);
        let sentence = framer.next_sentence().unwrap();
        prop_assert_eq!(ToVehicle::decode(&sentence).unwrap(), message);
    }
}
