//! Prints the rows of the 7k format: reading, writing and indexing sidescan records, in memory and in the page cache.

use std::fs::File;
use std::hint::black_box;
use std::io::{Cursor, Read as _, Seek as _, SeekFrom};

use backseat_bench::in_turn;
use backseat_s7k::file::{FileInfo, FileItem, FileWriter, Frames, Index};
use backseat_s7k::record::{
    Channel, ChannelHeader, HeaderLayout, Imagery, ImageryHeader, Record, SampleFormat, SideScanHeader,
};
use backseat_s7k::{Checksum, DeviceId, FRAME_LIMIT, Frame, FrameHeader, FrameWriter, Time7k};

/// Bytes of records that a part of a measurement goes over: more than the caches hold.
const BYTES: usize = 64 << 20;
/// Each measurement goes over all records once.
const CALLS: u32 = 16;
const GIGABYTE: u64 = 1 << 30;

pub(crate) fn print() {
    println!("| work | ours | floor | ratio | aim |\n|---|---|---|---|---|");
    for samples in [455, 8192] {
        let records = records(samples);
        reading(samples, &records);
        writing(samples, &records);
    }
    indexing();
}

/// A record of two channels.
fn record(samples: u32, ping: u32) -> Vec<u8> {
    let bytes: Vec<u8> = (0..samples * 2)
        .map(|at| (at.wrapping_mul(2_654_435_761) >> 24) as u8)
        .collect();
    let mut channel = ChannelHeader::read(&[0; ChannelHeader::SIZE]).expect("it is whole");
    (channel.samples, channel.bytes_per_sample) = (samples, 2);
    let channels = [Channel {
        header: channel,
        bytes: &bytes,
    }; 2];
    let header = ImageryHeader {
        time_ms: ping,
        ping,
        channels: 2,
        channel_bytes: 0,
        data_format: SampleFormat::Envelope,
    };
    let mut out = Vec::new();
    let mut frame = FrameWriter::begin(FrameHeader::new(3000, DeviceId::SIDESCAN_HIGH).counted(ping), &mut out);
    Imagery::compose(header, HeaderLayout::Spec, &channels, 160, frame.bytes()).expect("the channels fit");
    frame.begin_optional(SideScanHeader::OPTIONAL_ID);
    frame.bytes().extend_from_slice(&[0; 2 * SideScanHeader::SIZE]);
    frame.finish(FRAME_LIMIT).expect("it is short");
    out
}

fn records(samples: u32) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(BYTES + (1 << 20));
    let mut ping = 0;
    while bytes.len() < BYTES {
        bytes.extend_from_slice(&record(samples, ping));
        ping += 1;
    }
    bytes
}

/// Prints one row in bytes a second, and what the floor is.
fn row(work: &str, bytes: usize, (ours_ns, floor_ns): (f64, f64), floor_is: &str, aim: &str) {
    let rate = |ns: f64| bytes as f64 / ns;
    println!(
        "| {work} | {:.1} GB/s | {:.1} GB/s ({floor_is}) | {:.2} | {aim} |",
        rate(ours_ns),
        rate(floor_ns),
        ours_ns / floor_ns
    );
}

/// A pass over all bytes, eight at a time.
fn pass(bytes: &[u8]) -> u64 {
    let (words, _) = bytes.as_chunks::<8>();
    words.iter().fold(0, |sum, word| sum ^ u64::from_le_bytes(*word))
}

fn reading(samples: u32, records: &[u8]) {
    let headers = || {
        let mut channels = 0;
        for item in Frames::new(records) {
            let FileItem::Record { frame, .. } = item else {
                panic!("the records are whole")
            };
            if let Ok(Record::SideScan(imagery)) = Record::read(&frame) {
                channels += imagery.channels().map(|channel| channel.bytes.len()).sum::<usize>();
            }
        }
        black_box(channels);
    };
    let floor = || {
        black_box(pass(records));
    };
    let what = format!("2 x {samples} samples");
    row(
        &format!("read records, {what}"),
        records.len(),
        in_turn(CALLS, headers, floor),
        "a pass over the bytes",
        "2 GB/s",
    );
    let checked = || {
        let valid = Frames::new(records)
            .filter(|item| matches!(item, FileItem::Record { frame, .. } if frame.checksum() == Checksum::Valid));
        black_box(valid.count());
    };
    let times = in_turn(CALLS, checked, floor);
    row(
        &format!("read and audit checksums, {what}"),
        records.len(),
        times,
        "a pass over the bytes",
        "2 GB/s",
    );
    let mut amplitudes = Vec::new();
    let decoded = || {
        for item in Frames::new(records) {
            let FileItem::Record { frame, .. } = item else {
                panic!("the records are whole")
            };
            let Ok(Record::SideScan(imagery)) = Record::read(&frame) else {
                panic!("they are sidescan")
            };
            amplitudes.clear();
            imagery
                .channels()
                .for_each(|channel| imagery.samples(&channel).amplitudes(&mut amplitudes));
            black_box(&amplitudes);
        }
    };
    let times = in_turn(CALLS, decoded, floor);
    row(
        &format!("read amplitudes as f32, {what}"),
        records.len(),
        times,
        "a pass over the bytes",
        "",
    );
}

