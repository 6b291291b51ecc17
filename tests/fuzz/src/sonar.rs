use std::io::Cursor;

use backseat_s7k::file::{FileItem, FileReader, Frames, Index};
use backseat_s7k::plc::{Alarm, CommandId, Generic, Order, Status};
use backseat_s7k::record::{Action, BluefinData, Record};
use backseat_s7k::{Frame, FrameError, StreamItem, StreamReader, layouts, read_header};

/// The longest record that a target accepts, so that sizes above the limit are met.
const LIMIT: usize = 4096;

/// Reads one record. If it is one, its parts must be inside it, and writing what was read must give the same bytes.
pub fn s7k_frame(data: &[u8]) {
    match Frame::read(data, LIMIT) {
        Ok(frame) => {
            assert!(frame.bytes().len() <= LIMIT && data.starts_with(frame.bytes()));
            let _ = (frame.checksum(), frame.header().faults());
            record(&frame);
        }
        Err(FrameError::Incomplete { needed, .. }) => assert!(data.len() < needed && needed <= LIMIT),
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}

/// Reads a record's body as each type in turn, whatever its frame says.
pub fn s7k_record(data: &[u8]) {
    for record_type in [3000_u32, 3001, 3100, 7200, 7300, 7400, 11_000, 11_001, 11_002, 9000] {
        let mut bytes = Vec::new();
        let header = backseat_s7k::FrameHeader::new(record_type, backseat_s7k::DeviceId(1));
        let mut frame = backseat_s7k::FrameWriter::begin(header, &mut bytes);
        // The first byte says how much of the rest is optional data.
        let (share, body) = data
            .split_first()
            .map_or((0, data), |(share, body)| (usize::from(*share), body));
        let (body, optional) = body.split_at(body.len() - (share * body.len() / 255).min(body.len()));
        frame.bytes().extend_from_slice(body);
        if !optional.is_empty() {
            frame.begin_optional(u32::from(share as u8 % 3));
            frame.bytes().extend_from_slice(optional);
        }
        frame.finish(1 << 24).expect("it is below the limit");
        let frame = Frame::read(&bytes, 1 << 24).expect("it was written as a frame");
        record(&frame);
    }
    for layout in layouts() {
        assert!(layout.size > 0);
    }
}

/// Everything that can be asked of a record.
fn record(frame: &Frame<'_>) {
    let Ok(record) = Record::read(frame) else { return };
    let mut out = Vec::new();
    record.write(&mut out);
    assert_eq!(out, frame.body().expect("the record was read from it"));
    match record {
        Record::SideScan(imagery) | Record::SubBottom(imagery) => {
            assert_eq!(imagery.channels().count(), imagery.header.channels as usize);
            let mut amplitudes = Vec::new();
            for channel in imagery.channels() {
                let samples = imagery.samples(&channel);
                amplitudes.clear();
                samples.amplitudes(&mut amplitudes);
                assert!(amplitudes.len() <= samples.len() && samples.complex().count() <= samples.len());
            }
            let _ = (imagery.side_scan_headers().count(), imagery.segy_headers().count());
        }
        Record::Bluefin(record) => {
            for frame in record.frames() {
                let _ = frame.checksum_matches(backseat_s7k::BluefinChecksum::WholePacket);
                if let BluefinData::Navigation(navigation) = frame.data {
                    let _ = (navigation.faults(), navigation.quality.fields().count());
                }
            }
        }
        Record::FileHeader(header) => {
            let _ = (header.devices().count(), header.catalog());
        }
        Record::Catalog(catalog) => {
            let _ = catalog.entries().count();
        }
        Record::Command(command) => {
            let _ = Order::read(command.header.command, command.header.action, &command.text());
        }
        Record::Message(message) => {
            let _ = Status::read(message.header.id, &message.text());
            let _ = Alarm::read(message.header.id, &message.text());
        }
        Record::Time(..) | Record::Acknowledge(..) | Record::Other(_) => {}
    }
}

/// Reads a text as the command, status or alarm that its first byte names. What is read and written is read and written
/// as the same text.
pub fn s7k_text(data: &[u8]) {
    let Some((first, text)) = data.split_first() else {
        return;
    };
    let text = String::from_utf8_lossy(text);
    let id = i32::from(*first % 32);
    for action in [Action::Set, Action::Get] {
        let command = CommandId::from(u32::from(*first % 32));
        again(&text, |text, out| {
            Order::read(command, action, text).ok()?.write(out).ok()
        });
    }
    again(&text, |text, out| Generic::read(text).ok()?.write(out).ok());
    again(&text, |text, out| Status::read(id, text)?.ok()?.write(out).ok());
    again(&text, |text, out| Alarm::read(id, text)?.ok()?.write(out).ok());
}

/// Reads a text and writes what was read, twice.
fn again(text: &str, rewrite: impl Fn(&str, &mut String) -> Option<()>) {
    let (mut first, mut second) = (String::new(), String::new());
    if rewrite(text, &mut first).is_some() {
        assert!(
            rewrite(&first, &mut second).is_some(),
            "{first:?} was written and cannot be read"
        );
        assert_eq!(first, second);
    }
}

/// Reads a file in memory, from a source in pieces, and by its index. All must find the same records.
pub fn s7k_file(data: &[u8]) {
    let whole: Vec<(u64, usize)> = Frames::with_limit(data, LIMIT)
        .filter_map(|item| match item {
            FileItem::Record { offset, frame } => Some((offset, frame.bytes().len())),
            FileItem::Skipped(_) => None,
        })
        .collect();
    let mut bytes = 0;
    for item in Frames::with_limit(data, LIMIT) {
        bytes += match item {
            FileItem::Record { frame, .. } => frame.bytes().len() as u64,
            FileItem::Skipped(skipped) => skipped.bytes,
        };
    }
    assert_eq!(bytes, data.len() as u64, "each byte is in a record or skipped");
    let mut reader = FileReader::with_limit(Pieces(data), LIMIT);
    let mut pieces = Vec::new();
    while let Some(item) = reader.next().expect("memory can be read") {
        if let FileItem::Record { offset, frame } = item {
            pieces.push((offset, frame.bytes().len()));
        }
    }
    assert_eq!(pieces, whole);
    let _ = Index::scan_with_limit(Cursor::new(data), LIMIT).expect("memory can be read");
    let _ = Index::from_catalog(Cursor::new(data));
}

/// A source that gives few bytes at once.
struct Pieces<'a>(&'a [u8]);

