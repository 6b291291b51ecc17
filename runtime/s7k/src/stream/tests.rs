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
    fn any_bytes_end_in_progress_and_bounded_memory(chunks in proptest::collection::vec(proptest::collection::vec(any::<u8>(), 0..300), 0..20)) {
        let mut reader = StreamReader::new(1000);
        for chunk in chunks {
            let _ = read(&mut reader, &chunk);
            prop_assert!(reader.buffer.len() < 1000 + 36 + 300 + 64);
        }
    }
}