fn writing(samples: u32, records: &[u8]) {
    let frames: Vec<Frame<'_>> = Frames::new(records)
        .map(|item| match item {
            FileItem::Record { frame, .. } => frame,
            FileItem::Skipped(skipped) => panic!("the records are whole: {skipped}"),
        })
        .collect();
    let mut file = Some(Vec::with_capacity(records.len() * 2));
    let ours = || {
        let mut memory = file.take().unwrap_or_default();
        memory.clear();
        let mut writer = FileWriter::create(Cursor::new(memory), FileInfo::default(), Time7k::NONE).expect("memory");
        for frame in &frames {
            writer.write(frame).expect("memory");
        }
        file = Some(writer.finish(Time7k::NONE).expect("memory").into_inner());
    };
    let mut copy = Vec::with_capacity(records.len() * 2);
    let floor = || {
        copy.clear();
        copy.extend_from_slice(records);
        black_box(&copy);
    };
    let what = format!("write a file of records, 2 x {samples} samples");
    row(
        &what,
        records.len(),
        in_turn(CALLS, ours, floor),
        "one copy",
        "0.5 GB/s",
    );
    let sample = record(samples, 0);
    let mut composed = Vec::with_capacity(sample.len() * 2);
    let bytes: Vec<u8> = vec![7; samples as usize * 2];
    let compose = || {
        composed.clear();
        let mut channel = ChannelHeader::read(&[0; ChannelHeader::SIZE]).expect("it is whole");
        (channel.samples, channel.bytes_per_sample) = (samples, 2);
        let channels = [Channel {
            header: channel,
            bytes: &bytes,
        }; 2];
        let header = ImageryHeader {
            time_ms: 0,
            ping: 0,
            channels: 2,
            channel_bytes: 0,
            data_format: SampleFormat::Envelope,
        };
        let mut frame = FrameWriter::begin(FrameHeader::new(3000, DeviceId::SIDESCAN_HIGH), &mut composed);
        Imagery::compose(header, HeaderLayout::Spec, &channels, 0, frame.bytes()).expect("the channels fit");
        frame.finish(FRAME_LIMIT).expect("it is short");
        black_box(&composed);
    };
    let mut copied = Vec::with_capacity(sample.len() * 2);
    let times = in_turn(CALLS * 256, compose, || {
        copied.clear();
        copied.extend_from_slice(&sample);
        black_box(&copied);
    });
    row(
        &format!("compose a record with its checksum, 2 x {samples} samples"),
        sample.len(),
        times,
        "one copy",
        "0.5 GB/s",
    );
}

/// A file of a gigabyte in the page cache, gone over by its headers.
fn indexing() {
    let path = tempfile::NamedTempFile::new().expect("there is room for a file of 1 GB");
    let mut writer = FileWriter::create(
        path.reopen().expect("it was just made"),
        FileInfo::default(),
        Time7k::NONE,
    )
    .expect("there is room");
    let record = record(8192, 0);
    let frame = Frame::read(&record, FRAME_LIMIT).expect("it is whole");
    while writer.length() < GIGABYTE {
        writer.write(&frame).expect("there is room for a file of 1 GB");
    }
    drop(writer.finish(Time7k::NONE).expect("there is room"));
    let open = || File::open(path.path()).expect("it was just written");
    let mut offsets = Vec::new();
    let scan = || {
        offsets = Index::scan(open())
            .expect("it can be read")
            .entries
            .iter()
            .map(|entry| entry.offset)
            .collect()
    };
    let mut places: Vec<u64> = Index::scan(open())
        .expect("it can be read")
        .entries
        .iter()
        .map(|entry| entry.offset)
        .collect();
    places.sort_unstable();
    let floor = || {
        let mut file = open();
        let mut header = [0; FrameHeader::SIZE];
        for place in &places {
            file.seek(SeekFrom::Start(*place)).expect("it can be read");
            file.read_exact(&mut header).expect("it can be read");
            black_box(&header);
        }
    };
    let (ours_ns, floor_ns) = in_turn(CALLS, scan, floor);
    println!(
        "| index a file of 1 GB, {} records | {:.1} ms | {:.1} ms (a read of each header) | {:.2} | 2 s |",
        places.len(),
        ours_ns / 1e6,
        floor_ns / 1e6,
        ours_ns / floor_ns
    );
    let (catalog_ns, _) = in_turn(CALLS, || drop(black_box(Index::from_catalog(open()))), || {});
    println!(
        "| index it by its catalogue | {:.1} ms | {:.1} ms (the scan) | {:.2} | |",
        catalog_ns / 1e6,
        ours_ns / 1e6,
        catalog_ns / ours_ns
    );
    assert_eq!(offsets, places);
}