impl std::io::Read for Pieces<'_> {
    fn read(&mut self, out: &mut [u8]) -> std::io::Result<usize> {
        let count = self.0.len().min(out.len()).min(97);
        let (piece, rest) = self.0.split_at(count);
        out[..count].copy_from_slice(piece);
        self.0 = rest;
        Ok(count)
    }
}

/// Reads a stream in pieces whose lengths come from its first bytes, and as a whole. Both must give the same records,
/// within the bound of memory.
pub fn s7k_stream(data: &[u8]) {
    let (cuts, data) = data.split_at(data.len().min(8));
    if cuts.is_empty() {
        return;
    }
    let whole = records(core::iter::once(data));
    let mut rest = data;
    let mut lengths = cuts.iter().cycle();
    let pieces = core::iter::from_fn(|| {
        let length = usize::from(*lengths.next()?).max(1);
        let (piece, after) = rest.split_at(length.min(rest.len()));
        rest = after;
        (!piece.is_empty()).then_some(piece)
    });
    assert_eq!(records(pieces), whole);
    let _ = read_header(data, LIMIT);
}

fn records<'a>(pieces: impl Iterator<Item = &'a [u8]>) -> Vec<Vec<u8>> {
    let mut reader = StreamReader::new(LIMIT);
    let mut records = Vec::new();
    for piece in pieces {
        reader.push(piece);
        while let Some(item) = reader.next() {
            if let StreamItem::Record(frame) = item {
                records.push(frame.bytes().to_vec());
            }
        }
    }
    records
}
