use proptest::prelude::*;

use super::*;
use crate::{FrameHeader, FrameWriter};

/// A record of a type and of so many bytes.
fn record(record_type: u32, length: usize) -> Vec<u8> {
    let mut out = Vec::new();
    let mut frame = FrameWriter::begin(FrameHeader::new(record_type, DeviceId(11_001)), &mut out);
    frame
        .bytes()
        .extend((0..length).map(|index| u8::try_from(index % 251).unwrap()));
    frame.finish(FRAME_LIMIT).unwrap();
    out
}

fn packets(record: &[u8], packet_max: usize, transmission: u16) -> Vec<u8> {
    let mut out = Vec::new();
    NetworkHeader::new(DeviceId(1), transmission)
        .enclose(record, packet_max, &mut out)
        .unwrap();
    out
}

/// What a reader gives for these bytes: the types of records, and the errors.
fn read(reader: &mut StreamReader, bytes: &[u8]) -> (Vec<u32>, Vec<StreamError>) {
    reader.push(bytes);
    let (mut records, mut errors) = (Vec::new(), Vec::new());
    while let Some(item) = reader.next() {
        match item {
            StreamItem::Record(frame) => {
                assert_eq!(frame.checksum(), crate::Checksum::Valid);
                records.push(frame.header().record_type);
            }
            StreamItem::Skipped { why, .. } => errors.push(why),
        }
    }
    (records, errors)
}

#[test]
fn records_come_whole_in_one_packet_in_several_and_several_in_one() {
    let mut stream = packets(&record(1, 100), 1400, 0);
    stream.extend(packets(&record(2, 5000), 1400, 1));
    let both = [record(3, 10), record(4, 0)].concat();
    stream.extend(packets(&both, 1400, 2));
    stream.extend(record(5, 7));
    let mut reader = StreamReader::default();
    assert_eq!(read(&mut reader, &stream), (vec![1, 2, 3, 4, 5], vec![]));
    let counts = *reader.counts();
    assert_eq!(
        (
            counts.packets,
            counts.records,
            counts.fragmented_records,
            counts.bare_records
        ),
        (6, 5, 1, 1)
    );
    assert_eq!(counts.skipped_bytes, 0);
}

#[test]
fn a_whole_record_is_lent_from_the_buffer() {
    let mut reader = StreamReader::default();
    reader.push(&packets(&record(1, 100), 1400, 0));
    let lent = match reader.next() {
        Some(StreamItem::Record(frame)) => frame.bytes().as_ptr() as usize,
        other => panic!("{other:?}"),
    };
    let buffer = reader.buffer.as_ptr_range();
    assert!((buffer.start as usize..buffer.end as usize).contains(&lent));
}

#[test]
fn transmissions_of_several_senders_may_alternate() {
    let split = |source: u32, bytes: &[u8]| {
        let mut out = Vec::new();
        NetworkHeader::new(DeviceId(source), 0)
            .enclose(bytes, 136, &mut out)
            .unwrap();
        out.chunks(136).map(<[u8]>::to_vec).collect::<Vec<_>>()
    };
    let (first, second) = (split(1, &record(1, 500)), split(2, &record(2, 500)));
    let stream: Vec<u8> = first
        .into_iter()
        .zip(second)
        .flat_map(|(a, b)| [a, b].concat())
        .collect();
    assert_eq!(read(&mut StreamReader::default(), &stream), (vec![1, 2], vec![]));
}

#[test]
fn a_sender_that_counts_no_packets_is_believed_by_its_sizes() {
    // Total packets 0, and the sequence number counts records.
    let mut stream = Vec::new();
    for (number, length) in [(1_u32, 20), (2, 3000), (3, 40)] {
        let mut sent = packets(&record(number, length), 1036, 0);
        let mut at = 0;
        while at < sent.len() {
            let size = u32::from_le_bytes([sent[at + 12], sent[at + 13], sent[at + 14], sent[at + 15]]);
            sent[at + 4..at + 8].copy_from_slice(&[0; 4]);
            sent[at + 20..at + 24].copy_from_slice(&number.to_le_bytes());
            at += size as usize;
        }
        stream.extend(sent);
    }
    assert_eq!(read(&mut StreamReader::default(), &stream), (vec![1, 2, 3], vec![]));
}

#[test]
fn a_frame_header_may_itself_be_split() {
    // 5 bytes of data in each packet.
    let stream = packets(&record(9, 50), 41, 3);
    assert_eq!(read(&mut StreamReader::default(), &stream), (vec![9], vec![]));
}

#[test]
fn a_missing_packet_costs_its_own_record_only() {
    let lost = packets(&record(1, 500), 136, 0);
    let mut stream = lost[..136].to_vec();
    stream.extend(&lost[2 * 136..]);
    stream.extend(packets(&record(2, 10), 1400, 1));
    let mut reader = StreamReader::default();
    let (records, errors) = read(&mut reader, &stream);
    assert_eq!(records, [2]);
    assert_eq!(
        errors[0],
        StreamError::Abandoned {
            reason: "a packet is missing"
        }
    );
    assert!(
        errors[1..]
            .iter()
            .all(|error| matches!(error, StreamError::NoBeginning { .. })),
        "{errors:?}"
    );
    assert_eq!(reader.counts().abandoned_records, 1);
}

#[test]
fn a_new_record_ends_one_that_never_ended() {
    let mut stream = packets(&record(1, 500), 136, 0)[..136].to_vec();
    stream.extend(packets(&record(2, 500), 136, 0));
    let (records, errors) = read(&mut StreamReader::default(), &stream);
    assert_eq!(
        (records, errors),
        (
            vec![2],
            vec![StreamError::Abandoned {
                reason: "another record began"
            }]
        )
    );
}

#[test]
fn garbage_between_records_is_skipped_and_counted() {
    let garbage = b"HTTP/1.1 200 OK\r\nContent-Length: 0\r\nServer: not a payload controller\r\n\r\n";
    let mut stream = packets(&record(1, 30), 1400, 0);
    stream.extend(garbage);
    stream.extend(packets(&record(2, 30), 1400, 1));
    stream.extend(garbage);
    stream.extend(record(3, 30));
    let mut reader = StreamReader::default();
    let (records, errors) = read(&mut reader, &stream);
    assert_eq!(records, [1, 2, 3]);
    assert!(!errors.is_empty());
    assert_eq!(reader.counts().skipped_bytes, 2 * garbage.len() as u64);
}

#[test]
fn an_older_version_is_named() {
    let mut old = record(1, 30);
    old[0] = 3;
    let (_, errors) = read(&mut StreamReader::default(), &old);
    assert_eq!(errors[0], StreamError::Frame(FrameError::Version { version: 3 }));
}

#[test]
fn sizes_that_lie_take_no_more_memory_than_the_limit() {
    let limit = 10_000;
    let mut reader = StreamReader::new(limit);
    let mut header = NetworkHeader::new(DeviceId(1), 0);
    for round in 0..2000_u32 {
        // Each begins a record of nearly the limit that never ends, from a sender of its own.
        header.source_device = DeviceId(round);
        let mut begun = record(1, 9000);
        begun.truncate(600);
        let mut packet = Vec::new();
        header.enclose(&begun, 2000, &mut packet).unwrap();
        let _ = read(&mut reader, &packet);
        let held: usize = reader
            .transmissions
            .iter()
            .map(|transmission| transmission.bytes.capacity())
            .sum();
        assert!(
            held <= 2 * limit && reader.transmissions.len() <= TRANSMISSIONS,
            "{held}"
        );
    }
    assert!(reader.counts().abandoned_records > 1900);
    // A size above the limit is refused at once.
    let mut huge = packets(&record(1, 30), 1400, 0);
    huge[12..16].copy_from_slice(&u32::MAX.to_le_bytes());
    let (_, errors) = read(&mut StreamReader::new(limit), &huge);
    assert_eq!(
        errors[0],
        StreamError::Packet(NetworkError::Size {
            packet_size: u32::MAX,
            limit
        })
    );
}

/// A record that holds another one, in a packet of its own, in its middle.
fn hiding(record_type: u32, length: usize, hidden: &[u8]) -> Vec<u8> {
    let mut out = record(record_type, length);
    let at = FrameHeader::SIZE + length / 2;
    out[at..at + hidden.len()].copy_from_slice(hidden);
    out
}

/// What a reader gives for these bytes, pushed so many at once: the types of records and the first error.
fn in_pieces(limit: usize, stream: &[u8], piece: usize) -> (Vec<u32>, Option<StreamError>) {
    let mut reader = StreamReader::new(limit);
    let (mut records, mut error) = (Vec::new(), None);
    for bytes in stream.chunks(piece) {
        let (more, errors) = read(&mut reader, bytes);
        records.extend(more);
        error = error.or(errors.first().copied());
        assert!(
            reader.buffer.len() <= 2 * limit + piece + 200,
            "{}",
            reader.buffer.len()
        );
    }
    assert_eq!(reader.buffer.len() - reader.at, 0, "nothing is left over");
    (records, error)
}

#[test]
fn nothing_inside_a_record_above_the_limit_is_read() {
    let limit = 4096;
    for hidden in [record(7, 30), packets(&record(7, 30), 1400, 9)] {
        let long = hiding(1, 50_000, &hidden);
        for sent in [
            long.clone(),
            packets(&long, 1 << 20, 0),
            packets(&long, 1000, 0),
            packets(&long, 45, 0),
            // The hidden record begins a packet of its own.
            packets(&long, 36 + 64 + 25_000, 0),
            packets(&long, 36 + (64 + 25_000) / 10, 0),
        ] {
            let mut stream = packets(&record(2, 30), 1400, 5);
            stream.extend(&sent);
            stream.extend(packets(&record(3, 30), 1400, 1));
            stream.extend(b"noise, and then the same again");
            stream.extend(&sent);
            stream.extend(packets(&record(4, 30), 1400, 2));
            for piece in [1, 7, 1000, stream.len()] {
                let (records, error) = in_pieces(limit, &stream, piece);
                assert_eq!(records, [2, 3, 4], "{piece} {error:?}");
                assert!(error.is_some());
            }
        }
    }
}

#[test]
fn a_sender_that_counts_no_packets_cannot_hide_one_either() {
    let long = hiding(1, 5000, &record(7, 30));
    let mut sent = packets(&long, 36 + 64 + 2500, 0);
    let mut at = 0;
    while at < sent.len() {
        let size = u32::from_le_bytes([sent[at + 12], sent[at + 13], sent[at + 14], sent[at + 15]]);
        sent[at + 4..at + 8].copy_from_slice(&[0; 4]);
        at += size as usize;
    }
    sent.extend(packets(&record(3, 30), 1400, 1));
    assert_eq!(in_pieces(3000, &sent, 50).0, [3]);
}

#[test]
fn a_continuation_that_looks_like_a_record_is_none() {
    // The packet before it is missing.
    let long = hiding(1, 1000, &record(7, 30));
    let sent = packets(&long, 36 + (64 + 500) / 2, 0);
    let (records, errors) = read(&mut StreamReader::default(), &sent[36 + (64 + 500) / 2..]);
    assert_eq!(records.len(), 0);
    assert!(
        errors
            .iter()
            .all(|error| matches!(error, StreamError::NoBeginning { .. })),
        "{errors:?}"
    );
}

#[test]
fn nothing_inside_a_record_or_a_packet_of_another_version_is_read() {
    let long = hiding(1, 500, &packets(&record(7, 30), 1400, 9));
    for (at, whole) in [
        (0, long.clone()),
        (36, packets(&long, 1400, 0)),
        (0, packets(&long, 1400, 0)),
    ] {
        for version in [1, 2, 3, 6, 15] {
            let mut stream = b"noise".to_vec();
            for _ in 0..2 {
                let mut sent = whole.clone();
                sent[at] = version;
                stream.extend(sent);
                stream.extend(packets(&record(3, 30), 1400, 1));
            }
            for piece in [1, 50, stream.len()] {
                assert_eq!(in_pieces(4096, &stream, piece).0, [3, 3], "version {version}");
            }
            let (_, errors) = read(&mut StreamReader::default(), &stream[5..]);
            let version = u16::from(version);
            let said = [
                StreamError::Frame(FrameError::Version { version }),
                StreamError::Packet(NetworkError::Version { version }),
            ];
            assert_eq!(errors.len(), 2);
            assert!(errors.iter().all(|error| said.contains(error)), "{errors:?}");
        }
    }
}

#[test]
fn a_length_that_lies_costs_what_it_covers_and_no_more() {
    let limit = 4096;
    let mut liar = record(1, 30);
    liar[8..12].copy_from_slice(&5000_u32.to_le_bytes());
    let mut reader = StreamReader::new(limit);
    let mut stream = liar.clone();
    while stream.len() < 6000 {
        stream.extend(packets(&record(3, 30), 1400, 1));
    }
    let (records, _) = read(&mut reader, &stream);
    assert!((5..=8).contains(&records.len()), "{}", records.len());
    assert!(!reader.is_astray());
    // A length that no record has is believed up to a point, and its reader says so.
    liar[8..12].copy_from_slice(&u32::MAX.to_le_bytes());
    let mut reader = StreamReader::new(limit);
    assert_eq!(read(&mut reader, &liar).0.len(), 0);
    assert!(reader.is_astray());
    let long = packets(&record(3, 60_000), 1 << 20, 0);
    let mut pushed = liar.len();
    while pushed + long.len() <= StreamReader::SKIP_MAX {
        assert_eq!(read(&mut reader, &long).0.len(), 0);
        pushed += long.len();
        assert!(reader.buffer.len() <= long.len());
    }
    let mut after = Vec::new();
    for _ in 0..3 {
        after.extend(read(&mut reader, &packets(&record(4, 30), 1400, 1)).0);
        after.extend(read(&mut reader, &vec![0; long.len()]).0);
    }
    assert_eq!(after.last(), Some(&4));
    assert_eq!(reader.counts().records, after.len() as u64);
}

proptest! {
    #[test]
    fn the_cuts_between_pushes_do_not_matter(cuts in proptest::collection::vec(1_usize..400, 1..60), packet_max in 40_usize..900) {
        let mut stream = Vec::new();
        for (index, length) in [0_usize, 700, 3, 150].into_iter().enumerate() {
            let number = u16::try_from(index).unwrap();
            stream.extend(packets(&record(u32::from(number), length), packet_max, number));
        }
        let mut reader = StreamReader::default();
        let mut records = Vec::new();
        let mut rest = stream.as_slice();
        for cut in cuts.into_iter().cycle() {
            let (chunk, behind) = rest.split_at(cut.min(rest.len()));
            let (more, errors) = read(&mut reader, chunk);
            prop_assert_eq!(errors, vec![]);
            records.extend(more);
            rest = behind;
            if rest.is_empty() {
                break;
            }
        }
        prop_assert_eq!(records, vec![0, 1, 2, 3]);
    }

    #[test]
    fn what_is_refused_hides_nothing_wherever_the_cuts_are(
        parts in proptest::collection::vec((0_u8..6, 38_usize..3000, 1000_usize..9000), 1..8),
        cuts in proptest::collection::vec(1_usize..700, 1..20),
    ) {
        let (mut stream, mut good) = (Vec::new(), Vec::new());
        for (number, (part, packet_max, length)) in (100_u32..).zip(parts) {
            let transmission = u16::try_from(number).unwrap();
            let long = hiding(1, 4096 + length, &packets(&record(7, 30), 1400, 9));
            let foreign = |at: usize, mut bytes: Vec<u8>| {
                bytes[at] = 3;
                bytes
            };
            let short = hiding(1, 1000, &packets(&record(7, 30), 1400, 9));
            stream.extend(match part {
                0 => {
                    good.push(number);
                    packets(&record(number, length / 3), packet_max, transmission)
                }
                1 => long,
                2 => packets(&long, packet_max, transmission),
                3 => foreign(0, short),
                4 => foreign(0, packets(&short, 1400, transmission)),
                _ => b"neither a packet nor a record\r\n".repeat(length / 1000),
            });
        }
        let mut reader = StreamReader::new(4096);
        let (mut records, mut rest) = (Vec::new(), stream.as_slice());
        for cut in cuts.into_iter().cycle() {
            let (chunk, behind) = rest.split_at(cut.min(rest.len()));
            records.extend(read(&mut reader, chunk).0);
            prop_assert!(reader.buffer.len() < 2 * 4096 + 700 + 200);
            rest = behind;
            if rest.is_empty() {
                break;
            }
        }
        prop_assert_eq!(records, good);
    }

    #[test]
    fn any_bytes_end_in_progress_and_bounded_memory(chunks in proptest::collection::vec(proptest::collection::vec(any::<u8>(), 0..300), 0..20)) {
        let mut reader = StreamReader::new(1000);
        for chunk in chunks {
            let _ = read(&mut reader, &chunk);
            prop_assert!(reader.buffer.len() < 1000 + 36 + 300 + 64);
        }
    }
}
